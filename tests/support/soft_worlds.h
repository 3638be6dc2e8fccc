#pragma once

#include "brim/body/cloth/cloth_body.h"
#include "brim/body/fem/fem_body.h"
#include "brim/body/mass_spring/mass_spring_body.h"
#include "brim/body/particle_fluid/particle_fluid_body.h"
#include "brim/body/rod/rod_body.h"
#include "brim/mesh/primitives.h"
#include "support/solids.h"
#include "support/worlds.h"

/// Small worlds of soft bodies that touch rigid ones and each other.
namespace brim::testing {

template <class B, class... Args>
std::unique_ptr<Body> named(std::string name, Args&&... args) {
  auto b = std::make_unique<B>(std::forward<Args>(args)...);
  b->set_name(std::move(name));
  return b;
}

inline TetMesh block_at(int cells, double side, const Vec3& corner) {
  TetMesh mesh = block(cells, cells, cells, side / cells);
  for (Vec3& x : mesh.vertices) x += corner;
  return mesh;
}

inline std::unique_ptr<Body> jelly(const std::string& name, double side, const Vec3& corner) {
  FemOptions o;
  o.density = 500, o.young = 1e5, o.stiffness_damping = 0.03;
  return named<FemBody>(name, block_at(3, side, corner), o);
}

/// A sheet of side x side around a point.
inline std::unique_ptr<Body> sheet(const std::string& name, double side, const Vec3& middle) {
  TriMesh mesh = shapes::grid(6, 6, side, side);
  Vec3 mean = Vec3::Zero();
  for (const Vec3& x : mesh.vertices) mean += x / static_cast<double>(mesh.vertices.size());
  for (Vec3& x : mesh.vertices) x += middle - mean;
  ClothOptions o;
  o.membrane.young = 500, o.bending = 1e-3, o.areal_density = 1.0, o.thickness = 0.1, o.stiffness_damping = 0.03;
  return named<ClothBody>(name, mesh, o);
}

inline std::unique_ptr<Body> springs(const std::string& name, double side, const Vec3& corner) {
  MassSpringOptions o;
  o.density = 500, o.stiffness = 2e5, o.stiffness_damping = 0.03;
  return named<MassSpringBody>(name, block_at(2, side, corner), o);
}

inline std::unique_ptr<Body> rope(const std::string& name, const Vec3& from, const Vec3& to, int segments = 8) {
  std::vector<Vec3> x;
  for (int i = 0; i <= segments; ++i) x.push_back(from + (to - from) * (double(i) / segments));
  RodOptions o;
  o.radius = 0.05, o.linear_density = 1.0, o.stretch = 5e3, o.bending = 0.05, o.stiffness_damping = 0.03;
  return named<RodBody>(name, x, o);
}

/// A blob of particles on a lattice from a corner.
inline std::unique_ptr<Body> blob(const std::string& name, int n, double spacing, const Vec3& corner) {
  std::vector<Vec3> x;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) x.push_back(corner + spacing * Vec3(i + 0.5, j + 0.5, k + 0.5));
  ParticleFluidOptions o;
  o.spacing = spacing, o.viscosity = 5.0;
  return named<ParticleFluidBody>(name, x, o);
}

/// A jelly on the ground, a sheet over it, a box on both; beside it a block of springs with a rope over it.
inline World soft_world() {
  World w(options_at(0.1));
  w.add(ground(0.5));
  w.add(jelly("jelly", 0.5, Vec3(-0.25, -0.25, 0.0)));
  w.add(sheet("sheet", 0.8, Vec3(0, 0, 0.56)));
  w.add(box("box", {Vec3(0.02, 0.01, 0.78)}, 0.5, 0.3, 300));
  w.add(springs("springs", 0.4, Vec3(0.8, -0.2, 0.0)));
  w.add(rope("rope", Vec3(1.0, -0.5, 0.47), Vec3(1.0, 0.5, 0.48)));
  return w;
}

/// The same with a blob of fluid that falls on all of it.
inline World soft_world_in_rain() {
  World w = soft_world();
  w.add(blob("fluid", 6, 0.1, Vec3(0.2, -0.3, 0.75)));
  return w;
}

}  // namespace brim::testing
