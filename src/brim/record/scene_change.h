#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace brim {

/// True when two scenes make the same motion: equal but for comments, layout, and what only says how long a run is,
/// what is expected of it and what it is called. Files that a scene names are not looked into.
bool same_scene(const std::string& a, const std::string& b);

/// Compares a scene with the one that a run folder keeps. A folder without one is let through.
/// @throws InputError  when they differ
void need_same_scene(const std::string& folder, const std::string& text);

/// Takes a scene that differs over from here on: the one before becomes scene_until_frame_<frame>.json, its last frame.
/// One that is the same changes nothing. @throws InputError  when the files cannot be written
void replace_scene(const std::string& folder, const std::string& text, std::int64_t frame);

/// Names of the scenes that were replaced, in the order of their frames.
std::vector<std::string> earlier_scenes(const std::string& folder);

}  // namespace brim
