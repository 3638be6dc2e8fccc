#include "brim/scene/kinds.h"

#include <list>
#include <utility>

namespace brim {

// Each is defined in kinds/<name>.cpp.
BodyKind obstacle_kind();
BodyKind rigid_kind();
BodyKind finite_elements_kind();
BodyKind cloth_kind();
BodyKind particle_fluid_kind();
BodyKind image_volume_kind();
BodyKind articulated_kind();
BodyKind mass_spring_kind();
BodyKind rod_kind();
BodyKind points_kind();
BodyKind meshless_kind();
BodyKind grid_fluid_kind();

namespace {

/// In a list, so that references stay good when kinds are added.
std::list<BodyKind>& all_kinds() {
  // One a line, so that two who add a kind do not meet.
  static std::list<BodyKind> kinds = {
      obstacle_kind(),         //
      rigid_kind(),            //
      finite_elements_kind(),  //
      cloth_kind(),            //
      particle_fluid_kind(),   //
      image_volume_kind(),     //
      articulated_kind(),      //
      mass_spring_kind(),      //
      rod_kind(),              //
      points_kind(),           //
      meshless_kind(),         //
      grid_fluid_kind(),       //
  };
  return kinds;
}

}  // namespace

void add_body_kind(BodyKind kind) { all_kinds().push_back(std::move(kind)); }

std::size_t body_kind_count() { return all_kinds().size(); }

bool has_body_kind(const std::string& name) {
  for (const BodyKind& kind : all_kinds())
    if (kind.name == name) return true;
  return false;
}

const BodyKind& find_body_kind(const std::string& name) {
  for (const BodyKind& kind : all_kinds())
    if (kind.name == name) return kind;
  throw ProgrammingError("the schema allows the body kind \"" + name + "\" but kinds.cpp does not list it");
}

}  // namespace brim
