#include "brim/record/export/export.h"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "brim/core/error.h"
#include "brim/record/export/items.h"
#include "brim/record/export/staging.h"
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

/// Velocities are recorded per generalised coordinate. They are those of the display's vertices where the coordinates
/// are the vertices' positions; for any other body the run has none. Grains have their spin behind each velocity.
std::vector<Vec3f> vertex_velocities(const RecordedBody& body, const State& state, const std::vector<Vec3f>& x) {
  const std::size_t stride = body.kind == "points" ? 6 : 3;
  if (body.q_size != 3 * x.size() || body.v_size != stride * x.size()) return {};
  const double *q = state.q.data() + body.q_offset, *v = state.v.data() + body.v_offset;
  std::vector<Vec3f> velocities(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (Vec3f(Vec3(q + 3 * i).cast<float>()) != x[i]) return {};
    velocities[i] = Vec3(v + stride * i).cast<float>();
  }
  return velocities;
}

Frame read_frame(const Job& job, std::int64_t index, std::int64_t order) {
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
    frame.velocities.push_back(gone ? std::vector<Vec3f>() : vertex_velocities(*item.recorded, state, x));
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

std::string manifest(const Job& job, const std::string& format, const std::vector<std::string>& files) {
  nlohmann::ordered_json bodies = nlohmann::ordered_json::array();
  for (const Item& item : job.items) bodies.push_back(item.name);
  return nlohmann::ordered_json{{"format", format},
                                {"scene", job.run->scene_name()},
                                {"brim_version", job.run->brim_version()},
                                {"first_frame", job.frames.first},
                                {"last_frame", job.frames.last},
                                {"stride", job.frames.stride},
                                {"frame_time", job.run->frame_time()},
                                {"bodies", bodies},
                                {"files", files}}
             .dump(2, ' ', false, nlohmann::json::error_handler_t::replace) +
         "\n";
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
  Staging staging(request.folder, request.force);
  job.folder = staging.folder();
  const std::unique_ptr<Writer> writer = format.make(job);
  const std::int64_t count = job.frames.count();
  for (std::int64_t k = 0; k < count; ++k) {
    writer->frame(read_frame(job, job.frames.first + k * job.frames.stride, k));
    if (progress && !progress(k + 1, count)) throw InputError("the export was stopped; nothing of it is left");
  }
  writer->finish();
  ExportResult result{count, staging.files()};
  staging.commit(manifest(job, format.name, result.files), result.files);
  return result;
}

}  // namespace brim
