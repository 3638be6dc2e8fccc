#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "brim/body/body.h"
#include "brim/core/error.h"
#include "brim/scene/placement.h"
#include "brim/world/world.h"

namespace brim {

class Node;

/// What a scene says of one body of a kind of one's own: the values of its keys, checked against the kind's schema.
class OwnEntry {
 public:
  OwnEntry(const Node& n, const Placement& p, const Material& m, const WorldOptions& w)
      : place(p), material(m), world(w), node_(n) {}

  bool has(const char* key) const;
  double number(const char* key) const;
  bool boolean(const char* key) const;
  std::string string(const char* key) const;
  Vec3 vec3(const char* key) const;
  /// Path of a file that a key names, relative to the scene's folder; ${NAME} stands for an environment variable.
  std::string path(const char* key) const;
  /// The error to throw about a key's value: "file:line: pointer: message".
  InputError error(const char* key, const std::string& message) const;

  const Placement& place;    ///< where this copy starts and how it moves
  const Material& material;  ///< that its "material" names
  const WorldOptions& world;

 private:
  const Node& node_;
};

using OwnMaker = std::function<std::unique_ptr<Body>(const OwnEntry&)>;

/// Makes scenes understand a kind of body of one's own, in this process and from now on (docs/bodies/your_own.md).
/// Besides its own keys the kind gets those of every free body: name, material, voxel_size, transform, velocity,
/// angular_velocity and repeat.
/// Call it before scenes are read, from one thread.
/// @param name   the word for "kind"
/// @param keys   the kind's own keys: the "properties" of a JSON Schema object; those without a default are required
/// @param make   makes one body; called for each copy; may throw InputError, which then gets its place in the file
/// @return true, so that a static variable can hold it
/// @throws InputError  when the name is taken or the keys are no JSON object
bool add_body_kind(const std::string& name, std::string_view keys, OwnMaker make);

}  // namespace brim
