#pragma once

#include <functional>
#include <memory>
#include <string>

#include "brim/body/body.h"
#include "brim/scene/node.h"
#include "brim/scene/repeat.h"
#include "brim/world/world.h"

namespace brim {

class SolidStore;

/// Input of a kind besides its own node.
struct BuildContext {
  const WorldOptions& world;
  const Material& material;
  double duration;     ///< [s] of the run
  SolidStore& solids;  ///< solids sampled so far
};

/// Makes the copies of one entry of "bodies"; shared data was read at its construction.
class BodyMaker {
 public:
  virtual ~BodyMaker() = default;
  /// A body at a placement, not yet named. @throws InputError
  virtual std::unique_ptr<Body> body(const Placement& place) const = 0;
};

/// Scene interface of one kind of body. A new kind is a file in kinds/ that defines one of these, its line in
/// kinds.cpp, and its branch of "body" in the schema; no other code knows kinds.
struct BodyKind {
  std::string name;
  /// Checks that the schema cannot express: mutually exclusive keys, contradicting sizes. Reads no files. @throws
  /// InputError
  std::function<void(const Node&)> check;
  /// Reads files, builds meshes. @throws InputError
  std::function<std::unique_ptr<BodyMaker>(const Node&, const BuildContext&)> make;
};

/// The kind that "kind" names; the schema has already refused others.
const BodyKind& find_body_kind(const std::string& name);

/// True for brim's own and for added kinds.
bool has_body_kind(const std::string& name);

/// Number of known kinds.
std::size_t body_kind_count();

/// Adds a kind at run time, next to its branch in the schema (add_body_branch); own_kind.h does both.
void add_body_kind(BodyKind kind);

}  // namespace brim
