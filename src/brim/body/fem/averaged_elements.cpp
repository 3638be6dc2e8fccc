#include "brim/body/fem/averaged_elements.h"

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/mesh/mass_properties.h"

namespace brim {

AveragedElements::AveragedElements(const TetMesh& rest, ElasticLaw law, const Lame& lame, double averaging,
                                   std::span<const double> stiffness, std::span<const EdgeShares> edges)
    : tets_(rest, law, lame), nodes_(rest.vertices.size()) {
  if (!(averaging >= 0.0 && averaging < 1.0))
    throw InputError(fmt::format("finite elements: averaging is {}; it must be at least 0 and below 1", averaging));
  std::vector<double> single(stiffness.begin(), stiffness.end());
  single.resize(rest.tets.size(), 1.0);
  if (averaging > 0.0) {
    std::vector<EdgeShares> sixths(edges.begin(), edges.end());
    for (std::size_t e = sixths.size(); e < single.size(); ++e) sixths.emplace_back().fill(single[e]);
    EdgeDomains domains = edge_domains(rest, sixths);
    for (double& v : domains.volume) v *= averaging;
    domains_.emplace(std::move(domains.shape), std::move(domains.volume), law, lame, rest.vertices);
    for (double& s : single) s *= 1.0 - averaging;
    shares_ = std::move(sixths);
    for (EdgeShares& of_tet : shares_)
      for (double& s : of_tet) s *= averaging;
  }
  tets_.scale_stiffness(single);
}

void AveragedElements::make_pattern(BlockMatrix& matrix) {
  matrix.begin(nodes_);
  // The domains of a tetrahedron's edges hold all pairs of its corners.
  if (domains_)
    domains_->add_pattern(matrix);
  else
    matrix.add_elements(tets_.nodes(), 4);
  matrix.finish();
  tets_.find_pairs(matrix);
  if (domains_) domains_->find_pairs(matrix);
}

std::optional<double> AveragedElements::add(std::span<const Vec3> x, std::span<Vec3> force,
                                            BlockMatrix& stiffness) const {
  const std::optional<double> energy = tets_.add(x, force, stiffness);
  if (!domains_) return energy;
  domains_->add(x, force, stiffness);
  return std::nullopt;
}

double AveragedElements::energy(std::span<const Vec3> x) const {
  return tets_.energy(x) + (domains_ ? domains_->energy(x) : 0.0);
}

void AveragedElements::find_stress(const TetMesh& rest, std::span<const Vec3> x, std::span<Mat3> F,
                                   std::span<Mat3> P) const {
  tets_.find_stress(x, F, P);
  if (!domains_) return;
  std::vector<Mat3> of_domain(domains_->size());
  parallel_for(
      of_domain.size(), [&](std::size_t d) { of_domain[d] = domains_->stress(d, x); }, 256);
  const std::vector<std::array<std::int32_t, 6>> domains = domains_of_tets(rest);
  for (std::size_t e = 0; e < P.size(); ++e)
    for (std::size_t i = 0; i < 6; ++i)
      P[e] += shares_[e][i] / 6.0 * of_domain[static_cast<std::size_t>(domains[e][i])];
}

StressField AveragedElements::stress_field(const TetMesh& rest, std::span<const Vec3> x,
                                           std::span<const double> filled) const {
  const std::size_t n = rest.tets.size();
  StressField out{{x.begin(), x.end()}, rest.tets,           tet_volumes(rest), {filled.begin(), filled.end()},
                  std::vector<Mat3>(n), std::vector<Mat3>(n)};
  find_stress(rest, x, out.deformation, out.stress);
  parallel_for(
      n, [&](std::size_t e) { out.stress[e] = cauchy_stress(out.stress[e], out.deformation[e]); }, 256);
  return out;
}

}  // namespace brim
