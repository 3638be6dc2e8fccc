#include "brim/contact/stencil.h"

namespace brim {

namespace {

constexpr Stencil make_stencil() {
  constexpr double smooth[3] = {3.0 / 16.0, 10.0 / 16.0, 3.0 / 16.0};
  constexpr double first[3] = {-0.5, 0.0, 0.5};
  constexpr double second[3] = {1.0, -2.0, 1.0};
  Stencil s{};
  int n = 0;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        Stencil::Row& r = s.rows[n++];
        r.offset = block_index(i - 1, j - 1, k - 1);
        r.gradient = {first[i] * smooth[j] * smooth[k], smooth[i] * first[j] * smooth[k],
                      smooth[i] * smooth[j] * first[k]};
        r.hessian = {second[i] * smooth[j] * smooth[k], smooth[i] * second[j] * smooth[k],
                     smooth[i] * smooth[j] * second[k], first[i] * first[j] * smooth[k],
                     first[i] * smooth[j] * first[k],   smooth[i] * first[j] * first[k]};
      }
  return s;
}

constexpr Stencil kStencil = make_stencil();

}  // namespace

const Stencil& stencil() { return kStencil; }

Vec3 density_gradient(const double* rho, int node, double h) {
  double x = 0.0, y = 0.0, z = 0.0;
  for (const Stencil::Row& r : kStencil.rows) {
    const double value = rho[node + r.offset];
    x += r.gradient[0] * value;
    y += r.gradient[1] * value;
    z += r.gradient[2] * value;
  }
  return Vec3(x, y, z) / h;
}

void density_derivatives(const double* rho, int node, double h, Vec3& gradient, Mat3& hessian) {
  double g[3] = {}, s[6] = {};
  for (const Stencil::Row& r : kStencil.rows) {
    const double value = rho[node + r.offset];
    for (int a = 0; a < 3; ++a) g[a] += r.gradient[a] * value;
    for (int a = 0; a < 6; ++a) s[a] += r.hessian[a] * value;
  }
  gradient = Vec3(g[0], g[1], g[2]) / h;
  hessian << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
  hessian /= h * h;
}

}  // namespace brim
