#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "brim/core/error.h"
#include "brim/scene/document.h"
#include "brim/scene/pairs/pair_table.h"
#include "brim/scene/scene.h"
#include "brim/world/world.h"
#include "checkout_paths.h"

/// Which kind takes which wiring: every kind is given each, and what comes of it is the table of docs/links.md.
namespace brim::wiring_table_test {
namespace {

struct Wiring {
  const char* heading;
  const char* list;   ///< of the scene
  const char* entry;  ///< PLACE, LOW and HIGH stand for a place in the body and the corners of its box
};

constexpr Wiring kWirings[] = {
    {"point", "attachments", R"({"name": "w", "body": "upper", "point": PLACE})"},
    {"region", "attachments", R"({"name": "w", "body": "upper", "region": {"kind": "box", "lo": LOW, "hi": HIGH}})"},
    {"fixed", "joints", R"({"name": "w", "body": "upper", "position": PLACE})"},
    {"revolute", "joints",
     R"({"name": "w", "body": "upper", "kind": "revolute", "position": PLACE, "axis": [0, 1, 0]})"},
    {"prismatic", "joints",
     R"({"name": "w", "body": "upper", "kind": "prismatic", "position": PLACE, "axis": [0, 1, 0]})"},
    {"ball", "joints", R"({"name": "w", "body": "upper", "kind": "ball", "position": PLACE})"},
    {"filter", "filters", R"({"between": ["upper", "lower"]})"},
    {"of a part", "filters", R"({"between": ["upper", "lower"], "region": {"kind": "box", "lo": LOW, "hi": HIGH}})"},
    {"force", "forces", R"({"name": "w", "bodies": ["upper"], "force": [0.1, 0, 0]})"},
    {"torque", "forces", R"({"name": "w", "bodies": ["upper"], "torque": [0, 0.001, 0]})"},
    {"at a point", "forces", R"({"name": "w", "bodies": ["upper"], "force": [0.1, 0, 0], "point": PLACE})"},
    {"at a region", "forces",
     R"({"name": "w", "bodies": ["upper"], "force": [0.1, 0, 0], "region": {"kind": "box", "lo": LOW, "hi": HIGH}})"},
    {"weight", "forces", R"({"name": "w", "bodies": ["upper"], "gravity_scale": 0.5, "damping": 0.1})"},
    {"wind", "forces", R"({"name": "w", "bodies": ["upper"], "wind": {"velocity": [1, 0, 0]}})"},
    {"attractor", "forces",
     R"({"name": "w", "bodies": ["upper"], "attractor": {"center": [1, 0, 0], "strength": 1, "range": 5}})"},
    {"pulled", "timeline", R"({"at": 0, "grab": "upper", "point": PLACE})"},
};

std::string with_places(std::string text, const PairKind& kind) {
  const double z = 0.03 - kind.lowest;
  const auto put = [&](const std::string& word, const std::string& value) {
    for (std::size_t at; (at = text.find(word)) != std::string::npos;) text.replace(at, word.size(), value);
  };
  put("PLACE", fmt::format("[0.013, 0.021, {}]", z));
  put("LOW", "[-9, -9, -9]"), put("HIGH", "[9, 9, 9]");
  return text;
}

/// Nothing where the wiring does what it is for; else why not.
std::string refusal(const PairTable& table, const PairKind& kind, const Wiring& wiring) {
  Json scene = Json::parse(pair_scene_text(table, table.find("plane"), kind));
  scene["bodies"][0]["transform"] = {{"position", {0, 0, -5}}};
  scene["bodies"][1].erase("velocity");
  scene[wiring.list] = Json::array({Json::parse(with_places(wiring.entry, kind))});
  try {
    World w = build_world(parse_scene(scene.dump()));
    for (int s = 0; s < 3; ++s) {
      const StepReport r = w.step();
      EXPECT_TRUE(r.ok) << kind.name << ", " << wiring.heading;
      for (const Warning& warning : r.warnings)
        if (warning.code == "edit_refused") return warning.message;
    }
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

/// The rows of the table in the page, from its heading to the first line that is none.
std::string written_table() {
  std::ifstream in(std::string(BRIM_SOURCE_DIR) + "/docs/links.md");
  std::string line, table;
  bool inside = false;
  while (std::getline(in, line)) {
    if (line.starts_with("| kind | point |")) inside = true;
    if (inside && !line.starts_with('|')) break;
    if (inside) table += line + "\n";
  }
  return table;
}

TEST(WiringTable, IsWhatEveryKindDoes) {
  const PairTable& table = standard_pairs();
  std::string made = "| kind |", rule = "|---|";
  for (const Wiring& w : kWirings) made += fmt::format(" {} |", w.heading), rule += ":-:|";
  made += "\n" + rule + "\n";
  for (const PairKind& kind : table.kinds) {
    if (kind.name == "plane" || kind.name == "mesh") continue;  // do not move
    made += fmt::format("| {} |", kind.name);
    for (const Wiring& w : kWirings) {
      const std::string why = refusal(table, kind, w);
      made += why.empty() ? " ✓ |" : " – |";
      // One clear sentence that names the body or the kind, and is of no numbers gone wrong.
      if (why.empty()) continue;
      EXPECT_NE(why.find("upper"), std::string::npos) << kind.name << ", " << w.heading << ": " << why;
      EXPECT_EQ(why.find("nan"), std::string::npos) << why;
      EXPECT_EQ(why.find('\n'), std::string::npos) << why;
      if (std::getenv("BRIM_TELL") != nullptr) std::printf("%s, %s: %s\n", kind.name.c_str(), w.heading, why.c_str());
    }
    made += "\n";
  }
  EXPECT_EQ(made, written_table()) << "docs/links.md does not have the table that is";
}

}  // namespace
}  // namespace brim::wiring_table_test
