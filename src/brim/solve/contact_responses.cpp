#include "brim/solve/contact_responses.h"

#include <cmath>

namespace brim {

namespace {

Eigen::Index at(std::size_t c) { return static_cast<Eigen::Index>(3 * c); }

}  // namespace

void ContactResponses::add(std::span<const ContactEntry> entries) {
  for (const ContactEntry& e : entries) {
    if (e.row == Vec3::Zero() && e.response == Vec3::Zero()) continue;
    if (e.index >= place_.size()) place_.resize(e.index + 1, -1);
    std::ptrdiff_t& place = place_[e.index];
    if (place < 0) place = static_cast<std::ptrdiff_t>(width_++);
    entries_.push_back({static_cast<std::size_t>(place), e.row, e.response});
  }
  first_.push_back(entries_.size());
}

Mat3 ContactResponses::local(std::size_t c) const {
  Mat3 W = Mat3::Zero();
  for (std::size_t i = first_[c]; i < first_[c + 1]; ++i) W += entries_[i].row * entries_[i].response.transpose();
  return W;
}

void ContactResponses::scale(std::size_t c, double s) {
  for (std::size_t i = first_[c]; i < first_[c + 1]; ++i) entries_[i].row *= s, entries_[i].response *= s;
}

Vec3 ContactResponses::velocity(std::size_t c, const Eigen::VectorXd& t) const {
  Vec3 u = Vec3::Zero();
  for (std::size_t i = first_[c]; i < first_[c + 1]; ++i)
    u += entries_[i].row * t[static_cast<Eigen::Index>(entries_[i].index)];
  return u;
}

void ContactResponses::respond(const Eigen::VectorXd& impulse, Eigen::VectorXd& t) const {
  t.setZero(static_cast<Eigen::Index>(width_));
  for (std::size_t c = 0; c < size(); ++c) {
    const Vec3 own = impulse.segment<3>(at(c));
    for (std::size_t i = first_[c]; i < first_[c + 1]; ++i)
      t[static_cast<Eigen::Index>(entries_[i].index)] += entries_[i].response.dot(own);
  }
}

Eigen::MatrixXd ContactResponses::dense() const {
  Eigen::MatrixXd W(at(size()), at(size()));
  Eigen::VectorXd t = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(width_));
  for (std::size_t c = 0; c < size(); ++c)
    for (int k = 0; k < 3; ++k) {
      for (std::size_t i = first_[c]; i < first_[c + 1]; ++i)
        t[static_cast<Eigen::Index>(entries_[i].index)] = entries_[i].response[k];
      for (std::size_t d = 0; d < size(); ++d) W.block<3, 1>(at(d), at(c) + k) = velocity(d, t);
      for (std::size_t i = first_[c]; i < first_[c + 1]; ++i) t[static_cast<Eigen::Index>(entries_[i].index)] = 0.0;
    }
  return W;
}

void ContactResponses::multiply(const Eigen::VectorXd& impulse, Eigen::VectorXd& u) const {
  respond(impulse, t_);
  u.resize(at(size()));
  for (std::size_t c = 0; c < size(); ++c) u.segment<3>(at(c)) = velocity(c, t_);
}

bool ContactResponses::factor(double shift) {
  shift_ = shift;
  const auto m = static_cast<Eigen::Index>(width_);
  Eigen::MatrixXd K = shift * Eigen::MatrixXd::Identity(m, m);
  for (std::size_t c = 0; c < size(); ++c)
    for (std::size_t j = first_[c]; j < first_[c + 1]; ++j) {
      if (entries_[j].row == Vec3::Zero()) continue;
      auto column = K.col(static_cast<Eigen::Index>(entries_[j].index));
      for (std::size_t i = first_[c]; i < first_[c + 1]; ++i)
        column[static_cast<Eigen::Index>(entries_[i].index)] += entries_[i].response.dot(entries_[j].row);
    }
  factor_.compute(K);
  const auto pivots = factor_.matrixLU().diagonal();
  return pivots.allFinite() && (pivots.array() != 0.0).all();
}

void ContactResponses::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  respond(b, t_);
  t_ = factor_.solve(t_);
  x.resize(b.size());
  for (std::size_t c = 0; c < size(); ++c) x.segment<3>(at(c)) = (b.segment<3>(at(c)) - velocity(c, t_)) / shift_;
}

}  // namespace brim
