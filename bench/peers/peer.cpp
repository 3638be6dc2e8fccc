// One scene in one engine, in a process of its own: what a step costs and how well things rest, as one line of JSON.
//   peer scene.json brim|Bullet|BulletAsleep|MuJoCo|MuJoCoCG [--seconds S] [--window W] [--budget B] [--threads N]
//        [--start FILE] [--save FILE]
// --seconds S    [s] simulated; default: the scene's duration
// --window W     [s] at the end that are told apart as "rest"; default 1, at most half of the run
// --budget B     [s] of processor time after which the run is cut; "complete" then is false
// --save FILE    writes where the solids of a pile lie in the end
// --start FILE   starts where they lie in such a file, at rest
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/world/report_fields.h"
#include "cloth.h"
#include "pile.h"

namespace brim::peers {

namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string scene, engine, start, save;
  double seconds = 0.0, window = 1.0, budget = 1e9;
  int threads = 1;
};

/// [s] of processor time of this process: another program's load does not count.
double processor_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Times the steps of a run and adds what they cost to the result.
void time_steps(const Options& o, double dt, const std::function<void()>& step, Json& out) {
  const auto steps = static_cast<std::size_t>(o.seconds / dt + 0.5);
  std::vector<double> processor{processor_seconds()}, wall{wall_seconds()};
  while (processor.size() <= steps && processor.back() - processor.front() < o.budget) {
    step();
    processor.push_back(processor_seconds());
    wall.push_back(wall_seconds());
  }
  const std::size_t done = processor.size() - 1;
  const std::size_t window = std::clamp<std::size_t>(static_cast<std::size_t>(o.window / dt + 0.5), 1, (done + 1) / 2),
                    first = done - window;
  const auto per_step = [](const std::vector<double>& t, std::size_t a, std::size_t b) {
    return b > a ? 1e3 * (t[b] - t[a]) / static_cast<double>(b - a) : 0.0;
  };
  out["complete"] = done == steps;
  out["steps"] = done;
  out["simulated"] = static_cast<double>(done) * dt;
  out["ms_before"] = per_step(processor, 0, first);
  out["ms_rest"] = per_step(processor, first, done);
  out["ms_mean"] = per_step(processor, 0, done);
  out["wall_ms_mean"] = per_step(wall, 0, done);
  out["processor_seconds"] = processor.back() - processor.front();
}

void add_overlap(const Pile& pile, World& ruler, const Placement& p, Json& out) {
  double fastest = 0.0;
  int out_of_pit = 0;
  for (std::size_t b = 0; b < p.position.size(); ++b) {
    double reach = 0.0;
    for (const Piece& piece : pile.shapes[pile.solids[b].shape]) reach = std::max(reach, piece.reach());
    fastest = std::max(fastest, p.velocity[b].norm() + reach * p.spin[b].norm());
    double side = 0.0;
    for (const Wall& w : pile.walls) side = std::max(side, w.center.head<2>().cwiseAbs().maxCoeff());
    out_of_pit += p.position[b].z() < 0.0 || p.position[b].head<2>().cwiseAbs().maxCoeff() > side;
  }
  const Overlap overlap = measure_overlap(ruler, p);
  out["overlap_mm"] = 1e3 * overlap.worst;
  out["overlap_mean_mm"] = 1e3 * overlap.mean;
  out["pairs"] = overlap.pairs;
  out["fastest"] = fastest;
  out["escaped"] = out_of_pit;
}

void write_placement(const Placement& p, const std::string& file) {
  Json out = Json::array();
  for (std::size_t b = 0; b < p.position.size(); ++b) {
    const Vec3& x = p.position[b];
    const Quat& r = p.rotation[b];
    out.push_back({x.x(), x.y(), x.z(), r.w(), r.x(), r.y(), r.z()});
  }
  std::ofstream(file) << out.dump() << "\n";
}

/// Moves the solids of a pile to where a file says.
void read_placement(const std::string& file, Pile& pile) {
  std::ifstream in(file);
  if (!in) throw InputError(file + " cannot be read");
  const Json rows = Json::parse(in);
  if (rows.size() != pile.solids.size()) throw InputError(file + " is of another scene");
  for (std::size_t b = 0; b < rows.size(); ++b) {
    const auto q = rows[b].get<std::array<double, 7>>();
    pile.solids[b].position = Vec3(q[0], q[1], q[2]);
    pile.solids[b].rotation = Quat(q[3], q[4], q[5], q[6]).normalized();
  }
}

