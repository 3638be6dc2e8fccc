#include <gtest/gtest.h>

#include "brim/core/parallel.h"
#include "brim/math/ramp.h"
#include "support/carried.h"
#include "support/particle_laws.h"
#include "support/tiles.h"

/// Laws of bodies whose nodes carry particles of matter: deformable volumes and meshless solids.
namespace brim::carried_body_test {
namespace {

using testing::flat;
using testing::meshless;
using testing::soft;
using testing::voxels;

constexpr unsigned kSeed = 41;

std::vector<std::unique_ptr<CarriedBody>> both() {
  std::vector<std::unique_ptr<CarriedBody>> list;
  list.push_back(meshless(Vec3(0.4, 0.3, 0.3), 0.1, 0.05, soft()));
  list.push_back(voxels(Vec3(0.4, 0.3, 0.3), 0.12, 0.05, soft()));
  return list;
}

/// Rest shape bent, turned and shaken.
std::vector<double> deformed(const CarriedBody& body, double amount) {
  testing::Noise noise(kSeed);
  const Mat3 R = Eigen::AngleAxisd(1.0, Vec3(1, 1, 0).normalized()).toRotationMatrix();
  std::vector<Vec3> x;
  for (const Vec3& p : body.rest_positions())
    x.push_back(R * (p + amount * 0.05 * noise.vec() + amount * Vec3(p.y() * p.z(), 0, p.x() * p.x())));
  return flat(x);
}

TEST(CarriedBody, ObeysTheLawsOfElasticParticles) {
  for (const auto& body : both()) {
    SCOPED_TRACE(std::string(body->kind()));
    testing::expect_force_is_minus_energy_gradient(*body, deformed(*body, 0.3), 1e-7, 1e-6, kSeed);
    testing::expect_stiffness_is_symmetric_and_definite(*body, deformed(*body, 0.5), kSeed);
    testing::expect_inner_forces_balance(*body, deformed(*body, 0.5));
    testing::expect_rigid_motion_makes_no_force(*body);
    std::vector<Vec3> stretched;
    testing::Noise noise(kSeed);
    for (const Vec3& p : body->rest_positions()) stretched.push_back(1.15 * p + 0.0005 * noise.vec());
    testing::expect_stiffness_is_force_derivative(*body, flat(stretched), 1e-7, 1e-6, kSeed);
  }
}

TEST(CarriedBody, MassIsThatOfTheMatter) {
  for (const auto& body : both()) EXPECT_NEAR(body->mass(), 1000 * 0.4 * 0.3 * 0.3, 0.02 * 36) << body->kind();
}

TEST(CarriedBody, MapIsAdjointAndMovesAffineMotionsExactly) {
  for (const LayerWeights kind : {LayerWeights::Affine, LayerWeights::DensityRate})
    for (const bool image : {false, true}) {
      std::unique_ptr<CarriedBody> body;
      if (image)
        body = voxels(Vec3(0.4, 0.3, 0.3), 0.12, 0.05, soft(1e4, kind));
      else
        body = meshless(Vec3(0.4, 0.3, 0.3), 0.1, 0.05, soft(1e4, kind));
      testing::set(*body, deformed(*body, 0.2));
      const double h = 0.05, w = 3 * h;
      std::vector<TileKey> tiles;
      body->presence(0, h, w, body->bounds(0).inflated(1.0), tiles);
      std::vector<DensityBlock> blocks(tiles.size());
      body->rasterize(0, h, w, tiles, blocks);
      std::vector<Vec3> points;
      std::vector<std::int32_t> sources;
      testing::for_each_node(tiles, h, [&](std::size_t t, int n, const Vec3& r) {
        if (blocks[t].rho[n] > 0.05 && blocks[t].rho[n] < 0.95)
          points.push_back(r), sources.push_back(blocks[t].source[n]);
      });
      ASSERT_GT(points.size(), 100u);
      std::unique_ptr<Map> map;
      body->make_map(0, points, sources, map);
      Mat3 L;
      if (kind == LayerWeights::Affine)
        L << 0.1, 2, -1, 0.3, 0.2, 0.4, 1, -2, 0.5;
      else
        L << 0, 2, -1, -2, 0, 0.4, 1, -0.4, 0;  // the rate of a density is exact for rigid motions
      std::vector<Vec3> v;
      for (const Vec3& x : body->positions()) v.push_back(Vec3(1, 2, 3) + L * x);
      std::vector<Vec3> u(points.size()), f(points.size());
      map->apply(flat(v), u);
      double worst = 0.0;
      for (std::size_t p = 0; p < points.size(); ++p)
        worst = std::max(worst, (u[p] - Vec3(1, 2, 3) - L * points[p]).norm());
      EXPECT_LT(worst, 1e-8) << body->kind();
      testing::Noise noise(kSeed);
      std::vector<double> a(body->v_size()), Q(body->v_size(), 0.0);
      for (double& e : a) e = noise();
      Vec3 force = Vec3::Zero(), torque = Vec3::Zero(), got = Vec3::Zero(), got_torque = Vec3::Zero();
      for (std::size_t p = 0; p < points.size(); ++p) {
        f[p] = noise.vec();
        force += f[p];
        torque += points[p].cross(f[p]);
      }
      map->apply(a, u);
      map->apply_transpose(f, Q);
      double left = 0.0, right = 0.0;
      for (std::size_t p = 0; p < points.size(); ++p) left += u[p].dot(f[p]);
      for (std::size_t i = 0; i < Q.size(); ++i) right += Q[i] * a[i];
      EXPECT_NEAR(left, right, 1e-10 * static_cast<double>(Q.size()));
      for (std::size_t k = 0; k < body->particle_count(); ++k) {
        const Vec3 q(Q[3 * k], Q[3 * k + 1], Q[3 * k + 2]);
        got += q;
        got_torque += body->positions()[k].cross(q);
      }
      EXPECT_LT((got - force).norm(), 1e-9 * static_cast<double>(points.size()));
      EXPECT_LT((got_torque - torque).norm(), 1e-8 * static_cast<double>(points.size()));
    }
}

TEST(CarriedBody, FacesLieWhereMatterEnds_WhereverTheyCutCellsAndInFinerVoxels) {
  // Cells of 0.05 m, cut at a quarter, half and three quarters by the faces of blocks; contact in 0.02 m.
  const double cell = 0.05, h = 0.02, w = 3 * h;
  for (const double cut : {0.25, 0.5, 0.75, 1.0})
    for (const bool image : {false, true}) {
      const Vec3 size(0.4, 0.4, 0.3 + 2.0 * cell * (cut - 1.0));
      std::unique_ptr<CarriedBody> body;
      if (image)
        body = voxels(size, 0.1, cell, soft());
      else
        body = meshless(size, 0.1, cell, soft());
      testing::set(*body, flat(body->rest_positions()));
      std::vector<TileKey> tiles;
      body->presence(0, h, w, body->bounds(0).inflated(1.0), tiles);
      std::vector<DensityBlock> blocks(tiles.size());
      body->rasterize(0, h, w, tiles, blocks);
      double worst = 0.0;
      testing::for_each_node(tiles, h, [&](std::size_t t, int n, const Vec3& r) {
        // Away from the edges, where the ramp is steep.
        const double d = std::abs(r.z()) - 0.5 * size.z();
        if (std::abs(r.x()) > 0.06 || std::abs(r.y()) > 0.06 || std::abs(d) > 0.5 * h) return;
        worst = std::max(worst, std::abs(ramp_inverse(blocks[t].rho[n], w) - d));
      });
      EXPECT_LT(worst, 0.05 * cell) << body->kind() << " cut at " << cut;
    }
}

TEST(CarriedBody, DensityFollowsWhatTheMatterFillsWhenStretched) {
  for (const auto& body : both()) {
    std::vector<Vec3> x;
    for (const Vec3& p : body->rest_positions()) x.push_back(Vec3(1.5 * p.x(), p.y(), 0.8 * p.z()));
    testing::set(*body, flat(x));
    const double h = 0.05;
    std::vector<TileKey> tiles;
    body->presence(0, h, 3 * h, body->bounds(0).inflated(1.0), tiles);
    std::vector<DensityBlock> blocks(tiles.size());
    body->rasterize(0, h, 3 * h, tiles, blocks);
    double middle = 0.0;
    testing::for_each_node(tiles, h, [&](std::size_t t, int n, const Vec3& r) {
      if (r.norm() < 0.5 * h) middle = blocks[t].rho[n];
    });
    EXPECT_GT(middle, 0.97) << body->kind();
  }
}

TEST(CarriedBody, ThreadsDoNotChangeABit) {
  const auto list = both();
  for (const auto& body : list) {
    std::vector<double> first;
    const std::vector<double> q = deformed(*body, 0.5);
    for (const int threads : {1, 2, 4}) {
      ThreadLimit limit(threads);
      testing::set(*body, q);
      body->begin_solve(0.01);
      std::vector<double> y(q.size(), 0.0);
      body->apply_system(q, y);
      const auto f = flat(body->inner_forces());
      y.insert(y.end(), f.begin(), f.end());
      if (first.empty()) first = y;
      EXPECT_EQ(y, first);
    }
  }
}

/// A block of voxels whose modulus is a function of the place.
template <class Young>
std::unique_ptr<SoftImageBody> block_of(const Young& young_at, double young = 1e4, bool neo_hookean = false) {
  const Vec3 half(0.2, 0.15, 0.15);
  const VoxelImage image = testing::scan({-half - Vec3::Constant(0.05), half + Vec3::Constant(0.05)}, 0.025,
                                         [=](const Vec3& x) { return testing::box_distance(x, half); });
  const OccupancyGrid grid = sample_occupancy(image, {0, 100}, 0.05);
  std::vector<float> cells(grid.share.size());
  for (int k = 0; k < grid.cells.z(); ++k)
    for (int j = 0; j < grid.cells.y(); ++j)
      for (int i = 0; i < grid.cells.x(); ++i) {
        const std::size_t at = grid.index(i, j, k);
        cells[at] = static_cast<float>(young_at(grid.center(i, j, k)) * grid.share[at] / 255.0);
      }
  ElasticOptions options = soft(young);
  options.neo_hookean = neo_hookean;
  return std::make_unique<SoftImageBody>(grid, display_surface(grid), 0.06, Quat::Identity(), Vec3::Zero(), options,
                                         CellMaterial{{}, cells});
}

/// Energy of the block stretched by a tenth along x.
double stretched(SoftImageBody& body) {
  std::vector<Vec3> x;
  for (const Vec3& p : body.rest_positions()) x.push_back(Vec3(1.1 * p.x(), p.y(), p.z()));
  testing::set(body, flat(x));
  return body.elastic_energy();
}

TEST(SoftImage, AModulusByCellsIsThatOfTheElements) {
  for (const bool neo_hookean : {false, true}) {
    const auto one = block_of([](const Vec3&) { return 1e4; }, 1e4, neo_hookean);
    const auto given_elsewhere = block_of([](const Vec3&) { return 1e4; }, 77.0, neo_hookean);
    const double energy = stretched(*one);
    EXPECT_NEAR(stretched(*given_elsewhere), energy, 1e-6 * energy);
    EXPECT_NEAR(given_elsewhere->part(0).modulus, 1e4, 1e-2);
    // Energy is linear in the moduli: a field and its mirror image together are twice their mean.
    const auto graded = [](double x) { return 1e4 + 4e4 * x; };
    const auto halves = [](double x) { return 1e4 * (std::abs(x) < 1e-9 ? 2 : x < 0 ? 1 : 3); };
    const auto energy_of = [&](const auto& along, double sign) {
      return stretched(*block_of([&](const Vec3& x) { return along(sign * x.x()); }, 1e4, neo_hookean));
    };
    EXPECT_NEAR(energy_of(graded, 1) + energy_of(graded, -1), 2.0 * energy, 1e-6 * energy);
    EXPECT_NEAR(energy_of(halves, 1) + energy_of(halves, -1), 4.0 * energy, 1e-6 * energy);
    EXPECT_NEAR(energy_of(halves, 1), 2.0 * energy, 0.25 * energy) << "the lattice reaches out on one side further";
    // In contact halves are behind each other; there is a layer of the mean between them.
    const auto both = block_of([&](const Vec3& x) { return halves(x.x()); });
    EXPECT_NEAR(both->part(0).modulus, 1.5e4, 0.12e4);
  }
}

TEST(SoftImage, AStretchTakesTheEnergyOfTheMatterAndNotOfTheLattice) {
  // E = ½ (λ + 2μ) ε² V, uniaxial strain. Tetrahedra at the surface are partly empty; the lattice has 1.3 to 2.8
  // times the volume of the matter.
  const double strain = 0.1, young = 1e4, poisson = 0.3;
  const double pressed = young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson));
  const Vec3 size(0.4, 0.3, 0.3);
  for (const double spacing : {0.06, 0.1, 0.15, 0.2})
    for (const double cell : {0.025, 0.05}) {
      ElasticOptions options = soft(young);
      const auto body = voxels(size, spacing, cell, options);
      const double energy = 0.5 * pressed * strain * strain * size.prod(), found = stretched(*body);
      EXPECT_NEAR(found, energy, 0.04 * energy) << spacing << " " << cell << ": measured 2.3 % at worst, by sampling";
      // Averaging counts the same matter.
      options.averaging = 0.9;
      EXPECT_NEAR(stretched(*voxels(size, spacing, cell, options)), energy, 0.04 * energy) << spacing << " " << cell;
    }
}

