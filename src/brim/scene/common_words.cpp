#include "brim/scene/common_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace brim {

namespace {

struct Synonym {
  std::string_view given, meant;
};

/// Of several meanings the first that is allowed is taken.
constexpr std::array kSynonyms = {
    // kinds of joints
    Synonym{"hinge", "revolute"},
    Synonym{"pin", "revolute"},
    Synonym{"rotational", "revolute"},
    Synonym{"continuous", "revolute"},
    Synonym{"slider", "prismatic"},
    Synonym{"slide", "prismatic"},
    Synonym{"linear", "prismatic"},
    Synonym{"spherical", "ball"},
    Synonym{"socket", "ball"},
    Synonym{"weld", "fixed"},
    Synonym{"rigid", "fixed"},
    // shapes
    Synonym{"diameter", "radius"},
    Synonym{"height", "length"},
    Synonym{"half_extents", "size"},
    Synonym{"extents", "size"},
    Synonym{"dimensions", "size"},
    Synonym{"width", "size"},
    Synonym{"cube", "box"},
    Synonym{"cuboid", "box"},
    Synonym{"ball", "sphere"},
    Synonym{"ground", "plane"},
    Synonym{"floor", "plane"},
    Synonym{"path", "file"},
    // bodies
    Synonym{"soft", "finite_elements"},
    Synonym{"softbody", "finite_elements"},
    Synonym{"fem", "finite_elements"},
    Synonym{"static", "obstacle"},
    Synonym{"fixed", "obstacle"},
    Synonym{"dynamic", "rigid"},
    Synonym{"grains", "points"},
    Synonym{"rope", "rod"},
    Synonym{"cable", "rod"},
    Synonym{"sheet", "cloth"},
    Synonym{"water", "particle_fluid"},
    Synonym{"fluid", "particle_fluid"},
    Synonym{"robot", "articulated"},
    Synonym{"type", "kind"},
    Synonym{"id", "name"},
    Synonym{"geometry", "shape"},
    Synonym{"linear_velocity", "velocity"},
    Synonym{"speed", "velocity"},
    Synonym{"spin", "angular_velocity"},
    Synonym{"omega", "angular_velocity"},
    Synonym{"pose", "transform"},
    Synonym{"youngs_modulus", "young_modulus"},
    Synonym{"E", "young_modulus"},
    Synonym{"nu", "poisson_ratio"},
    // transforms, joints
    Synonym{"translation", "position"},
    Synonym{"location", "position"},
    Synonym{"origin", "position"},
    Synonym{"circle", "around"},
    Synonym{"ring", "around"},
    Synonym{"angle", "degrees"},
    Synonym{"center", "point"},
    Synonym{"orientation", "rotation"},
    Synonym{"child", "body"},
    Synonym{"parent", "to"},
    // the world and the scene
    Synonym{"dt", "time_step"},
    Synonym{"step", "time_step"},
    Synonym{"substeps", "max_substeps"},
    Synonym{"resolution", "voxel_size"},
    Synonym{"objects", "bodies"},
    Synonym{"time", "duration"},
    Synonym{"constraints", "joints"},
};

bool is_allowed(const std::vector<std::string>& words, std::string_view word) {
  return std::ranges::find(words, word) != words.end();
}

}  // namespace

std::string meant_word(std::string_view given, const std::vector<std::string>& allowed) {
  for (const Synonym& s : kSynonyms)
    if (s.given == given && is_allowed(allowed, s.meant)) return std::string(s.meant);
  return "";
}

RightPlace right_place(std::string_view given, const std::vector<std::string>& allowed) {
  if (is_allowed(allowed, "transform") && (given == "position" || given == "rotation" || given == "scale"))
    return {"transform", fmt::format("it belongs in \"transform\": {{\"{}\": ...}}", given)};
  if (is_allowed(allowed, "material") &&
      (given == "friction" || given == "restitution" || given == "rolling_resistance"))
    return {
        "material",
        fmt::format("it belongs in \"materials\" of the scene, as {{\"NAME\": {{\"{}\": ...}}}}, which bodies name by "
                    "\"material\"",
                    given)};
  return {};
}

}  // namespace brim
