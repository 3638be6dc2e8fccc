#include "brim/mesh/primitives.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "brim/core/error.h"
#include "brim/math/splitmix.h"
#include "brim/mesh/shape_builders.h"
#include "brim/mesh/topology.h"

namespace brim::shapes {

using std::numbers::pi;

namespace {

void require_positive(const char* shape, const char* name, double value) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw InputError(fmt::format("{}: {} is {} m; it must be positive and finite", shape, name, value));
}

void require_at_least(const char* shape, const char* name, int value, int least) {
  if (value < least) throw InputError(fmt::format("{}: {} is {}; it must be at least {}", shape, name, value, least));
}

void require_less(const char* shape, const char* small, double a, const char* large, double b) {
  if (!(a < b))
    throw InputError(fmt::format("{}: {} is {} m; it must be less than {}, {} m", shape, small, a, large, b));
}

TriMesh refined(TriMesh mesh, double max_edge) {
  if (max_edge == 0.0) return mesh;
  return refine(mesh, max_edge);
}

// Points of a circular arc in the (r, z) half plane, both ends included.
void arc(std::vector<RZ>& profile, double r0, double z0, double radius, double from, double to, int steps) {
  for (int i = 0; i <= steps; ++i) {
    const double a = from + (to - from) * i / steps;
    profile.push_back({r0 + radius * std::cos(a), z0 + radius * std::sin(a)});
  }
}

struct Random {
  std::uint64_t state;
  double operator()() { return static_cast<double>(next_scattered(state) >> 11) * 0x1p-53; }
};

}  // namespace

TriMesh box(const Vec3& extent, int subdivisions) {
  for (int k = 0; k < 3; ++k) require_positive("box", "extent", extent[k]);
  require_at_least("box", "subdivisions", subdivisions, 1);
  const int n = subdivisions;
  TriMesh mesh;
  std::map<std::array<int, 3>, std::int32_t> index;
  const auto vertex = [&](std::array<int, 3> g) {
    const auto [it, is_new] = index.try_emplace(g, static_cast<std::int32_t>(mesh.vertices.size()));
    if (is_new)
      mesh.vertices.emplace_back(extent.x() * (double(g[0]) / n - 0.5), extent.y() * (double(g[1]) / n - 0.5),
                                 extent.z() * (double(g[2]) / n - 0.5));
    return it->second;
  };
  // Axis k is the face normal, u and v span the face with u × v = k.
  for (int k = 0; k < 3; ++k)
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const int u = (k + 1) % 3, v = (k + 2) % 3;
          const auto at = [&](int a, int b) {
            std::array<int, 3> g{};
            g[k] = side * n;
            g[u] = i + a;
            g[v] = j + b;
            return vertex(g);
          };
          std::array<std::int32_t, 4> q = {at(0, 0), at(1, 0), at(1, 1), at(0, 1)};
          if (side == 0) std::swap(q[1], q[3]);
          mesh.triangles.push_back({q[0], q[1], q[2]});
          mesh.triangles.push_back({q[0], q[2], q[3]});
        }
  return mesh;
}

