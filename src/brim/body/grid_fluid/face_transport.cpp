#include "brim/body/grid_fluid/face_transport.h"

#include <algorithm>
#include <cmath>

namespace brim {

namespace {

constexpr unsigned char kUnknown = 0, kKnown = 1, kHeld = 2;

/// True for faces on the sides of the box.
bool on_side(const MacGrid& g, int a, const Vec3i& at) { return at[a] == 0 || at[a] == g.n[a]; }

/// Smallest and largest of the samples that a trilinear value comes from.
void range_at(const MacGrid& g, std::span<const double> u, int a, const Vec3& x, double& low, double& high) {
  const Vec3 s = (x - g.origin) / g.dx - g.face_offset(a);
  const Vec3i count = g.face_count(a);
  const SamplePlace X(s.x(), count.x()), Y(s.y(), count.y()), Z(s.z(), count.z());
  const int at = g.face(a, X.low, Y.low, Z.low);
  low = high = u[at];
  for (int c = 1; c < 8; ++c) {
    const double v = u[at + (c & 1) * X.step * g.face_stride(0) + ((c >> 1) & 1) * Y.step * g.face_stride(1) +
                       (c >> 2) * Z.step * g.face_stride(2)];
    low = std::min(low, v);
    high = std::max(high, v);
  }
}

Layers layers_with_mass(const MacGrid& g, std::span<const double> mass) {
  const int count = g.n.z() + 1;
  const std::size_t layer = mass.size() / static_cast<std::size_t>(count);
  Layers out{count, 0};
  for (int k = 0; k < count; ++k)
    if (std::ranges::any_of(mass.subspan(k * layer, layer), [](double m) { return m != 0.0; }))
      out = {std::min(out.begin, k), k + 1};
  return out;
}

/// [cells] farthest place that a value is interpolated at after a motion over dt, with its samples.
int reach(const MacGrid& g, std::span<const double> u, double dt) {
  double fastest = 0.0;
  for (const double x : u) fastest = std::max(fastest, std::abs(x));
  return static_cast<int>(std::min(std::ceil(fastest * dt / g.dx), double(g.n.z()))) + 1;
}

}  // namespace

void extend_velocity(const MacGrid& g, const WetFaces& wet, const std::array<bool, 6>& open, int layers,
                     std::span<double> u, ExtensionMarks& marks) {
  marks.known.assign(g.faces(), 0);
  const Layers near = wet.layers.grown_by(layers);
  for (int a = 0; a < 3; ++a)
    for_places(g.face_count(a), [&](int i, int j, int k) {
      const int f = g.face(a, i, j, k);
      const Vec3i at(i, j, k);
      const bool side = on_side(g, a, at), closed = side && !open[2 * a + (at[a] > 0 ? 1 : 0)];
      if (wet.kind[f] != WetFaces::Kind::Dry) marks.known[f] = kKnown;
      // A closed side holds the flow through it; it does not drag the faces in front of it.
      if (closed && wet.kind[f] == WetFaces::Kind::Dry) marks.known[f] = kHeld;
      if (closed || marks.known[f] != kKnown) u[f] = 0.0;
    });
  for (int layer = 0; layer < layers; ++layer) {
    marks.next = marks.known;
    for (int a = 0; a < 3; ++a) {
      const Vec3i count = g.face_count(a);
      for_places(count, near, [&](int i, int j, int k) {
        const int f = g.face(a, i, j, k);
        if (marks.known[f] != kUnknown) return;
        const std::array<int, 3> at = {i, j, k};
        double sum = 0.0;
        int found = 0;
        for (int b = 0; b < 3; ++b)
          for (const int side : {-1, 1}) {
            if (at[b] + side < 0 || at[b] + side >= count[b]) continue;
            const int other = f + side * g.face_stride(b);
            if (marks.known[other] != kKnown) continue;
            sum += u[other];
            ++found;
          }
        if (found == 0) return;
        u[f] = sum / found;
        marks.next[f] = kKnown;
      });
    }
    std::swap(marks.known, marks.next);
  }
}

void advect_velocity(const MacGrid& g, std::span<const double> u, std::span<const double> mass, double dt,
                     std::span<double> out) {
  std::vector<double> forth(g.faces(), 0.0);
  std::vector<Vec3> from(g.faces());
  // Faces of fluid ask no farther than it moves.
  const Layers asked = layers_with_mass(g, mass), answer = asked.grown_by(reach(g, u, dt));
  for (int a = 0; a < 3; ++a)
    for_places(g.face_count(a), answer, [&](int i, int j, int k) {
      const int f = g.face(a, i, j, k);
      from[f] = trace_back(g, u, g.face_position(a, i, j, k), dt);
      forth[f] = sample_face(g, u, a, from[f]);
    });
  std::fill(out.begin(), out.end(), 0.0);
  for (int a = 0; a < 3; ++a)
    for_places(g.face_count(a), asked, [&](int i, int j, int k) {
      const int f = g.face(a, i, j, k);
      if (mass[f] == 0.0) return;
      const double back = sample_face(g, forth, a, trace_back(g, u, g.face_position(a, i, j, k), -dt));
      double low, high;
      range_at(g, u, a, from[f], low, high);
      out[f] = std::clamp(forth[f] + 0.5 * (u[f] - back), low, high);
    });
}

}  // namespace brim
