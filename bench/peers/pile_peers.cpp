// One pile, several engines, one after another on one thread: what a step costs and how well the pile rests.
//   pile_peers scenes/pile.json [seconds] [names to run: brim Bullet MuJoCo ...]
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "pile.h"

namespace brim::peers {

namespace {

/// [s] of processor time of this process: another program's load does not count.
double processor_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void run(Engine& engine, const Pile& pile, World& ruler, double seconds) {
  const int steps = static_cast<int>(seconds / pile.time_step + 0.5),
            last = std::min(steps, static_cast<int>(1.0 / pile.time_step + 0.5));
  const double start = processor_seconds();
  double rest = start;
  for (int i = 0; i < steps; ++i) {
    if (i == steps - last) rest = processor_seconds();
    engine.step();
  }
  const double end = processor_seconds();
  const Placement p = engine.placement();
  double fastest = 0.0, mean = 0.0, height = 0.0;
  int out = 0;
  for (std::size_t b = 0; b < p.position.size(); ++b) {
    double reach = 0.0;
    for (const Piece& piece : pile.shapes[pile.solids[b].shape])
      for (const Vec3& x : piece.points) reach = std::max(reach, x.norm() + piece.radius);
    const double speed = p.velocity[b].norm() + reach * p.spin[b].norm();
    fastest = std::max(fastest, speed);
    mean += speed / static_cast<double>(p.position.size());
    height += p.position[b].z() / static_cast<double>(p.position.size());
    double side = 0.0;
    for (const Wall& w : pile.walls) side = std::max(side, w.center.head<2>().cwiseAbs().maxCoeff());
    out += p.position[b].z() < 0.0 || p.position[b].head<2>().cwiseAbs().maxCoeff() > side;
  }
  const Overlap o = measure_overlap(ruler, p);
  fmt::print("| {} | {:.1f} | {:.1f} | {:.2f} | {:.3f} | {:.4f} | {:.4f} | {:.3f} | {} |\n", engine.name(),
             1e3 * (rest - start) / std::max(1, steps - last), 1e3 * (end - rest) / last, o.worst, o.mean, fastest,
             mean, height, out);
  std::fflush(stdout);
}

}  // namespace

}  // namespace brim::peers

int main(int argc, char** argv) try {
  using namespace brim;
  using namespace brim::peers;
  if (argc < 2) throw InputError("usage: pile_peers scene.json [seconds] [engines]");
  const Scene scene = load_scene(argv[1]);
  const double seconds =
      argc > 2 ? std::atof(argv[2]) : scene.world.time_step * scene.steps_per_frame * static_cast<double>(scene.frames);
  const ThreadLimit one(1);
  World ruler = build_world(scene);
  const Pile pile = cut_pile(scene, ruler);
  fmt::print("{} bodies, steps of {:.2f} ms, {} s, one thread; times are processor time\n\n", pile.solids.size(),
             1e3 * pile.time_step, seconds);
  fmt::print(
      "| engine | ms a step, falling | ms a step, last second | worst overlap [voxels] | mean of touching pairs | "
      "fastest [m/s] | mean speed [m/s] | mean height [m] | escaped |\n|---|---|---|---|---|---|---|---|---|\n");
  std::fflush(stdout);
  using Make = std::function<std::unique_ptr<Engine>()>;
  std::vector<std::pair<std::string, Make>> engines;
  engines.emplace_back("brim", [&] { return make_brim(scene); });
#ifdef BRIM_PEER_BULLET
  engines.emplace_back("Bullet", [&] { return make_bullet(pile, false); });
  engines.emplace_back("BulletAsleep", [&] { return make_bullet(pile, true); });
#endif
#ifdef BRIM_PEER_MUJOCO
  engines.emplace_back("MuJoCo", [&] { return make_mujoco(pile, "Newton"); });
  engines.emplace_back("MuJoCoCG", [&] { return make_mujoco(pile, "CG"); });
#endif
  for (const auto& [name, make] : engines) {
    const bool wanted = argc <= 3 || std::find(argv + 3, argv + argc, name) != argv + argc;
    if (wanted) run(*make(), pile, ruler, seconds);
  }
  return 0;
} catch (const brim::InputError& e) {
  fmt::print(stderr, "{}\n", e.what());
  return 1;
}
