#include "brim/record/scene_change.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "brim/core/error.h"
#include "brim/io/regular_file.h"
#include "brim/record/run_folder.h"

namespace brim {

namespace {

constexpr const char* kKept = "scene.json";
constexpr const char* kEarlier = "scene_until_frame_";
/// Keys of a scene that do not change what happens.
constexpr const char* kBeside[] = {"$schema", "name", "description", "duration", "frames", "expect"};

nlohmann::json motion_of(const std::string& text) {
  auto scene = nlohmann::json::parse(text, nullptr, false, true);
  if (scene.is_object())
    for (const char* key : kBeside) scene.erase(key);
  return scene;
}

std::optional<std::string> kept_scene(const std::string& folder) {
  return read_regular_file((std::filesystem::path(folder) / kKept).string());
}

}  // namespace

bool same_scene(const std::string& a, const std::string& b) { return a == b || motion_of(a) == motion_of(b); }

void need_same_scene(const std::string& folder, const std::string& text) {
  const std::optional<std::string> kept = kept_scene(folder);
  if (kept && !same_scene(*kept, text))
    throw InputError(fmt::format(
        "{}: its scene.json differs from the scene given; give that one, or --edit to go on with the change", folder));
}

void replace_scene(const std::string& folder, const std::string& text, std::int64_t frame) {
  const std::optional<std::string> kept = kept_scene(folder);
  if (kept && same_scene(*kept, text)) return;
  const std::filesystem::path root(folder);
  if (kept) write_whole((root / fmt::format("{}{}.json", kEarlier, frame)).string(), *kept);
  write_whole((root / kKept).string(), text);
}

std::vector<std::string> earlier_scenes(const std::string& folder) {
  std::vector<std::pair<std::int64_t, std::string>> found;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(kEarlier) || !name.ends_with(".json")) continue;
    const std::string digits =
        name.substr(std::string(kEarlier).size(), name.size() - std::string(kEarlier).size() - 5);
    if (digits.empty() || digits.size() > 18 ||
        !std::ranges::all_of(digits, [](char c) { return c >= '0' && c <= '9'; }))
      continue;
    found.emplace_back(std::stoll(digits), name);
  }
  std::ranges::sort(found);
  std::vector<std::string> names;
  for (auto& [frame, name] : found) names.push_back(std::move(name));
  return names;
}

}  // namespace brim
