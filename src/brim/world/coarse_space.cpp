#include "brim/world/coarse_space.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "brim/body/filling.h"
#include "brim/body/walled.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"
#include "brim/math/block_matrix.h"
#include "brim/world/coarse_lanes.h"

namespace brim {

namespace {

/// Smallest share of a mode that must be independent of the others.
constexpr double kIndependentMode = 1e-6;
/// Contacts processed as one piece.
constexpr std::size_t kContactsOfPatch = 4096;
/// Numbers of a vector processed by one thread at a time.
constexpr std::size_t kOfBlock = 4096;

using ConstColumn = Eigen::Map<const Eigen::VectorXd>;

/// Column k of `columns`, of n numbers each.
ConstColumn column_of(const std::vector<double>& columns, std::size_t n, int k) {
  return {columns.data() + static_cast<std::size_t>(k) * n, static_cast<Eigen::Index>(n)};
}

/// Calls f(first, size) on blocks of [0, n).
template <class F>
void for_segments(std::size_t n, const F& f) {
  parallel_blocks(n, kOfBlock, [&](std::size_t begin, std::size_t end) {
    f(static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(end - begin));
  });
}

/// Scalar product. Same bits for any number of threads.
double dot(const ConstColumn& x, const ConstColumn& y) {
  return ordered_sum(
      static_cast<std::size_t>(x.size()),
      [&](std::size_t begin, std::size_t end) {
        const auto at = static_cast<Eigen::Index>(begin), length = static_cast<Eigen::Index>(end - begin);
        return x.segment(at, length).dot(y.segment(at, length));
      },
      kOfBlock);
}

}  // namespace

void CoarseSpace::take_modes(const Body& body, std::size_t n, Modes& m) const {
  m.count = m.coupled = 0;
  m.free = true;
  m.columns.resize(kModes * n);
  m.system.setZero();
  if (body.immobile()) return;
  // A motion that the body's own walls forbid would violate the constraints of its preconditioner.
  if (const auto* walled = interface_of<Walled>(body); walled && walled->confined()) return;
  const Aabb box = body.part_count() > 0 ? body.bounds(0) : Aabb{Vec3::Zero(), Vec3::Zero()};
  const bool fluid = interface_of<Filling>(body) != nullptr;
  const std::optional<BlockSystem> blocks = body.block_system();
  m.place = blocks ? blocks->place : std::span<const Vec3>();
  m.center = box.lo.allFinite() && box.hi.allFinite() ? box.center() : Vec3::Zero();
  m.basis.setZero();
  const std::optional<int> translations = find_modes(body, n, m);
  if (!translations) return;
  std::vector<double> image(n);
  for (int k = 0; k < m.count; ++k) {
    const std::span<const double> x(m.columns.data() + static_cast<std::size_t>(k) * n, n);
    std::fill(image.begin(), image.end(), 0.0);
    // Nothing inside a fluid resists a rigid motion, and nothing inside any body a translation.
    if (fluid)
      body.apply_mass(x, image);
    else if (blocks && m.free && k < *translations)
      parallel_blocks(n, kOfBlock, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) image[i] = blocks->mass_share * blocks->mass[i / 3] * x[i];
      });
    else
      body.apply_system(x, image);
    const ConstColumn y(image.data(), static_cast<Eigen::Index>(n));
    for (int j = 0; j < m.count; ++j) m.system(j, k) = dot(y, column_of(m.columns, n, j));
  }
  // The motion of a fluid as a whole follows from its pressure in as many iterations.
  m.coupled = fluid ? 0 : m.count;
}

std::optional<int> CoarseSpace::find_modes(const Body& body, std::size_t n, Modes& m) {
  int translations = 0;
  for (int k = 0; k < kModes; ++k) {
    const Vec3 w = k < 3 ? Vec3::Zero() : Vec3(Vec3::Unit(k - 3));
    const Vec3 t = k < 3 ? Vec3(Vec3::Unit(k)) : Vec3(-w.cross(m.center));
    const std::span<double> x(m.columns.data() + static_cast<std::size_t>(m.count) * n, n);
    const ConstColumn own = column_of(m.columns, n, m.count);
    if (!body.rigid_motion(t, w, x)) return std::nullopt;
    const double unfiltered = dot(own, own);
    body.filter(x);
    const double squared = dot(own, own), length = std::sqrt(squared);
    m.free = m.free && squared == unfiltered;
    if (!(length > 0.0) || !add_mode(n, k, length, m)) continue;
    if (k < 3) translations = m.count;
  }
  return translations;
}

