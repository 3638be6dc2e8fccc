#include "brim/raster/polyhedron_distances.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "brim/core/simd.h"
#include "brim/math/wide_vectors.h"

namespace brim {

namespace {

BRIM_INLINE double root_of(double x) { return std::sqrt(x); }
BRIM_INLINE CubeRow root_of(const CubeRow& x) { return wide_root(x); }
BRIM_INLINE Lanes root_of(const Lanes& x) {
  Lanes r;
  for (int i = 0; i < kLanes; ++i) r[i] = std::sqrt(x[i]);
  return r;
}
BRIM_INLINE bool any_positive(double x) { return x > 0.0; }
BRIM_INLINE bool any_positive(const CubeRow& x) { return bits_of(x > 0.0f) != 0; }
BRIM_INLINE bool any_positive(const Lanes& x) { return x[0] > 0.0 || x[1] > 0.0 || x[2] > 0.0 || x[3] > 0.0; }

template <class Number, class T>
BRIM_INLINE Number along(const std::array<T, 3>& n, const Number& x, const Number& y, const Number& z) {
  return n[0] * x + (n[1] * y + n[2] * z);
}

std::size_t index(int i) { return static_cast<std::size_t>(i); }

}  // namespace

template <class T>
PolyhedronDistances::Features<T> PolyhedronDistances::features_of(const ConvexPolyhedron& solid) {
  const auto rounded = [](const Vec3& v) {
    return std::array<T, 3>{static_cast<T>(v[0]), static_cast<T>(v[1]), static_cast<T>(v[2])};
  };
  // Between faces that turn by less than 2 degrees the separation from the larger one is right to 2e-4, and that from
  // the edge would be rounding.
  constexpr double kTooBlunt = 0.9994;
  Features<T> out;
  for (const auto& f : solid.faces) out.normals.push_back(rounded(f.normal));
  for (const auto& e : solid.edges)
    out.edges.push_back({rounded(e.along), e.faces[0], e.faces[1], static_cast<T>(e.cosine),
                         static_cast<T>(e.cosine > kTooBlunt ? 0.0 : 1.0 / (1.0 - e.cosine * e.cosine)),
                         static_cast<T>(0.5 * e.length)});
  return out;
}

template <class T>
void PolyhedronDistances::find_origin(const Vec3& p, Origin<T>& origin) const {
  for (std::size_t f = 0; f < solid_.faces.size(); ++f)
    origin.faces[f] = static_cast<T>(solid_.faces[f].normal.dot(p) - solid_.faces[f].offset);
  for (std::size_t e = 0; e < solid_.edges.size(); ++e) {
    const auto& edge = solid_.edges[e];
    const Vec3 middle = 0.5 * (solid_.corners[index(edge.corners[0])] + solid_.corners[index(edge.corners[1])]);
    origin.edges[e] = static_cast<T>(edge.along.dot(p - middle));
  }
  for (std::size_t c = 0; c < solid_.corners.size(); ++c) {
    const Vec3 from = p - solid_.corners[c];
    for (int r = 0; r < 3; ++r) origin.corners[c][index(r)] = static_cast<T>(from[r]);
  }
}

template <class Number, class T>
BRIM_INLINE Number PolyhedronDistances::value(const Features<T>& features, const Origin<T>& origin, const Number& x,
                                              const Number& y, const Number& z) const {
  Number apart[ConvexPolyhedron::kMostFaces], place[ConvexPolyhedron::kMostEdges];
  const std::size_t faces = features.normals.size(), edges = features.edges.size();
  Number most = apart[0] = along(features.normals[0], x, y, z) + origin.faces[0];
  for (std::size_t f = 1; f < faces; ++f) {
    apart[f] = along(features.normals[f], x, y, z) + origin.faces[f];
    most = apart[f] > most ? apart[f] : most;
  }
  if (!any_positive(most)) return most;
  // Squares of the separations from edges and corners.
  Number square = most * most;
  for (std::size_t e = 0; e < edges; ++e) {
    const auto& edge = features.edges[e];
    const Number s = apart[edge.f], t = apart[edge.g], u = t - edge.cosine * s, v = s - edge.cosine * t,
                 line = (s * v + t * u) * edge.scale;
    square = ((u > T{0}) & (v > T{0}) & (line > square)) ? line : square;
    place[e] = along(edge.along, x, y, z) + origin.edges[e];
  }
  for (std::size_t c = 0; c < solid_.corners.size(); ++c) {
    const auto& from = origin.corners[c];
    const Number dx = x + from[0], dy = y + from[1], dz = z + from[2], length = dx * dx + (dy * dy + dz * dz);
    auto behind = length > square;
    for (int k = first_spoke_[c]; k < first_spoke_[c + 1]; ++k) {
      const Spoke& spoke = spokes_[index(k)];
      const Number& way = place[spoke.edge];
      const T half = features.edges[index(spoke.edge)].half;
      behind = behind & (spoke.second ? way >= half : way <= -half);
    }
    square = behind ? length : square;
  }
  return most > T{0} ? root_of(square) : most;
}

PolyhedronDistances::PolyhedronDistances(ConvexPolyhedron solid)
    : solid_(std::move(solid)), fine_(features_of<double>(solid_)), coarse_(features_of<float>(solid_)) {
  find_origin(Vec3::Zero(), origin_);
  first_spoke_.push_back(0);
  for (int c = 0; c < static_cast<int>(solid_.corners.size()); ++c) {
    for (std::size_t e = 0; e < solid_.edges.size(); ++e)
      for (const int end : {0, 1})
        if (solid_.edges[e].corners[index(end)] == c) spokes_.push_back({static_cast<int>(e), end == 1});
    first_spoke_.push_back(static_cast<int>(spokes_.size()));
  }
}

double PolyhedronDistances::operator()(const Vec3& p) const { return value<double>(fine_, origin_, p[0], p[1], p[2]); }

double PolyhedronDistances::operator()(const Vec3& p, Vec3& gradient) const {
  double most = -std::numeric_limits<double>::infinity();
  std::array<double, ConvexPolyhedron::kMostFaces> apart;
  for (std::size_t f = 0; f < solid_.faces.size(); ++f) {
    apart[f] = solid_.faces[f].normal.dot(p) - solid_.faces[f].offset;
    if (apart[f] > most) most = apart[f], gradient = solid_.faces[f].normal;
  }
  if (most <= 0.0) return most;
  double square = most * most;
  for (const auto& edge : fine_.edges) {
    const double s = apart[index(edge.f)], t = apart[index(edge.g)], u = t - edge.cosine * s, v = s - edge.cosine * t,
                 line = (s * v + t * u) * edge.scale;
    if (!(u > 0.0 && v > 0.0 && line > square)) continue;
    square = line;
    gradient = edge.scale * (v * solid_.faces[index(edge.f)].normal + u * solid_.faces[index(edge.g)].normal);
  }
  for (std::size_t c = 0; c < solid_.corners.size(); ++c) {
    const Vec3 from = p - solid_.corners[c];
    if (!(from.squaredNorm() > square)) continue;
    bool behind = true;
    for (int k = first_spoke_[c]; behind && k < first_spoke_[c + 1]; ++k) {
      const Spoke& spoke = spokes_[index(k)];
      const double way = solid_.edges[index(spoke.edge)].along.dot(from);
      behind = spoke.second ? way >= 0.0 : way <= 0.0;
    }
    if (behind) square = from.squaredNorm(), gradient = from;
  }
  const double d = std::sqrt(square);
  gradient.normalize();
  return d;
}

BRIM_WIDE void PolyhedronDistances::at(const PlaceArrays& places, double* d) const {
  int i = 0;
  for (; i + kLanes <= places.count; i += kLanes) {
    const Lanes r =
        value<Lanes>(fine_, origin_, load_lanes(places.x + i), load_lanes(places.y + i), load_lanes(places.z + i));
    store_lanes(d + i, r);
  }
  for (; i < places.count; ++i) d[i] = value<double>(fine_, origin_, places.x[i], places.y[i], places.z[i]);
}

BRIM_WIDE void PolyhedronDistances::at(const CubeFrame& frame, const NodeMask& wanted, float* d) const {
  Origin<float> origin;
  find_origin(frame.base, origin);
  const Vec3f dx = frame.dx.cast<float>(), dy = frame.dy.cast<float>(), dz = frame.dz.cast<float>();
  const CubeRow steps = {0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f};
  for (int k = 0; k < kCubeSize; ++k)
    for (int j = 0; j < kCubeSize; ++j) {
      if (wanted.row(j, k) == 0) continue;
      const float fj = static_cast<float>(j), fk = static_cast<float>(k);
      const CubeRow x = dx[0] * steps + (fj * dy[0] + fk * dz[0]), y = dx[1] * steps + (fj * dy[1] + fk * dz[1]),
                    z = dx[2] * steps + (fj * dy[2] + fk * dz[2]);
      const CubeRow row = value<CubeRow>(coarse_, origin, x, y, z);
      std::memcpy(d + cube_index(0, j, k), &row, sizeof row);
    }
}

}  // namespace brim
