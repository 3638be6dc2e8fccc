#include "brim/raster/splat_reach.h"

#include <algorithm>
#include <cmath>

#include "brim/core/parallel.h"
#include "brim/math/splitmix.h"

namespace brim {

namespace {

constexpr std::size_t kTriangleGrain = 1024;
/// Added to angles and reaches for what single precision rounds.
constexpr float kCosineSlack = 1e-5f, kReachSlack = 1e-3f;

/// sin θ of a vertex whose normals have at least the cosine `along`, and whose corners at least the cosine `corner`.
float sine_aside(float along, float corner) {
  const float cosine = along - kCosineSlack;
  if (!(cosine > 0.1f) || !(corner > -0.99f)) return 1.0f;
  const float cosine2 = cosine * cosine, tan2 = std::max(0.0f, 1.0f / cosine2 - 1.0f);
  const float half2 = (1.0f - corner) / (1.0f + corner) / cosine2;  // tan²(ψ'/2)
  const float lean2 = tan2 * (1.0f + half2);                        // tan² ∠(u, n)
  if (!(lean2 * tan2 < 1.0f)) return 1.0f;                          // θ >= 90°
  return (std::sqrt(lean2) + std::sqrt(tan2)) / std::sqrt((1.0f + lean2) * (1.0f + tan2));
}

}  // namespace

void SplatReach::build(std::span<const Vec3> x, std::span<const Triangle> triangles, double reach) {
  fan_.assign(x.size(), Fan{});
  aside_.resize(x.size());
  normal_.resize(triangles.size()), corner_.resize(triangles.size()), beyond_.resize(triangles.size());
  parallel_blocks(triangles.size(), kTriangleGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Triangle& c = triangles[t];
      const Vec3 ab = x[c[1]] - x[c[0]], bc = x[c[2]] - x[c[1]], ca = x[c[0]] - x[c[2]], m = ab.cross(bc);
      const double lab = ab.squaredNorm(), lbc = bc.squaredNorm(), lca = ca.squaredNorm(), m2 = m.squaredNorm();
      const double longest = std::max({lab, lbc, lca});
      if (!(m2 > 1e-12 * longest * longest)) {
        normal_[t].setZero();
        continue;
      }
      normal_[t] = (m / std::sqrt(m2)).cast<float>();
      corner_[t] = Vec3(-ab.dot(ca) / std::sqrt(lab * lca), -ab.dot(bc) / std::sqrt(lab * lbc),
                        -bc.dot(ca) / std::sqrt(lbc * lca))
                       .cast<float>();
    }
  });
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int i = 0; i < 3; ++i) {
      const Triangle& c = triangles[t];
      Fan& fan = fan_[c[i]];
      fan.normal += normal_[t];
      // A triangle without area opens the ring. Numbers of vertices are scattered so that no other sums of differences
      // than those of rings vanish.
      fan.ring += normal_[t].isZero(0.0f) ? 1 : scattered(c[(i + 1) % 3]) - scattered(c[(i + 2) % 3]);
    }
  parallel_blocks(x.size(), kTriangleGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) fan_[v].normal.normalize();
  });
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int i = 0; i < 3; ++i) {
      Fan& fan = fan_[triangles[t][i]];
      fan.along = std::min(fan.along, fan.normal.dot(normal_[t]));
      fan.corner = std::min(fan.corner, corner_[t][i]);
    }
  parallel_blocks(x.size(), kTriangleGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v)
      aside_[v] = fan_[v].ring == 0 ? sine_aside(fan_[v].along, fan_[v].corner) : 1.0f;
  });
  const auto whole = static_cast<float>(reach);
  parallel_blocks(triangles.size(), kTriangleGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Triangle& c = triangles[t];
      const float aside = std::max({aside_[c[0]], aside_[c[1]], aside_[c[2]]});
      for (int a = 0; a < 3; ++a) {
        const float n = std::abs(normal_[t][a]);
        const float share = n + aside * std::sqrt(std::max(0.0f, 1.0f - n * n)) + kReachSlack;
        beyond_[t][a] = aside < 1.0f && share < 1.0f ? share * whole : whole;
      }
    }
  });
}

}  // namespace brim
