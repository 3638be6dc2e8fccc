#include "brim/body/grid_fluid/face_map.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::face_map_test {
namespace {

constexpr unsigned kSeed = 23;

/// A pool with a dent, and points on its surface, in it and far above.
struct Dented {
  MacGrid grid{Vec3(-0.5, -0.5, 0.0), 0.1, Vec3i(10, 10, 8)};
  std::vector<double> phi;
  WetFaces wet;
  std::vector<Vec3> surface, inside;

  explicit Dented(unsigned seed) : phi(grid.cells()) {
    const Vec3 center(0.03, -0.02, 0.5);
    for_places(grid.n, [&](int i, int j, int k) {
      const Vec3 x = grid.cell_center(i, j, k);
      phi[grid.cell(i, j, k)] = std::max(x.z() - 0.47, 0.28 - (x - center).norm());
    });
    wet.find(grid, phi, {});
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (int p = 0; p < 40; ++p) {
      Vec3 n(unit(rng), unit(rng), -0.4 - 0.6 * std::abs(unit(rng)));
      surface.push_back(center + 0.28 * n.normalized() + 0.02 * Vec3(unit(rng), unit(rng), unit(rng)));
      const double side = unit(rng) > 0.0 ? 0.45 : -0.45;  // clear of the dent
      inside.push_back(Vec3(side, 0.4 * unit(rng), 0.1 + 0.05 * unit(rng)));
    }
  }
};

std::vector<double> random_faces(std::size_t n, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<double> v(n);
  for (double& x : v) x = unit(rng);
  return v;
}

std::vector<double> constant(const MacGrid& g, const Vec3& u) {
  std::vector<double> v(g.faces());
  for (std::size_t f = 0; f < v.size(); ++f) v[f] = u[static_cast<int>(f % 3)];
  return v;
}

TEST(FaceMap, ForcesAreTheTransposeOfVelocities) {
  const Dented d(kSeed);
  for (const SurfaceMotion motion : {SurfaceMotion::Sticks, SurfaceMotion::Slips}) {
    FaceMap map;
    map.reset(d.grid, d.wet, d.phi, motion, d.surface);
    const auto v = random_faces(d.grid.faces(), kSeed + 1);
    std::mt19937 rng(kSeed + 2);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::vector<Vec3> f(map.points()), u(map.points());
    for (Vec3& e : f) e = Vec3(unit(rng), unit(rng), unit(rng));
    std::vector<double> Q(d.grid.faces(), 0.0);
    map.apply(v, u);
    map.apply_transpose(f, Q);
    double power = 0.0, work = 0.0;
    for (std::size_t p = 0; p < f.size(); ++p) power += f[p].dot(u[p]);
    for (std::size_t i = 0; i < Q.size(); ++i) work += Q[i] * v[i];
    EXPECT_NEAR(power, work, 1e-12);
    EXPECT_GT(std::abs(power), 1e-3);
  }
}

TEST(FaceMap, ConstantFieldIsReproduced_SoLinearMomentumIsExact) {
  const Dented d(kSeed);
  FaceMap map;
  map.reset(d.grid, d.wet, d.phi, SurfaceMotion::Sticks, d.surface);
  const Vec3 t(0.3, -0.8, 0.5);
  std::vector<Vec3> u(map.points());
  map.apply(constant(d.grid, t), u);
  for (const Vec3& e : u) EXPECT_LT((e - t).norm(), 1e-12);
  map.reset(d.grid, d.wet, d.phi, SurfaceMotion::Slips, d.inside);
  map.apply(constant(d.grid, t), u);
  for (const Vec3& e : u) EXPECT_LT((e - t).norm(), 1e-12);
}

TEST(FaceMap, FluidThatSlipsMovesAlongItsNormalOnly) {
  const Dented d(kSeed);
  FaceMap map;
  map.reset(d.grid, d.wet, d.phi, SurfaceMotion::Slips, d.surface);
  std::vector<Vec3> first(map.points()), second(map.points());
  map.apply(random_faces(d.grid.faces(), kSeed + 5), first);
  map.apply(random_faces(d.grid.faces(), kSeed + 6), second);
  for (std::size_t p = 0; p < first.size(); ++p)
    EXPECT_LT(first[p].cross(second[p]).norm(), 1e-9 * (first[p].norm() * second[p].norm() + 1e-12)) << p;
}

TEST(FaceMap, FluidThatSlipsTakesForcesAlongItsDirectionsWhole) {
  const Dented d(kSeed);
  FaceMap map;
  map.reset(d.grid, d.wet, d.phi, SurfaceMotion::Slips, d.surface);
  for (std::size_t p = 0; p < d.surface.size(); ++p) {
    const Vec3& along = map.directions()[p];
    EXPECT_NEAR(along.norm(), 1.0, 1e-12);
    for (const Vec3& force : {along, Vec3(along.unitOrthogonal())}) {
      std::vector<Vec3> f(map.points(), Vec3::Zero());
      f[p] = force;
      std::vector<double> Q(d.grid.faces(), 0.0);
      map.apply_transpose(f, Q);
      Vec3 taken = Vec3::Zero();
      for (std::size_t face = 0; face < Q.size(); ++face) taken[static_cast<int>(face % 3)] += Q[face];
      // Of others it takes what lies along its normal, and gives it along the direction.
      EXPECT_LT((taken - taken.dot(along) * along).norm(), 1e-12);
      if (force == along) {
        EXPECT_LT((taken - along).norm(), 1e-12);
      }
    }
  }
  map.reset(d.grid, d.wet, d.phi, SurfaceMotion::Sticks, d.surface);
  for (const Vec3& any : map.directions()) EXPECT_EQ(any, Vec3::Zero()) << "takes all of every force";
}

TEST(FaceMap, TheSurfaceItselfFollowsItsMatterAlongItAndMovesAcrossItAsContactIsTold) {
  const Dented d(kSeed);
  const auto v = random_faces(d.grid.faces(), kSeed + 7);
  std::vector<FaceWeight> row;
  SurfaceFaces surface;
  surface.find(d.grid, d.wet, d.phi);
  std::vector<Vec3> told(d.surface.size());
  FaceMap map;
  map.reset(d.grid, d.wet, d.phi, SurfaceMotion::Slips, d.surface);
  map.apply(v, told);
  double along = 0.0;
  for (std::size_t p = 0; p < d.surface.size(); ++p) {
    const Vec3 u = surface_velocity(d.grid, d.wet, surface, d.phi, SurfaceMotion::Follows, v, d.surface[p], row);
    const Vec3 n = told[p].normalized();
    EXPECT_NEAR(u.dot(n), told[p].norm(), 1e-12);
    along = std::max(along, (u - u.dot(n) * n).norm());
  }
  EXPECT_GT(along, 0.1);
}

TEST(FaceMap, DiagonalIsThatOfTheAssembledMatrix) {
  const Dented d(kSeed);
  FaceMap map;
  const std::vector<Vec3> points(d.surface.begin(), d.surface.begin() + 4);
  map.reset(d.grid, d.wet, d.phi, SurfaceMotion::Sticks, points);
  std::mt19937 rng(kSeed + 3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<Mat3> K(points.size());
  for (Mat3& k : K) {
    const Vec3 n(unit(rng), unit(rng), unit(rng));
    k = n * n.transpose() + 0.1 * Mat3::Identity();
  }
  BlockDiagonal D;
  const std::vector<int> sizes(d.grid.faces() / 3 + 1, 3);
  D.reset(sizes);
  map.add_block_diagonal(K, 1, D);
  double largest = 0.0;
  for (std::size_t f = 0; f < d.grid.faces(); ++f) {
    std::vector<double> e(d.grid.faces(), 0.0), Q(d.grid.faces(), 0.0);
    e[f] = 1.0;
    std::vector<Vec3> u(points.size());
    map.apply(e, u);
    for (std::size_t p = 0; p < u.size(); ++p) u[p] = K[p] * u[p];
    map.apply_transpose(u, Q);
    const auto block = D.block(1 + f / 3);
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_NEAR(block(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(f % 3)), Q[f / 3 * 3 + a], 1e-12);
    largest = std::max(largest, Q[f]);
  }
  EXPECT_GT(largest, 0.01);
}

TEST(FaceMap, PressureOnALevelSurfaceReachesEveryColumnAlike) {
  // One point per cell column, all pressed alike: the force of each on the one face under the surface, nothing else.
  const MacGrid g{Vec3::Zero(), 0.1, Vec3i(10, 10, 8)};
  std::vector<double> phi(g.cells());
  for_places(g.n, [&](int i, int j, int k) { phi[g.cell(i, j, k)] = g.cell_center(i, j, k).z() - 0.43; });
  WetFaces wet;
  wet.find(g, phi, {});
  std::vector<Vec3> points;
  for (int j = 0; j < 10; ++j)
    for (int i = 0; i < 10; ++i) points.push_back(Vec3(0.1 * i + 0.05, 0.1 * j + 0.05, 0.43));
  FaceMap map;
  map.reset(g, wet, phi, SurfaceMotion::Slips, points);
  std::vector<double> Q(g.faces(), 0.0);
  map.apply_transpose(std::vector<Vec3>(points.size(), Vec3(0, 0, -2.0)), Q);
  double sum = 0.0;
  for (const double q : Q) sum += q;
  EXPECT_NEAR(sum, -2.0 * 100, 1e-9);
  // Columns that no kernel reaches which the box cuts.
  for (int j = 3; j < 7; ++j)
    for (int i = 3; i < 7; ++i) EXPECT_NEAR(Q[g.face(2, i, j, 4)], -2.0, 0.02);
}

TEST(FaceMap, PointFarFromAllFluidDoesNotMove) {
  const Dented d(kSeed);
  FaceMap map;
  map.reset(d.grid, d.wet, d.phi, SurfaceMotion::Slips, std::vector<Vec3>{Vec3(0.03, -0.02, 9.0)});
  std::vector<Vec3> u(1);
  std::vector<double> none(d.grid.faces(), 0.0);
  WetFaces dry;
  std::vector<double> air(d.grid.cells(), 1.0);
  dry.find(d.grid, air, {});
  map.reset(d.grid, dry, air, SurfaceMotion::Slips, d.surface);
  u.resize(map.points());
  map.apply(random_faces(d.grid.faces(), 1), u);
  for (const Vec3& e : u) EXPECT_EQ(e.norm(), 0.0);
}

}  // namespace
}  // namespace brim::face_map_test
