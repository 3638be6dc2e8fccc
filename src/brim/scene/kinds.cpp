#include "brim/scene/kinds.h"

#include <vector>

namespace brim {

// Each is defined in kinds/<name>.cpp.
BodyKind obstacle_kind();
BodyKind rigid_kind();
BodyKind finite_elements_kind();
BodyKind cloth_kind();
BodyKind image_volume_kind();
BodyKind articulated_kind();

const BodyKind& find_body_kind(const std::string& name) {
  static const std::vector<BodyKind> kinds = {
      obstacle_kind(), rigid_kind(), finite_elements_kind(), cloth_kind(), image_volume_kind(), articulated_kind(),
  };
  for (const BodyKind& kind : kinds)
    if (kind.name == name) return kind;
  throw ProgrammingError("the schema allows the body kind \"" + name + "\" but kinds.cpp does not list it");
}

}  // namespace brim
