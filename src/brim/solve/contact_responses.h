#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cstddef>
#include <span>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Coupling of one velocity to a contact.
struct ContactEntry {
  std::size_t index = 0;         ///< of the velocity
  Vec3 row = Vec3::Zero();       ///< its share in u_n, u_t1, u_t2
  Vec3 response = Vec3::Zero();  ///< its change by a unit impulse along n, t1, t2
};

/// The responses W = R (P Rᵀ) of the velocities of contacts to their impulses, kept as the two sparse factors: rows R
/// of some velocities, and what unit impulses change of these. Where contacts outnumber the velocities, as between
/// bodies that touch at several points each, products and solves with the factors cost less than with W. Tests:
/// tests/solve/contact_responses_test.cpp
class ContactResponses {
 public:
  /// Adds a contact. @param entries  no index twice
  void add(std::span<const ContactEntry> entries);
  std::size_t size() const { return first_.size() - 1; }
  /// Velocities that take part.
  std::size_t width() const { return width_; }
  /// W of one contact, [1/kg].
  Mat3 local(std::size_t c) const;
  /// Multiplies the rows of contact c by s, and its impulses as well: W_cd becomes s_c W_cd s_d.
  void scale(std::size_t c, double s);

  /// W, shape (3 size, 3 size).
  Eigen::MatrixXd dense() const;
  /// u = W λ. @param impulse  λ, shape (3 size)
  void multiply(const Eigen::VectorXd& impulse, Eigen::VectorXd& u) const;
  /// Prepares solve for W + shift, shift > 0:
  ///   (W + s)⁻¹ = (1 − R (s + P Rᵀ R)⁻¹ P Rᵀ) / s     a matrix of width² in the place of (3 size)²
  /// @return false where it is singular to rounding
  bool factor(double shift);
  /// x = (W + shift)⁻¹ b.
  void solve(const Eigen::VectorXd& b, Eigen::VectorXd& x);

 private:
  /// t = P Rᵀ λ, of the velocities that take part.
  void respond(const Eigen::VectorXd& impulse, Eigen::VectorXd& t) const;
  /// R t of contact c.
  Vec3 velocity(std::size_t c, const Eigen::VectorXd& t) const;

  std::vector<ContactEntry> entries_;  ///< index: among the velocities that take part
  std::vector<std::size_t> first_{0};  ///< entries of contact c: first_[c] to first_[c + 1]
  std::vector<std::ptrdiff_t> place_;  ///< of each velocity among those that take part, or -1
  std::size_t width_ = 0;
  double shift_ = 0.0;
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
  mutable Eigen::VectorXd t_;
};

}  // namespace brim
