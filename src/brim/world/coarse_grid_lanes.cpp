#include "brim/world/coarse_grid_lanes.h"

#include <algorithm>
#include <bit>

#include "brim/core/widest.h"

namespace brim::coarse_grid_lanes {

namespace {

BRIM_INLINE void clear(float* sum) { std::fill_n(sum, kPair, 0.0f); }

/// Index in kAround of a cell by the difference of codes; kAround when it is farther away.
BRIM_INLINE std::size_t around(std::int32_t difference, std::int32_t width, std::int32_t height) {
  const std::int32_t plane = width * height, d = difference + 1 + width + plane;
  const std::int32_t z = d / plane, y = d % plane / width, x = d % width;
  return d < 0 || x > 2 || y > 2 || z > 2 ? kAround : static_cast<std::size_t>(x + 3 * (y + 3 * z));
}

/// sum_Ik += w_I part_k
template <class Widest>
BRIM_INLINE void add_outer(const float* weight, const WideFloats (&part)[9], float* sum) {
  typename Widest::Floats two[4];
  for (int k = 0; k < 4; ++k) two[k] = joined<Widest>(part[2 * k], part[2 * k + 1]);
  for (int I = 0; I < 8; ++I, sum += 9 * kWideLanes) {
    for (int k = 0; k < 4; ++k)
      store_lanes(sum + k * kWidestLanes,
                  typename Widest::Floats(load_widest<Widest>(sum + k * kWidestLanes) + weight[I] * two[k]));
    store_wide(load_wide(sum + 8 * kWideLanes) + weight[I] * part[8], sum + 8 * kWideLanes);
  }
}

template <class Widest>
BRIM_INLINE void sum_rows(const Rows& rows, const std::int32_t* row, std::size_t n, std::size_t node, float* sum,
                          std::uint32_t& used) {
  WideFloats others[kAround][9];
  for (std::size_t k = 0; k < n; ++k, ++node) {
    const std::int32_t r = row[k], code = rows.code[node];
    WideFloats own[9] = {};
    std::uint32_t touched = 1u << kSelf;
    for (std::int32_t s = rows.first[r]; s < rows.first[r + 1]; ++s) {
      const std::int32_t j = rows.node[3 * rows.column[s]];
      if (j < 0) continue;
      const WideFloats w = load_wide(rows.weight + 8 * j);
      if (rows.column[s] == r) {
        const double* d = rows.diagonal[r].data();
        for (int i = 0; i < 9; ++i) own[i] += rows.stiffness_share * static_cast<float>(d[i]) * w;
        for (int i = 0; i < 9; i += 4) own[i] += rows.mass_share * static_cast<float>(rows.mass[r]) * w;
        continue;
      }
      const float* v = rows.value + 9 * s;
      const WideFloats scaled = rows.stiffness_share * w;
      if (rows.code[j] == code) {
        for (int i = 0; i < 9; ++i) own[i] += v[i] * scaled;
        continue;
      }
      if (rows.code[j] < code) continue;
      const std::size_t c = around(rows.code[j] - code, rows.width, rows.height);
      if (c == kAround) continue;
      if ((touched >> c & 1) == 0) {
        touched |= 1u << c;
        for (WideFloats& x : others[c]) x = WideFloats{};
      }
      for (int i = 0; i < 9; ++i) others[c][i] += v[i] * scaled;
    }
    for (std::uint32_t rest = touched; rest != 0; rest &= rest - 1) {
      const int c = std::countr_zero(rest);
      float* to = sum + static_cast<std::size_t>(c) * kPair;
      if ((used >> c & 1) == 0) used |= 1u << c, clear(to);
      add_outer<Widest>(rows.weight + 8 * node, c == kSelf ? own : others[c], to);
    }
  }
}

template <class Widest>
BRIM_INLINE void sum_contact(const Sight& s, int a, int b, const float* K, float* sum) {
  if (s.plain) {
    const WideFloats m = load_wide(s.motion[b][0]);
    WideFloats part[9];
    for (int k = 0; k < 9; ++k) part[k] = K[k] * m;
    add_outer<Widest>(s.motion[a][0], part, sum);
    return;
  }
  WideFloats KB[9];
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r)
      KB[3 * c + r] = K[r] * load_wide(s.motion[b][3 * c]) + K[3 + r] * load_wide(s.motion[b][3 * c + 1]) +
                      K[6 + r] * load_wide(s.motion[b][3 * c + 2]);
  for (int I = 0; I < 8; ++I, sum += 9 * kWideLanes)
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) {
        const auto A = [&](int k) BRIM_LAMBDA_INLINE { return s.motion[a][3 * r + k][I]; };
        float* to = sum + (3 * c + r) * kWideLanes;
        store_wide(load_wide(to) + (A(0) * KB[3 * c] + A(1) * KB[3 * c + 1] + A(2) * KB[3 * c + 2]), to);
      }
}

