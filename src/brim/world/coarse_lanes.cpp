#include "brim/world/coarse_lanes.h"

#include "brim/core/widest.h"

namespace brim::coarse_lanes {

namespace {

/// The fourth lane is unused.
BRIM_INLINE Lanes cross(const Lanes& a, const Lanes& b) {
  const Lanes a1 = __builtin_shufflevector(a, a, 1, 2, 0, 3), b1 = __builtin_shufflevector(b, b, 1, 2, 0, 3);
  const Lanes c = a * b1 - a1 * b;
  return __builtin_shufflevector(c, c, 1, 2, 0, 3);
}
BRIM_INLINE Lanes three(const double* x) { return Lanes{x[0], x[1], x[2], 0.0}; }

BRIM_WIDE void wrench(const double* place, const double* center, const double* force, std::size_t n, double* out) {
  const Lanes c = three(center);
  Lanes sum[2] = {}, torque[2] = {};  // two chains side by side
  const auto add = [&](const Lanes& x, const Lanes& f, int chain) BRIM_LAMBDA_INLINE {
    sum[chain] += f;
    torque[chain] += cross(x - c, f);
  };
  std::size_t i = 0;
  for (; i + 2 < n; i += 2) {  // loads reach into the next node
    add(load_lanes(place + 3 * i), load_lanes(force + 3 * i), 0);
    add(load_lanes(place + 3 * i + 3), load_lanes(force + 3 * i + 3), 1);
  }
  for (; i < n; ++i) add(three(place + 3 * i), three(force + 3 * i), 0);
  const Lanes f = sum[0] + sum[1], m = torque[0] + torque[1];
  for (int k = 0; k < 3; ++k) out[k] = f[k], out[3 + k] = m[k];
}

BRIM_WIDE void motion(const double* x, const double* t, const double* w, std::size_t n, double* v) {
  const Lanes tl = three(t), wl = three(w);
  std::size_t i = 0;
  for (; i + 4 < n; i += 4, x += 12, v += 12) {
    Lanes u[4];
    for (int k = 0; k < 4; ++k) u[k] = tl + cross(wl, load_lanes(x + 3 * k));
    // Twelve numbers of four nodes.
    const Lanes a = __builtin_shufflevector(u[0], u[1], 0, 1, 2, 4),
                b = __builtin_shufflevector(u[1], u[2], 1, 2, 4, 5),
                c = __builtin_shufflevector(u[2], u[3], 2, 4, 5, 6);
    store_lanes(v, Lanes(load_lanes(v) + a));
    store_lanes(v + 4, Lanes(load_lanes(v + 4) + b));
    store_lanes(v + 8, Lanes(load_lanes(v + 8) + c));
  }
  for (; i < n; ++i, x += 3, v += 3) {
    const Lanes u = tl + cross(wl, three(x));
    for (int k = 0; k < 3; ++k) v[k] += u[k];
  }
}

template <class Widest>
BRIM_INLINE void sum_contact(const double* a, const double* b, const double* K, PairSums& sum) {
  using Row = typename Widest::Doubles;
  const auto load_row = [](const double* at) BRIM_LAMBDA_INLINE { return load_widest<Widest>(at); };
  Row Ka[3], Kb[3];
  for (int r = 0; r < 3; ++r) {
    Ka[r] = K[r] * load_row(a) + K[3 + r] * load_row(a + 8) + K[6 + r] * load_row(a + 16);
    Kb[r] = K[r] * load_row(b) + K[3 + r] * load_row(b + 8) + K[6 + r] * load_row(b + 16);
  }
  const auto add = [&](const double* s, const Row(&KS)[3], double sign, double* to) BRIM_LAMBDA_INLINE {
    store_lanes(to, Row(load_row(to) + sign * (s[0] * KS[0] + s[8] * KS[1] + s[16] * KS[2])));
  };
  for (int i = 0; i < 6; ++i) {
    add(a + i, Ka, 1.0, sum.aa[i]);
    add(b + i, Kb, 1.0, sum.bb[i]);
    add(a + i, Kb, -1.0, sum.ab[i]);
  }
}

BRIM_WIDEST(pair_contact, (const double* a, const double* b, const double* K, PairSums& sum),
            sum_contact<Widest>(a, b, K, sum))

}  // namespace

void add_contact(const double* a, const double* b, const double* K, PairSums& sum) { pair_contact(a, b, K, sum); }

void sum_wrench(std::span<const Vec3> place, const Vec3& c, std::span<const double> force, double* out) {
  wrench(place.front().data(), c.data(), force.data(), place.size(), out);
}

void add_motion(std::span<const Vec3> place, const Vec3& t, const Vec3& w, std::span<double> v) {
  motion(place.front().data(), t.data(), w.data(), place.size(), v.data());
}

}  // namespace brim::coarse_lanes
