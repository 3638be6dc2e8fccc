#pragma once

#include <array>
#include <vector>

#include "brim/mesh/convex_polyhedron.h"
#include "brim/raster/cube_distances.h"
#include "brim/raster/place_distances.h"

namespace brim {

/// Signed distance to a convex polyhedron: the largest separation along any direction m,
///   d(p) = max over m of m · p − max over x in the solid of m · x
/// Candidates are the normals of faces; the direction from an edge, for places whose separations s_f, s_g from its two
/// faces let it lie between their normals; and that from a corner, for places behind it along all its edges. With c the
/// cosine between the two normals, u = s_g − c s_f and v = s_f − c s_g, an edge counts where u, v > 0, and its
/// separation is sqrt((s_f v + s_g u) / (1 − c²)). Inside only faces count. Edges whose faces turn by less than 2
/// degrees are left out: the distance beside them is up to 2e-4 of itself too small. Tests:
/// tests/raster/polyhedron_distances_test.cpp
class PolyhedronDistances {
 public:
  explicit PolyhedronDistances(ConvexPolyhedron solid);
  const ConvexPolyhedron& solid() const { return solid_; }

  /// @param p  [m] @return [m]
  double operator()(const Vec3& p) const;
  /// The same, with the unit vector away from the surface.
  double operator()(const Vec3& p, Vec3& gradient) const;
  /// The same bits at many places, four at a time.
  void at(const PlaceArrays& places, double* d) const;
  /// Distances at all nodes of the rows that contain a wanted one, eight at a time in single precision.
  void at(const CubeFrame& frame, const NodeMask& wanted, float* d) const;

 private:
  /// Faces and edges in one precision.
  template <class T>
  struct Features {
    struct Edge {
      std::array<T, 3> along;
      int f, g;
      T cosine, scale, half;  ///< c, 1 / (1 − c²), half of the length
    };
    std::vector<std::array<T, 3>> normals;
    std::vector<Edge> edges;
  };
  /// Where the origin of places lies: its separations from the faces, its place along each edge from the middle, and
  /// the vector to it from each corner.
  template <class T>
  struct Origin {
    std::array<T, ConvexPolyhedron::kMostFaces> faces;
    std::array<T, ConvexPolyhedron::kMostEdges> edges;
    std::array<std::array<T, 3>, ConvexPolyhedron::kMostCorners> corners;
  };
  /// An edge at a corner: its second end or its first.
  struct Spoke {
    int edge;
    bool second;
  };
  template <class T>
  static Features<T> features_of(const ConvexPolyhedron& solid);
  template <class T>
  void find_origin(const Vec3& p, Origin<T>& origin) const;
  template <class Number, class T>
  Number value(const Features<T>& features, const Origin<T>& origin, const Number& x, const Number& y,
               const Number& z) const;

  ConvexPolyhedron solid_;
  Features<double> fine_;
  Features<float> coarse_;
  Origin<double> origin_;
  std::vector<Spoke> spokes_;     ///< of one corner after the other
  std::vector<int> first_spoke_;  ///< size corners + 1
};

}  // namespace brim