bool CoarseSpace::add_mode(std::size_t n, int k, double length, Modes& m) {
  Eigen::Map<Eigen::VectorXd> x(m.columns.data() + static_cast<std::size_t>(m.count) * n, static_cast<Eigen::Index>(n));
  const ConstColumn own = column_of(m.columns, n, m.count);
  auto basis = m.basis.col(m.count);
  basis = Block::Identity().col(k);
  for (int j = 0; j < m.count; ++j) {
    const ConstColumn y = column_of(m.columns, n, j);
    const double share = dot(y, own);
    for_segments(n, [&](Eigen::Index at, Eigen::Index size) { x.segment(at, size) -= share * y.segment(at, size); });
    basis -= share * m.basis.col(j);
  }
  const double left = std::sqrt(dot(own, own));
  if (!(left > kIndependentMode * length)) return false;
  for_segments(n, [&](Eigen::Index at, Eigen::Index size) { x.segment(at, size) /= left; });
  basis /= left;
  ++m.count;
  return true;
}

void CoarseSpace::begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
                        std::span<const WorldPart> parts, std::span<const std::uint8_t> without) {
  seen_ = false;
  modes_.resize(bodies.size());
  complete_.resize(bodies.size());
  first_v_.assign(first_v.begin(), first_v.end());
  body_of_part_.resize(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) body_of_part_[p] = parts[p].body_index;
  parallel_for(bodies.size(), [&](std::size_t b) {
    if (without[b])
      modes_[b].count = modes_[b].coupled = 0;
    else
      take_modes(*bodies[b], first_v[b + 1] - first_v[b], modes_[b]);
  });
  std::size_t rows = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    modes_[b].row = rows;
    rows += modes_[b].coupled;
    complete_[b] = !without[b] && static_cast<std::size_t>(modes_[b].coupled) == first_v[b + 1] - first_v[b];
  }
  coarse_.resize(static_cast<Eigen::Index>(rows));
}

void CoarseSpace::see(const ContactMaps& maps, std::size_t n) {
  seen_ = true;
  seen_a_.resize(n), seen_b_.resize(n), velocity_a_.resize(n), velocity_b_.resize(n);
  column_.resize(first_v_.back());
  for (int k = 0; k < kModes; ++k) {
    parallel_for(modes_.size(), [&](std::size_t b) {
      const std::size_t size = first_v_[b + 1] - first_v_[b];
      double* to = column_.data() + first_v_[b];
      if (k < modes_[b].coupled)
        std::copy_n(modes_[b].columns.data() + k * size, size, to);
      else
        std::fill_n(to, size, 0.0);
    });
    maps.velocities(column_, velocity_a_, velocity_b_);
    parallel_for(
        n,
        [&](std::size_t c) {
          if (k == 0) seen_a_[c].setZero(), seen_b_[c].setZero();
          seen_a_[c].col(k) = velocity_a_[c], seen_b_[c].col(k) = velocity_b_[c];
        },
        512);
  }
}

void CoarseSpace::add_block(const Block& block, const Modes& a, const Modes& b) {
  for (int j = 0; j < b.coupled; ++j)
    for (int i = 0; i < a.coupled; ++i)
      entries_.emplace_back(static_cast<int>(a.row) + i, static_cast<int>(b.row) + j, block(i, j));
}

void CoarseSpace::sum_contacts(std::span<const Seen> a, std::span<const Seen> b, const Penalty& response,
                               Patch& patch) {
  coarse_lanes::PairSums sum;
  for (std::size_t c = patch.begin; c < patch.end; ++c) {
    if (!response.acting()[c]) continue;
    const Mat3 K = response.block(c);
    coarse_lanes::add_contact(a[c].data(), b[c].data(), K.data(), sum);
  }
  for (int i = 0; i < kModes; ++i)
    for (int j = 0; j < kModes; ++j)
      patch.sum[0](i, j) = sum.aa[i][j], patch.sum[1](i, j) = sum.bb[i][j], patch.sum[2](i, j) = sum.ab[i][j];
}

