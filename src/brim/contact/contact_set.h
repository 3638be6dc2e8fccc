#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/grid/tile.h"
#include "brim/math/types.h"

namespace brim {

/// A tile on which two parts are both present.
struct PairTile {
  std::int32_t pair = 0;  ///< index into the pairs given to detect
  TileKey tile;
  const DensityBlock* a = nullptr;
  const DensityBlock* b = nullptr;
  Octants octants = kAllOctants;  ///< those that are searched
};

/// Two parts that may touch, and where their contacts are in a ContactSet.
struct ContactPair {
  std::int32_t part_a = 0, part_b = 0;  ///< global part numbers, part_a < part_b; the same where one meets itself
  double h = 0.0;                       ///< [m] step at which they meet
  double w = 0.0;                       ///< [m] ramp width at that step
  double margin = 0.0;             ///< [-] nodes with ρ_a + ρ_b > 1 − margin are found: they may touch in this step
  std::size_t begin = 0, end = 0;  ///< contacts of the pair
  /// 0 to 1: how round two solids are where they touch, of which one is fixed; 1 for all others.
  double roundness = 1.0;
};

/// A list of vectors kept in single precision: written and read in double.
class FloatVectors {
 public:
  Vec3 operator[](std::size_t i) const { return data_[i].cast<double>(); }
  void set(std::size_t i, const Vec3& v) { data_[i] = v.cast<float>(); }
  void set(std::size_t i, const Vec3f& v) { data_[i] = v; }
  const Vec3f& raw(std::size_t i) const { return data_[i]; }
  const Vec3f* data() const { return data_.data(); }
  std::size_t size() const { return data_.size(); }
  void resize(std::size_t n) { data_.resize(n); }
  void append(const FloatVectors& from, std::size_t i) { data_.push_back(from.data_[i]); }
  void erase(std::size_t i) { data_.erase(data_.begin() + static_cast<std::ptrdiff_t>(i)); }
  bool operator==(const FloatVectors&) const = default;

 private:
  std::vector<Vec3f> data_;
};

/// The tensor T H T, T = 1 − ĝĝᵀ, of the three numbers uu, uv, vv that it has in the frame u, v across g
/// (TangentFrame); zero where g is.
Mat3 unpack_tangent_tensor(const Vec3f& g, const std::array<float, 3>& packed);

/// One contact (ContactSet has the meaning of each number).
struct Contact {
  Vec3 point;
  Vec3i node;
  float overlap, depth;
  Vec3f gradient_a, gradient_b;
  std::array<float, 3> bend_a, bend_b;
  std::int32_t source_a, source_b;
};

/// Nodes where the densities of two parts sum to more than 1 (paper, section 4.1) or soon may, ordered by pair, block
/// and node. Structure of arrays, each of shape (n): 100 bytes a contact.
struct ContactSet {
  std::vector<ContactPair> pairs;
  std::vector<Vec3i> node;              ///< the grid point, at h (i, j, k) with the pair's h
  std::vector<Vec3> point;              ///< [m] where the force is applied: the node carried to where ρ_a = ρ_b
  std::vector<float> overlap;           ///< [-] ρ̄ = ρ_a + ρ_b − 1, > −margin of the pair
  std::vector<float> depth;             ///< [m] penetration: minus the sum of the distances to the two surfaces
  FloatVectors gradient_a, gradient_b;  ///< [1/m] ∇ρ
  std::vector<std::array<float, 3>> bend_a, bend_b;  ///< [1/m²] packed; read by curvature_a and curvature_b
  std::vector<std::int32_t> source_a, source_b;
  /// The last pairs are no contacts but links that others have added, one entry of `link_point_b` per link: where the
  /// force acts on side b, [m].
  std::size_t link_pairs = 0;
  std::vector<Vec3> link_point_b;
  std::int64_t engulfed = 0;  ///< overlapping nodes without any gradient: one part deep inside the other

  std::size_t size() const { return node.size(); }
  /// The first link, and the first pair of links.
  std::size_t first_link() const { return point.size() - link_point_b.size(); }
  std::size_t first_link_pair() const { return pairs.size() - link_pairs; }
  /// Where the force acts on side b, [m].
  const Vec3& point_b(std::size_t c) const { return c < first_link() ? point[c] : link_point_b[c - first_link()]; }
  void resize(std::size_t n);
  /// Place of the grid point, [m]. @param h  [m] step of the pair
  Vec3 node_at(std::size_t c, double h) const { return h * node[c].cast<double>(); }
  /// T H T, tangential second derivatives of ρ, [1/m²].
  Mat3 curvature_a(std::size_t c) const { return unpack_tangent_tensor(gradient_a.raw(c), bend_a[c]); }
  Mat3 curvature_b(std::size_t c) const { return unpack_tangent_tensor(gradient_b.raw(c), bend_b[c]); }
  void set(std::size_t c, const Contact& contact);
  /// Appends contact c of another set, elsewhere. @param x  [m] its point  @param d  [m] its depth
  void append(const ContactSet& from, std::size_t c, const Vec3& x, double d);
  /// Takes contact c out; those behind it move up.
  void erase(std::size_t c);
};

/// Finds the contacts on the given tiles, which must be ordered by pair. `set.pairs` holds the pairs on entry; their
/// ranges and all arrays are filled. Same bits for any number of threads.
void detect(std::span<const PairTile> tiles, ContactSet& set);

}  // namespace brim
