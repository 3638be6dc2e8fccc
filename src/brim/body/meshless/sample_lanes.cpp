#include "brim/body/meshless/sample_lanes.h"

#include <cstring>

#include "brim/body/fem/elastic_lanes.h"

namespace brim {

namespace {

using namespace elastic_lanes;

/// F of one half of the samples.
BRIM_INLINE void deformation(const SampleLanes& samples, const double* x, int at, Mat3L& F) {
  for (auto& row : F)
    for (Lanes& entry : row) entry = Lanes{};
  for (std::size_t k = 0; k < samples.frames; ++k) {
    const double* g = samples.gradient + 3 * SampleLanes::kCount * k + at;
    const double* q = x + 3 * SampleLanes::kCount * k + at;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t c = 0; c < 3; ++c)
        F[r][c] += load_lanes(q + SampleLanes::kCount * r) * load_lanes(g + SampleLanes::kCount * c);
  }
}

/// The gradient of a frame in the principal frame.
BRIM_INLINE void turn(const SampleLanes& samples, const Mat3W& W, std::size_t k, WideFloats (&a)[3]) {
  const double* g = samples.gradient + 3 * SampleLanes::kCount * k;
  const WideFloats g0 = narrow(g), g1 = narrow(g + SampleLanes::kCount), g2 = narrow(g + 2 * SampleLanes::kCount);
  for (int i = 0; i < 3; ++i) a[i] = W[i][0] * g0 + W[i][1] * g1 + W[i][2] * g2;
}

}  // namespace

BRIM_WIDE void energy(ElasticLaw law, const Lame& lame, const SampleLanes& samples, const double* x, double* out) {
  for (int at = 0; at < kWideLanes; at += kLanes) {
    Mat3L F;
    deformation(samples, x, at, F);
    store_lanes(out + at, Lanes(load_lanes(samples.volume + at) * density(law, lame, F)));
  }
}

BRIM_WIDE void respond(ElasticLaw law, const Lame& lame, const SampleLanes& samples, const double* x, double* force,
                       float* block) {
  constexpr std::size_t kCount = SampleLanes::kCount;
  double rotation[3][3][kCount], left[3][3][kCount], volume[kCount];
  for (int at = 0; at < kWideLanes; at += kLanes) {
    Mat3L F, P, R;
    deformation(samples, x, at, F);
    split(law, lame, F, at, rotation, left, R, P);
    const Lanes v = load_lanes(samples.volume + at);
    store_lanes(volume + at, v);
    for (std::size_t k = 0; k < samples.frames; ++k) {
      const double* g = samples.gradient + 3 * kCount * k + at;
      const Lanes g0 = load_lanes(g), g1 = load_lanes(g + kCount), g2 = load_lanes(g + 2 * kCount);
      for (std::size_t r = 0; r < 3; ++r)
        store_lanes(force + kCount * (3 * k + r) + at, Lanes(-v * (P[r][0] * g0 + P[r][1] * g1 + P[r][2] * g2)));
    }
  }
  PrincipalFrame frame;
  principal_frame(law, lame, true, rotation, left, volume, frame);
  for (std::size_t k = 0; k < samples.frames; ++k) {
    WideFloats a[3], b[3];
    turn(samples, frame.W, k, a);
    for (std::size_t l = k + 1; l < samples.frames; ++l, block += 9 * kCount) {
      turn(samples, frame.W, l, b);
      float out[9][kCount];
      store_block(frame.response, frame.Q, a, b, out);
      std::memcpy(block, out, sizeof out);
    }
  }
}

}  // namespace brim
