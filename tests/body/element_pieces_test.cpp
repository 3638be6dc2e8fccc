#include "brim/body/particles/element_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "brim/body/particles/line_contact.h"
#include "brim/body/particles/sheet_contact.h"
#include "brim/mesh/primitives.h"

namespace brim::element_pieces_test {
namespace {

/// Segments of a given length along x.
LineContact line(int segments, double length, std::vector<Vec3>& x) {
  std::vector<LineContact::Segment> s;
  for (int i = 0; i <= segments; ++i) x.emplace_back(length * i, 0.0, 0.0);
  for (int i = 0; i < segments; ++i) s.push_back({i, i + 1});
  return LineContact(s, 0.05);
}

TEST(ElementPieces, EachElementIsInOnePieceThatReachesNoFartherThanItMay) {
  const TriMesh mesh = shapes::grid(20, 12, 2.0, 1.2);
  const SheetContact sheet(mesh.triangles, 0.1);
  const double reach = 0.35;
  const ElementPieces pieces(mesh.vertices, sheet.elements(), {reach, 0.2, 0.1});
  std::vector<int> times(mesh.triangles.size(), 0);
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    Aabb box;
    for (const std::int32_t e : pieces.of(p)) {
      ++times[e];
      for (const std::int32_t i : mesh.triangles[e]) box.extend(mesh.vertices[i]);
    }
    EXPECT_LT(box.extent().maxCoeff(), 2.0 * (reach + 0.1));
  }
  for (const int t : times) EXPECT_EQ(t, 1);
  EXPECT_GT(pieces.size(), 6u);
  EXPECT_LT(pieces.size(), 60u);
}

TEST(ElementPieces, BesideIsWhatLessOfALineLiesBetween) {
  std::vector<Vec3> x;
  const LineContact contact = line(30, 0.1, x);
  const ElementPieces pieces(x, contact.elements(), {0.4, 0.25, 0.15});
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j)
      // |i − j| − 1 segments lie between two that are not the same.
      EXPECT_EQ(pieces.elements_beside(i, j), 0.1 * (std::abs(i - j) - 1) < 0.25) << i << " " << j;
  std::vector<std::size_t> of(30);
  for (std::size_t p = 0; p < pieces.size(); ++p)
    for (const std::int32_t e : pieces.of(p)) of[e] = p;
  for (std::size_t p = 0; p < pieces.size(); ++p)
    for (std::size_t q = 0; q < pieces.size(); ++q) {
      std::size_t beside = 0;
      for (int i = 0; i < 30; ++i)
        for (int j = 0; j < 30; ++j) beside += p != q && of[i] == p && of[j] == q && pieces.elements_beside(i, j);
      using enum ElementPieces::Beside;
      EXPECT_EQ(pieces.pieces_beside(static_cast<std::int32_t>(p), static_cast<std::int32_t>(q)),
                beside == 0                                           ? None
                : beside == pieces.of(p).size() * pieces.of(q).size() ? All
                                                                      : Some);
    }
  for (std::size_t p = 0; p < pieces.size(); ++p)
    for (int j = 0; j < 30; ++j) {
      bool around = false;
      for (const std::int32_t i : pieces.of(p)) around = around || (of[j] != p && 0.1 * (std::abs(i - j) - 1) < 0.15);
      EXPECT_EQ(std::ranges::count(pieces.border(p), j), around);
    }
}

TEST(ElementPieces, CoarseCellsAreBesideTheirNeighboursAltogether) {
  // Cells of five reaches: each triangle is a piece.
  const TriMesh mesh = shapes::grid(6, 5, 6.0, 5.0);
  const SheetContact sheet(mesh.triangles, 0.1);
  const ElementPieces pieces(mesh.vertices, sheet.elements(), {0.2, 0.3, 0.1});
  ASSERT_EQ(pieces.size(), mesh.triangles.size());
  for (std::int32_t p = 0; p < static_cast<std::int32_t>(pieces.size()); ++p)
    for (std::int32_t q = 0; q < p; ++q) {
      const bool beside = pieces.elements_beside(p, q);
      EXPECT_EQ(pieces.pieces_beside(p, q), beside ? ElementPieces::Beside::All : ElementPieces::Beside::None);
    }
}

TEST(ElementPieces, WaysGoAlongTheBodyAndNotThroughSpace) {
  // Two layers of a folded sheet, 1 cm apart.
  TriMesh mesh = shapes::grid(40, 4, 4.0, 0.4);
  for (Vec3& v : mesh.vertices) v.x() += 2.0;
  for (Vec3& v : mesh.vertices)
    if (v.x() > 2.0) v = Vec3(4.0 - v.x(), v.y(), 0.01);
  const SheetContact sheet(mesh.triangles, 0.1);
  const ElementPieces pieces(mesh.vertices, sheet.elements(), {0.3, 0.3, 0.1});
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    double below = 0.0, above = 0.0;  // farthest from the fold
    for (const std::int32_t e : pieces.of(p))
      for (const std::int32_t i : mesh.triangles[e]) {
        const Vec3& v = mesh.vertices[i];
        (v.z() == 0.0 ? below : above) = std::max(v.z() == 0.0 ? below : above, 2.0 - v.x());
      }
    EXPECT_LT(std::min(below, above), 0.7) << "a piece has both layers far from the fold";
  }
  // The first triangles of the two ends lie upon each other.
  const std::int32_t last = 2 * 39;
  EXPECT_FALSE(pieces.elements_beside(0, last));
  EXPECT_TRUE(pieces.elements_beside(0, 2));
}

}  // namespace
}  // namespace brim::element_pieces_test
