#include "brim/mesh/kinked_cells.h"

#include <algorithm>
#include <cmath>

#include "brim/core/parallel.h"

namespace brim {

namespace {

/// What is set at nodes −1 to 2 around each along an axis; border nodes stand for those beyond.
/// @param stride  from node to node  @param count  nodes along the axis
void spread(std::vector<std::uint8_t>& flags, std::size_t stride, std::size_t count) {
  const std::size_t block = stride * count;
  parallel_for(flags.size() / block, [&](std::size_t b) {
    std::uint8_t* const first = flags.data() + b * block;
    std::vector<std::uint8_t> before(first, first + block);
    for (std::size_t i = 0; i < count; ++i)
      for (const int other : {-1, 1, 2}) {
        const auto j =
            static_cast<std::size_t>(std::clamp(static_cast<int>(i) + other, 0, static_cast<int>(count) - 1));
        for (std::size_t k = 0; k < stride; ++k) first[i * stride + k] |= before[j * stride + k];
      }
  });
}

}  // namespace

KinkedCells::KinkedCells(const std::vector<float>& values, const Vec3i& nodes, double spacing) {
  const auto nx = static_cast<std::size_t>(nodes.x()), ny = static_cast<std::size_t>(nodes.y()),
             nz = static_cast<std::size_t>(nodes.z()), nxy = nx * ny;
  std::vector<std::uint8_t> flags(values.size(), 0);
  const auto most = static_cast<float>(kBend * spacing);
  parallel_for(nz, [&](std::size_t k) {
    for (std::size_t j = 0; j < ny; ++j)
      for (std::size_t i = 0; i < nx; ++i) {
        const std::size_t n = i + nx * j + nxy * k;
        const auto bent = [&](std::size_t at, std::size_t count, std::size_t stride) {
          if (at == 0 || at + 1 == count) return false;
          return std::abs((values[n - stride] - values[n]) + (values[n + stride] - values[n])) > most;
        };
        flags[n] = static_cast<std::uint8_t>(bent(i, nx, 1) || bent(j, ny, nx) || bent(k, nz, nxy));
      }
  });
  spread(flags, 1, nx), spread(flags, nx, ny), spread(flags, nxy, nz);
  bits_.assign(flags.size() / 32 + 1, 0);
  for (std::size_t n = 0; n < flags.size(); ++n) bits_[n >> 5] |= std::uint32_t{flags[n]} << (n & 31);
}

}  // namespace brim
