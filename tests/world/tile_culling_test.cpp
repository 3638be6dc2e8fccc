#include "brim/world/tile_culling.h"

#include <gtest/gtest.h>

#include <bit>
#include <numbers>
#include <random>

#include "brim/body/posed_shape.h"
#include "brim/math/ramp.h"
#include "brim/mesh/distance_grid.h"
#include "brim/mesh/primitives.h"
#include "brim/raster/grid_shape.h"
#include "support/detect.h"

namespace brim::tile_culling_test {
namespace {

constexpr double kStep = 0.1;

class Bounded final : public DistanceBound {
 public:
  explicit Bounded(std::shared_ptr<const Shape> shape) : solid(std::move(shape), {}) {}
  double distance_bound(int, const Vec3& x) const override { return solid.distance_bound(x); }
  PosedShape solid;
};

ContactPair pair_with(double margin) { return {0, 1, kStep, 3 * kStep, margin, 0, 0}; }

/// The contacts of a tile, by filling both blocks there where they are wanted.
ContactSet contacts_of(const Bounded& a, const Bounded& b, const ContactPair& pair, const TileKey& tile,
                       Octants octants) {
  DensityBlock of_a, of_b;
  // What is not wanted may hold anything before.
  for (DensityBlock* block : {&of_a, &of_b})
    std::fill(std::begin(block->rho), std::end(block->rho), 0.7), block->octants = octants;
  a.solid.rasterize(pair.h, pair.w, {&tile, 1}, {&of_a, 1});
  b.solid.rasterize(pair.h, pair.w, {&tile, 1}, {&of_b, 1});
  ContactSet set;
  set.pairs = {pair};
  const testing::PairTile both{0, tile, &of_a, &of_b, octants};
  testing::detect({&both, 1}, set);
  return set;
}

TEST(TileRoom, TwoBallsThatTouchInTheTileHaveRoomAndTwoFarApartHaveNone) {
  Bounded a(make_sphere(1.0)), b(make_sphere(1.0));
  const TileKey tile{0, 0, 0};  // nodes from 0 to 0.7
  a.solid.place({Mat3::Identity(), {-0.7, 0.3, 0.3}});
  b.solid.place({Mat3::Identity(), {1.28, 0.3, 0.3}});
  EXPECT_TRUE(octants_with_room({&a, 0}, {&b, 0}, pair_with(0.1), tile));
  // A gap of 0.4 m: each ball still has density in the tile, but no node has enough of both.
  b.solid.place({Mat3::Identity(), {1.7, 0.3, 0.3}});
  EXPECT_FALSE(octants_with_room({&a, 0}, {&b, 0}, pair_with(0.1), tile));
}

TEST(TileRoom, NoTileWithAContactIsRuledOutForRandomPlacesOfBoxesBallsAndSampledRings) {
  constexpr unsigned kSeed = 20260103;
  SCOPED_TRACE(::testing::Message() << "seed " << kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> in(-1.0, 1.0);
  const auto ring = [] {
    DistanceGridOptions options;
    options.spacing = kStep;
    return make_grid_shape(std::make_shared<DistanceGrid>(make_distance_grid(shapes::torus(0.8, 0.3, 48, 24), options)),
                           0.6);
  }();
  Bounded bodies[] = {Bounded(make_box({1.1, 0.9, 0.5})), Bounded(make_sphere(0.6)), Bounded(ring)};
  int with = 0, without = 0, kept = 0, octants = 0, tiles = 0;
  for (int trial = 0; trial < 400; ++trial) {
    Bounded &a = bodies[trial % 3], b = bodies[(trial / 3) % 3];
    for (Bounded* body : {&a, &b}) {
      const Vec3 axis = Vec3(in(random), in(random), in(random)).normalized();
      body->solid.place({Eigen::AngleAxisd(std::numbers::pi * in(random), axis).toRotationMatrix(),
                         Vec3(in(random), in(random), in(random)) + Vec3::Constant(0.35)});
    }
    const ContactPair pair = pair_with(0.2 * (1.0 + in(random)));
    const TileKey tile{0, 0, 0};
    const Octants room = octants_with_room({&a, 0}, {&b, 0}, pair, tile);
    const ContactSet all = contacts_of(a, b, pair, tile, kAllOctants), found = contacts_of(a, b, pair, tile, room);
    const bool contact = all.size() + static_cast<std::size_t>(all.engulfed) > 0;
    EXPECT_EQ(found.node, all.node) << "trial " << trial;
    EXPECT_EQ(found.depth, all.depth) << "trial " << trial;
    EXPECT_EQ(found.gradient_a, all.gradient_a) << "trial " << trial;
    EXPECT_EQ(found.engulfed, all.engulfed) << "trial " << trial;
    octants += std::popcount(room), tiles += room != 0;
    (contact ? with : without) += 1;
    kept += room != 0 && !contact;
    EXPECT_TRUE(room != 0 || !contact) << "trial " << trial;
  }
  EXPECT_GT(with, 50);
  EXPECT_GT(without, 50);
  EXPECT_LT(kept, without / 2) << "most tiles without a contact are ruled out";
  EXPECT_LT(octants, 5 * tiles) << "and most octants of the others";
}

TEST(TileRoom, BesideAPartWithoutBoundsTheOtherMustReachIntoTheOctant) {
  Bounded ball(make_sphere(0.1));
  const ContactPair pair = pair_with(0.4);  // ramps reach 0.15 m beyond the surface
  const TileKey tile{0, 0, 0};              // nodes from 0 to 0.7
  ball.solid.place({Mat3::Identity(), {0.1, 0.1, 0.1}});
  EXPECT_EQ(octants_with_room({&ball, 0}, {}, pair, tile), 1);
  EXPECT_EQ(octants_with_room({}, {&ball, 0}, pair, tile), 1);
  ball.solid.place({Mat3::Identity(), {-0.3, 0.1, 0.1}});
  EXPECT_EQ(octants_with_room({&ball, 0}, {}, pair, tile), 0);
  ball.solid.place({Mat3::Identity(), {0.35, 0.35, 0.35}});  // amid the tile
  EXPECT_EQ(octants_with_room({&ball, 0}, {}, pair, tile), kAllOctants);
  EXPECT_EQ(octants_with_room({}, {}, pair, tile), kAllOctants);
}

TEST(TileRoom, APartThatKnowsNoBoundIsNeverRuledOut) {
  class Unknown final : public DistanceBound {
    double distance_bound(int, const Vec3&) const override { return -std::numeric_limits<double>::infinity(); }
  } unknown;
  Bounded far(make_sphere(0.1));
  far.solid.place({Mat3::Identity(), {50.0, 0.0, 0.0}});
  EXPECT_TRUE(octants_with_room({&far, 0}, {&unknown, 0}, pair_with(0.4), {0, 0, 0}));
}

}  // namespace
}  // namespace brim::tile_culling_test
