#pragma once

#include "brim/body/body.h"

namespace brim {

/// A body without coordinates, mass or display, to take the place of another.
class StandIn : public Body {
 public:
  std::size_t q_size() const override { return 0; }
  std::size_t v_size() const override { return 0; }
  void initial_state(std::span<double>, std::span<double>) const override {}
  void update(double, std::span<const double>, std::span<const double>) override {}
  void advance(double, std::span<double>, std::span<const double>) const override {}
  void add_forces(const Environment&, std::span<double>) const override {}
  void apply_mass(std::span<const double>, std::span<double>) const override {}
  std::vector<int> block_sizes() const override { return {}; }
  void add_system_diagonal(std::size_t, BlockDiagonal&) const override {}
  double potential_energy(const Environment&) const override { return 0.0; }
  Vec3 linear_momentum(std::span<const double>) const override { return Vec3::Zero(); }
  Vec3 angular_momentum(std::span<const double>) const override { return Vec3::Zero(); }
  const Display& display() const override { return display_; }
  void display_positions(std::span<Vec3f>) const override {}

 private:
  Display display_;
};

}  // namespace brim
