#include "brim/record/export/export.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/record/export/catalogue.h"
#include "brim/record/export/items.h"
#include "brim/record/export/staging.h"
#include "brim/record/export/velocities.h"
#include "brim/world/edits.h"
#include "brim/world/measures.h"

namespace brim {

using namespace exporting;

std::vector<int> choose_bodies(const RunReader& run, const std::vector<std::string>& names) {
  const std::vector<RecordedBody>& bodies = run.bodies();
  std::vector<char> chosen(bodies.size(), names.empty() ? 1 : 0);
  for (const std::string& name : names) {
    bool found = false;
    for (std::size_t b = 0; b < bodies.size(); ++b)
      if (concerns(name, bodies[b].name)) {
        chosen[b] = 1;
        found = true;
      }
    if (found) continue;
    std::string known;
    for (std::size_t b = 0; b < bodies.size() && b < 20; ++b) known += (b ? ", " : "") + bodies[b].name;
    throw InputError(fmt::format("body \"{}\" is not in the run; it has {}{}", name, known,
                                 bodies.size() > 20 ? fmt::format(" and {} more", bodies.size() - 20) : ""));
  }
  std::vector<int> list;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (chosen[b]) list.push_back(static_cast<int>(b));
  return list;
}

namespace {

const Format& format_named(const std::string& name) {
  std::string known;
  for (const Format& f : formats()) {
    if (name == f.name) return f;
    known += (known.empty() ? "" : ", ") + std::string(f.name);
  }
  throw InputError(fmt::format("format \"{}\" is not one that can be written; it must be one of {}", name, known));
}

Frame read_frame(const Job& job, Velocities& velocities, std::int64_t index, std::int64_t order) {
  Frame frame;
  frame.index = index;
  frame.order = order;
  frame.time = job.run->time(index);
  const State state = job.run->state(index);
  std::vector<char> chosen(job.run->bodies().size(), 0);
  const std::vector<int> removed = removed_in(state);
  for (const Item& item : job.items) {
    chosen[static_cast<std::size_t>(item.body)] = 1;
    const bool gone = std::ranges::binary_search(removed, item.body);
    frame.gone.push_back(gone ? 1 : 0);
    std::vector<Vec3f> x;
    std::vector<Triangle> triangles;
    std::vector<Line> lines;
    if (!gone) {
      x = job.run->positions(item.body, index);
      triangles = job.run->triangles(item.body, index);
      lines = item.recorded->display.lines;
    }
    const bool moving = !gone && item.velocity != VelocitySource::None;
    frame.velocities.push_back(moving ? velocities.at(item.body, index, state, x) : std::vector<Vec3f>());
    frame.positions.push_back(std::move(x));
    frame.triangles.push_back(std::move(triangles));
    frame.lines.push_back(std::move(lines));
  }
  const auto takes_part = [&](std::int32_t part) {
    const auto& parts = job.run->parts();
    if (part < 0 || static_cast<std::size_t>(part) >= parts.size()) return false;
    return chosen[static_cast<std::size_t>(parts[static_cast<std::size_t>(part)].body)] != 0;
  };
  for (const ContactSample& c : job.run->contacts(index))
    if (takes_part(c.part_a) || takes_part(c.part_b)) frame.contacts.push_back(c);
  return frame;
}

}  // namespace

ExportResult export_run(const RunReader& run, const ExportRequest& request, const WorldAt& world_at,
                        const std::function<bool(std::int64_t, std::int64_t)>& progress) {
  const Format& format = format_named(request.format);
  Job job;
  job.run = &run;
  job.frames = parse_frames(request.frames, run.frames());
  job.items = make_items(run, choose_bodies(run, request.bodies));
  job.voxel_size = request.voxel_size;
  job.world_at = world_at;
  if (format.world && !world_at)
    throw InputError(
        fmt::format("format \"{}\" writes what is not recorded and needs the scene of the run", format.name));
  Velocities velocities(run, world_at);
  if (format.velocities)
    for (Item& item : job.items) item.velocity = velocities.source(item.body);
  Staging staging(request.folder, request.force);
  job.folder = staging.folder();
  Catalogue catalogue(job, format.name);
  const std::unique_ptr<Writer> writer = format.make(job);
  const std::int64_t count = job.frames.count();
  for (std::int64_t k = 0; k < count; ++k) {
    const Frame frame = read_frame(job, velocities, job.frames.first + k * job.frames.stride, k);
    writer->frame(frame);
    catalogue.frame(frame);
    if (progress && !progress(k + 1, count)) throw InputError("the export was stopped; nothing of it is left");
  }
  writer->finish();
  ExportResult result{count, staging.files()};
  staging.commit(catalogue.text(*writer, result.files), result.files);
  return result;
}

}  // namespace brim
