#include "brim/body/meshless/sample_elements.h"

#include <algorithm>

#include "brim/body/fem/principal_block.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/math/svd3.h"

namespace brim {

SampleElements::SampleElements(ShapeFunctions shape, std::vector<double> volume, ElasticLaw law, const Lame& lame,
                               std::span<const Vec3> frames)
    : shape_(std::move(shape)), volume_(std::move(volume)), law_(law), lame_(lame) {
  BRIM_CHECK(shape_.rows.rows(), ==, volume_.size());
  // The schedule wants as many frames for each sample: shorter lists repeat their first.
  std::int32_t most = 0;
  for (std::size_t s = 0; s < size(); ++s) most = std::max(most, shape_.rows.first[s + 1] - shape_.rows.first[s]);
  std::vector<std::int32_t> padded;
  for (std::size_t s = 0; s < size(); ++s)
    for (std::int32_t k = 0; k < most; ++k) {
      const std::int32_t e = shape_.rows.first[s] + k;
      padded.push_back(
          shape_.rows.source[static_cast<std::size_t>(e < shape_.rows.first[s + 1] ? e : shape_.rows.first[s])]);
    }
  schedule_.build(padded, most, frames);
}

void SampleElements::add_pattern(BlockMatrix& matrix) const {
  for (std::size_t s = 0; s < size(); ++s) {
    const auto n = shape_.rows.first[s + 1] - shape_.rows.first[s];
    matrix.add_elements(std::span(shape_.rows.source)
                            .subspan(static_cast<std::size_t>(shape_.rows.first[s]), static_cast<std::size_t>(n)),
                        n);
  }
}

void SampleElements::find_pairs(const BlockMatrix& matrix) {
  pair_.clear();
  first_pair_.assign(1, 0);
  for (std::size_t s = 0; s < size(); ++s) {
    for (std::int32_t i = shape_.rows.first[s]; i < shape_.rows.first[s + 1]; ++i)
      for (std::int32_t j = i + 1; j < shape_.rows.first[s + 1]; ++j)
        pair_.push_back(matrix.pair(shape_.rows.source[static_cast<std::size_t>(i)],
                                    shape_.rows.source[static_cast<std::size_t>(j)]));
    first_pair_.push_back(pair_.size());
  }
}

Mat3 SampleElements::deformation(std::size_t s, std::span<const Vec3> x) const {
  Mat3 F = Mat3::Zero();
  for (std::int32_t e = shape_.rows.first[s]; e < shape_.rows.first[s + 1]; ++e)
    F += x[static_cast<std::size_t>(shape_.rows.source[static_cast<std::size_t>(e)])] *
         shape_.gradient[static_cast<std::size_t>(e)].transpose();
  return F;
}

void SampleElements::add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness) const {
  const auto order = schedule_.order();
  schedule_.for_each([&](std::size_t place) {
    const auto s = static_cast<std::size_t>(order[place]);
    const auto first = static_cast<std::size_t>(shape_.rows.first[s]);
    const auto n = static_cast<std::size_t>(shape_.rows.first[s + 1]) - first;
    const Svd3 d = svd3(deformation(s, x));
    const PrincipalResponse r = principal_response(law_, lame_, d.s, true);
    const Mat3 stress = d.U * r.first.asDiagonal() * d.V.transpose();
    const Vec3 plus = 0.5 * (r.twist + r.flip), minus = 0.5 * (r.flip - r.twist);
    std::array<Vec3, 256> g;
    BRIM_CHECK(n, <=, g.size());
    for (std::size_t k = 0; k < n; ++k) {
      force[static_cast<std::size_t>(shape_.rows.source[first + k])] -=
          volume_[s] * (stress * shape_.gradient[first + k]);
      g[k] = d.V.transpose() * shape_.gradient[first + k];
    }
    const std::int32_t* pair = pair_.data() + first_pair_[s];
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j)
        stiffness.add(*pair++, volume_[s] * (d.U * principal_block(r, plus, minus, g[i], g[j]) * d.U.transpose()));
  });
}

double SampleElements::energy(std::span<const Vec3> x) const {
  return ordered_sum(size(), [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t s = begin; s < end; ++s)
      sum += volume_[s] * elastic_energy_density(law_, lame_, svd3(deformation(s, x)).s);
    return sum;
  });
}

}  // namespace brim
