#include "brim/body/particle_fluid/wall_fill.h"

#include <cmath>

namespace brim {

WallFill::WallFill(const FluidKernel& kernel, double spacing, double volume) {
  // Planes further off than the support do not count; with a support of two spacings only the next one does.
  double value = 0.0, slope = 0.0;
  const int n = static_cast<int>(std::ceil(kernel.support() / spacing));
  for (int z = 1; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x) {
        const double r = spacing * std::sqrt(static_cast<double>(x * x + y * y + z * z));
        value += volume * kernel.value(r);
        slope += volume * kernel.slope_over_r(r) * spacing * z;
      }
  const double steep = -2.0 * slope;  // −λ'(s/2) = 2 a (d₀ − s/2) and λ(s/2) = a (d₀ − s/2)²
  reach_ = 0.5 * spacing + 2.0 * value / steep;
  scale_ = steep * steep / (4.0 * value);
}

}  // namespace brim
