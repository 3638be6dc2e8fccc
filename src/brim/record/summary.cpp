#include "brim/record/summary.h"

#if defined(__unix__) || defined(__APPLE__)
#include <sys/resource.h>
#endif

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "brim/body/spinning_balls.h"
#include "brim/world/report_fields.h"

namespace brim {

namespace {

using Json = nlohmann::ordered_json;

double energy(const StepReport& r) { return r.kinetic_energy + r.potential_energy + r.contact_energy; }

double ratio(double a, double b) { return b > 0.0 ? a / b : 0.0; }

Json finding_json(const ExpectationResult& f) {
  const Expectation& e = f.expectation;
  Json j{{"metric", e.metric}};
  if (!e.body.empty()) j["body"] = e.body;
  if (!e.reading.sensor.empty()) {
    j["sensor"] = e.reading.sensor;
    j["channel"] = e.reading.channel;
    j["take"] = e.take;
    if (!e.over.sensor.empty()) j["over"] = {{"sensor", e.over.sensor}, {"channel", e.over.channel}};
  }
  j["from"] = e.from;
  if (std::isfinite(e.to)) j["to"] = e.to;
  if (std::isfinite(e.min)) j["min"] = e.min;
  if (std::isfinite(e.max)) j["max"] = e.max;
  if (!f.body.empty()) j["worst_body"] = f.body;
  if (f.reached && std::isfinite(f.value))
    j["value"] = f.value;
  else
    j["value"] = nullptr;
  j["reached"] = f.reached;
  j["ok"] = f.ok;
  if (!e.known_miss.empty()) j["known_miss"] = e.known_miss;
  if (std::isfinite(e.known_worst)) j["known_worst"] = e.known_worst;
  if (f.worse()) j["worse"] = true;
  return j;
}

}  // namespace

const char* run_end_word(RunEnd end) {
  switch (end) {
    case RunEnd::Completed:
      return "completed";
    case RunEnd::Interrupted:
      return "interrupted";
    case RunEnd::Failed:
      return "failed";
  }
  return "failed";
}

void RunTotals::warn(const Warning& w) {
  ++warning_count;
  ++warning_codes[w.code];
  if (warnings.size() < kWarningsKept) warnings.push_back(w);
}

void RunTotals::add(const StepReport& r, int n) {
  ++frames;
  last = r;
  last.pairs.clear();
  last.warnings.clear();
  for (const Warning& w : r.warnings) warn(w);
  for (std::size_t i = 0; i < seconds.size(); ++i) seconds[i] += r.seconds[i];
  if (n == 0) return;
  if (steps == 0) energy_first = energy_largest = energy(r);
  steps += n;
  substeps += r.substeps;
  solves += r.solves;
  wall += r.wall;
  contact_seconds += brim::contact_seconds(r);
  const auto count = [&](const char* name, double total, double per) {
    Count& c = counts[name];
    c.sum += total;
    c.largest = std::max(c.largest, ratio(total, per));
  };
  count("contacts", static_cast<double>(r.contacts) * n, n);
  count("tiles_present", static_cast<double>(r.tiles_present), n);
  count("tiles", static_cast<double>(r.tiles), n);
  count("voxels", static_cast<double>(r.voxels), n);
  count("cg_iterations", r.cg_iterations, r.solves);
  count("substeps", r.substeps, n);
  count("constraint_sweeps", r.sweeps, n);
  if (r.worst_overlap > worst_overlap) {
    worst_overlap = r.worst_overlap;
    worst_overlap_time = r.time;
  }
  for (const PairReport& p : r.pairs)
    if (p.worst_overlap > worst_pair_overlap) {
      worst_pair_overlap = p.worst_overlap;
      worst_part_a = p.part_a;
      worst_part_b = p.part_b;
    }
  momentum_error = std::max(momentum_error, r.momentum_error);
  angular_error = std::max(angular_error, r.angular_error);
  cg_residual = std::max(cg_residual, r.cg_residual);
  row_residual = std::max(row_residual, r.row_residual);
  energy_last = energy(r);
  energy_largest = std::max(energy_largest, energy_last);
}

std::string summary_text(const World& world, const RunTotals& t, const RunFacts& facts,
                         const std::vector<ExpectationResult>& findings) {
  double particles = 0.0;
  std::map<std::string, int> kinds;
  for (int b = 0; b < world.body_count(); ++b) {
    const Body& body = world.body(b);
    ++kinds[std::string(body.kind())];
    // Six velocities are a rigid body; more come in threes, one per node, or sixes.
    if (std::isfinite(body.mass()) && body.v_size() > 6)
      particles += static_cast<double>(body.v_size() / velocities_per_node(body));
  }
  const auto part_name = [&](int p) {
    const PartRef ref = world.part(p);
    const Body& body = world.body(ref.body);
    return body.part_count() > 1 ? fmt::format("{}/{}", body.name(), ref.index) : body.name();
  };
  Json seconds;
  for (std::size_t i = 0; i < t.seconds.size(); ++i) seconds[kPhaseNames[i]] = t.seconds[i];
  Json counts{{"bodies", world.body_count()},         {"kinds", kinds},
              {"parts", world.part_count()},          {"coordinates", world.state().q.size()},
              {"velocities", world.state().v.size()}, {"particles", particles}};
  for (const auto& [name, c] : t.counts) {
    const double per = name == "cg_iterations" ? static_cast<double>(t.solves) : static_cast<double>(t.steps);
    counts[name] = {{"mean", ratio(c.sum, per)}, {"max", c.largest}};
  }
  Json overlap{{"voxels", t.worst_overlap}, {"time", t.worst_overlap_time}};
  if (t.worst_part_a >= 0) overlap["pair"] = Json::array({part_name(t.worst_part_a), part_name(t.worst_part_b)});
  Json warnings = Json::array();
  for (const Warning& w : t.warnings) warnings.push_back({{"time", w.time}, {"code", w.code}, {"message", w.message}});
  Json expect = Json::array();
  bool all = true;
  for (const ExpectationResult& f : findings) {
    expect.push_back(finding_json(f));
    all = all && f.as_expected();
  }
  const Json summary{
      {"brim_version", BRIM_VERSION},
      {"scene", {{"name", facts.scene_name}, {"file", facts.scene_file}}},
      {"end", run_end_word(facts.end)},
      {"threads", facts.threads},
      {"frames", t.frames},
      {"frames_wanted", facts.frames_wanted + 1},
      {"frame_time", facts.frame_time},
      {"steps", t.steps},
      {"substeps", t.substeps},
      {"simulated_seconds", world.state().time},
      {"wall_seconds", facts.wall},
      {"build_seconds", facts.build_wall},
      {"step_seconds", ratio(t.wall, static_cast<double>(t.steps))},
      {"steps_per_second", ratio(static_cast<double>(t.steps), t.wall)},
      {"seconds", seconds},
      {"contact_share", ratio(t.contact_seconds, t.wall)},
      {"counts", counts},
      {"worst_overlap", overlap},
      {"momentum_error", t.momentum_error},
      {"angular_error", t.angular_error},
      {"cg_residual", t.cg_residual},
      {"row_residual", t.row_residual},
      {"stiffness", world.stiffness()},
      {"energy",
       {{"first", t.energy_first},
        {"last", t.energy_last},
        {"largest", t.energy_largest},
        {"kinetic", t.last.kinetic_energy},
        {"potential", t.last.potential_energy},
        {"contact", t.last.contact_energy}}},
      {"max_speed", t.last.max_speed},
      {"hash", fmt::format("{:016x}", world.hash())},
      {"peak_memory_bytes", peak_memory()},
      {"warnings", {{"count", t.warning_count}, {"codes", t.warning_codes}, {"first", warnings}}},
      {"expect", expect},
      {"expect_ok", all},
  };
  return summary.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

double peak_memory() {
#if defined(__unix__) || defined(__APPLE__)
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0.0;
#if defined(__APPLE__)
  return static_cast<double>(usage.ru_maxrss);
#else
  return static_cast<double>(usage.ru_maxrss) * 1024.0;
#endif
#else
  return 0.0;
#endif
}

}  // namespace brim
