#include "brim/raster/capsule_splat.h"

namespace brim {

BRIM_WIDE void splat_capsules(std::span<const Capsule> capsules, std::span<const std::int32_t> ids, const Vec3& origin,
                              double h, double w, Octants wanted, BlockScratch& scratch) {
  const double inverse_h = 1.0 / h;
  const WideFloats zero{}, one = wide(1.0f), lanes = lane_numbers();
  const NodeRange clip = wanted_nodes(wanted);
  for (std::size_t c = 0; c < capsules.size(); ++c) {
    const Vec3 p[2] = {in_voxels(capsules[c].a, origin, inverse_h), in_voxels(capsules[c].b, origin, inverse_h)};
    const double radius = capsules[c].radius * inverse_h, reach = radius + 0.5 * w * inverse_h;
    const NodeRange n = nodes_around(p, Vec3(reach, reach, reach), clip);
    if (n.empty()) continue;
    const Vec3 ab(p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]);
    const double length2 = dotted(ab, ab), inverse = length2 > 0.0 ? 1.0 / length2 : 0.0;
    // Place along the segment, from 0 to 1: linear in the node's place.
    const Vec3 slope = times(inverse, ab);
    const auto s_base = static_cast<float>(-dotted(slope, p[0]));
    const float sx = static_cast<float>(slope[0]), sy = static_cast<float>(slope[1]), sz = static_cast<float>(slope[2]);
    const float ax = static_cast<float>(p[0][0]), ay = static_cast<float>(p[0][1]), az = static_cast<float>(p[0][2]);
    const float ux = static_cast<float>(ab[0]), uy = static_cast<float>(ab[1]), uz = static_cast<float>(ab[2]);
    const auto r = static_cast<float>(radius);
    const RowGroups groups = row_groups(n.lo[0], n.hi[0]);
    for (int g = 0; g < groups.count; ++g) {
      const WideFloats at = lanes + static_cast<float>(groups.start[g]), along = at * sx, from_a = at - ax;
      for (int k = n.lo[2]; k <= n.hi[2]; ++k)
        for (int j = n.lo[1]; j <= n.hi[1]; ++j) {
          const float y = static_cast<float>(j), z = static_cast<float>(k);
          const WideFloats s = wide_min(wide_max(s_base + y * sy + z * sz + along, zero), one);
          const WideFloats dx = from_a - s * ux, dy = (y - ay) - s * uy, dz = (z - az) - s * uz;
          const WideFloats d = wide_root(dx * dx + dy * dy + dz * dz) - r;
          const int node = block_index(groups.start[g], j, k);
          const WideFloats kept = load_wide(scratch.value + node);
          const WideIds closer = d < kept;
          store_wide(closer ? d : kept, scratch.value + node);
          const WideIds held = load_wide(scratch.nearest + node);
          store_wide(closer ? wide(ids[c]) : held, scratch.nearest + node);
        }
    }
  }
}

BRIM_WIDE void settle_capsules(const BlockScratch& scratch, double h, double w, DensityBlock& block) {
  const float inverse_w = static_cast<float>(h / w);
  for_wanted_groups(block.octants, [&](int group) BRIM_LAMBDA_INLINE {
    const WideIds nearest = load_wide(scratch.nearest + group);
    const WideFloats near = wide_ramp(load_wide(scratch.value + group), inverse_w);
    const WideFloats rho = nearest < 0 ? wide(0.0f) : near;
    store_group(rho, rho > 0.0f ? nearest : wide(-1), group, block);
  });
}

}  // namespace brim
