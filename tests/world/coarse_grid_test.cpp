#include "brim/world/coarse_grid.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "brim/body/fem/fem_body.h"
#include "brim/core/parallel.h"
#include "brim/world/contact_preconditioner.h"
#include "support/dense_contacts.h"
#include "support/soft_worlds.h"

namespace brim::testing::coarse_grid_test {
namespace {

constexpr unsigned kSeed = 11;
constexpr double kEdge = 0.2;

/// Two soft blocks, one above the other and a part of a cell aside, one corner of the first held; contacts made up
/// between their surfaces. Other velocities lie between theirs.
struct Problem {
  std::vector<std::unique_ptr<FemBody>> bodies;
  std::vector<std::size_t> first_v = {4, 0};
  std::size_t velocities = 0;
  std::vector<CoarseGrid::Member> members;
  ContactRows rows;
  Eigen::MatrixXd A;

  explicit Problem(bool plain = true) {
    FemOptions held;
    held.fixed = {0};
    for (int b = 0; b < 2; ++b) {
      TetMesh mesh = block(4, 4, 2, kEdge);
      for (Vec3& x : mesh.vertices) x += b * Vec3(0.07, 0.03, 2 * kEdge);
      bodies.push_back(std::make_unique<FemBody>(mesh, b == 0 ? held : FemOptions{}));
      FemBody& body = *bodies.back();
      std::vector<double> q(body.q_size()), v(body.v_size());
      body.initial_state(q, v);
      body.update(0.0, q, v);
      body.begin_solve(0.01);
      if (b == 1) first_v[1] = first_v[0] + bodies[0]->v_size() + 2;
      velocities = first_v[b] + v.size();
      members.push_back({first_v[b], *body.block_system()});
    }
    A = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(velocities), static_cast<Eigen::Index>(velocities));
    for (std::size_t b = 0; b < 2; ++b)
      for (std::size_t k = 0; k < bodies[b]->v_size(); ++k) {
        std::vector<double> x(bodies[b]->v_size(), 0.0), y(x.size(), 0.0);
        x[k] = 1.0;
        bodies[b]->apply_system(x, y);
        A.col(static_cast<Eigen::Index>(first_v[b] + k))
            .segment(static_cast<Eigen::Index>(first_v[b]), static_cast<Eigen::Index>(y.size())) =
            Eigen::Map<const Eigen::VectorXd>(y.data(), static_cast<Eigen::Index>(y.size()));
      }
    add_contacts(plain);
  }

