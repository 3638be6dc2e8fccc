#include "brim/record/export/items.h"

#include <cmath>

#include "brim/core/error.h"
#include "brim/record/export/names.h"

namespace brim::exporting {

namespace {

/// sRGB, as hexadecimal colours on screens are, to linear.
Vec3f linear(int rgb) {
  Vec3f c;
  for (int a = 0; a < 3; ++a) {
    const double s = ((rgb >> (16 - 8 * a)) & 0xff) / 255.0;
    c[a] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
  }
  return c;
}

// The same as in viewer/src/scene/palette.ts, so that a body keeps its colour from program to program.
constexpr int kColours[] = {0x4f83b5, 0xe2a03f, 0xb8455f, 0x43a88c, 0xe8c9a0, 0x6b4f8f, 0x8cc7dd, 0x7b5a3a};
constexpr int kFixedColour = 0xb4babd;

/// Rigid pieces of a body that has several, named as its parts are, in identifiers without the body's own name.
std::vector<ItemPiece> pieces_of(const RunReader& run, int body) {
  const std::vector<RecordedPiece> recorded = run.pieces(body);
  if (recorded.size() < 2) return {};
  std::vector<std::string> names(recorded.size()), words;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = fmt::format("piece {}", i);
  for (const RecordedPart& part : run.parts())
    if (part.body == body && static_cast<std::size_t>(part.part) < names.size())
      names[static_cast<std::size_t>(part.part)] = part.name;
  const std::string prefix = run.bodies()[static_cast<std::size_t>(body)].name + "/";
  for (const std::string& name : names) {
    const std::string word = name.starts_with(prefix) ? name.substr(prefix.size()) : name;
    words.push_back(!word.empty() && word[0] >= '0' && word[0] <= '9' ? "piece_" + word : word);
  }
  words = identifiers(words);
  std::vector<ItemPiece> pieces;
  for (std::size_t i = 0; i < names.size(); ++i) pieces.push_back({names[i], words[i], recorded[i]});
  return pieces;
}

}  // namespace

std::vector<Item> make_items(const RunReader& run, const std::vector<int>& bodies) {
  std::vector<Vec3f> colours;
  std::size_t moving = 0;
  for (std::size_t b = 0; b < run.bodies().size(); ++b) {
    const bool fixed = run.bodies()[b].immobile && run.still(static_cast<int>(b));
    colours.push_back(linear(fixed ? kFixedColour : kColours[moving++ % std::size(kColours)]));
  }
  // Of all bodies of the run, so that a choice of them changes no name.
  std::vector<std::string> names;
  for (const RecordedBody& body : run.bodies()) names.push_back(body.name);
  const std::vector<std::string> files = file_names(names),
                                 words = identifiers(names, {"contacts", "World", "Materials"});
  std::vector<Item> items;
  for (const int b : bodies) {
    const auto n = static_cast<std::size_t>(b);
    const RecordedBody& body = run.bodies()[n];
    Item item;
    item.body = b;
    item.name = body.name;
    item.file_name = files[n];
    item.identifier = words[n];
    item.recorded = &body;
    item.pieces = pieces_of(run, b);
    item.still = run.still(b);
    item.colour = colours[n];
    items.push_back(std::move(item));
  }
  return items;
}

std::string pattern(std::string_view name, std::string_view end) { return fmt::format("{}_%05d.{}", name, end); }

std::string numbered(std::string_view name, std::int64_t frame, std::string_view end) {
  return fmt::format("{}_{:05}.{}", name, frame, end);
}

}  // namespace brim::exporting
