#include "brim/scene/pairs/pair_table.h"

#include <fmt/format.h>

#include <limits>
#include <set>

#include "brim/core/error.h"
#include "brim/scene/document.h"
#include "brim/scene/node.h"
#include "brim/scene/validate.h"

namespace brim {

const std::string& standard_pairs_text();
const std::string& pairs_schema_text();

namespace {

PairKind read_kind(const Node& n) {
  PairKind kind;
  kind.name = n.string("name");
  kind.about = n.string("about");
  kind.picture = n.string("picture");
  kind.lowest = n.number("lowest");
  kind.highest = n.number("highest");
  if (kind.lowest >= kind.highest) throw n.at("highest").error("must be above \"lowest\"");
  kind.linear = n.number("linear");
  kind.lever = n.number("lever");
  kind.rolls = n.boolean("rolls");
  for (const char* key : {"name", "velocity", "repeat"})
    if (n.at("body").has(key)) throw n.at("body").at(key).error("is for brim pairs to choose; leave it out");
  kind.body = n.at("body").json().dump();
  return kind;
}

std::vector<PairNote> read_notes(const Node& n, const char* key) {
  std::vector<PairNote> notes(n.at(key).size());
  for (std::size_t i = 0; i < notes.size(); ++i) {
    const Node note = n.at(key).at(i), pairs = note.at("pairs");
    notes[i].why = note.string("why");
    for (std::size_t j = 0; j < pairs.size(); ++j) notes[i].pairs.push_back(pairs.at(j).string());
  }
  return notes;
}

PairWorld read_world(const Node& n, const std::string& name, const PairDrop& drop) {
  PairWorld world;
  world.name = name;
  world.about = n.string("about");
  world.patch = n.at("world").json().dump();
  world.steps = n.has("steps") ? static_cast<int>(n.integer("steps")) : drop.steps;
  world.voxel_size = n.number("voxel_size");
  world.floor = n.boolean("floor");
  world.notes = read_notes(n, "notes");
  world.constraint_notes = read_notes(n, "constraint_notes");
  return world;
}

/// The kind's entry with a name, moved along, at a velocity.
Json placed_body(const PairKind& kind, const char* name, const std::array<double, 3>& move, double speed) {
  Json body = Json::parse(kind.body);
  body["name"] = name;
  Json& position = body["transform"]["position"];
  for (std::size_t a = 0; a < 3; ++a)
    position[a] = (position[a].is_number() ? position[a].get<double>() : 0.0) + move[a];
  if (speed != 0.0) body["velocity"] = {0, 0, -speed};
  return body;
}

}  // namespace

namespace {

/// @param what  the entries are called, in words
template <class Entry>
const Entry& find_named(const std::vector<Entry>& entries, const std::string& name, const char* what) {
  std::set<std::string> names;
  std::string list;
  for (const Entry& entry : entries) {
    if (entry.name == name) return entry;
    names.insert(entry.name);
    list += (list.empty() ? "" : ", ") + entry.name;
  }
  const std::string near = nearest_word(name, names);
  throw InputError(fmt::format("\"{}\" is no {} of the table; must be one of: {}{}", name, what, list,
                               near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
}

}  // namespace

const PairKind& PairTable::find(const std::string& kind) const { return find_named(kinds, kind, "kind"); }

PairTable PairTable::in_world(const std::string& other) const {
  const PairWorld& chosen = find_named(worlds, other, "world");
  PairTable table = *this;
  table.name = chosen.name;
  table.about = chosen.about;
  table.floor = chosen.floor;
  table.drop.steps = chosen.steps;
  table.worlds.clear();
  table.notes = chosen.notes;
  table.constraint_notes = chosen.constraint_notes;
  Json settings = Json::parse(world);
  settings.merge_patch(Json::parse(chosen.patch));
  if (chosen.voxel_size > 0.0) {
    settings["voxel_size"] = chosen.voxel_size;
    for (PairKind& kind : table.kinds) {
      Json body = Json::parse(kind.body);
      if (body.contains("voxel_size")) body["voxel_size"] = chosen.voxel_size;
      kind.body = body.dump();
    }
  }
  table.world = settings.dump();
  return table;
}

void PairTable::cut(int steps) {
  if (steps < drop.steps) bounds.speed = bounds.carried = std::numeric_limits<double>::infinity();
  drop.steps = steps;
}

void PairTable::set_response(const std::string& response) {
  Json settings = Json::parse(world);
  settings["response"] = response;
  world = settings.dump();
  if (response != "constraint") return;
  notes = constraint_notes;
  for (PairWorld& other : worlds) other.notes = other.constraint_notes;
}

void PairTable::add_kinds(const PairTable& other) {
  for (const PairKind& kind : other.kinds) {
    for (const PairKind& mine : kinds)
      if (mine.name == kind.name)
        throw InputError(fmt::format("\"{}\" is already a kind of the table; choose another name", kind.name));
    kinds.push_back(kind);
  }
  const auto append = [](std::vector<PairNote>& to, const std::vector<PairNote>& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(notes, other.notes);
  append(constraint_notes, other.constraint_notes);
  for (PairWorld& mine : worlds)
    for (const PairWorld& theirs : other.worlds) {
      if (mine.name != theirs.name) continue;
      append(mine.notes, theirs.notes);
      append(mine.constraint_notes, theirs.constraint_notes);
    }
}

bool PairNote::about(const std::string& lower, const std::string& upper) const {
  for (const std::string& pair : pairs)
    if (pair == lower || pair == upper || pair == upper + " on " + lower) return true;
  return false;
}

const PairTable& standard_pairs() {
  static const PairTable table = read_pair_table(standard_pairs_text(), "scenes/pairs/kinds.json");
  return table;
}

PairTable read_pair_table(std::string_view text, const std::string& file) {
  static const Json schema = Json::parse(pairs_schema_text());
  Document document = parse_document(text, file);
  validate(document, schema);
  const Node root(document, document.root, "");
  PairTable table;
  const Node drop = root.at("drop"), bounds = root.at("bounds");
  table.drop.speed = drop.number("speed");
  table.drop.gap = drop.number("gap");
  for (std::size_t a = 0; a < 2; ++a) table.drop.offset[a] = drop.at("offset").at(a).number();
  table.drop.steps = static_cast<int>(drop.integer("steps"));
  table.bounds = {bounds.number("overlap"), bounds.number("energy"), bounds.number("drift"),
                  bounds.number("leak"),    bounds.number("speed"),  bounds.number("carried")};
  Json settings = root.at("world").json();
  settings.emplace("response", "penalty");  // one response for all pairs, rigid ones too
  table.world = settings.dump();
  table.notes = read_notes(root, "notes");
  table.constraint_notes = read_notes(root, "constraint_notes");
  for (const auto& [name, entry] : root.at("worlds").json().items())
    table.worlds.push_back(read_world(root.at("worlds").at(name.c_str()), name, table.drop));
  std::set<std::string> names;
  for (std::size_t i = 0; i < root.at("kinds").size(); ++i) {
    const Node n = root.at("kinds").at(i);
    table.kinds.push_back(read_kind(n));
    if (!names.insert(table.kinds.back().name).second)
      throw n.at("name").error(fmt::format("\"{}\" is given twice; names must be unique", table.kinds.back().name));
  }
  return table;
}

std::string pair_scene_text(const PairTable& table, const PairKind& lower, const PairKind& upper) {
  const double rise = lower.highest - upper.lowest + table.drop.gap;
  Json scene;
  scene["brim"] = 1;
  scene["name"] = upper.name + "_on_" + lower.name;
  scene["description"] = fmt::format("{} flies down on {}.", upper.about.empty() ? upper.name : upper.about,
                                     lower.about.empty() ? lower.name : lower.about);
  scene["frames"] = table.drop.steps;
  scene["world"] = Json::parse(table.world);
  scene["bodies"] =
      Json::array({placed_body(lower, "lower", {0, 0, 0}, 0.0),
                   placed_body(upper, "upper", {table.drop.offset[0], table.drop.offset[1], rise}, table.drop.speed)});
  if (table.floor)
    scene["bodies"].push_back({{"name", "floor"},
                               {"kind", "obstacle"},
                               {"shape", {{"kind", "plane"}, {"display_size", 1}}},
                               {"transform", {{"position", {0, 0, lower.lowest}}}}});
  return scene.dump(2);
}

}  // namespace brim
