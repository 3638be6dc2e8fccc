#include "brim/scene/idle_keys.h"

#include "brim/scene/errors.h"
#include "brim/scene/node.h"

namespace brim {

namespace {

constexpr const char* kOfDeformable[] = {"young_modulus", "poisson_ratio",     "law",
                                         "averaging",     "stiffness_damping", "mass_damping"};

bool is_rigid_volume(const Json& body) {
  return body.is_object() && body.value("kind", Json()) == "image_volume" &&
         body.value("motion", Json("rigid")) == "rigid";
}

}  // namespace

void refuse_idle_keys(const Document& document, ErrorList& errors) {
  if (!document.root.is_object() || !document.root.contains("bodies")) return;
  const Node bodies = Node(document, document.root, "").at("bodies");
  if (!bodies.json().is_array()) return;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Node body = bodies.at(i);
    if (!is_rigid_volume(body.json())) continue;
    for (const char* key : kOfDeformable)
      if (body.has(key))
        errors.add(body.at(key).pointer(),
                   body.at(key)
                       .error(fmt::format("only a deformable volume has \"{}\"; \"motion\" is \"rigid\"", key))
                       .what());
  }
}

}  // namespace brim
