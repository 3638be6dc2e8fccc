#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace brim {

/// True when two scenes give the same motion: equal except for comments, layout, length of the run, expectations and
/// names. Files named by a scene are not compared.
bool same_scene(const std::string& a, const std::string& b);

/// Compares a scene with the one stored in a run folder. A folder without one is accepted.
/// @throws InputError  when they differ
void need_same_scene(const std::string& folder, const std::string& text);

/// Replaces the stored scene from here on: the previous one becomes scene_until_frame_<frame>.json, named after its
/// last frame. An equal scene changes nothing. @throws InputError  when the files cannot be written
void replace_scene(const std::string& folder, const std::string& text, std::int64_t frame);

/// Names of the replaced scenes, in the order of their frames.
std::vector<std::string> earlier_scenes(const std::string& folder);

}  // namespace brim
