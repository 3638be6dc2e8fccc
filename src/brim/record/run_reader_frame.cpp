#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "brim/record/run_layout.h"
#include "brim/record/run_reader_impl.h"
#include "brim/world/edits.h"

namespace brim {

using h5::Type;
using Row = std::vector<std::uint64_t>;

std::vector<int> RunReader::removed(std::int64_t frame) const {
  const auto [first, n] = impl_->range("/memory", frame);
  State state;
  state.warm_start = impl_->rows<double>("/memory/value", first, n, 1, Type::Float64);
  std::vector<int> list = removed_in(state);
  std::erase_if(list, [&](int b) { return static_cast<std::size_t>(b) >= impl_->tables.bodies.size(); });
  return list;
}

std::vector<ContactSample> RunReader::contacts(std::int64_t frame) const {
  const auto [first, n] = impl_->range("/contacts", frame);
  const auto x = impl_->rows<float>("/contacts/position", first, n, 3, Type::Float32);
  const auto f = impl_->rows<float>("/contacts/force", first, n, 3, Type::Float32);
  const auto t = impl_->rows<float>("/contacts/friction", first, n, 3, Type::Float32);
  const auto o = impl_->rows<float>("/contacts/overlap", first, n, 1, Type::Float32);
  const auto p = impl_->parts_of("/contacts/pair", first, n);
  std::vector<ContactSample> list(n);
  for (std::size_t i = 0; i < n; ++i)
    list[i] = {Vec3f(&x[3 * i]), Vec3f(&f[3 * i]), Vec3f(&t[3 * i]), o[i], p[2 * i], p[2 * i + 1]};
  return list;
}

std::vector<std::pair<TileKey, double>> RunReader::tiles(std::int64_t frame) const {
  const auto [first, n] = impl_->range("/tiles", frame);
  const auto k = impl_->rows<std::int32_t>("/tiles/key", first, n, 3, Type::Int32);
  const auto h = impl_->rows<double>("/tiles/step", first, n, 1, Type::Float64);
  std::vector<std::pair<TileKey, double>> list(n);
  for (std::size_t i = 0; i < n; ++i) list[i] = {TileKey{k[3 * i], k[3 * i + 1], k[3 * i + 2]}, h[i]};
  return list;
}

std::vector<PairReport> RunReader::pairs(std::int64_t frame) const {
  const auto [first, n] = impl_->range("/pairs", frame);
  const auto parts = impl_->parts_of("/pairs/parts", first, n);
  const auto force = impl_->rows<double>("/pairs/force", first, n, 3, Type::Float64);
  const auto friction = impl_->rows<double>("/pairs/friction", first, n, 3, Type::Float64);
  const auto center = impl_->rows<double>("/pairs/center", first, n, 3, Type::Float64);
  const auto contacts = impl_->rows<std::int32_t>("/pairs/contacts", first, n, 1, Type::Int32);
  const auto overlap = impl_->rows<double>("/pairs/overlap", first, n, 1, Type::Float64);
  const auto pressure = impl_->rows<double>("/pairs/pressure", first, n, 1, Type::Float64);
  std::vector<PairReport> list(n);
  for (std::size_t i = 0; i < n; ++i) {
    PairReport& r = list[i];
    r.part_a = parts[2 * i];
    r.part_b = parts[2 * i + 1];
    r.contacts = contacts[i];
    r.worst_overlap = overlap[i];
    r.worst_pressure = pressure[i];
    r.force_on_a = Vec3(&force[3 * i]);
    r.friction_on_a = Vec3(&friction[3 * i]);
    r.center = Vec3(&center[3 * i]);
  }
  return list;
}

std::vector<LinkReport> RunReader::links(std::int64_t frame) const {
  impl_->need(frame);
  if (!impl_->file.exists("/links")) return {};
  const auto [first, n] = impl_->range("/links", frame);
  const auto force = impl_->rows<double>("/links/force", first, n, 3, Type::Float64);
  const auto error = impl_->rows<double>("/links/error", first, n, 1, Type::Float64);
  const auto coordinate = impl_->rows<double>("/links/coordinate", first, n, 1, Type::Float64);
  const auto effort = impl_->rows<double>("/links/effort", first, n, 1, Type::Float64);
  const auto broken = impl_->rows<std::int32_t>("/links/broken", first, n, 1, Type::Int32);
  std::vector<LinkReport> list(n);
  for (std::size_t i = 0; i < n; ++i)
    list[i] = {Vec3(&force[3 * i]), error[i], coordinate[i], effort[i], broken[i] != 0};
  return list;
}

std::vector<std::string> RunReader::link_names() const { return impl_->lines_of("/links", "names"); }
std::vector<std::string> RunReader::link_kinds() const { return impl_->lines_of("/links", "kinds"); }

std::vector<std::pair<int, int>> RunReader::link_bodies() const {
  std::vector<std::pair<int, int>> list;
  const int n = static_cast<int>(impl_->tables.bodies.size());
  for (const std::string& line : impl_->lines_of("/links", "bodies")) {
    std::istringstream words(line);
    std::pair<int, int> both{-1, -1};
    if (!(words >> both.first >> both.second) || both.first < 0 || both.second < -1 ||
        std::max(both.first, both.second) >= n)
      throw InputError(fmt::format("{}: the bodies of its attachments are damaged: \"{}\"", impl_->path, line));
    list.push_back(both);
  }
  return list;
}

std::vector<RecordedEnd> RunReader::link_ends(std::int64_t frame) const {
  impl_->need(frame);
  if (!impl_->file.exists("/link_ends")) return {};
  const auto [first, n] = impl_->range("/link_ends", frame);
  const auto link = impl_->rows<std::int32_t>("/link_ends/link", first, n, 1, Type::Int32);
  const auto a = impl_->rows<float>("/link_ends/a", first, n, 3, Type::Float32);
  const auto b = impl_->rows<float>("/link_ends/b", first, n, 3, Type::Float32);
  std::vector<RecordedEnd> list(n);
  for (std::size_t i = 0; i < n; ++i) list[i] = {link[i], Vec3f(&a[3 * i]), Vec3f(&b[3 * i])};
  return list;
}

std::vector<Warning> RunReader::warnings(std::int64_t frame) const {
  const auto [first, n] = impl_->range("/warnings", frame);
  const auto bytes = impl_->rows<std::uint8_t>("/warnings/text", first, n, 1, Type::UInt8);
  std::istringstream lines(std::string(bytes.begin(), bytes.end()));
  std::vector<Warning> list;
  for (std::string line; std::getline(lines, line);) {
    const auto w = nlohmann::json::parse(line, nullptr, false);
    if (!w.is_object() || !w.contains("time") || !w["time"].is_number()) continue;
    const auto word = [&](const char* key) {
      return w.contains(key) && w[key].is_string() ? w[key].get<std::string>() : std::string();
    };
    list.push_back({w["time"].get<double>(), word("code"), word("message")});
  }
  return list;
}

StepReport RunReader::report(std::int64_t frame) const {
  StepReport r;
  for (const ReportField& f : report_fields()) f.set(r, impl_->scalars(f.name, impl_->need(frame), 1)[0]);
  r.time = time(frame);
  r.pairs = pairs(frame);
  r.links = links(frame);
  r.warnings = warnings(frame);
  return r;
}

int RunReader::steps(std::int64_t frame) const {
  const double steps = impl_->scalars("steps", impl_->need(frame), 1)[0];
  if (!(steps >= 0.0 && steps <= static_cast<double>(kMostSteps)))
    throw InputError(fmt::format("{}:/series/steps: is {} at frame {}", impl_->path, steps, frame));
  return static_cast<int>(steps);
}

std::vector<BodySample> RunReader::samples(std::int64_t frame) const {
  std::vector<BodySample> list(impl_->tables.bodies.size());
  for (const run_layout::MotionField& f : run_layout::kMotion) {
    if (f.late && !impl_->sets.contains(f.path) && !impl_->file.exists(f.path)) continue;
    const auto width = static_cast<std::size_t>(f.width);
    const auto x = impl_->rows<double>(f.path, impl_->need(frame), 1,
                                       width > 1 ? Row{list.size(), width} : Row{list.size()}, Type::Float64);
    for (std::size_t b = 0; b < list.size(); ++b) f.set(list[b], &x[b * width]);
  }
  return list;
}

std::vector<double> RunReader::series(const std::string& name) const {
  return impl_->scalars(name, 0, static_cast<std::uint64_t>(impl_->frames));
}

}  // namespace brim
