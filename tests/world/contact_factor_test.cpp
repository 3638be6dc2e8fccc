#include "brim/world/contact_factor.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "brim/body/fem/fem_body.h"
#include "brim/body/points/points_body.h"
#include "support/dense_contacts.h"
#include "support/soft_worlds.h"
#include "support/solids.h"

namespace brim::testing::contact_factor_test {
namespace {

constexpr unsigned kSeed = 7;

TetMesh cube(int n) { return block(n, n, n, 0.2); }

std::unique_ptr<Body> soft_cube() {
  FemOptions soft;
  soft.fixed = {0};
  return std::make_unique<FemBody>(cube(3), soft);
}

/// Something of many nodes, a ball and a box, with contacts made up between them.
struct Problem {
  std::vector<std::unique_ptr<Body>> bodies;
  std::vector<std::size_t> first_v{0}, first_block{0};
  std::vector<std::uint8_t> sparse;
  BlockDiagonal diagonal;
  ContactRows rows;
  Eigen::MatrixXd A;  ///< the whole system

  explicit Problem(int contacts, std::unique_ptr<Body> many = soft_cube()) {
    bodies.push_back(std::move(many));
    bodies.push_back(ball("ball", {Vec3(0, 0, 2)}));
    bodies.push_back(box("box", {Vec3(0, 2, 0), Quat(0.9, 0.1, 0.2, 0.3).normalized()}));
    std::vector<int> sizes;
    for (auto& b : bodies) {
      std::vector<double> q(b->q_size()), v(b->v_size());
      b->initial_state(q, v);
      b->update(0.0, q, v);
      b->begin_solve(0.01);
      first_v.push_back(first_v.back() + b->v_size());
      const auto s = b->block_sizes();
      sizes.insert(sizes.end(), s.begin(), s.end());
      first_block.push_back(sizes.size());
    }
    sparse.assign(bodies.size(), 1);
    diagonal.reset(sizes);
    for (std::size_t b = 0; b < bodies.size(); ++b) bodies[b]->add_system_diagonal(first_block[b], diagonal);
    A = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(first_v.back()), static_cast<Eigen::Index>(first_v.back()));
    for (std::size_t b = 0; b < bodies.size(); ++b)
      for (std::size_t k = first_v[b]; k < first_v[b + 1]; ++k) {
        std::vector<double> x(bodies[b]->v_size(), 0.0), y(x.size(), 0.0);
        x[k - first_v[b]] = 1.0;
        bodies[b]->apply_system(x, y);
        for (std::size_t i = 0; i < y.size(); ++i)
          A(static_cast<Eigen::Index>(first_v[b] + i), static_cast<Eigen::Index>(k)) = y[i];
      }
    add_contacts(contacts);
  }

