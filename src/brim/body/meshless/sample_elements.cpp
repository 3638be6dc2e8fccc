#include "brim/body/meshless/sample_elements.h"

#include <algorithm>

#include "brim/core/error.h"

namespace brim {

SampleElements::SampleElements(ShapeFunctions shape, std::vector<double> volume, ElasticLaw law, const Lame& lame,
                               std::span<const Vec3> frames)
    : shape_(std::move(shape)), volume_(std::move(volume)), law_(law), lame_(lame) {
  BRIM_CHECK(shape_.rows.rows(), ==, volume_.size());
  // The schedule wants as many frames for each sample: shorter lists repeat their first.
  std::size_t most = 0;
  for (std::size_t s = 0; s < size(); ++s) most = std::max(most, frames_of(s));
  std::vector<std::int32_t> padded;
  for (std::size_t s = 0; s < size(); ++s)
    for (std::size_t k = 0; k < most; ++k)
      padded.push_back(shape_.rows.source[static_cast<std::size_t>(shape_.rows.first[s]) + (k < frames_of(s) ? k : 0)]);
  schedule_.build(padded, static_cast<int>(most), frames);

  std::vector<std::size_t> chunk_end((size() + ElementSchedule::kChunk - 1) / ElementSchedule::kChunk + 1, 0);
  schedule_.for_chunks([&](std::size_t begin, std::size_t end) {
    chunk_end[(begin + ElementSchedule::kChunk - 1) / ElementSchedule::kChunk] = end;
  });
  std::vector<std::size_t> samples;
  for (std::size_t c = 0, begin = 0; begin < size(); begin = chunk_end[c++]) {
    const auto order = schedule_.order().subspan(begin, chunk_end[c] - begin);
    samples.assign(order.begin(), order.end());
    std::stable_sort(samples.begin(), samples.end(),
                     [&](std::size_t a, std::size_t b) { return frames_of(a) < frames_of(b); });
    for (std::size_t k = 0; k < samples.size(); k += kLanes)
      add_group(std::span(samples).subspan(k, std::min(kLanes, samples.size() - k)));
  }
}

void SampleElements::add_group(std::span<const std::size_t> samples) {
  const std::size_t n = frames_of(samples.back()), pairs = n * (n - 1) / 2 * kLanes;
  group_.push_back({n, samples.size(), node_.size(), pair_.size()});
  node_.resize(node_.size() + n * kLanes);
  gradient_.resize(gradient_.size() + 3 * n * kLanes);
  pair_.resize(pair_.size() + pairs, -1);
  const std::size_t at = group_.back().node;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const std::size_t s = samples[std::min(lane, samples.size() - 1)];
    const auto first = static_cast<std::size_t>(shape_.rows.first[s]);
    lane_volume_.push_back(volume_[s]);
    for (std::size_t k = 0; k < n; ++k) {
      const bool has = k < frames_of(s);
      node_[at + kLanes * k + lane] = shape_.rows.source[first + (has ? k : 0)];
      for (std::size_t c = 0; c < 3; ++c)
        gradient_[3 * at + kLanes * (3 * k + c) + lane] =
            has ? shape_.gradient[first + k][static_cast<Eigen::Index>(c)] : 0.0;
    }
  }
}

SampleLanes SampleElements::lanes(std::size_t group) const {
  return {group_[group].frames, gradient_.data() + 3 * group_[group].node, lane_volume_.data() + kLanes * group};
}

void SampleElements::add_pattern(BlockMatrix& matrix) const {
  for (std::size_t s = 0; s < size(); ++s) {
    const auto n = shape_.rows.first[s + 1] - shape_.rows.first[s];
    matrix.add_elements(std::span(shape_.rows.source)
                            .subspan(static_cast<std::size_t>(shape_.rows.first[s]), static_cast<std::size_t>(n)),
                        n);
  }
}

void SampleElements::find_pairs(const BlockMatrix& matrix) {
  for (const Group& g : group_) {
    const std::int32_t* node = node_.data() + g.node;
    std::int32_t* pair = pair_.data() + g.pair;
    for (std::size_t i = 0; i < g.frames; ++i)
      for (std::size_t j = i + 1; j < g.frames; ++j)
        for (std::size_t lane = 0; lane < kLanes; ++lane, ++pair) {
          const std::int32_t a = node[kLanes * i + lane], b = node[kLanes * j + lane];
          // Frames ascend; one that is missing repeats the first.
          *pair = lane < g.samples && a < b ? matrix.pair(a, b) : -1;
        }
  }
}

Mat3 SampleElements::deformation(std::size_t s, std::span<const Vec3> x) const {
  Mat3 F = Mat3::Zero();
  for (std::int32_t e = shape_.rows.first[s]; e < shape_.rows.first[s + 1]; ++e)
    F += x[static_cast<std::size_t>(shape_.rows.source[static_cast<std::size_t>(e)])] *
         shape_.gradient[static_cast<std::size_t>(e)].transpose();
  return F;
}

void SampleElements::take(const Group& g, std::span<const Vec3> x, std::vector<double>& out) const {
  out.resize(3 * kLanes * g.frames);
  const std::int32_t* node = node_.data() + g.node;
  for (std::size_t k = 0; k < g.frames; ++k)
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const Vec3& q = x[static_cast<std::size_t>(node[kLanes * k + lane])];
      for (std::size_t c = 0; c < 3; ++c) out[kLanes * (3 * k + c) + lane] = q[static_cast<Eigen::Index>(c)];
    }
}

void SampleElements::add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness) const {
  schedule_.for_chunks([&](std::size_t begin, std::size_t end) {
    std::vector<double> q, f;
    std::vector<float> block;
    for (std::size_t i = first_group(begin), last = i + (end - begin + kLanes - 1) / kLanes; i < last; ++i) {
      const Group& g = group_[i];
      const std::size_t pairs = g.frames * (g.frames - 1) / 2;
      take(g, x, q);
      f.resize(q.size());
      block.resize(9 * kLanes * pairs);
      respond(law_, lame_, lanes(i), q.data(), f.data(), block.data());
      const std::int32_t *node = node_.data() + g.node, *pair = pair_.data() + g.pair;
      for (std::size_t k = 0; k < g.frames; ++k)
        for (std::size_t lane = 0; lane < g.samples; ++lane)
          for (std::size_t c = 0; c < 3; ++c)
            force[static_cast<std::size_t>(node[kLanes * k + lane])][static_cast<Eigen::Index>(c)] +=
                f[kLanes * (3 * k + c) + lane];
      for (std::size_t p = 0; p < pairs; ++p)
        for (std::size_t lane = 0; lane < g.samples; ++lane) {
          const std::int32_t slot = pair[kLanes * p + lane];
          if (slot < 0) continue;
          float* to = stiffness.values(slot);
          for (std::size_t k = 0; k < 9; ++k) to[k] += block[kLanes * (9 * p + k) + lane];
        }
    }
  });
}

double SampleElements::energy(std::span<const Vec3> x) const {
  std::vector<double> of_sample(size());
  schedule_.for_chunks([&](std::size_t begin, std::size_t end) {
    std::vector<double> q;
    double e[kLanes];
    for (std::size_t i = first_group(begin), at = begin; at < end; ++i, at += kLanes) {
      take(group_[i], x, q);
      brim::energy(law_, lame_, lanes(i), q.data(), e);
      std::copy_n(e, group_[i].samples, of_sample.data() + at);
    }
  });
  double sum = 0.0;
  for (const double e : of_sample) sum += e;
  return sum;
}

}  // namespace brim