  void add_contacts(bool plain) {
    std::mt19937 rng(kSeed);
    std::normal_distribution<float> normal;
    rows.first = {0};
    const auto near = [&](std::size_t b, const Vec3& x) {
      std::size_t best = 0;
      const auto place = members[b].system.place;
      for (std::size_t r = 0; r < place.size(); ++r)
        if ((place[r] - x).squaredNorm() < (place[best] - x).squaredNorm()) best = r;
      return static_cast<std::int32_t>(first_v[b] + 3 * best);
    };
    for (int c = 0; c < 30; ++c) {
      const Vec3 x(kEdge * (c % 6) * 0.7, kEdge * (c / 6) * 0.8, 2 * kEdge);
      for (std::size_t b = 0; b < 2; ++b)
        for (int k = 0; k < 2; ++k) {
          const float weight = b == 0 ? 0.5f : -0.5f;
          rows.offset.push_back(near(b, x + 0.5 * kEdge * k * Vec3::UnitX()));
          if (plain)
            rows.blocks.add(weight);
          else
            rows.blocks.add(Eigen::Matrix3f(weight * Eigen::Matrix3f::Identity() +
                                            0.1f * Eigen::Matrix3f::NullaryExpr([&] { return normal(rng); })));
        }
      const Eigen::Vector3f n = Eigen::Vector3f(normal(rng), normal(rng), normal(rng)).normalized();
      rows.contact.push_back(static_cast<std::uint32_t>(c));
      rows.stiffness.push_back(300.0f * n * n.transpose() + 20.0f * Eigen::Matrix3f::Identity());
      rows.first.push_back(static_cast<std::int32_t>(rows.offset.size()));
    }
    add_contact_stiffness(rows, A);
  }
};

/// The motions of the grid as columns.
Eigen::MatrixXd motions(const CoarseGrid& grid, const Problem& p) {
  const auto corners = static_cast<Eigen::Index>(grid.corners());
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(p.A.rows(), 3 * corners);
  for (std::size_t b = 0; b < 2; ++b)
    for (std::size_t r = 0; r < p.members[b].system.place.size(); ++r) {
      const std::size_t v = p.first_v[b] + 3 * r;
      const Eigen::VectorXd w = grid.weights(v);
      for (Eigen::Index I = 0; I < corners; ++I)
        W.block<3, 3>(static_cast<Eigen::Index>(v), 3 * I) = w[I] * Mat3::Identity();
    }
  return W;
}

TEST(CoarseGrid, HasAllLinearMotionsOfTheNodesThatAreFree) {
  const Problem p;
  CoarseGrid grid;
  grid.begin(p.members, p.velocities, 1.5);
  ASSERT_GT(grid.corners(), 30u);
  EXPECT_EQ(grid.weights(p.first_v[0]), Eigen::VectorXd::Zero(static_cast<Eigen::Index>(grid.corners())));
  // Whatever is linear in space: the weights of all nodes span 1, x, y and z.
  const auto nodes = static_cast<Eigen::Index>(p.members[0].system.place.size() + p.members[1].system.place.size());
  Eigen::MatrixXd w(nodes - 1, static_cast<Eigen::Index>(grid.corners())), linear(nodes - 1, 4);
  Eigen::Index i = 0;
  for (std::size_t b = 0; b < 2; ++b)
    for (std::size_t r = b == 0 ? 1 : 0; r < p.members[b].system.place.size(); ++r, ++i) {
      w.row(i) = grid.weights(p.first_v[b] + 3 * r).transpose();
      linear.row(i) << 1.0, p.members[b].system.place[r].transpose();
    }
  EXPECT_LT((w.rowwise().sum() - Eigen::VectorXd::Ones(nodes - 1)).cwiseAbs().maxCoeff(), 1e-6);
  const Eigen::MatrixXd fit = w.completeOrthogonalDecomposition().solve(linear);
  EXPECT_LT((w * fit - linear).cwiseAbs().maxCoeff(), 1e-6);
}

class CoarseGridOf : public ::testing::TestWithParam<std::tuple<bool, double>> {};

TEST_P(CoarseGridOf, IsGalerkinsMatrixOfBodiesAndContacts) {
  SCOPED_TRACE(kSeed);
  const Problem p(std::get<0>(GetParam()));
  CoarseGrid grid;
  grid.begin(p.members, p.velocities, std::get<1>(GetParam()));
  grid.factor(p.rows);
  const Eigen::MatrixXd W = motions(grid, p), exact = W.transpose() * p.A * W;
  EXPECT_LT((grid.dense() - exact).norm(), 1e-5 * exact.norm());
}

TEST_P(CoarseGridOf, AddsTheAnswerOfTheCoarseSystem) {
  SCOPED_TRACE(kSeed);
  const Problem p(std::get<0>(GetParam()));
  CoarseGrid grid;
  grid.begin(p.members, p.velocities, std::get<1>(GetParam()));
  grid.factor(p.rows);
  const Eigen::MatrixXd W = motions(grid, p);
  const Eigen::VectorXd r = Eigen::VectorXd::Random(p.A.rows());
  // Motions that no free node can tell from others add nothing.
  const Eigen::VectorXd exact =
      W * (W.transpose() * p.A * W).completeOrthogonalDecomposition().solve(W.transpose() * r);
  std::vector<double> z(p.velocities, 1.0);
  grid.add(std::span(r.data(), p.velocities), z);
  const Eigen::Map<const Eigen::VectorXd> got(z.data(), r.size());
  EXPECT_LT((got - Eigen::VectorXd::Ones(r.size()) - exact).norm(), 1e-3 * exact.norm());
  EXPECT_EQ(z[0], 1.0);  // of no member
}

INSTANTIATE_TEST_SUITE_P(Cells, CoarseGridOf,
                         ::testing::Combine(::testing::Bool(), ::testing::Values(1.2, 1.5, 2.5, 50.0)));

TEST(CoarseGrid, GivesTheSameBitsForAnyNumberOfThreads) {
  const Problem p;
  const auto answer = [&](int threads) {
    const ThreadLimit limit(threads);
    CoarseGrid grid;
    grid.begin(p.members, p.velocities, 1.5);
    grid.factor(p.rows);
    std::vector<double> r(p.velocities), z(p.velocities, 0.0);
    for (std::size_t i = 0; i < r.size(); ++i) r[i] = std::sin(static_cast<double>(i));
    grid.add(r, z);
    return z;
  };
  EXPECT_EQ(answer(1), answer(4));
}

TEST(CoarseGrid, TakesOtherContactsAfterOthers) {
  const Problem p, q(false);
  CoarseGrid grid, anew;
  grid.begin(p.members, p.velocities, 1.5);
  grid.factor(q.rows);
  grid.factor(p.rows);
  anew.begin(p.members, p.velocities, 1.5);
  anew.factor(p.rows);
  EXPECT_EQ(grid.dense(), anew.dense());
}

TEST(CoarseGrid, LargeSlabsOnEachOtherTakeFewIterations) {
  // More nodes each than make a body large (ContactPreconditioner::kLarge), of meshes that do not match.
  WorldOptions options = options_at(0.02);
  options.time_step = 0.01;
  World w(options);
  FemOptions o;
  o.density = 1000, o.young = 1e5, o.stiffness_damping = 0.0;
  for (int b = 0; b < 2; ++b) {
    TetMesh mesh = block(56, 56, 3, 0.04 + 0.0008 * b);
    if (b == 0)
      for (std::int32_t i = 0; i < 57 * 57; ++i) o.fixed.push_back(i);
    else
      o.fixed.clear();
    ASSERT_GE(mesh.vertices.size(), ContactPreconditioner::kLarge);
    for (Vec3& x : mesh.vertices) x += b * Vec3(0.006, 0.01, 0.12);
    w.add(named<FemBody>("slab" + std::to_string(b), mesh, o));
  }
  int iterations = 0, solves = 0;
  for (int i = 0; i < 3; ++i) {
    const StepReport r = w.step();
    iterations += r.cg_iterations, solves += r.solves;
    EXPECT_GT(r.contacts, 3000u);
  }
  // 24 a solve without the grid.
  EXPECT_LE(iterations, 20 * solves);
}

}  // namespace
}  // namespace brim::testing::coarse_grid_test