  void add_contacts(int contacts) {
    std::mt19937 rng(kSeed);
    std::normal_distribution<float> normal;
    const auto per_node = static_cast<std::int32_t>(velocities_per_node(*bodies[0]));
    std::uniform_int_distribution<std::int32_t> node(0, static_cast<std::int32_t>(first_v[1]) / per_node - 1);
    rows.first = {0};
    const auto add = [&](std::int32_t offset, const auto& J) { rows.offset.push_back(offset), rows.blocks.add(J); };
    for (int c = 0; c < contacts; ++c) {
      const int rigid = c % 2 + 1;
      for (int k = 0; k < 4; ++k) add(per_node * node(rng), 0.25f);
      const Vec3 arm(normal(rng), normal(rng), normal(rng));
      add(static_cast<std::int32_t>(first_v[rigid]), -1.0f);
      add(static_cast<std::int32_t>(first_v[rigid]) + 3, Eigen::Matrix3f(skew(arm).cast<float>()));
      const Eigen::Vector3f n = Eigen::Vector3f(normal(rng), normal(rng), normal(rng)).normalized();
      rows.contact.push_back(static_cast<std::uint32_t>(c));
      rows.stiffness.push_back(200.0f * n * n.transpose() + Eigen::Matrix3f::Identity());
      rows.first.push_back(static_cast<std::int32_t>(rows.offset.size()));
    }
    add_contact_stiffness(rows, A);
  }
};

/// Velocities of the problem that some contact touches and none prescribes.
std::vector<Eigen::Index> touched(const Problem& p) {
  std::vector<std::uint8_t> is(p.first_v.back(), 0);
  for (const std::int32_t o : p.rows.offset)
    for (int a = 0; a < 3; ++a) is[static_cast<std::size_t>(o + a)] = 1;
  for (int a = 0; a < 3; ++a) is[a] = 0;
  std::vector<Eigen::Index> list;
  for (std::size_t v = 0; v < is.size(); ++v)
    if (is[v]) list.push_back(static_cast<Eigen::Index>(v));
  return list;
}

TEST(ContactFactor, SolvesExactlyWhatContactTouches) {
  SCOPED_TRACE(kSeed);
  const Problem p(12);
  ContactFactor factor;
  factor.begin(p.bodies, p.first_v, p.diagonal, p.first_block, p.sparse);
  factor.factor(p.rows, {});
  const auto t = touched(p);
  ASSERT_EQ(3 * factor.touched(), t.size());
  const Eigen::VectorXd r = Eigen::VectorXd::Random(p.A.rows());
  std::vector<double> z(p.first_v.back(), -7.0);
  factor.apply(std::span(r.data(), z.size()), z);
  const Eigen::VectorXd exact = Eigen::MatrixXd(p.A(t, t)).llt().solve(Eigen::VectorXd(r(t)));
  double error = 0.0;
  for (std::size_t i = 0; i < t.size(); ++i)
    error = std::max(error, std::abs(z[static_cast<std::size_t>(t[i])] - exact[static_cast<Eigen::Index>(i)]));
  EXPECT_LT(error, 1e-4 * exact.cwiseAbs().maxCoeff());  // single precision times the condition
  for (std::size_t v = 0; v < z.size(); ++v)
    if (std::find(t.begin(), t.end(), static_cast<Eigen::Index>(v)) == t.end()) {
      EXPECT_EQ(z[v], -7.0) << v;
    }
}

TEST(ContactFactor, InPiecesItIsTheInverseOfTheirBlocks) {
  SCOPED_TRACE(kSeed);
  const Problem p(40);
  ContactFactor factor;
  factor.begin(p.bodies, p.first_v, p.diagonal, p.first_block, p.sparse);
  factor.factor(p.rows, {.whole = 8, .cluster = 8});
  // The answers to unit vectors tell the pieces; each must be the inverse of its part of A.
  const auto t = touched(p);
  const auto n = static_cast<Eigen::Index>(t.size());
  Eigen::MatrixXd P(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    std::vector<double> r(p.first_v.back(), 0.0), z(r);
    r[static_cast<std::size_t>(t[k])] = 1.0;
    factor.apply(r, z);
    for (Eigen::Index i = 0; i < n; ++i) P(i, k) = z[static_cast<std::size_t>(t[i])];
  }
  std::size_t least = t.size();
  for (Eigen::Index k = 0; k < n; ++k) {
    std::vector<Eigen::Index> piece, local;
    for (Eigen::Index i = 0; i < n; ++i)
      if (P(i, k) != 0.0) piece.push_back(t[i]), local.push_back(i);
    least = std::min(least, piece.size());
    EXPECT_LE(piece.size(), 24u);
    const Eigen::MatrixXd inverse = Eigen::MatrixXd(p.A(piece, piece)).inverse();
    EXPECT_LT((P(local, local) - inverse).norm(), 1e-3 * inverse.norm());
  }
  EXPECT_LT(least, t.size());
}

/// The factor's answer to a vector that is always the same.
std::vector<double> answer(ContactFactor& factor, const Problem& p) {
  std::vector<double> r(p.first_v.back()), z(r.size(), 0.0);
  for (std::size_t i = 0; i < r.size(); ++i) r[i] = std::sin(static_cast<double>(i));
  factor.apply(r, z);
  return z;
}

TEST(ContactFactor, FactorsOtherStiffnessAsIfItWereNew) {
  Problem p(40);
  ContactFactor again, anew;
  for (ContactFactor* f : {&again, &anew}) f->begin(p.bodies, p.first_v, p.diagonal, p.first_block, p.sparse);
  again.factor(p.rows, {});
  for (std::size_t i = 0; i < p.rows.size(); ++i) p.rows.stiffness[i] *= i % 3 == 0 ? 3.0f : 1.5f;
  again.refactor(p.rows);
  anew.factor(p.rows, {});
  ASSERT_EQ(again.touched(), anew.touched());
  EXPECT_EQ(answer(again, p), answer(anew, p));
}

TEST(ContactFactor, WhatIsDoneBesideItIsDoneOnceWhereItIsNotTheWholeSystem) {
  Problem p(40);
  ContactFactor factor;
  factor.begin(p.bodies, p.first_v, p.diagonal, p.first_block, p.sparse);
  int calls = 0;
  const auto beside = [&] { ++calls; };
  factor.factor(p.rows, {}, beside);
  ASSERT_FALSE(factor.complete());  // of the block only what is touched
  EXPECT_EQ(calls, 1);
  factor.refactor(p.rows, beside);
  EXPECT_EQ(calls, 2);
  // Two rigid bodies that are all there is.
  Problem rigid(40);
  for (std::int32_t& o : rigid.rows.offset)
    if (o < static_cast<std::int32_t>(rigid.first_v[1])) o = static_cast<std::int32_t>(rigid.first_v[1]);
  rigid.bodies.erase(rigid.bodies.begin());
  const std::size_t gone = rigid.first_v[1];
  rigid.first_v = {0, 6, 12}, rigid.first_block = {0, 1, 2}, rigid.sparse = {1, 1};
  rigid.diagonal.reset(std::vector<int>{6, 6});
  for (std::size_t b = 0; b < 2; ++b) rigid.bodies[b]->add_system_diagonal(b, rigid.diagonal);
  for (std::int32_t& o : rigid.rows.offset) o -= static_cast<std::int32_t>(gone);
  ContactFactor whole;
  whole.begin(rigid.bodies, rigid.first_v, rigid.diagonal, rigid.first_block, rigid.sparse);
  whole.factor(rigid.rows, {}, beside);
  EXPECT_TRUE(whole.complete());
  EXPECT_EQ(calls, 2);
}

TEST(ContactFactor, KeepsItsClustersForOtherStiffness) {
  Problem p(40);
  ContactFactor factor;
  factor.begin(p.bodies, p.first_v, p.diagonal, p.first_block, p.sparse);
  factor.factor(p.rows, {.whole = 8, .cluster = 8});
  const std::vector<double> first = answer(factor, p);
  const auto stiffness = p.rows.stiffness;
  for (std::size_t i = 0; i < p.rows.size(); ++i) p.rows.stiffness[i] *= i % 3 == 0 ? 3.0f : 1.5f;
  factor.refactor(p.rows);
  EXPECT_NE(answer(factor, p), first);
  p.rows.stiffness = stiffness;
  factor.refactor(p.rows);
  EXPECT_EQ(answer(factor, p), first);
}

/// Grains of which many overlap, two are held, and some are far from all others.
std::unique_ptr<Body> grains(bool turn) {
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> place(-0.3, 0.3);
  std::vector<Vec3> x;
  for (int i = 0; i < 40; ++i) x.emplace_back(place(rng), place(rng), i < 30 ? place(rng) : 2.0 * i);
  PointsOptions o;
  o.radius = {0.1};
  o.density = 1000.0;
  o.young = 1e4;
  o.turn = turn;
  o.fixed = {0, 7};
  return std::make_unique<PointsBody>(x, o);
}

TEST(ContactFactor, GrainsThatTouchEachOtherTakePart) {
  SCOPED_TRACE(kSeed);
  for (const bool turn : {true, false}) {
    const Problem p(6, grains(turn));
    ContactFactor factor;
    factor.begin(p.bodies, p.first_v, p.diagonal, p.first_block, p.sparse);
    factor.factor(p.rows, {});
    // Blocks of six that something ties to others, without what is held.
    std::vector<Eigen::Index> t;
    for (Eigen::Index v = 0; v < p.A.rows(); ++v) {
      const Eigen::Index first = v / 6 * 6;
      const bool tied = (p.A.middleRows<6>(first).squaredNorm() - p.A.block<6, 6>(first, first).squaredNorm()) > 1e-9;
      const bool held = first == 0 || first == 42 || (!turn && v < 240 && v % 6 >= 3);
      if (tied && !held) t.push_back(v);
    }
    ASSERT_GT(t.size(), 100u);
    ASSERT_LT(t.size(), static_cast<std::size_t>(p.A.rows()));
    ASSERT_EQ(3 * factor.touched(), t.size());
    const Eigen::VectorXd r = Eigen::VectorXd::Random(p.A.rows());
    std::vector<double> z(p.first_v.back(), 0.0);
    factor.apply(std::span(r.data(), z.size()), z);
    const Eigen::VectorXd exact = Eigen::MatrixXd(p.A(t, t)).llt().solve(Eigen::VectorXd(r(t)));
    for (std::size_t i = 0; i < t.size(); ++i)
      EXPECT_NEAR(z[static_cast<std::size_t>(t[i])], exact[static_cast<Eigen::Index>(i)],
                  1e-3 * exact.cwiseAbs().maxCoeff());  // single precision times the condition
  }
}

TEST(ContactFactor, BodiesWithoutRowsAreLeftOut) {
  const Problem p(12);
  std::vector<std::uint8_t> sparse = {0, 1, 1};
  ContactFactor factor;
  factor.begin(p.bodies, p.first_v, p.diagonal, p.first_block, sparse);
  factor.factor(p.rows, {});
  EXPECT_EQ(factor.touched(), 4u);  // two rigid bodies, two blocks each
}

TEST(ContactFactor, TakesASheetWholeSoThatItNeedsFewIterations) {
  World w(options_at(0.1));
  w.add(ground(0.5));
  w.add(sheet("sheet", 2.0, Vec3(0, 0, 0.06)));
  double iterations = 0.0, solves = 0.0;
  std::int64_t contacts = 0;
  for (int s = 0; s < 20; ++s) {
    const StepReport r = w.step();
    iterations += r.cg_iterations, solves += r.solves, contacts += r.contacts;
  }
  ASSERT_GT(contacts, 1000);
  EXPECT_LE(iterations, 4.0 * solves);
}

}  // namespace
}  // namespace brim::testing::contact_factor_test
