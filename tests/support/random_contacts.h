#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "brim/solve/contact_responses.h"

namespace brim::testing {

/// Contacts that are rows R of the velocities of masses that hang together, P the inverse of their masses.
inline ContactResponses responses_of(const Eigen::MatrixXd& R, const Eigen::MatrixXd& P) {
  ContactResponses all;
  const Eigen::MatrixXd PRt = P * R.transpose();
  for (Eigen::Index c = 0; c < R.rows() / 3; ++c) {
    std::vector<ContactEntry> entries;
    for (Eigen::Index i = 0; i < R.cols(); ++i)
      entries.push_back({static_cast<std::size_t>(i), R.block<3, 1>(3 * c, i), PRt.block<1, 3>(i, 3 * c).transpose()});
    all.add(entries);
  }
  return all;
}

struct RandomContacts {
  Eigen::MatrixXd R, P;
  ContactResponses responses;

  /// @param seen  velocities that each contact sees
  RandomContacts(int contacts, int velocities, int seen, std::mt19937& rng) {
    std::normal_distribution<double> normal;
    const auto random = [&](int rows, int columns) {
      return Eigen::MatrixXd(Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(rng); }));
    };
    R = random(3 * contacts, velocities);
    std::vector<int> order(static_cast<std::size_t>(velocities));
    std::iota(order.begin(), order.end(), 0);
    for (int c = 0; c < contacts; ++c) {
      std::shuffle(order.begin(), order.end(), rng);
      for (std::size_t i = static_cast<std::size_t>(seen); i < order.size(); ++i)
        R.block<3, 1>(3 * c, order[i]).setZero();
    }
    const Eigen::MatrixXd B = random(velocities, velocities);
    P = B * B.transpose() + Eigen::MatrixXd::Identity(velocities, velocities);
    responses = responses_of(R, P);
  }
};

}  // namespace brim::testing
