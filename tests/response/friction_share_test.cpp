#include "brim/response/friction_share.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace brim::friction_share_test {
namespace {

struct Patch {
  std::vector<Vec3> x, n;
  std::vector<double> load;  // those of the solve
  double net = 0.0;
  Vec3 center = Vec3::Zero();
};

Patch patch_of(const std::vector<Vec3>& x, const Vec3& normal, const std::vector<double>& load) {
  Patch p{x, std::vector<Vec3>(x.size(), normal), load};
  for (std::size_t i = 0; i < x.size(); ++i) p.net += load[i], p.center += load[i] * x[i];
  p.center /= p.net;
  return p;
}

/// A square patch of nodes, a tenth of which pull, around a centre.
Patch random_patch(unsigned seed, const Vec3& normal) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> place(-1.0, 1.0), load(0.0, 1.0);
  const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
  std::vector<Vec3> x;
  std::vector<double> l;
  for (int i = 0; i < 200; ++i) {
    x.push_back(Vec3(3, 1, 2) + place(rng) * u + place(rng) * v);
    l.push_back(i % 10 == 0 ? -3.0 * load(rng) : load(rng));
  }
  return patch_of(x, normal, l);
}

FrictionShare share(const Patch& p) { return share_about(p.x, p.n, p.load, p.net, p.center); }

TEST(FrictionShare, HasTheSumAndTheCentreOfTheNetLoad) {
  const Vec3 normal = Vec3(1, 2, 2).normalized();
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const Patch p = random_patch(seed, normal);
    const FrictionShare s = share(p);
    double sum = 0.0;
    Vec3 moment = Vec3::Zero();
    for (std::size_t i = 0; i < p.x.size(); ++i) {
      const double l = s.of(p.load[i], p.x[i]);
      EXPECT_GE(l, 0.0);
      if (p.load[i] <= 0.0) {
        EXPECT_EQ(l, 0.0);
      }
      sum += l, moment += l * (p.x[i] - p.center);
    }
    EXPECT_NEAR(sum, p.net, 1e-12 * p.net);
    EXPECT_LT((moment / sum).norm(), 2e-4);  // of a radius of about 1.4: the accuracy of Newton's steps
  }
}

TEST(FrictionShare, IsEvenWhereNothingPulls) {
  const Patch p = patch_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, Vec3::UnitZ(), {1.0, 2.0, 3.0, 0.5});
  const FrictionShare s = share(p);
  for (std::size_t i = 0; i < p.x.size(); ++i) EXPECT_NEAR(s.of(p.load[i], p.x[i]), p.load[i], 1e-12);
}

TEST(FrictionShare, KeepsTheSumWhereTheCentreLiesOutside) {
  // The node that pulls is the farthest one: the net load lies beyond the others.
  const Patch p = patch_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, Vec3::UnitZ(), {-0.9, 1.0, 1.0, 1.0});
  const FrictionShare s = share(p);
  double sum = 0.0;
  for (std::size_t i = 0; i < p.x.size(); ++i) sum += s.of(p.load[i], p.x[i]);
  EXPECT_NEAR(sum, p.net, 1e-12);
  EXPECT_GT(s.of(1.0, p.x[3]), s.of(1.0, p.x[1]));
}

TEST(FrictionShare, IsEvenOnALineAndWhereNormalsDiffer) {
  Patch line = patch_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, Vec3::UnitZ(), {-0.5, 1.0, 1.0});
  EXPECT_EQ(share(line).tilt, Vec3::Zero());
  Patch arc = random_patch(1, Vec3::UnitZ());
  arc.n[1] = Vec3::UnitX();
  const FrictionShare s = share(arc);
  EXPECT_EQ(s.tilt, Vec3::Zero());
  double push = 0.0;
  for (const double l : arc.load) push += std::max(0.0, l);
  EXPECT_NEAR(s.scale, arc.net / push, 1e-12);
}

}  // namespace
}  // namespace brim::friction_share_test
