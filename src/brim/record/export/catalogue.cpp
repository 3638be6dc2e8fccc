#include "brim/record/export/catalogue.h"

#include <nlohmann/json.hpp>

namespace brim::exporting {

namespace {

using Json = nlohmann::ordered_json;

const char* display_word(Display::Kind kind) {
  return kind == Display::Kind::Triangles ? "triangles" : kind == Display::Kind::Lines ? "lines" : "points";
}

const char* velocity_word(VelocitySource source) {
  switch (source) {
    case VelocitySource::None:
      return "none";
    case VelocitySource::Twist:
    case VelocitySource::Nodes:
      return "recorded";
    case VelocitySource::Map:
      return "map";
    case VelocitySource::Differences:
      return "differences";
  }
  return "none";
}

Json place_of(const ItemPlace& place) {
  Json json = Json::object();
  if (!place.file.empty()) json["file"] = place.file;
  if (!place.path.empty()) json["path"] = place.path;
  return json;
}

Json body_of(const Item& item, const ItemPlace& place, const std::vector<std::int64_t>& gone) {
  Json body = {{"name", item.name},           {"number", item.body},
               {"kind", item.recorded->kind}, {"display", display_word(item.recorded->display.kind)},
               {"still", item.still},         {"changing", item.recorded->changing}};
  body.update(place_of(place));
  body["velocity"] = velocity_word(item.velocity);
  body["removed"] = gone;
  Json pieces = Json::array();
  for (std::size_t p = 0; p < item.pieces.size(); ++p) {
    const ItemPiece& piece = item.pieces[p];
    Json entry = {
        {"name", piece.name}, {"first_vertex", piece.vertices.first_vertex}, {"vertices", piece.vertices.vertices}};
    if (p < place.pieces.size()) entry["path"] = place.pieces[p];
    pieces.push_back(std::move(entry));
  }
  body["pieces"] = pieces;
  return body;
}

}  // namespace

void Catalogue::frame(const Frame& frame) {
  frames_.push_back(frame.index);
  times_.push_back(frame.time);
  for (std::size_t i = 0; i < job_.items.size(); ++i)
    if (frame.gone[i] != 0) gone_[i].push_back(frame.index);
}

std::string Catalogue::text(const Writer& writer, const std::vector<std::string>& files) const {
  Json bodies = Json::array(), parts = Json::array();
  for (std::size_t i = 0; i < job_.items.size(); ++i)
    bodies.push_back(body_of(job_.items[i], writer.place(job_.items[i]), gone_[i]));
  for (const RecordedPart& part : job_.run->parts())
    parts.push_back({{"name", part.name},
                     {"body", job_.run->bodies()[static_cast<std::size_t>(part.body)].name},
                     {"material", part.material}});
  const Json json = {{"format", format_},
                     {"scene", job_.run->scene_name()},
                     {"brim_version", job_.run->brim_version()},
                     {"first_frame", job_.frames.first},
                     {"last_frame", job_.frames.last},
                     {"stride", job_.frames.stride},
                     {"frame_time", job_.run->frame_time()},
                     {"frames", frames_},
                     {"times", times_},
                     {"bodies", bodies},
                     {"contacts", place_of(writer.contacts_place())},
                     {"parts", parts},
                     {"files", files}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace brim::exporting
