#include "brim/world/direct_rows.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

void DirectRows::begin(std::size_t bodies, std::size_t first) {
  first_ = first, size_ = 0;
  body_.resize(bodies);
  for (Rows& b : body_) b.touch.clear();
}

void DirectRows::add(std::size_t body, std::size_t contact, const std::array<std::vector<double>, 3>& force) {
  Touch t;
  t.contact = contact;
  for (std::size_t i = 0; i < force[0].size(); ++i) {
    const Vec3 row(force[0][i], force[1][i], force[2][i]);
    if (row == Vec3::Zero()) continue;
    t.index.push_back(i);
    t.row.push_back(row);
  }
  body_[body].touch.push_back(std::move(t));
}

void DirectRows::solve(const BodyInverses& inverses, std::span<const std::size_t> first_v) {
  for (std::size_t b = 0; b < body_.size(); ++b) {
    Rows& rows = body_[b];
    const std::size_t n = rows.touch.size(), nv = first_v[b + 1] - first_v[b];
    rows.first = first_ + size_;
    size_ += 3 * n;
    rows.response.assign(n * n, Mat3::Zero());
    constexpr std::size_t kContacts = BodyInverses::kTogether / 3;
    parallel_for((n + kContacts - 1) / kContacts, [&](std::size_t piece) {
      const std::size_t begin = piece * kContacts, end = std::min(n, begin + kContacts);
      BodyInverses::Together x = BodyInverses::Together::Zero(static_cast<Eigen::Index>(nv), BodyInverses::kTogether);
      for (std::size_t c = begin; c < end; ++c) {
        const Touch& from = rows.touch[c];
        for (std::size_t i = 0; i < from.index.size(); ++i)
          x.row(static_cast<Eigen::Index>(from.index[i])).segment<3>(static_cast<Eigen::Index>(3 * (c - begin))) =
              from.row[i].transpose();
      }
      inverses.solve_together(b, x);
      for (std::size_t d = 0; d < n; ++d) {
        const Touch& to = rows.touch[d];
        Eigen::Matrix<double, 3, BodyInverses::kTogether, Eigen::RowMajor> y =
            Eigen::Matrix<double, 3, BodyInverses::kTogether, Eigen::RowMajor>::Zero();
        for (std::size_t i = 0; i < to.index.size(); ++i)
          for (int axis = 0; axis < 3; ++axis)
            y.row(axis) += to.row[i][axis] * x.row(static_cast<Eigen::Index>(to.index[i]));
        for (std::size_t c = begin; c < end; ++c)
          rows.response[d + n * c] = y.middleCols<3>(static_cast<Eigen::Index>(3 * (c - begin)));
      }
    });
  }
}

void DirectRows::append(std::size_t body, std::size_t contact, std::vector<ProjectedGaussSeidel::Entry>& out) const {
  const Rows& rows = body_[body];
  const auto at = std::lower_bound(rows.touch.begin(), rows.touch.end(), contact,
                                   [](const Touch& t, std::size_t c) { return t.contact < c; });
  const std::size_t c = static_cast<std::size_t>(at - rows.touch.begin()), n = rows.touch.size();
  BRIM_CHECK(c, <, n);
  for (std::size_t d = 0; d < n; ++d)
    for (int i = 0; i < 3; ++i)
      out.push_back({rows.first + 3 * d + static_cast<std::size_t>(i),
                     d == c ? Vec3(Vec3::Unit(i)) : Vec3(Vec3::Zero()), rows.response[d + n * c].row(i).transpose()});
}

void DirectRows::read(std::span<const std::size_t> first_v, std::span<double> all) const {
  for (std::size_t b = 0; b < body_.size(); ++b)
    for (std::size_t c = 0; c < body_[b].touch.size(); ++c) {
      const Touch& t = body_[b].touch[c];
      Vec3 y = Vec3::Zero();
      for (std::size_t i = 0; i < t.index.size(); ++i) y += all[first_v[b] + t.index[i]] * t.row[i];
      for (std::size_t i = 0; i < 3; ++i) all[body_[b].first + 3 * c + i] = y[static_cast<int>(i)];
    }
}

void DirectRows::respond(const BodyInverses& inverses, std::span<const std::size_t> first_v,
                         std::span<const Vec3> lambda, std::span<double> v) const {
  parallel_for(body_.size(), [&](std::size_t b) {
    if (!holds(b)) return;
    const std::size_t nv = first_v[b + 1] - first_v[b];
    std::vector<double> force(nv, 0.0), answer(nv);
    for (const Touch& t : body_[b].touch)
      for (std::size_t i = 0; i < t.index.size(); ++i) force[t.index[i]] += t.row[i].dot(lambda[t.contact]);
    inverses.local(b, force, answer);
    for (std::size_t i = 0; i < nv; ++i) v[first_v[b] + i] += answer[i];
  });
}

}  // namespace brim
