#include "brim/body/particles/body_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "brim/body/particles/line_contact.h"
#include "brim/body/particles/sheet_contact.h"
#include "brim/core/error.h"
#include "brim/mesh/primitives.h"
#include "support/soft_worlds.h"

namespace brim::body_pieces_test {
namespace {

constexpr double kThickness = 0.1, kStep = 0.05, kRamp = 0.15;

PartInfo part() {
  PartInfo p;
  p.voxel_size = kStep, p.thickness = kThickness;
  return p;
}

/// A strip of 2 x 0.4 m.
TriMesh strip() { return shapes::grid(40, 8, 2.0, 0.4); }

/// The strip bent to a part of a circle by an angle, [rad].
std::vector<Vec3> bent(const TriMesh& mesh, double angle) {
  std::vector<Vec3> x = mesh.vertices;
  if (angle == 0.0) return x;
  const double r = 2.0 / angle;
  for (Vec3& v : x) v = Vec3(r * std::sin(v.x() / r), v.y(), r * (1.0 - std::cos(v.x() / r)));
  return x;
}

bool any_meet(const BodyPieces& pieces) {
  for (int p = 0; p < pieces.part_count(); ++p)
    for (int q = 0; q < p; ++q)
      if (pieces.parts_collide(p, q) && pieces.bounds(p).overlaps(pieces.bounds(q))) return true;
  return false;
}

TEST(BodyPieces, TogetherTheyHaveTheDensityOfTheWhole) {
  const TriMesh mesh = strip();
  const SheetContact whole(mesh.triangles, kThickness);
  BodyPieces pieces(mesh.vertices, whole, part());
  const std::vector<Vec3> x = bent(mesh, 2.0);
  pieces.follow(x);
  std::vector<TileKey> tiles;
  whole.presence(x, kStep, kRamp, Aabb{Vec3::Constant(-10.0), Vec3::Constant(10.0)}, tiles);
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  ASSERT_GT(tiles.size(), 4u);
  std::vector<DensityBlock> of_whole(tiles.size()), of_piece(tiles.size());
  for (DensityBlock& b : of_whole) b.octants = kAllOctants;
  whole.rasterize(x, kStep, kRamp, tiles, of_whole);
  std::vector<std::vector<float>> most(tiles.size(), std::vector<float>(kBlockNodes, 0.0f));
  std::size_t full = 0;
  for (int p = 0; p < pieces.part_count(); ++p) {
    for (DensityBlock& b : of_piece) b = {}, b.octants = kAllOctants;
    pieces.rasterize(p, kStep, kRamp, tiles, of_piece);
    for (std::size_t t = 0; t < tiles.size(); ++t)
      for (int i = 0; i < kBlockNodes; ++i) {
        const float rho = of_piece[t].rho[i];
        most[t][i] = std::max(most[t][i], rho);
        if (rho == 0.0f) continue;
        // Its source names the triangle of the whole, which one piece says.
        const std::int32_t e = pieces.source_of(p, of_piece[t].source[i]);
        ASSERT_LT(e, static_cast<std::int32_t>(mesh.triangles.size()));
        if (e < 0 || e != of_whole[t].source[i]) continue;
        EXPECT_EQ(rho, of_whole[t].rho[i]);
        ++full;
      }
  }
  std::size_t nodes = 0;
  for (std::size_t t = 0; t < tiles.size(); ++t)
    for (int i = 0; i < kBlockNodes; ++i) {
      EXPECT_NEAR(most[t][i], of_whole[t].rho[i], 1e-6);
      nodes += of_whole[t].rho[i] > 0.0f;
    }
  EXPECT_LE(full, nodes);
  EXPECT_GT(full, 9 * nodes / 10) << "other triangles are as near here and there";
}

TEST(BodyPieces, NothingMeetsBeforeTheBodyComesBackToItself) {
  const TriMesh mesh = strip();
  const SheetContact whole(mesh.triangles, kThickness);
  BodyPieces pieces(mesh.vertices, whole, part());
  for (const double angle : {0.0, 1.0, 2.0, 4.0}) {
    const std::vector<Vec3> x = bent(mesh, angle);
    pieces.follow(x);
    EXPECT_FALSE(any_meet(pieces)) << angle;
  }
  // The ends of a whole circle are at one place.
  const std::vector<Vec3> x = bent(mesh, 2.0 * std::numbers::pi);
  pieces.follow(x);
  EXPECT_TRUE(any_meet(pieces));
}

/// A sheet in a zigzag: it turns by 130° at each line of its grid.
std::vector<Vec3> creased(const TriMesh& mesh, double cell) {
  constexpr double kSlope = 65.0 / 180.0 * std::numbers::pi;
  std::vector<Vec3> x = mesh.vertices;
  for (Vec3& v : x) {
    const double s = v.x() / cell, down = std::abs(s - 2.0 * std::round(0.5 * s));  // 0 to 1
    v = Vec3(std::cos(kSlope) * v.x(), v.y(), std::sin(kSlope) * cell * down);
  }
  return x;
}

TEST(BodyPieces, CreasesOfCoarseCellsMeetNowhere) {
  const double cell = 3.3 * kThickness;
  const TriMesh mesh = shapes::grid(12, 6, 12 * cell, 6 * cell);
  const SheetContact whole(mesh.triangles, kThickness);
  BodyPieces pieces(mesh.vertices, whole, part());
  const std::vector<Vec3> x = creased(mesh, cell);
  pieces.follow(x);
  std::size_t near = 0;
  for (int p = 0; p < pieces.part_count(); ++p)
    for (int q = 0; q < p; ++q) {
      if (!pieces.parts_collide(p, q)) continue;
      near += pieces.bounds(p).overlaps(pieces.bounds(q));
      EXPECT_TRUE(pieces.meeting_region(p, q, 0.5 * kRamp, 0.3 * kRamp).empty()) << p << " " << q;
    }
  EXPECT_GT(near, 300u) << "neither boxes nor directions tell them apart";
}

TEST(BodyPieces, AllPlacesOfContactAreInTheRegion) {
  // A crumpled sheet; every node at which two pieces sum to 1 by elements of their own that may touch.
  constexpr double kGap = 0.3 * kRamp;
  for (const double cell : {0.35, 0.12}) {
    const TriMesh mesh = shapes::grid(static_cast<int>(std::lround(2.8 / cell)), 4, 2.8, 4 * cell);
    const SheetContact whole(mesh.triangles, kThickness);
    BodyPieces pieces(mesh.vertices, whole, part());
    std::vector<Vec3> x = mesh.vertices;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0.0, 0.3 * cell);
    for (Vec3& v : x) {
      v = Vec3(0.6 * std::sin(2.5 * v.x()), 0.6 * v.y(), 0.3 * std::cos(2.5 * v.x()) + 0.2 * v.y());
      for (double& c : v) c += unit(random);
    }
    pieces.follow(x);
    std::vector<TileKey> tiles;
    whole.presence(x, kStep, kRamp, Aabb{Vec3::Constant(-10.0), Vec3::Constant(10.0)}, tiles);
    sort_unique(tiles);
    const int n = pieces.part_count();
    std::vector<std::vector<DensityBlock>> of(n, std::vector<DensityBlock>(tiles.size()));
    for (int p = 0; p < n; ++p) pieces.rasterize(p, kStep, kRamp, tiles, of[p]);
    std::size_t found = 0;
    for (std::size_t t = 0; t < tiles.size(); ++t)
      for (int k = 0; k < kTileSize; ++k)
        for (int j = 0; j < kTileSize; ++j)
          for (int i = 0; i < kTileSize; ++i) {
            const int node = block_index(i + kHalo, j + kHalo, k + kHalo);
            const int octant = i / 4 + 2 * (j / 4) + 4 * (k / 4);
            const Vec3 place = tile_box(tiles[t], kStep).lo + kStep * Vec3(i, j, k);
            const auto own = [&](int p) {
              const DensityBlock& b = of[p][t];
              return b.rho[node] > 0.0 ? pieces.source_of(p, b.source[node]) : -1;
            };
            for (int p = 0; p < n; ++p) {
              if (own(p) < 0) continue;
              for (int q = 0; q < p; ++q) {
                if (own(q) < 0 || of[p][t].rho[node] + of[q][t].rho[node] <= 1.0 || !pieces.may_meet(own(p), own(q)))
                  continue;
                if (!pieces.parts_collide(p, q)) continue;  // neighbours that are nearly flat
                ++found;
                const Aabb region = pieces.meeting_region(p, q, 0.5 * kRamp + 1e-6, kGap);
                EXPECT_TRUE(region.overlaps(Aabb{place, place})) << p << " " << q;
                EXPECT_TRUE((of[p][t].octants & of[q][t].octants) >> octant & 1) << p << " " << q;
              }
            }
          }
    EXPECT_GT(found, 100u) << cell;
  }
}

TEST(BodyPieces, ALineThatTurnsBackMeetsItself) {
  std::vector<Vec3> rest, back;
  std::vector<LineContact::Segment> segments;
  for (int i = 0; i <= 40; ++i) {
    rest.emplace_back(0.05 * i, 0.0, 0.0);
    back.emplace_back(0.05 * std::min(i, 40 - i), i <= 20 ? 0.0 : 0.04, 0.0);
  }
  for (int i = 0; i < 40; ++i) segments.push_back({i, i + 1});
  const LineContact whole(segments, 0.5 * kThickness);
  BodyPieces pieces(rest, whole, part());
  EXPECT_FALSE(any_meet(pieces));
  pieces.follow(back);
  EXPECT_TRUE(any_meet(pieces));
  EXPECT_FALSE(pieces.may_meet(3, 4));
  EXPECT_TRUE(pieces.may_meet(3, 36));
}

TEST(BodyPieces, SpeedsAreThoseOfTheirParticles) {
  const TriMesh mesh = strip();
  const SheetContact whole(mesh.triangles, kThickness);
  const BodyPieces pieces(mesh.vertices, whole, part());
  std::vector<double> v;
  for (const Vec3& x : mesh.vertices) v.insert(v.end(), {3.0 * x.x(), 0.0, 1.0});
  for (int p = 0; p < pieces.part_count(); ++p) {
    // A particle at one side of the box has 3 m/s a metre more than one at the other.
    const double low = pieces.bounds(p).lo.x() + 0.5 * kThickness, high = pieces.bounds(p).hi.x() - 0.5 * kThickness;
    const Vec3 mean = pieces.mean_velocity(p, v);
    EXPECT_NEAR(mean.z(), 1.0, 1e-12);
    EXPECT_GT(mean.x(), 3.0 * low);
    EXPECT_LT(mean.x(), 3.0 * high);
    EXPECT_NEAR(pieces.relative_speed_bound(p, v), std::max(3.0 * high - mean.x(), mean.x() - 3.0 * low), 1e-9);
  }
}

TEST(BodyPieces, SolidsAndFreeParticlesAreRefused) {
  FemOptions o;
  o.self_contact = true;
  EXPECT_THROW(FemBody(testing::block_at(2, 0.5, Vec3::Zero()), o), InputError);
}

}  // namespace
}  // namespace brim::body_pieces_test
