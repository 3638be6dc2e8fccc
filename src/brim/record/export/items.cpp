#include "brim/record/export/items.h"

#include <cmath>
#include <set>

#include "brim/core/error.h"

namespace brim::exporting {

namespace {

bool letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool digit(char c) { return c >= '0' && c <= '9'; }

/// The name made of allowed characters, lengthened by a number where another item has it already. "contacts" is kept
/// for the contacts.
template <class Allowed>
std::string fit_name(std::string name, std::set<std::string>& taken, Allowed allowed) {
  for (char& c : name)
    if (!allowed(c)) c = '_';
  if (name.empty() || name.front() == '.') name.insert(name.begin(), '_');
  std::string unique = name;
  for (int n = 2; !taken.insert(unique).second; ++n) unique = name + "_" + std::to_string(n);
  return unique;
}

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

}  // namespace

std::vector<Item> make_items(const RunReader& run, const std::vector<int>& bodies) {
  std::vector<Vec3f> colours;
  std::size_t moving = 0;
  for (std::size_t b = 0; b < run.bodies().size(); ++b) {
    const bool fixed = run.bodies()[b].immobile && run.still(static_cast<int>(b));
    colours.push_back(linear(fixed ? kFixedColour : kColours[moving++ % std::size(kColours)]));
  }
  std::set<std::string> files = {"contacts"}, identifiers = {"contacts", "World", "Materials"};
  std::vector<Item> items;
  for (const int b : bodies) {
    const RecordedBody& body = run.bodies()[static_cast<std::size_t>(b)];
    Item item;
    item.body = b;
    item.name = body.name;
    item.file_name = fit_name(body.name, files, [](char c) { return letter(c) || digit(c) || c == '-' || c == '.'; });
    const std::string word = !body.name.empty() && digit(body.name.front()) ? "_" + body.name : body.name;
    item.identifier = fit_name(word, identifiers, [](char c) { return letter(c) || digit(c); });
    item.recorded = &body;
    item.still = run.still(b);
    item.colour = colours[static_cast<std::size_t>(b)];
    items.push_back(std::move(item));
  }
  return items;
}

std::string numbered(std::string_view name, std::int64_t frame, std::string_view end) {
  return fmt::format("{}_{:05}.{}", name, frame, end);
}

}  // namespace brim::exporting
