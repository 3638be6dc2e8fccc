#include "brim/raster/cube_distances.h"

#include <cstring>

#include "brim/core/simd.h"
#include "brim/math/wide_vectors.h"

#define BRIM_LAMBDA_INLINE __attribute__((always_inline))

namespace brim {

namespace {

/// Places of the nodes of a row along one axis of the shape: start + i step.
struct Along {
  float start, step;
};

BRIM_INLINE CubeRow spread(float x) { return x - CubeRow{}; }
BRIM_INLINE CubeRow at(const Along& a) {
  const CubeRow steps = {0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f};
  return a.start + a.step * steps;
}
BRIM_INLINE CubeRow larger(const CubeRow& a, const CubeRow& b) { return a > b ? a : b; }
BRIM_INLINE CubeRow smaller(const CubeRow& a, const CubeRow& b) { return a < b ? a : b; }
BRIM_INLINE CubeRow positive(const CubeRow& a) { return larger(a, CubeRow{}); }
BRIM_INLINE CubeRow size_of(const CubeRow& a) { return larger(a, -a); }

/// Writes distance(x, y, z) for every wanted row; x, y, z: how far its nodes are from the cube's first, per axis.
template <class Distance>
BRIM_INLINE void for_rows(const CubeFrame& f, const NodeMask& wanted, float* d, const Distance& distance) {
  const Vec3f dx = f.dx.cast<float>(), dy = f.dy.cast<float>(), dz = f.dz.cast<float>();
  for (int k = 0; k < kCubeSize; ++k)
    for (int j = 0; j < kCubeSize; ++j) {
      if (wanted.row(j, k) == 0) continue;
      const float fj = static_cast<float>(j), fk = static_cast<float>(k);
      const Along x{fj * dy[0] + fk * dz[0], dx[0]}, y{fj * dy[1] + fk * dz[1], dx[1]},
          z{fj * dy[2] + fk * dz[2], dx[2]};
      const CubeRow row = distance(at(x), at(y), at(z));
      std::memcpy(d + cube_index(0, j, k), &row, sizeof row);
    }
}

/// |base + x| − half without loss near either face, whatever the base: the larger of (base − half) + x and
/// (−base − half) − x, each offset rounded only once.
struct Slab {
  float upper, lower;
  Slab(double base, double half) : upper(static_cast<float>(base - half)), lower(static_cast<float>(-base - half)) {}
};
BRIM_INLINE CubeRow beyond(const Slab& s, const CubeRow& x) { return larger(s.upper + x, s.lower - x); }

}  // namespace

BRIM_WIDE void sphere_distances(const CubeFrame& frame, double radius, const NodeMask& wanted, float* d) {
  const Vec3f b = frame.base.cast<float>();
  const float r = static_cast<float>(radius);
  for_rows(frame, wanted, d, [&](const CubeRow& x, const CubeRow& y, const CubeRow& z) BRIM_LAMBDA_INLINE {
    const CubeRow px = b[0] + x, py = b[1] + y, pz = b[2] + z;
    return wide_root(px * px + py * py + pz * pz) - r;
  });
}

BRIM_WIDE void box_distances(const CubeFrame& frame, const Vec3& half, const NodeMask& wanted, float* d) {
  const Slab sx(frame.base[0], half[0]), sy(frame.base[1], half[1]), sz(frame.base[2], half[2]);
  for_rows(frame, wanted, d, [&](const CubeRow& x, const CubeRow& y, const CubeRow& z) BRIM_LAMBDA_INLINE {
    const CubeRow qx = beyond(sx, x), qy = beyond(sy, y), qz = beyond(sz, z);
    const CubeRow ox = positive(qx), oy = positive(qy), oz = positive(qz);
    return wide_root(ox * ox + oy * oy + oz * oz) + smaller(larger(qx, larger(qy, qz)), CubeRow{});
  });
}

BRIM_WIDE void capsule_distances(const CubeFrame& frame, double radius, double half, const NodeMask& wanted, float* d) {
  const Vec3f b = frame.base.cast<float>();
  const Slab sz(frame.base[2], half);
  const float r = static_cast<float>(radius);
  for_rows(frame, wanted, d, [&](const CubeRow& x, const CubeRow& y, const CubeRow& z) BRIM_LAMBDA_INLINE {
    const CubeRow px = b[0] + x, py = b[1] + y, oz = positive(beyond(sz, z));
    return wide_root(px * px + py * py + oz * oz) - r;
  });
}

BRIM_WIDE void cylinder_distances(const CubeFrame& frame, double radius, double half, const NodeMask& wanted,
                                  float* d) {
  const Vec3f b = frame.base.cast<float>();
  const Slab sz(frame.base[2], half);
  const float r = static_cast<float>(radius);
  for_rows(frame, wanted, d, [&](const CubeRow& x, const CubeRow& y, const CubeRow& z) BRIM_LAMBDA_INLINE {
    const CubeRow px = b[0] + x, py = b[1] + y;
    const CubeRow qr = wide_root(px * px + py * py) - r, qz = beyond(sz, z), orr = positive(qr), oz = positive(qz);
    return wide_root(orr * orr + oz * oz) + smaller(larger(qr, qz), CubeRow{});
  });
}

BRIM_WIDE void torus_distances(const CubeFrame& frame, double radius, double tube, const NodeMask& wanted, float* d) {
  const Vec3f b = frame.base.cast<float>();
  const float big = static_cast<float>(radius), r = static_cast<float>(tube);
  for_rows(frame, wanted, d, [&](const CubeRow& x, const CubeRow& y, const CubeRow& z) BRIM_LAMBDA_INLINE {
    const CubeRow px = b[0] + x, py = b[1] + y, pz = b[2] + z, s = wide_root(px * px + py * py) - big;
    return wide_root(s * s + pz * pz) - r;
  });
}

BRIM_WIDE void bowl_distances(const CubeFrame& frame, double middle, double half, const NodeMask& wanted, float* d) {
  const Vec3f b = frame.base.cast<float>();
  const float m = static_cast<float>(middle), t = static_cast<float>(half);
  for_rows(frame, wanted, d, [&](const CubeRow& x, const CubeRow& y, const CubeRow& z) BRIM_LAMBDA_INLINE {
    const CubeRow px = b[0] + x, py = b[1] + y, pz = b[2] + z, ss = px * px + py * py, s = wide_root(ss) - m;
    const CubeRow shell = size_of(wide_root(ss + pz * pz) - m), rim = wide_root(s * s + pz * pz);
    return (pz > CubeRow{} ? rim : shell) - t;
  });
}

BRIM_WIDE void cup_distances(const CubeFrame& frame, double radius, double height, double thickness,
                             const NodeMask& wanted, float* d) {
  const Vec3f b = frame.base.cast<float>();
  const Slab ends(frame.base[2] - 0.5 * height, 0.5 * height);
  const float r = static_cast<float>(radius), inner = static_cast<float>(radius - thickness),
              above = static_cast<float>(frame.base[2] - height), up = static_cast<float>(frame.base[2] - thickness);
  for_rows(frame, wanted, d, [&](const CubeRow& x, const CubeRow& y, const CubeRow& z) BRIM_LAMBDA_INLINE {
    const CubeRow px = b[0] + x, py = b[1] + y, s = wide_root(px * px + py * py);
    const CubeRow side = s - r, end = beyond(ends, z), os = positive(side), oe = positive(end);
    const CubeRow outer = wide_root(os * os + oe * oe) + smaller(larger(side, end), CubeRow{});
    const CubeRow wall = s - inner, over = up + z, ow = positive(wall), of = positive(-over);
    const CubeRow hollow = wide_root(ow * ow + of * of) + smaller(larger(wall, -over), CubeRow{});
    const CubeRow top = above + z;
    const CubeRow open = smaller(wide_root(wall * wall + top * top), over);
    const CubeRow solid = larger(outer, -hollow);
    return ((top > CubeRow{}) & (wall < CubeRow{})) ? open : solid;
  });
}

BRIM_WIDE void half_space_distances(const CubeFrame& frame, const NodeMask& wanted, float* d) {
  const float b = static_cast<float>(frame.base[2]);
  for_rows(frame, wanted, d,
           [&](const CubeRow&, const CubeRow&, const CubeRow& z) BRIM_LAMBDA_INLINE { return b + z; });
}

BRIM_WIDE void cube_ramp(const float* d, double w, const NodeMask& wanted, float* rho) {
  const float inverse = static_cast<float>(1.0 / w);
  const CubeRow one = spread(1.0f);
  for (int k = 0; k < kCubeSize; ++k)
    for (int j = 0; j < kCubeSize; ++j) {
      if (wanted.row(j, k) == 0) continue;
      CubeRow row;
      std::memcpy(&row, d + cube_index(0, j, k), sizeof row);
      const CubeRow t = smaller(positive(row * inverse + 0.5f), one);
      row = one - t * t * (3.0f - 2.0f * t);
      std::memcpy(rho + cube_index(0, j, k), &row, sizeof row);
    }
}

}  // namespace brim