std::unique_ptr<Engine> make_engine(const Scene& scene, const Pile& pile, const Options& o) {
  if (o.engine == "brim") return make_brim(scene, o.start.empty() ? nullptr : &pile);
  if (o.engine == "Bullet") return make_bullet(pile, false);
  if (o.engine == "BulletAsleep") return make_bullet(pile, true);
#ifdef BRIM_PEER_MUJOCO
  if (o.engine == "MuJoCo") return make_mujoco(pile, "Newton");
  if (o.engine == "MuJoCoCG") return make_mujoco(pile, "CG");
#endif
  throw InputError("no such engine here: " + o.engine);
}

void run_pile(const Scene& scene, const Options& o, Json& out) {
  World ruler = build_world(scene);
  Pile pile = cut_pile(scene, ruler);
  if (!o.start.empty()) read_placement(o.start, pile);
  const auto engine = make_engine(scene, pile, o);
  out["bodies"] = pile.solids.size();
  time_steps(
      o, pile.time_step, [&] { engine->step(); }, out);
  const Placement end = engine->placement();
  add_overlap(pile, ruler, end, out);
  if (!o.save.empty()) write_placement(end, o.save);
}

void add_depth(const ClothOnBall& cloth, const std::vector<Vec3>& nodes, Json& out) {
  const double depth = depth_in_ball(cloth, nodes);
  out["overlap_mm"] = 1e3 * (depth + 0.5 * cloth.thickness);
  out["inside_ball_mm"] = 1e3 * std::max(0.0, depth);
}

/// A run of brim alone: besides what it costs, every counter of its steps.
void run_brim(const Scene& scene, const Options& o, const ClothOnBall* cloth, Json& out) {
  World world = build_world(scene);
  StepReport sum;
  double overlap = 0.0;
  const auto step = [&] {
    StepReport r = world.step();
    if (!r.ok) throw InputError(fmt::format("a step failed at {} s", world.state().time));
    r.pairs.clear();
    overlap = r.worst_overlap;
    accumulate(sum, std::move(r));
  };
  time_steps(o, scene.world.time_step, step, out);
  out["overlap_voxels"] = overlap;
  Json counters;
  for (const ReportField& f : report_fields()) counters[f.name] = f.get(sum);
  out["report"] = counters;
  out["contact_seconds"] = contact_seconds(sum);
  if (!cloth) return;
  for (int b = 0; b < world.body_count(); ++b)
    if (world.body(b).kind() == "cloth") {
      std::vector<Vec3> nodes;
      for (std::size_t i = 0; i + 2 < world.q(b).size(); i += 3)
        nodes.emplace_back(world.q(b)[i], world.q(b)[i + 1], world.q(b)[i + 2]);
      add_depth(*cloth, nodes, out);
    }
}

bool all_rigid(const Scene& scene) {
  const Json document = Json::parse(scene.text, nullptr, true, true);
  for (const Json& b : document.at("bodies"))
    if (b.at("kind") != "rigid" && b.at("kind") != "obstacle") return false;
  return true;
}

void run(Options o) {
  const Scene scene = load_scene(o.scene);
  if (o.seconds == 0.0) o.seconds = scene.frame_time() * static_cast<double>(scene.frames);
  const ThreadLimit limit(o.threads);
  Json out{{"scene", scene.name}, {"engine", o.engine}, {"threads", o.threads}, {"started", !o.start.empty()}};
  const auto cloth = cut_cloth(scene);
  if (all_rigid(scene)) {
    run_pile(scene, o, out);
  } else if (o.engine == "brim") {
    run_brim(scene, o, cloth.get(), out);
  } else if (cloth && o.engine == "Bullet") {
    const auto sheet = make_bullet_cloth(*cloth);
    time_steps(
        o, cloth->time_step, [&] { sheet->step(); }, out);
    add_depth(*cloth, sheet->nodes(), out);
  } else {
    throw InputError(o.engine + " has no twin of this scene");
  }
  fmt::print("{}\n", out.dump());
}

}  // namespace

}  // namespace brim::peers

int main(int argc, char** argv) try {
  brim::peers::Options o;
  CLI::App app("one scene in one engine: what a step costs and how well things rest");
  app.add_option("scene", o.scene)->required();
  app.add_option("engine", o.engine)->required();
  app.add_option("--seconds", o.seconds, "[s] simulated; default: the scene's duration");
  app.add_option("--window", o.window, "[s] at the end that count as rest");
  app.add_option("--budget", o.budget, "[s] of processor time after which the run is cut");
  app.add_option("--threads", o.threads);
  app.add_option("--start", o.start, "start a pile where it lies in this file, at rest");
  app.add_option("--save", o.save, "write where the solids of a pile lie in the end");
  CLI11_PARSE(app, argc, argv);
  brim::peers::run(o);
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "{}\n", e.what());
  return 1;
}
