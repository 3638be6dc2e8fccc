#pragma once

#include <cstddef>

#include "brim/body/fem/elastic_law.h"

namespace brim {

/// Samples of matter processed together, padded to the same number of frames. The sample is the last array index.
struct SampleLanes {
  static constexpr std::size_t kCount = 8;
  std::size_t frames;      ///< n of each sample; padding frames have zero gradient
  const double* gradient;  ///< [1/m] ∇φ_k, shape (n, 3, kCount)
  const double* volume;    ///< [m³] shape (kCount)
};

/// Forces on the frames of samples and their stiffness blocks (formulas: SampleElements, method: elastic_lanes.h).
/// @param x      [m] frames, shape (n, 3, kCount)
/// @param force  [N] shape (n, 3, kCount)
/// @param block  [N/m] K_kl for k < l, ascending, column by column: shape (n (n − 1) / 2, 9, kCount)
void respond(ElasticLaw law, const Lame& lame, const SampleLanes& samples, const double* x, double* force,
             float* block);
/// Their elastic energy, [J], shape (kCount).
void energy(ElasticLaw law, const Lame& lame, const SampleLanes& samples, const double* x, double* out);

}  // namespace brim
