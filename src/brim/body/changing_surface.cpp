#include "brim/body/changing_surface.h"

namespace brim {

const ChangingSurface* changing_surface(const Body& body) { return dynamic_cast<const ChangingSurface*>(&body); }

void display_now(const Body& body, std::vector<Vec3f>& x) {
  if (const ChangingSurface* surface = changing_surface(body)) {
    std::vector<Triangle> triangles;
    surface->display_surface(x, triangles);
    return;
  }
  x.resize(body.display().vertices);
  body.display_positions(x);
}

}  // namespace brim
