#include "brim/record/export/motion.h"

#include <algorithm>
#include <cmath>

#include "brim/math/svd3.h"

namespace brim::exporting {

void Film::add(const Job& job, const Frame& frame) {
  times.push_back(frame.time);
  indices.push_back(frame.index);
  samples.resize(job.items.size());
  present.resize(job.items.size());
  positions.resize(job.items.size());
  triangles.resize(job.items.size());
  velocities.resize(job.items.size());
  for (std::size_t i = 0; i < job.items.size(); ++i) {
    present[i].push_back(frame.gone[i] == 0 ? 1 : 0);
    if (frame.gone[i] != 0 || (job.items[i].still && !samples[i].empty())) continue;
    samples[i].push_back(static_cast<std::size_t>(frame.order));
    positions[i].push_back(frame.positions[i]);
    if (job.items[i].recorded->changing) triangles[i].push_back(frame.triangles[i]);
    velocities[i].push_back(frame.velocities[i]);
  }
  contacts.push_back(frame.contacts);
}

bool Film::always(std::size_t item) const { return std::ranges::find(present[item], 0) == present[item].end(); }

std::vector<std::size_t> Film::changes(std::size_t item) const {
  std::vector<std::size_t> list;
  for (std::size_t f = 0; f < present[item].size(); ++f)
    if (f == 0 || present[item][f] != present[item][f - 1]) list.push_back(f);
  return list;
}

namespace {

using Points = Eigen::Matrix3Xd;

/// Rotation that brings the columns of a, both about their means, closest to those of b.
Mat3 best_rotation(const Points& a, const Points& b) { return polar_rotation(b * a.transpose()); }

Points centred(const std::vector<Vec3f>& x, Vec3& mean) {
  Points p(3, static_cast<Eigen::Index>(x.size()));
  for (std::size_t i = 0; i < x.size(); ++i) p.col(static_cast<Eigen::Index>(i)) = x[i].cast<double>();
  mean = p.rowwise().mean();
  p.colwise() -= mean;
  return p;
}

}  // namespace

std::vector<std::vector<Vec3f>> cut(const std::vector<std::vector<Vec3f>>& frames, const RecordedPiece& piece) {
  std::vector<std::vector<Vec3f>> own;
  for (const std::vector<Vec3f>& frame : frames) {
    const auto first = frame.begin() + static_cast<std::ptrdiff_t>(piece.first_vertex);
    own.emplace_back(first, first + static_cast<std::ptrdiff_t>(piece.vertices));
  }
  return own;
}

std::vector<Triangle> cut(const std::vector<Triangle>& triangles, const RecordedPiece& piece) {
  const auto first = static_cast<std::int32_t>(piece.first_vertex),
             end = first + static_cast<std::int32_t>(piece.vertices);
  std::vector<Triangle> own;
  for (const Triangle& t : triangles)
    if (t[0] >= first && t[0] < end) own.push_back({t[0] - first, t[1] - first, t[2] - first});
  return own;
}

std::optional<RigidMotion> find_rigid_motion(const std::vector<std::vector<Vec3f>>& frames) {
  if (frames.empty() || frames.front().size() < 3) return std::nullopt;
  RigidMotion motion;
  Vec3 mean;
  const Points first = centred(frames.front(), mean);
  for (Eigen::Index i = 0; i < first.cols(); ++i) motion.local.push_back(first.col(i).cast<float>());
  for (const std::vector<Vec3f>& frame : frames) {
    const Points now = centred(frame, mean);
    const Mat3 rotation = best_rotation(first, now);
    const double reach = mean.cwiseAbs().maxCoeff() + now.cwiseAbs().maxCoeff();
    const double stray = (rotation * first - now).cwiseAbs().maxCoeff();
    if (!(stray <= 4e-6 * reach)) return std::nullopt;  // also for what is not a number
    Placement p{Quat(rotation).normalized(), mean};
    if (!motion.placements.empty() && p.rotation.dot(motion.placements.back().rotation) < 0.0)
      p.rotation.coeffs() *= -1.0;
    motion.placements.push_back(p);
  }
  return motion;
}

}  // namespace brim::exporting
