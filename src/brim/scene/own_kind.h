#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "brim/body/body.h"
#include "brim/body/own/own_body.h"
#include "brim/core/error.h"
#include "brim/math/splitmix.h"
#include "brim/scene/placement.h"
#include "brim/world/world.h"

namespace brim {

class Node;

/// Scene entry of one body of a user-defined kind: the values of its keys, checked against the kind's schema.
class OwnEntry {
 public:
  OwnEntry(const Node& n, const Placement& p, const Material& m, const WorldOptions& w)
      : place(p), material(m), world(w), node_(n) {}

  bool has(const char* key) const;
  double number(const char* key) const;
  bool boolean(const char* key) const;
  std::string string(const char* key) const;
  Vec3 vec3(const char* key) const;
  /// Path of a file given by a key, relative to the scene's folder; ${NAME} is replaced by the environment variable.
  std::string path(const char* key) const;
  /// The error to throw about a key's value: "file:line: pointer: message".
  InputError error(const char* key, const std::string& message) const;

  const Placement& place;    ///< initial pose and velocity of this copy
  const Material& material;  ///< named by its "material"
  const WorldOptions& world;

 private:
  const Node& node_;
};

using OwnMaker = std::function<std::unique_ptr<Body>(const OwnEntry&)>;

/// Fingerprint of the types that a plugin and the program exchange: their sizes, as compiled. A plugin that was built
/// with other headers of brim has another one, most often.
inline constexpr std::uint64_t kOwnKindLayout = scattered(
    scattered(scattered(scattered(sizeof(Body)) + sizeof(OwnBody)) + sizeof(OwnModel) + 64 * sizeof(OwnEntry)) +
    sizeof(WorldOptions) + 64 * sizeof(Placement));

/// Registers a user-defined kind of body for scenes, in this process from now on (docs/bodies/your_own.md).
/// Besides its own keys the kind gets those of every free body: name, material, response, voxel_size, transform,
/// velocity, angular_velocity and repeat.
/// Call it before scenes are read, from one thread.
/// @param name   value of "kind"
/// @param keys   the kind's own keys: the "properties" of a JSON Schema object; those without a default are required
/// @param make   makes one body; called for each copy; an InputError from it gets its place in the file
///               (as one from OwnEntry), and so does any other exception
/// @param layout of the caller's headers; leave it out
/// @return true, so that a static variable can hold it
/// @throws InputError  when the name is taken, the keys are not a JSON object, or the layout is another; while a plugin
///                     is loaded load_plugin throws it, and this returns false
bool add_body_kind(const std::string& name, std::string_view keys, OwnMaker make,
                   std::uint64_t layout = kOwnKindLayout);

}  // namespace brim
