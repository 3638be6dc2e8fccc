#pragma once

#include "brim/body/stand_in.h"

namespace brim {

/// A body without coordinates, mass or surface that never moves. Links to space are attached to it: a world with such
/// links keeps one behind all its bodies, invisible to others. It also replaces a removed body, with as many parts, so
/// that the numbers of the others stay.
class Space : public StandIn {
 public:
  explicit Space(int parts = 1) : parts_(parts) { set_name("(space)"); }
  std::string_view kind() const override { return "space"; }
  void apply_system(std::span<const double>, std::span<double>) const override {}
  int part_count() const override { return parts_; }
  PartInfo part(int) const override { return {}; }
  bool immobile() const override { return true; }
  Aabb bounds(int) const override { return {}; }
  Vec3 mean_velocity(int, std::span<const double>) const override { return Vec3::Zero(); }
  double relative_speed_bound(int, std::span<const double>) const override { return 0.0; }
  void presence(int, double, double, const Aabb&, std::vector<TileKey>&) const override {}
  void rasterize(int, double, double, std::span<const TileKey>, std::span<DensityBlock>) const override {}
  void make_map(int, std::span<const Vec3> points, std::span<const std::int32_t>,
                std::unique_ptr<Map>& map) const override;
  void precondition(std::size_t, const BlockDiagonal&, std::span<const double>, std::span<double>) const override {}
  double mass() const override { return std::numeric_limits<double>::infinity(); }
  double kinetic_energy(std::span<const double>) const override { return 0.0; }

 private:
  int parts_;
};

}  // namespace brim