bool CoarseSpace::factor(const ContactMaps& maps, const ContactSet& contacts, const Penalty& response) {
  if (coarse_.size() == 0) return false;
  if (!seen_) see(maps, contacts.size());
  patches_.clear();
  for (std::size_t p = 0; p < contacts.pairs.size(); ++p)
    for (std::size_t c = contacts.pairs[p].begin; c < contacts.pairs[p].end; c += kContactsOfPatch) {
      Patch& patch = patches_.emplace_back();
      patch.pair = p, patch.begin = c, patch.end = std::min(c + kContactsOfPatch, contacts.pairs[p].end);
    }
  parallel_for(patches_.size(), [&](std::size_t i) { sum_contacts(seen_a_, seen_b_, response, patches_[i]); });
  entries_.clear();
  for (const Modes& m : modes_) add_block(m.system, m, m);
  for (const Patch& patch : patches_) {
    const ContactPair& pair = contacts.pairs[patch.pair];
    const Modes &a = modes_[body_of_part_[pair.part_a]], &b = modes_[body_of_part_[pair.part_b]];
    add_block(patch.sum[0], a, a);
    add_block(patch.sum[1], b, b);
    add_block(patch.sum[2], a, b);
    add_block(patch.sum[2].transpose(), b, a);
  }
  matrix_.resize(coarse_.size(), coarse_.size());
  matrix_.setFromTriplets(entries_.begin(), entries_.end());
  solver_.compute(matrix_);
  return solver_.info() == Eigen::Success && (solver_.vectorD().array() > 0.0).all();
}

void CoarseSpace::give_back(std::span<const double> r, std::span<double> x) const {
  parallel_for(modes_.size(), [&](std::size_t b) {
    const Modes& m = modes_[b];
    if (m.count == 0 || !m.free) return;
    const auto n = static_cast<Eigen::Index>(first_v_[b + 1] - first_v_[b]);
    const Eigen::Map<const Eigen::VectorXd> rb(r.data() + first_v_[b], n);
    const Eigen::Map<const Eigen::MatrixXd> R(m.columns.data(), n, m.count);
    Eigen::Map<Eigen::VectorXd> xb(x.data() + first_v_[b], n);
    const Eigen::VectorXd lost = R.transpose() * rb;
    xb += R * m.system.topLeftCorner(m.count, m.count).ldlt().solve(lost);
  });
}

Eigen::VectorXd CoarseSpace::restricted(const Modes& m, std::span<const double> r) {
  const auto n = static_cast<Eigen::Index>(r.size());
  if (m.place.empty())
    return Eigen::Map<const Eigen::MatrixXd>(m.columns.data(), n, m.count).transpose() *
           Eigen::Map<const Eigen::VectorXd>(r.data(), n);
  Eigen::Vector<double, kModes> sum;
  coarse_lanes::sum_wrench(m.place, m.center, r, sum.data());
  return m.basis.leftCols(m.count).transpose() * sum;
}

void CoarseSpace::add_prolonged(const Modes& m, const Eigen::VectorXd& c, std::span<double> z) {
  const auto n = static_cast<Eigen::Index>(z.size());
  if (m.place.empty()) {
    Eigen::Map<Eigen::VectorXd>(z.data(), n).noalias() +=
        Eigen::Map<const Eigen::MatrixXd>(m.columns.data(), n, m.count) * c;
    return;
  }
  const Eigen::Vector<double, kModes> motion = m.basis.leftCols(m.count) * c;
  const Vec3 w = motion.tail<3>(), t = motion.head<3>() - w.cross(m.center);
  parallel_blocks(m.place.size(), 4096, [&](std::size_t begin, std::size_t end) {
    coarse_lanes::add_motion(m.place.subspan(begin, end - begin), t, w, z.subspan(3 * begin));
  });
}

void CoarseSpace::add(std::span<const double> r, std::span<double> z) {
  if (coarse_.size() == 0) return;
  const auto segment = [&](const Modes& m) { return coarse_.segment(static_cast<Eigen::Index>(m.row), m.coupled); };
  const auto slice = [&](auto x, std::size_t b) { return x.subspan(first_v_[b], first_v_[b + 1] - first_v_[b]); };
  parallel_for(modes_.size(), [&](std::size_t b) {
    if (modes_[b].coupled > 0) segment(modes_[b]) = restricted(modes_[b], slice(r, b));
  });
  coarse_ = solver_.solve(coarse_);
  parallel_for(modes_.size(), [&](std::size_t b) {
    if (modes_[b].coupled > 0) add_prolonged(modes_[b], segment(modes_[b]), slice(z, b));
  });
}

}  // namespace brim
