#pragma once

#include <array>
#include <span>
#include <vector>

#include "brim/math/types.h"
#include "brim/solve/projected_gauss_seidel.h"
#include "brim/world/body_inverses.h"

namespace brim {

/// Rows on bodies of many velocities whose inverse is exact. In the sweeps such a body has coordinates of its own,
///   y_c = R_c v,  the velocities of its material at its contacts (normal and two tangents each),
/// which respond to an impulse at contact c by  W_dc = R_d A⁻¹ R_cᵀ.  So the cost of a sweep grows with the square of
/// the number of its contacts, not with its velocities.
class DirectRows {
 public:
  /// @param first  index of the first coordinate among all unknowns of the sweeps
  void begin(std::size_t bodies, std::size_t first);
  /// Adds the rows of a contact on a body; contacts come in ascending order.
  /// @param force  R_cᵀ: forces of the body for unit impulses along the normal and the tangents, filtered
  void add(std::size_t body, std::size_t contact, const std::array<std::vector<double>, 3>& force);
  /// Computes W of every body.
  void solve(const BodyInverses& inverses, std::span<const std::size_t> first_v);

  /// Number of coordinates of all bodies.
  std::size_t size() const { return size_; }
  bool holds(std::size_t body) const { return !body_[body].touch.empty(); }
  /// Appends the coordinates of one body that a contact moves.
  void append(std::size_t body, std::size_t contact, std::vector<ProjectedGaussSeidel::Entry>& out) const;
  /// y from the velocities v. @param all  v followed by the other unknowns of the sweeps, y among them
  void read(std::span<const std::size_t> first_v, std::span<double> all) const;
  /// v += A⁻¹ Σ R_cᵀ λ_c of the bodies held here. @param lambda  per contact
  void respond(const BodyInverses& inverses, std::span<const std::size_t> first_v, std::span<const Vec3> lambda,
               std::span<double> v) const;

 private:
  struct Touch {
    std::size_t contact = 0;
    std::vector<std::size_t> index;  ///< of velocities within the body
    std::vector<Vec3> row;           ///< their coefficients in y
  };
  struct Rows {
    std::size_t first = 0;
    std::vector<Touch> touch;
    std::vector<Mat3> response;  ///< W_dc at d + c size
  };
  std::size_t first_ = 0, size_ = 0;
  std::vector<Rows> body_;
};

}  // namespace brim
