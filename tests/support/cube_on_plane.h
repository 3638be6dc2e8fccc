#pragma once

#include <numbers>

#include "brim/body/fem/fem_body.h"
#include "support/contact_quality.h"
#include "support/solids.h"

namespace brim::testing {

/// Quality of the contact force of a finite-element cube that lies on a plane, undeformed, one face in the plane.
/// @param n        plane's normal, any length
/// @param cells    cells along an edge, six tetrahedra each
/// @param side     [m] edge
/// @param press    [m] overlap of cube and plane
/// @param random_yaw  turn the cube about the plane's normal, differently at each position; else by 0.3 rad
inline ContactQuality cube_contact_quality(const Vec3& n, unsigned seed, int positions = 16, int cells = 6,
                                           double side = 16.0, double press = 0.5, bool random_yaw = false,
                                           double h = 1.0, double w = 3.0) {
  TetMesh mesh = block(cells, cells, cells, side / cells);
  for (Vec3& x : mesh.vertices) x -= Vec3(0.5 * side, 0.5 * side, 0.0);
  FemBody cube(mesh, {});
  const auto plane = make_half_space();
  const std::vector<double> v(cube.v_size(), 0.0);
  std::vector<double> q(cube.q_size());
  const Pressed pressed = [&](const Pose& ground, double lift) {
    // A random angle of the position alone, so that lifted cubes are turned alike.
    const double yaw = random_yaw ? std::numbers::pi * std::fmod(1000.0 * ground.translation.sum() / h, 1.0) : 0.3;
    const Mat3 turn = ground.rotation * Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix();
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const Vec3 x = ground.translation + turn * (mesh.vertices[i] + Vec3(0, 0, lift - press));
      std::copy(x.begin(), x.end(), q.begin() + 3 * i);
    }
    cube.update(0.0, q, v);
    const Touching::Rasterize fem = [&](std::span<const TileKey> tiles, std::span<DensityBlock> out) {
      cube.rasterize(0, h, w, tiles, out);
    };
    return Touching(fem, Touching::fill(*plane, ground, h, w), cube.bounds(0), h, w);
  };
  return contact_quality(pressed, n, seed, positions, h);
}

}  // namespace brim::testing
