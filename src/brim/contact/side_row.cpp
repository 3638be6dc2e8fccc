#include "brim/contact/side_row.h"

#include "brim/contact/tangent_frame.h"
#include "brim/core/simd.h"
#include "brim/math/wide_vectors.h"

namespace brim {

namespace {

/// Smallest gradient of a distance that defines a direction: inside a solid, equally far from two surfaces, there is
/// none.
constexpr float kLeastSteepness = 0.5f;

BRIM_INLINE WideVectors as_vectors(const WideFloats* a) { return {a[0], a[1], a[2]}; }
BRIM_INLINE WideVectors gradient_of(const RowDerivatives& r, float scale) {
  return {scale * load_wide(r.gradient[0]), scale * load_wide(r.gradient[1]), scale * load_wide(r.gradient[2])};
}

/// scale T H T with T = 1 − ĝĝᵀ where `told` is set; zero elsewhere.
BRIM_INLINE void put_bend(const WideVectors& g, const RowDerivatives& r, const WideFloats& scale, const WideIds& told,
                          SideRow& out) {
  const WideFloats size = length(g), none{};
  const WideIds known = told & (size > 0.0f);
  const TangentFrame<WideFloats> t(g.x / size, g.y / size, g.z / size);
  WideFloats H[6];
  for (int i = 0; i < 6; ++i) H[i] = load_wide(r.hessian[i]);
  const auto times = [&](const WideFloats* x) BRIM_LAMBDA_INLINE {
    return WideVectors{H[0] * x[0] + H[3] * x[1] + H[4] * x[2], H[3] * x[0] + H[1] * x[1] + H[5] * x[2],
                       H[4] * x[0] + H[5] * x[1] + H[2] * x[2]};
  };
  const WideVectors Hu = times(t.u), Hv = times(t.v);
  store_wide(known ? scale * dot(as_vectors(t.u), Hu) : none, out.bend[0]);
  store_wide(known ? scale * dot(as_vectors(t.u), Hv) : none, out.bend[1]);
  store_wide(known ? scale * dot(as_vectors(t.v), Hv) : none, out.bend[2]);
}

}  // namespace

BRIM_WIDE void side_row(const RowDerivatives& rho, const RowDerivatives* told, float inverse_h, SideRow& out) {
  WideVectors g = gradient_of(rho, inverse_h);
  const WideIds everywhere = WideIds{} == WideIds{};
  if (told == nullptr) {
    put_bend(g, rho, WideFloats{} + inverse_h * inverse_h, everywhere, out);
  } else {
    const WideVectors away = gradient_of(*told, inverse_h);
    const WideFloats steepness = length(away), slope = -length(g) / steepness;
    const WideIds steep = steepness > kLeastSteepness;
    const WideVectors along = slope * away;
    put_bend(along, *told, slope * inverse_h * inverse_h, steep, out);
    g = {steep ? along.x : g.x, steep ? along.y : g.y, steep ? along.z : g.z};
  }
  store_wide(g.x, out.gradient[0]), store_wide(g.y, out.gradient[1]), store_wide(g.z, out.gradient[2]);
}

}  // namespace brim
