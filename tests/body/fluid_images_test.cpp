#include "brim/body/particle_fluid/fluid_images.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/particle_fluids.h"

namespace brim::fluid_images_test {
namespace {

using namespace testing::fluids;

/// What particles see of some planes, by distance and normal at a place.
struct Plane {
  Vec3 point, normal;
};

std::vector<Seen> seen_of(const ParticleFluidBody& b, const std::vector<Plane>& planes) {
  std::vector<Seen> seen;
  const auto x = b.fill_places();
  for (std::size_t p = 0; p < planes.size(); ++p)
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double d = planes[p].normal.dot(x[i] - planes[p].point);
      if (d < b.fill_reach())
        seen.push_back({static_cast<std::int32_t>(i), static_cast<std::int32_t>(p), d, planes[p].normal, 0.0});
    }
  return seen;
}

/// Fill of a block that is deformed, of the particles that lie two spacings from where no plane is: below its top, and
/// where `open` says from its sides along y.
void expect_fill(const Vec3& stretch, const std::vector<Plane>& planes, bool open, double expected) {
  const Vec3 size(0.3, 0.4, 0.3);
  std::vector<Vec3> x = block(size);
  for (Vec3& p : x) p = p.cwiseProduct(stretch);
  Held f(x, options());
  f.body.see(seen_of(f.body, planes));
  const std::vector<double> fill = f.body.fill();
  int count = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 start = x[i].cwiseQuotient(stretch);
    if (start.z() > size.z() - 2.0 * kSpacing) continue;
    if (open && std::abs(start.y() - 0.5 * size.y()) > 0.5 * size.y() - 2.0 * kSpacing) continue;
    EXPECT_NEAR(fill[i], expected, 2e-12) << x[i].transpose();
    ++count;
  }
  EXPECT_GT(count, 60);
}

std::vector<Plane> around(const Vec3& size) {
  return {{Vec3::Zero(), Vec3::UnitZ()},
          {Vec3::Zero(), Vec3::UnitX()},
          {Vec3(size.x(), 0, 0), -Vec3::UnitX()},
          {Vec3::Zero(), Vec3::UnitY()},
          {Vec3(0, size.y(), 0), -Vec3::UnitY()}};
}

TEST(FluidImages, BetweenWallsALatticeIsFullAlsoAlongEdges) {
  expect_fill(Vec3::Ones(), around(Vec3(0.3, 0.4, 0.3)), false, 1.0);
}

TEST(FluidImages, TheLayerAtAWallResistsNoMoreThanTheBulk) {
  // Narrowed by 8 % along one axis at the same volume, every particle at a floor and two walls has the fill of one
  // inside.
  const Vec3 stretch(1.0 / 0.92, 0.92, 1.0);
  std::vector<Vec3> x = block(Vec3(0.35, 0.35, 0.35));
  for (Vec3& p : x) p = p.cwiseProduct(stretch);
  const double bulk = Held(x, options()).body.fill()[x.size() / 2];
  EXPECT_GT(std::abs(bulk - 1.0), 1e-4);
  expect_fill(
      stretch,
      {{Vec3::Zero(), Vec3::UnitZ()}, {Vec3::Zero(), Vec3::UnitX()}, {Vec3(0.3 * stretch.x(), 0, 0), -Vec3::UnitX()}},
      true, bulk);
}

TEST(FluidImages, UnderAUniformPressureTheLatticeAtAWallIsInBalance) {
  Held f(block(Vec3(0.4, 0.4, 0.3)), options());
  const auto x = f.body.fill_places();
  std::vector<double> flat = f.q;
  for (std::size_t i = 0; i < flat.size(); ++i)
    if (i % 3 != 2) flat[i] *= 0.98;  // the same pressure inside, less at the free sides
  f.set(flat);
  const std::vector<Seen> seen = seen_of(f.body, {{Vec3::Zero(), Vec3::UnitZ()}});
  f.body.see(seen);
  std::vector<double> Q(f.v.size(), 0.0), push(seen.size());
  f.body.add_forces(Environment{Vec3::Zero()}, Q);
  f.body.press(push);
  for (std::size_t k = 0; k < seen.size(); ++k) Q[3 * seen[k].element + 2] += push[k];
  double most = 0.0, largest = 0.0;
  for (const double p : push) largest = std::max(largest, p);
  int inside = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 mid(0.196, 0.196, 0.0), off = (x[i] - mid).cwiseAbs();
    most = std::max(most, std::abs(Q[3 * i + 2]));
    if (off.x() > 0.09 || off.y() > 0.09 || x[i].z() > 0.1) continue;
    ++inside;
    EXPECT_NEAR(Q[3 * i + 2], 0.0, 1e-5 * largest) << x[i].transpose();
  }
  EXPECT_GT(inside, 10);
  EXPECT_GT(most, 0.1 * largest);  // the top is not held
}