BRIM_WIDEST(widest_rows,
            (const Rows& rows, const std::int32_t* row, std::size_t n, std::size_t node, float* sum,
             std::uint32_t& used),
            sum_rows<Widest>(rows, row, n, node, sum, used))
BRIM_WIDEST(widest_contact, (const Sight& s, int a, int b, const float* K, float* sum),
            sum_contact<Widest>(s, a, b, K, sum))

}  // namespace

void add_rows(const Rows& rows, const std::int32_t* row, std::size_t n, std::size_t node, float* sum,
              std::uint32_t& used) {
  widest_rows(rows, row, n, node, sum, used);
}

void add_contact(const Sight& s, int a, int b, const float* K, float* sum) { widest_contact(s, a, b, K, sum); }

BRIM_WIDE void see(Sight& s, int cell, const float* J, const float* weight) {
  const WideFloats w = load_wide(weight);
  float(&motion)[9][8] = s.motion[cell];
  const int count = s.plain ? 1 : 9;
  if ((s.used >> cell & 1) == 0) {
    s.used = static_cast<std::uint8_t>(s.used | 1 << cell);
    for (int k = 0; k < count; ++k) store_wide(WideFloats{}, motion[k]);
  }
  for (int k = 0; k < count; ++k) store_wide(load_wide(motion[k]) + J[k] * w, motion[k]);
}

BRIM_WIDE void restrict_to(const float* weight, const std::int32_t* velocity, std::size_t n, const double* r,
                           float* sum) {
  WideFloats s[3] = {};
  for (std::size_t i = 0; i < n; ++i) {
    const WideFloats w = load_wide(weight + 8 * i);
    for (int a = 0; a < 3; ++a) s[a] += static_cast<float>(r[velocity[i] + a]) * w;
  }
  for (int a = 0; a < 3; ++a) store_wide(s[a], sum + a * kWideLanes);
}

BRIM_WIDE void prolong(const float* weight, const std::int32_t* velocity, std::size_t n, const float* x, double* z) {
  const WideFloats X[3] = {load_wide(x), load_wide(x + kWideLanes), load_wide(x + 2 * kWideLanes)};
  const auto half = [](const WideFloats& v) BRIM_LAMBDA_INLINE {
    return FloatLanes(__builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7));
  };
  for (std::size_t i = 0; i < n; ++i) {
    const WideFloats w = load_wide(weight + 8 * i);
    const FloatLanes a = half(w * X[0]), b = half(w * X[1]), c = half(w * X[2]);
    const FloatLanes ab = __builtin_shufflevector(a, b, 0, 1, 4, 5) + __builtin_shufflevector(a, b, 2, 3, 6, 7);
    const FloatLanes cc = __builtin_shufflevector(c, c, 0, 1, 0, 1) + __builtin_shufflevector(c, c, 2, 3, 2, 3);
    double* to = z + velocity[i];
    to[0] += ab[0] + ab[1], to[1] += ab[2] + ab[3], to[2] += cc[0] + cc[1];
  }
}

}  // namespace brim::coarse_grid_lanes
