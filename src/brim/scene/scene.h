#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "brim/body/body.h"
#include "brim/world/expectation.h"
#include "brim/world/world.h"

namespace brim {

struct Document;
class SolidStore;
struct SceneSettings;  // brim/scene/parameters.h

/// A scene file, read and validated (schema/scene.schema.json, docs/scenes.md).
struct Scene {
  std::string file;  ///< as given by the user; paths inside are relative to its folder
  std::string name;
  std::string description;
  std::string text;  ///< for the run folder: the file's bytes, or the expanded scene if it has includes or settings
  WorldOptions world;
  std::int64_t frames = 0;  ///< recorded frames after the first
  int steps_per_frame = 1;
  std::map<std::string, Material> materials;
  std::vector<Expectation> expect;
  std::shared_ptr<const Document> document;  ///< source of the bodies

  double frame_time() const { return world.time_step * steps_per_frame; }  ///< [s]
};

/// Reads and checks a scene: syntax, schema, and everything that can be checked without building its bodies.
/// @throws InputError  "file:line: pointer: value and what is allowed"; InputErrors for several errors
/// Tests: tests/scene/bad_scenes_test.cpp
Scene load_scene(const std::string& path);
/// The same with values of its parameters.
Scene load_scene(const std::string& path, const SceneSettings& settings);

/// The same for a text. @param file  name used in messages; relative paths start from its folder
Scene parse_scene(std::string_view text, const std::string& file = "scene.json");
/// The same with values of its parameters.
Scene parse_scene(std::string_view text, const std::string& file, const SceneSettings& settings);

/// Builds the bodies, adds them to a world, and wires it up.
/// @throws InputError  likewise: unreadable files, unsuitable meshes, resolutions that exceed the memory limit
World build_world(const Scene& scene);

/// Gives a world that has the scene's bodies the rest: attachments, joints, forces, sensors, the timeline and levels.
/// @throws InputError  likewise
void wire_world(const Scene& scene, World& world);

/// The bodies alone, named, in the order of the scene. @throws InputError  likewise
std::vector<std::unique_ptr<Body>> build_bodies(const Scene& scene);
/// The same; bodies may share solids sampled before.
std::vector<std::unique_ptr<Body>> build_bodies(const Scene& scene, SolidStore& solids);
/// The same, passed on one by one; errors from `take` get the place of the body's entry.
void build_bodies(const Scene& scene, SolidStore& solids, const std::function<void(std::unique_ptr<Body>)>& take);

/// Checks a document that was read or generated: all of load_scene after reading.
/// @throws InputError
Scene check_scene(Document document);
Scene check_scene(Document document, const SceneSettings& settings);

/// The schema of scene files (JSON Schema 2020-12), the single source of what load_scene accepts.
const std::string& scene_schema_text();

/// The same with the kinds that were added (add_body_kind, plugins).
std::string known_schema_text();

}  // namespace brim