TEST(SoftImage, AveragedElementsObeyTheLawsOfElasticParticles) {
  ElasticOptions options = soft();
  options.averaging = 0.9;
  const auto body = voxels(Vec3(0.4, 0.3, 0.3), 0.12, 0.05, options);
  testing::expect_force_is_minus_energy_gradient(*body, deformed(*body, 0.3), 1e-7, 1e-6, kSeed);
  testing::expect_stiffness_is_symmetric_and_definite(*body, deformed(*body, 0.5), kSeed);
  testing::expect_inner_forces_balance(*body, deformed(*body, 0.5));
  testing::expect_rigid_motion_makes_no_force(*body);
}

TEST(SoftImage, ElementsOfManyModuliObeyTheLawsOfElasticParticles) {
  const auto body = block_of([](const Vec3& x) { return 1e4 * (1.0 + 8.0 * std::abs(x.x() + 0.5 * x.y())); });
  testing::expect_force_is_minus_energy_gradient(*body, deformed(*body, 0.3), 1e-7, 1e-6, kSeed);
  testing::expect_stiffness_is_symmetric_and_definite(*body, deformed(*body, 0.5), kSeed);
  testing::expect_inner_forces_balance(*body, deformed(*body, 0.5));
}

}  // namespace
}  // namespace brim::carried_body_test
