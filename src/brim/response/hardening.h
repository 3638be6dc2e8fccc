#pragma once

#include <cmath>

namespace brim {

/// Law of a contact's force over its overlap ρ̄: linear up to ρ₀, then a power, continuous in force and stiffness.
///   force/k      φ'(ρ̄) = ρ̄,           beyond ρ₀:  ρ₀ + ρ₀ (r^(m+1) − 1)/(m + 1)    r = ρ̄/ρ₀
///   stiffness/k  φ''(ρ̄) = 1,          beyond ρ₀:  r^m                             m = ln growth / ln(1/ρ₀)
///   energy/k     φ(ρ̄) = ½ ρ̄², beyond ρ₀ its integral
/// The linear law is limited: densities end at 1, and with them the force per area of a contact at about k/2. Here full
/// overlap is `growth` times as stiff as none, so contact carries concentrated loads without being stiff elsewhere. The
/// force depends on the overlap alone and has an energy. It is convex: linearized once a step, overlap that is too
/// large shrinks without passing the equilibrium.
/// Tests: tests/response/hardening_test.cpp
class Hardening {
 public:
  /// ρ₀: six times the overlap under the spread load that k was chosen for, 1.5 · 3.3 p/k / 3 at k = 100 p (loads.h).
  static constexpr double kStart = 0.1;

  Hardening() = default;  ///< linear
  /// @param growth  [-] stiffness at full overlap over that at little; linear at 1 and below
  explicit Hardening(double growth) : m_(growth > 1.0 ? std::log(growth) / std::log(1.0 / kStart) : 0.0) {}

  /// The law about an overlap, as a line: force k stiffness·offset at it, and slope k stiffness.
  struct Line {
    double stiffness = 1.0;  ///< φ''
    double offset = 0.0;     ///< φ'/φ'', ρ̄ where the law is linear
  };
  Line at(double overlap) const {
    if (!hardens(overlap)) return {1.0, overlap};
    const double r = overlap / kStart, stiffness = std::pow(r, m_);
    return {stiffness, kStart * (1.0 + (stiffness * r - 1.0) / (m_ + 1.0)) / stiffness};
  }
  /// φ
  double energy(double overlap) const {
    if (!hardens(overlap)) return 0.5 * overlap * overlap;
    const double r = overlap / kStart, n = m_ + 1.0, power = std::pow(r, m_ + 2.0);
    return kStart * kStart * (0.5 + (r - 1.0) + ((power - 1.0) / (n + 1.0) - (r - 1.0)) / n);
  }

 private:
  bool hardens(double overlap) const { return m_ > 0.0 && overlap > kStart; }

  double m_ = 0.0;
};

}  // namespace brim
