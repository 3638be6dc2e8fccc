#include "brim/record/frame_lists.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "brim/world/attachment.h"

namespace brim {

namespace {

using h5::Type;

constexpr std::uint64_t kContactRows = 4096, kTileRows = 1024, kPairRows = 512, kTextRows = 4096;  // in a chunk

constexpr ListColumn kContactColumns[] = {{"position", Type::Float32, 3},
                                          {"force", Type::Float32, 3},
                                          {"friction", Type::Float32, 3},
                                          {"overlap", Type::Float32, 0},
                                          {"pair", Type::Int32, 2}};
constexpr ListColumn kTileColumns[] = {{"key", Type::Int32, 3}, {"step", Type::Float64, 0}};
constexpr ListColumn kPairColumns[] = {{"parts", Type::Int32, 2},      {"force", Type::Float64, 3},
                                       {"friction", Type::Float64, 3}, {"center", Type::Float64, 3},
                                       {"contacts", Type::Int32, 0},   {"overlap", Type::Float64, 0},
                                       {"pressure", Type::Float64, 0}};
constexpr ListColumn kLinkColumns[] = {{"force", Type::Float64, 3},
                                       {"error", Type::Float64, 0},
                                       {"coordinate", Type::Float64, 0},
                                       {"effort", Type::Float64, 0},
                                       {"broken", Type::Int32, 0}};
constexpr ListColumn kEndColumns[] = {{"link", Type::Int32, 0}, {"a", Type::Float32, 3}, {"b", Type::Float32, 3}};
constexpr ListColumn kMemoryColumns[] = {{"value", Type::Float64, 0}};
constexpr ListColumn kWarningColumns[] = {{"text", Type::UInt8, 0}};

/// How a run calls what holds.
std::string kind_of(const Attachment& a) {
  if (!a.joint) return a.region ? "region" : "point";
  switch (a.joint->kind) {
    case JointKind::Revolute:
      return "hinge";
    case JointKind::Prismatic:
      return "slider";
    case JointKind::Ball:
      return "ball";
    default:
      return "fixed";
  }
}

/// −1: space.
int number_of(const World& world, const std::string& body) {
  int b = world.body_count() - 1;
  while (b >= 0 && (body.empty() || world.body(b).name() != body)) --b;
  return b;
}

}  // namespace

FrameLists::FrameLists(h5::File& file, const World& world, bool create)
    : contacts_(file, "/contacts", kContactColumns, kContactRows, create),
      tiles_(file, "/tiles", kTileColumns, kTileRows, create),
      pairs_(file, "/pairs", kPairColumns, kPairRows, create),
      memory_(file, "/memory", kMemoryColumns, kContactRows, create),
      warnings_(file, "/warnings", kWarningColumns, kTextRows, create) {
  if (create ? world.attachment_count() == 0 : !file.exists("/links")) return;
  links_.emplace(file, "/links", kLinkColumns, kPairRows, create);
  if (create || file.exists("/link_ends"))  // older runs have none
    link_ends_.emplace(file, "/link_ends", kEndColumns, kPairRows, create);
  if (!create) return;
  std::string names, kinds, bodies;
  for (int i = 0; i < world.attachment_count(); ++i) {
    const Attachment& a = world.attachment(i);
    names.append(i > 0 ? "\n" : "").append(a.name);
    kinds.append(i > 0 ? "\n" : "").append(kind_of(a));
    bodies += fmt::format("{}{} {}", i > 0 ? "\n" : "", number_of(world, a.body), number_of(world, a.to));
  }
  file.attribute("/links", "names", names);
  file.attribute("/links", "kinds", kinds);
  file.attribute("/links", "bodies", bodies);
}

void FrameLists::add(const World& world, const StepReport& frame, std::span<const ContactSample> contacts,
                     std::span<const std::pair<TileKey, double>> tiles) {
  add_contacts(contacts);
  add_tiles(tiles);
  add_pairs(frame.pairs);
  add_links(frame.links);
  add_link_ends(world);
  const State& state = world.state();
  memory_.append_rows(0, state.warm_start.data(), state.warm_start.size());
  memory_.close_frame(state.warm_start.size());
  add_warnings(frame.warnings);
}

void FrameLists::add_contacts(std::span<const ContactSample> list) {
  const auto copy3 = [](const Vec3f& x, float* to) { to[0] = x[0], to[1] = x[1], to[2] = x[2]; };
  contacts_.append<float>(0, list, 3, [&](const auto& c, float* x) { copy3(c.position, x); });
  contacts_.append<float>(1, list, 3, [&](const auto& c, float* x) { copy3(c.force, x); });
  contacts_.append<float>(2, list, 3, [&](const auto& c, float* x) { copy3(c.friction, x); });
  contacts_.append<float>(3, list, 1, [](const auto& c, float* x) { *x = c.overlap; });
  contacts_.append<std::int32_t>(4, list, 2, [](const auto& c, std::int32_t* x) {
    x[0] = c.part_a;
    x[1] = c.part_b;
  });
  contacts_.close_frame(list.size());
}

void FrameLists::add_tiles(std::span<const std::pair<TileKey, double>> list) {
  tiles_.append<std::int32_t>(0, list, 3, [](const auto& tile, std::int32_t* x) {
    x[0] = tile.first.x;
    x[1] = tile.first.y;
    x[2] = tile.first.z;
  });
  tiles_.append<double>(1, list, 1, [](const auto& tile, double* x) { *x = tile.second; });
  tiles_.close_frame(list.size());
}

void FrameLists::add_pairs(const std::vector<PairReport>& list) {
  const auto vectors = [&](std::size_t column, Vec3 PairReport::*member) {
    pairs_.append<double>(column, list, 3, [&](const PairReport& r, double* x) {
      for (int a = 0; a < 3; ++a) x[a] = (r.*member)[a];
    });
  };
  pairs_.append<std::int32_t>(0, list, 2, [](const PairReport& r, std::int32_t* x) {
    x[0] = r.part_a;
    x[1] = r.part_b;
  });
  vectors(1, &PairReport::force_on_a);
  vectors(2, &PairReport::friction_on_a);
  vectors(3, &PairReport::center);
  pairs_.append<std::int32_t>(4, list, 1, [](const PairReport& r, std::int32_t* x) { *x = r.contacts; });
  pairs_.append<double>(5, list, 1, [](const PairReport& r, double* x) { *x = r.worst_overlap; });
  pairs_.append<double>(6, list, 1, [](const PairReport& r, double* x) { *x = r.worst_pressure; });
  pairs_.close_frame(list.size());
}

void FrameLists::add_links(const std::vector<LinkReport>& list) {
  if (!links_) return;
  links_->append<double>(0, list, 3, [](const LinkReport& r, double* x) {
    for (int a = 0; a < 3; ++a) x[a] = r.force[a];
  });
  links_->append<double>(1, list, 1, [](const LinkReport& r, double* x) { *x = r.error; });
  links_->append<double>(2, list, 1, [](const LinkReport& r, double* x) { *x = r.coordinate; });
  links_->append<double>(3, list, 1, [](const LinkReport& r, double* x) { *x = r.effort; });
  links_->append<std::int32_t>(4, list, 1, [](const LinkReport& r, std::int32_t* x) { *x = r.broken ? 1 : 0; });
  links_->close_frame(list.size());
}

void FrameLists::add_link_ends(const World& world) {
  if (!link_ends_) return;
  struct End {
    std::int32_t link;
    Vec3f a, b;
  };
  std::vector<End> list;
  for (int i = 0; i < world.attachment_count(); ++i)
    for (const auto& [a, b] : world.attachment(i).ends) list.push_back({i, a.cast<float>(), b.cast<float>()});
  link_ends_->append<std::int32_t>(0, list, 1, [](const End& e, std::int32_t* x) { *x = e.link; });
  link_ends_->append<float>(1, list, 3, [](const End& e, float* x) { std::copy_n(e.a.data(), 3, x); });
  link_ends_->append<float>(2, list, 3, [](const End& e, float* x) { std::copy_n(e.b.data(), 3, x); });
  link_ends_->close_frame(list.size());
}

void FrameLists::add_warnings(const std::vector<Warning>& list) {
  std::string text;
  for (const Warning& w : list)
    text += nlohmann::ordered_json{{"time", w.time}, {"code", w.code}, {"message", w.message}}.dump(
                -1, ' ', false, nlohmann::json::error_handler_t::replace) +
            "\n";
  warnings_.append_rows(0, text.data(), text.size());
  warnings_.close_frame(text.size());
}

template <class Visit>
void FrameLists::for_each(const Visit& visit) {
  for (RaggedList* list : {&contacts_, &tiles_, &pairs_, &memory_, &warnings_}) visit(*list);
  if (links_) visit(*links_);
  if (link_ends_) visit(*link_ends_);
}

void FrameLists::cut(std::uint64_t frames) {
  for_each([&](RaggedList& list) { list.cut(frames); });
}

void FrameLists::flush() {
  for_each([](RaggedList& list) { list.flush(); });
}

}  // namespace brim