TriMesh icosphere(double radius, int level) {
  require_positive("icosphere", "radius", radius);
  require_at_least("icosphere", "level", level, 0);
  if (level > 9) throw InputError(fmt::format("icosphere: level is {}; it must be at most 9", level));
  const double g = std::numbers::phi;
  TriMesh mesh;
  mesh.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int l = 0; l < level; ++l) {
    std::map<Edge, std::int32_t> middle;
    const auto split = [&](std::int32_t a, std::int32_t b) {
      const Edge key = {std::min(a, b), std::max(a, b)};
      const auto [it, is_new] = middle.try_emplace(key, static_cast<std::int32_t>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back((mesh.vertices[a].normalized() + mesh.vertices[b].normalized()).normalized());
      return it->second;
    };
    std::vector<Triangle> fine;
    fine.reserve(mesh.triangles.size() * 4);
    for (const Triangle& t : mesh.triangles) {
      const std::int32_t ab = split(t[0], t[1]), bc = split(t[1], t[2]), ca = split(t[2], t[0]);
      fine.insert(fine.end(), {{t[0], ab, ca}, {t[1], bc, ab}, {t[2], ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(fine);
  }
  for (Vec3& x : mesh.vertices) x = radius * x.normalized();
  return mesh;
}

TriMesh capsule(double radius, double length, int around) {
  require_positive("capsule", "radius", radius);
  require_positive("capsule", "length", length);
  require_at_least("capsule", "around", around, 4);
  std::vector<RZ> profile;
  const int quarter = std::max(2, around / 4);
  arc(profile, 0.0, -0.5 * length, radius, -0.5 * pi, 0.0, quarter);
  const int rings = std::max(1, static_cast<int>(std::lround(length / (2.0 * pi * radius / around))));
  for (int i = 1; i < rings; ++i) profile.push_back({radius, length * (double(i) / rings - 0.5)});
  arc(profile, 0.0, 0.5 * length, radius, 0.0, 0.5 * pi, quarter);
  return revolve(profile, around);
}

TriMesh cylinder(double radius, double length, int around, double max_edge) {
  require_positive("cylinder", "radius", radius);
  require_positive("cylinder", "length", length);
  require_at_least("cylinder", "around", around, 3);
  return refined(
      revolve({{0.0, -0.5 * length}, {radius, -0.5 * length}, {radius, 0.5 * length}, {0.0, 0.5 * length}}, around),
      max_edge);
}

TriMesh torus(double R, double r, int nu, int nv) {
  require_positive("torus", "r", r);
  require_positive("torus", "R", R);
  require_less("torus", "r", r, "R", R);
  require_at_least("torus", "nu", nu, 3);
  require_at_least("torus", "nv", nv, 3);
  TriMesh mesh;
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) {
      const double u = 2.0 * pi * i / nu, v = 2.0 * pi * j / nv, d = R + r * std::cos(v);
      mesh.vertices.emplace_back(d * std::cos(u), d * std::sin(u), r * std::sin(v));
    }
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) {
      const auto at = [&](int a, int b) { return (i + a) % nu * nv + (j + b) % nv; };
      mesh.triangles.push_back({at(0, 0), at(1, 0), at(1, 1)});
      mesh.triangles.push_back({at(0, 0), at(1, 1), at(0, 1)});
    }
  return mesh;
}

TriMesh gear(int teeth, double outer, double root, double thickness, double bore, double max_edge) {
  require_at_least("gear", "teeth", teeth, 3);
  require_positive("gear", "outer", outer);
  require_positive("gear", "root", root);
  require_positive("gear", "thickness", thickness);
  require_less("gear", "root", root, "outer", outer);
  require_less("gear", "bore", bore, "root", root);
  if (bore < 0.0 || !std::isfinite(bore))
    throw InputError(fmt::format("gear: bore is {} m; it must be 0 or more", bore));
  // One pitch: a gap on the root circle, a flank, the tip, a flank. Arcs are cut so that few teeth still look round.
  const int arc_steps = std::max(2, 96 / teeth);
  std::vector<XY> profile;
  const auto add_arc = [&](double radius, double from, double to, int steps) {
    for (int i = 0; i <= steps; ++i) {
      const double a = from + (to - from) * i / steps;
      profile.push_back({radius * std::cos(a), radius * std::sin(a)});
    }
  };
  const double pitch = 2.0 * pi / teeth;
  for (int k = 0; k < teeth; ++k) {
    const double a = k * pitch;
    add_arc(root, a - 0.20 * pitch, a + 0.20 * pitch, arc_steps);
    add_arc(outer, a + 0.36 * pitch, a + 0.64 * pitch, std::max(1, arc_steps / 2));
  }
  return refined(extrude_around_center(profile, bore, thickness), max_edge);
}

TriMesh star(int points, double outer, double inner, double thickness, double max_edge) {
  require_at_least("star", "points", points, 2);
  require_positive("star", "outer", outer);
  require_positive("star", "inner", inner);
  require_positive("star", "thickness", thickness);
  require_less("star", "inner", inner, "outer", outer);
  std::vector<XY> profile;
  for (int k = 0; k < 2 * points; ++k) {
    const double a = pi * k / points, radius = k % 2 == 0 ? outer : inner;
    profile.push_back({radius * std::cos(a), radius * std::sin(a)});
  }
  return refined(extrude_around_center(profile, 0.0, thickness), max_edge);
}

TriMesh blob(std::uint64_t seed, double radius, int level) {
  TriMesh mesh = icosphere(1.0, level);
  require_positive("blob", "radius", radius);
  Random random{seed};
  struct Lump {
    Vec3 direction;
    double height, sharpness;
  };
  std::vector<Lump> lumps(10);
  for (Lump& l : lumps) {
    const double z = 2.0 * random() - 1.0, a = 2.0 * pi * random(), s = std::sqrt(std::max(0.0, 1.0 - z * z));
    l.direction = {s * std::cos(a), s * std::sin(a), z};
    l.height = -0.3 + 0.75 * random();
    l.sharpness = 4.0 + 8.0 * random();
  }
  for (Vec3& x : mesh.vertices) {
    double swell = 0.0;
    for (const Lump& l : lumps) swell += l.height * std::exp(l.sharpness * (l.direction.dot(x) - 1.0));
    // The exponential keeps the radius positive whatever the lumps add up to.
    x *= radius * std::exp(std::tanh(swell));
  }
  return mesh;
}

TriMesh bowl(double radius, double thickness, int around) {
  require_positive("bowl", "radius", radius);
  require_positive("bowl", "thickness", thickness);
  require_less("bowl", "thickness", thickness, "radius", radius);
  require_at_least("bowl", "around", around, 4);
  std::vector<RZ> profile;
  const int quarter = std::max(2, around / 4);
  const double middle = radius - 0.5 * thickness;
  arc(profile, 0.0, 0.0, radius, -0.5 * pi, 0.0, quarter);
  const int rim = std::max(6, around / 16);
  for (int i = 1; i < rim; ++i) {
    const double a = pi * i / rim;
    profile.push_back({middle + 0.5 * thickness * std::cos(a), 0.5 * thickness * std::sin(a)});
  }
  arc(profile, 0.0, 0.0, radius - thickness, 0.0, -0.5 * pi, quarter);
  return revolve(profile, around);
}

TriMesh cup(double radius, double height, double thickness, int around, double max_edge) {
  require_positive("cup", "radius", radius);
  require_positive("cup", "height", height);
  require_positive("cup", "thickness", thickness);
  require_less("cup", "thickness", thickness, "radius", radius);
  require_less("cup", "thickness", thickness, "height", height);
  require_at_least("cup", "around", around, 3);
  const double inner = radius - thickness;
  return refined(
      revolve({{0.0, 0.0}, {radius, 0.0}, {radius, height}, {inner, height}, {inner, thickness}, {0.0, thickness}},
              around),
      max_edge);
}

TriMesh l_profile(double leg_x, double leg_y, double width, double length, double max_edge) {
  require_positive("l_profile", "width", width);
  require_positive("l_profile", "length", length);
  require_less("l_profile", "width", width, "leg_x", leg_x);
  require_less("l_profile", "width", width, "leg_y", leg_y);
  return refined(
      extrude_polygon({{0, 0}, {leg_x, 0}, {leg_x, width}, {width, width}, {width, leg_y}, {0, leg_y}}, length),
      max_edge);
}

TriMesh u_profile(double outer, double height, double thickness, double length, double max_edge) {
  require_positive("u_profile", "thickness", thickness);
  require_positive("u_profile", "length", length);
  require_less("u_profile", "thickness", thickness, "half of outer", 0.5 * outer);
  require_less("u_profile", "thickness", thickness, "height", height);
  const double a = 0.5 * outer, b = a - thickness;
  return refined(
      extrude_polygon(
          {{-a, 0}, {a, 0}, {a, height}, {b, height}, {b, thickness}, {-b, thickness}, {-b, height}, {-a, height}},
          length),
      max_edge);
}

TriMesh grid(int nx, int ny, double lx, double ly) {
  require_at_least("grid", "nx", nx, 1);
  require_at_least("grid", "ny", ny, 1);
  require_positive("grid", "lx", lx);
  require_positive("grid", "ly", ly);
  TriMesh mesh;
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i)
      mesh.vertices.emplace_back(lx * (double(i) / nx - 0.5), ly * (double(j) / ny - 0.5), 0.0);
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const std::int32_t a = j * (nx + 1) + i, b = a + 1, c = b + nx + 1, d = c - 1;
      if ((i + j) % 2 == 0) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
      } else {
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({b, c, d});
      }
    }
  return mesh;
}

}  // namespace brim::shapes
