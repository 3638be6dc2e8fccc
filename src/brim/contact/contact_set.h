#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Two parts that may touch, and the range of their contacts in a ContactSet.
struct ContactPair {
  std::int32_t part_a = 0, part_b = 0;  ///< global part numbers, part_a < part_b; equal for self-contact
  double h = 0.0;                       ///< [m] step at which they meet
  double w = 0.0;                       ///< [m] ramp width at that step
  double margin = 0.0;             ///< [-] nodes with ρ_a + ρ_b > 1 − margin are found: they may touch in this step
  std::size_t begin = 0, end = 0;  ///< contacts of the pair
  /// [-] 0 to 1: roundness of the contact of two solids of which one is fixed; 1 for all other pairs.
  double roundness = 1.0;
};

/// A list of vectors stored in single precision, read and written in double.
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

/// The tensor T H T, T = 1 − ĝĝᵀ, from its components uu, uv, vv in the frame u, v perpendicular to g (TangentFrame);
/// zero when g is zero.
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
/// and node. Structure of arrays, each of shape (n): 100 bytes per contact.
struct ContactSet {
  std::vector<ContactPair> pairs;
  std::vector<Vec3i> node;              ///< the grid point, at h (i, j, k) with the pair's h
  std::vector<Vec3> point;              ///< [m] where the force is applied: the node shifted to where ρ_a = ρ_b
  std::vector<float> overlap;           ///< [-] ρ̄ = ρ_a + ρ_b − 1, > −margin of the pair
  std::vector<float> depth;             ///< [m] penetration: minus the sum of the distances to the two surfaces
  FloatVectors gradient_a, gradient_b;  ///< [1/m] ∇ρ
  std::vector<std::array<float, 3>> bend_a, bend_b;  ///< [1/m²] packed; read by curvature_a and curvature_b
  std::vector<std::int32_t> source_a, source_b;
  /// The last pairs are links added by others, not contacts. `link_point_b` has one entry per link: the point where the
  /// force acts on side b, [m].
  std::size_t link_pairs = 0;
  std::vector<Vec3> link_point_b;
  std::int64_t engulfed = 0;  ///< overlapping nodes without any gradient: one part deep inside the other

  std::size_t size() const { return node.size(); }
  /// Index of the first link, and of the first pair of links.
  std::size_t first_link() const { return point.size() - link_point_b.size(); }
  std::size_t first_link_pair() const { return pairs.size() - link_pairs; }
  /// Point where the force acts on side b, [m].
  const Vec3& point_b(std::size_t c) const { return c < first_link() ? point[c] : link_point_b[c - first_link()]; }
  void resize(std::size_t n);
  /// Position of the grid node, [m]. @param h  [m] step of the pair
  Vec3 node_at(std::size_t c, double h) const { return h * node[c].cast<double>(); }
  /// T H T, tangential second derivatives of ρ, [1/m²].
  Mat3 curvature_a(std::size_t c) const { return unpack_tangent_tensor(gradient_a.raw(c), bend_a[c]); }
  Mat3 curvature_b(std::size_t c) const { return unpack_tangent_tensor(gradient_b.raw(c), bend_b[c]); }
  void set(std::size_t c, const Contact& contact);
  /// Appends contact c of another set at another place. @param x  [m] its point  @param d  [m] its depth
  void append(const ContactSet& from, std::size_t c, const Vec3& x, double d);
  /// Removes contact c; those behind it move up.
  void erase(std::size_t c);
};

}  // namespace brim