TEST(FluidImages, OffsetAndBarrierHaveTheirSlopes) {
  const FluidImages images(FluidKernel(2.0 * kSpacing), kSpacing, std::pow(kSpacing, 3));
  const double e = 1e-6 * kSpacing;
  for (const double d : {-0.5, -0.1, 0.0, 0.2, 0.4, 0.6, 0.9, 1.19}) {
    double slope = 0.0, unused = 0.0;
    images.offset(d * kSpacing, slope);
    EXPECT_NEAR(slope, (images.offset(d * kSpacing + e, unused) - images.offset(d * kSpacing - e, unused)) / (2 * e),
                1e-5);
    images.barrier(d * kSpacing, slope);
    EXPECT_NEAR(slope, (images.barrier(d * kSpacing + e, unused) - images.barrier(d * kSpacing - e, unused)) / (2 * e),
                1e-4 / kSpacing);
  }
  double slope = 0.0;
  EXPECT_DOUBLE_EQ(images.offset(0.5 * kSpacing, slope), 0.5 * kSpacing);
  EXPECT_EQ(images.barrier(0.5 * kSpacing, slope), 0.0);
  // At the reach an image of what lies half a spacing off is out of the kernel's support.
  EXPECT_NEAR(4.0 * images.offset(images.reach(), slope) * 0.5 * kSpacing, 4.0 * kSpacing * kSpacing, 1e-12);
}

TEST(FluidImages, ForcesAreMinusTheDerivativeOfEnergyInACornerToo) {
  std::vector<Vec3> x = block(Vec3(0.2, 0.2, 0.2), 0.2);
  for (Vec3& p : x) p *= 0.93;
  Held f(x, options());
  const std::vector<Plane> planes = {{Vec3::Zero(), Vec3::UnitZ()}, {Vec3::Zero(), Vec3::UnitX()}};
  const auto see = [&](const std::vector<double>& q) {
    f.set(q);
    std::vector<Seen> seen = seen_of(f.body, planes);
    f.body.see(seen);
    return seen;
  };
  const std::vector<Seen> seen = see(f.q);
  std::vector<double> Q(f.v.size(), 0.0), push(seen.size());
  f.body.add_forces(Environment{Vec3::Zero()}, Q);
  f.body.press(push);
  for (std::size_t k = 0; k < seen.size(); ++k)
    for (int a = 0; a < 3; ++a) Q[3 * seen[k].element + a] += push[k] * seen[k].n[a];
  const std::vector<double> d = random_vector(Q.size(), kSeed);
  const double e = 1e-7;
  std::vector<double> plus = f.q, minus = f.q;
  for (std::size_t i = 0; i < d.size(); ++i) plus[i] += e * d[i], minus[i] -= e * d[i];
  const Environment still{Vec3::Zero()};
  see(plus);
  const double up = f.body.potential_energy(still);
  see(minus);
  const double down = f.body.potential_energy(still);
  EXPECT_NEAR(dot(Q, d), -(up - down) / (2 * e), 1e-5 * std::sqrt(dot(Q, Q) * dot(d, d)));
}

TEST(FluidImages, TheDiagonalBlocksAreThoseOfTheSystemWithItsContacts) {
  Held f(block(Vec3(0.2, 0.2, 0.2), 0.2), options(3.0));
  const std::vector<Plane> planes = {{Vec3::Zero(), Vec3::UnitZ()}, {Vec3::Zero(), Vec3::UnitX()}};
  const std::vector<Seen> seen = seen_of(f.body, planes);
  f.body.see(seen);
  f.body.begin_solve(0.005);
  BlockDiagonal D;
  D.reset(f.body.block_sizes());
  f.body.add_system_diagonal(0, D);
  for (std::size_t k = 0; k < seen.size(); ++k)
    D.block(seen[k].element) += f.body.fill_stiffness(k, 0.005) * seen[k].n * seen[k].n.transpose();
  for (const std::size_t i : {0u, 1u, 21u, 40u})
    for (int a = 0; a < 3; ++a) {
      std::vector<double> unit(f.v.size(), 0.0), column(f.v.size(), 0.0), rate(seen.size(), 0.0), push(seen.size());
      unit[3 * i + a] = 1.0;
      for (std::size_t k = 0; k < seen.size(); ++k)
        if (static_cast<std::size_t>(seen[k].element) == i) rate[k] = seen[k].n[a];
      f.body.apply_system_seeing(unit, rate, column, push);
      // The contact's force acts on the particle through its map.
      for (std::size_t k = 0; k < seen.size(); ++k)
        for (int c = 0; c < 3; ++c) column[3 * seen[k].element + c] -= push[k] * seen[k].n[c];
      // Contacts that share a particle have cross terms, which a sum of contacts does not know.
      double shared = 0.0;
      for (const Seen& s : seen) shared += static_cast<std::size_t>(s.element) == i;
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(D.block(i)(c, a), column[3 * i + c], (shared > 1 ? 0.2 : 2e-5) * D.block(i).norm()) << i << c << a;
    }
}

}  // namespace
}  // namespace brim::fluid_images_test
