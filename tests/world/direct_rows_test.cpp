#include "brim/world/direct_rows.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/body/cloth/cloth_body.h"
#include "brim/mesh/primitives.h"

namespace brim::direct_rows_test {
namespace {

constexpr unsigned kSeed = 31;

/// A hanging sheet of 75 velocities, of which six are held, after begin_solve.
struct Sheet {
  std::vector<std::unique_ptr<Body>> bodies;
  std::vector<std::size_t> first_v;
  BodyInverses inverses;

  Sheet() {
    ClothOptions o;
    o.fixed = {0, 4};
    bodies.push_back(std::make_unique<ClothBody>(shapes::grid(4, 4, 0.4, 0.4), o));
    first_v = {0, bodies[0]->v_size()};
    std::vector<double> q(bodies[0]->q_size()), v(bodies[0]->v_size());
    bodies[0]->initial_state(q, v);
    bodies[0]->update(0.0, q, v);
    bodies[0]->begin_solve(0.01);
    const std::uint8_t wanted = 2;
    inverses.begin(bodies, first_v, {&wanted, 1});
  }
  std::size_t size() const { return first_v[1]; }
};

std::vector<double> filtered_random(const Sheet& s, std::mt19937& random) {
  std::normal_distribution<double> some;
  std::vector<double> x(s.size());
  for (double& z : x) z = some(random);
  s.bodies[0]->filter(x);
  return x;
}

TEST(DirectRows, TheFactoredInverseOfASheetUndoesItsSystem) {
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  const Sheet s;
  ASSERT_TRUE(s.inverses.factored(0));
  ASSERT_TRUE(s.inverses.exact(0));
  EXPECT_EQ(s.inverses.modes(0), 0);
  for (int trial = 0; trial < 5; ++trial) {
    const std::vector<double> b = filtered_random(s, random);
    std::vector<double> x(s.size()), Ax(s.size(), 0.0);
    s.inverses.local(0, b, x);
    s.bodies[0]->apply_system(x, Ax);
    s.bodies[0]->filter(Ax);
    for (std::size_t i = 0; i < b.size(); ++i) EXPECT_NEAR(Ax[i], b[i], 1e-10);
  }
}

TEST(DirectRows, ManyRightHandSidesAreAnsweredAsEachByItself) {
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  const Sheet s;
  const auto n = static_cast<Eigen::Index>(s.size());
  BodyInverses::Together x(n, BodyInverses::kTogether);
  for (int k = 0; k < BodyInverses::kTogether; ++k) {
    const std::vector<double> b = filtered_random(s, random);
    x.col(k) = Eigen::Map<const Eigen::VectorXd>(b.data(), n);
  }
  BodyInverses::Together together = x;
  s.inverses.solve_together(0, together);
  for (int k = 0; k < BodyInverses::kTogether; ++k) {
    const Eigen::VectorXd b = x.col(k);
    Eigen::VectorXd alone(n);
    s.inverses.local(0, {b.data(), s.size()}, {alone.data(), s.size()});
    EXPECT_LT((together.col(k) - alone).norm(), 1e-12 * alone.norm()) << k;
  }
}

TEST(DirectRows, CoordinatesAnswerAsTheBodyItselfWould) {
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  const Sheet s;
  DirectRows rows;
  rows.begin(1, s.size());
  std::vector<std::array<std::vector<double>, 3>> force;
  const std::size_t contacts[] = {1, 4};
  for (const std::size_t c : contacts) {
    force.push_back({filtered_random(s, random), filtered_random(s, random), filtered_random(s, random)});
    rows.add(0, c, force.back());
  }
  rows.solve(s.inverses, s.first_v);
  ASSERT_EQ(rows.size(), 6u);

  // An impulse at the second contact, by the entries and by the body.
  const Vec3 impulse(0.3, -1.1, 0.7);
  std::vector<Vec3> lambda(5, Vec3::Zero());
  lambda[4] = impulse;
  std::vector<double> all(s.size() + rows.size(), 0.0), answer(s.size(), 0.0);
  rows.respond(s.inverses, s.first_v, lambda, answer);
  std::copy(answer.begin(), answer.end(), all.begin());
  rows.read(s.first_v, all);
  std::vector<ProjectedGaussSeidel::Entry> entries;
  rows.append(0, 4, entries);
  ASSERT_EQ(entries.size(), 6u);
  for (const auto& e : entries)
    EXPECT_NEAR(e.response.dot(impulse), all[e.index], 1e-12 * (1.0 + std::abs(all[e.index])));

  // And y itself, by hand.
  for (std::size_t k = 0; k < 2; ++k)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double y = 0.0;
      for (std::size_t i = 0; i < s.size(); ++i) y += force[k][axis][i] * answer[i];
      EXPECT_NEAR(all[s.size() + 3 * k + axis], y, 1e-12 * (1.0 + std::abs(y)));
    }
}

TEST(DirectRows, ABodyWithoutContactsHasNoCoordinates) {
  const Sheet s;
  DirectRows rows;
  rows.begin(1, s.size());
  rows.solve(s.inverses, s.first_v);
  EXPECT_EQ(rows.size(), 0u);
  EXPECT_FALSE(rows.holds(0));
}

}  // namespace
}  // namespace brim::direct_rows_test
