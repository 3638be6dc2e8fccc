#include <fmt/format.h>
#include <gtest/gtest.h>

#include "brim/scene/scene.h"

/// Bodies that fill a shape with tetrahedra.
namespace brim::solid_fill_test {
namespace {

TEST(SolidFill, ABodyHasTheMassOfItsShapeAtAnySpacing) {
  for (const char* kind : {"finite_elements", "mass_spring"})
    for (const char* shape : {R"("kind": "box", "size": [0.3, 0.3, 0.15])", R"("kind": "sphere", "radius": 0.1)"})
      for (const double spacing : {0.05, 0.06, 0.0675, 0.09, 0.1125}) {
        const std::string text =
            fmt::format(R"({{"brim": 1, "name": "mass", "duration": 1, "bodies": [{{"kind": "{}", "name": "body",
                            "density": 800, "lattice_spacing": {}, "shape": {{{}}}}}]}})",
                        kind, spacing, shape);
        const World w = build_world(parse_scene(text, "scene.json"));
        const bool box = std::string(shape).find("box") != std::string::npos;
        // The sphere is made of triangles.
        const double volume = box ? 0.3 * 0.3 * 0.15 : 4.0 / 3.0 * M_PI * 1e-3;
        EXPECT_NEAR(w.body(0).mass() / (800 * volume), 1.0, box ? 1e-6 : 0.01)
            << kind << ", " << shape << ", " << spacing;
      }
}

}  // namespace
}  // namespace brim::solid_fill_test
