// Contact alone, on one thread: nanoseconds a node sampled, and a contact found and answered, of touching bodies of one
// kind. Phases of whole steps are timed, so that what is measured is what a scene pays; responding includes the maps.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <ctime>

#include "brim/core/parallel.h"
#include "brim/core/stopwatch.h"
#include "brim/scene/scene.h"
#include "brim/world/report_fields.h"

namespace brim {
namespace {

/// Steps before those that count, in which contacts settle.
constexpr int kSettle = 5;

void contact(benchmark::State& state, const std::string& bodies) {
  const ThreadLimit one(1);
  World world = build_world(parse_scene(fmt::format(
      R"({{"brim": 1, "name": "contact", "duration": 1, "world": {{"time_step": 0.002, "cg_tolerance": 1e-2, "max_passes": 1}}, "bodies": [{}]}})",
      bodies)));
  for (int i = 0; i < kSettle; ++i) world.step();
  StepReport sum;
  double contacts = 0.0, wall = 0.0;
  const std::clock_t processor = std::clock();
  for (auto _ : state) {
    StepReport r;
    {
      const ScopedSeconds timer(wall);
      r = world.step();
    }
    contacts += static_cast<double>(r.contacts) * r.substeps;
    r.pairs.clear();
    accumulate(sum, std::move(r));
  }
  // Phases are timed by the wall clock: on a machine that does other things too, only this share of it is brim's.
  const double share = static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC / wall;
  const auto nanoseconds = [&](std::initializer_list<Phase> phases) {
    double s = 0.0;
    for (const Phase p : phases) s += sum.seconds[static_cast<std::size_t>(p)];
    return 1e9 * share * s;
  };
  const double nodes = static_cast<double>(sum.voxels), steps = static_cast<double>(state.iterations());
  state.counters["nodes"] = nodes / steps;
  state.counters["contacts"] = contacts / steps;
  state.counters["contact_ms"] =
      1e-6 * nanoseconds({Phase::Presence, Phase::Refine, Phase::Rasterize, Phase::Detect, Phase::Respond}) / steps;
  state.counters["search_ns_a_node"] = nanoseconds({Phase::Presence, Phase::Refine}) / nodes;
  state.counters["sample_ns_a_node"] = nanoseconds({Phase::Rasterize}) / nodes;
  state.counters["detect_ns_a_contact"] = nanoseconds({Phase::Detect}) / contacts;
  state.counters["respond_ns_a_contact"] = nanoseconds({Phase::Respond}) / contacts;
}

/// A grid of bodies that touch their neighbours and a floor. @param apart, above  [m] between centres
std::string grid(const char* kind, const char* body, double apart, double above, double height) {
  return fmt::format(
      R"({{"kind": "obstacle", "name": "floor", "voxel_size": 0.02, "shape": {{"kind": "plane"}}}},
         {{"kind": "{}", "name": "b", "voxel_size": 0.02, {}, "transform": {{"position": [0, 0, {}]}},
          "repeat": {{"count": [4, 4, 2], "spacing": [{}, {}, {}]}}}})",
      kind, body, height, apart, apart, above);
}

/// Two soft slabs on each other, the lower one held at its bottom: bench/scenes/slabs.json, half as wide.
std::string slabs() {
  return R"(
    {"kind": "finite_elements", "name": "lower", "voxel_size": 0.02, "shape": {"kind": "box", "size": [1.4, 1.4, 0.12]},
     "lattice_spacing": 0.04, "averaging": 0, "transform": {"position": [0, 0, 0.06]},
     "constraints": [{"select": {"kind": "box", "lo": [-2, -2, -0.1], "hi": [2, 2, 0.001]}}]},
    {"kind": "finite_elements", "name": "upper", "voxel_size": 0.02, "shape": {"kind": "box", "size": [1.4, 1.4, 0.12]},
     "lattice_spacing": 0.04, "averaging": 0, "transform": {"position": [0, 0, 0.18]}, "velocity": [0, 0, -0.3]})";
}

#define BRIM_CONTACT(...) BENCHMARK_CAPTURE(__VA_ARGS__)->Iterations(10)->Unit(benchmark::kMillisecond)
BRIM_CONTACT(contact, boxes, grid("rigid", R"("shape": {"kind": "box", "size": [0.4, 0.4, 0.4]})", 0.401, 0.401, 0.2));
BRIM_CONTACT(contact, balls, grid("rigid", R"("shape": {"kind": "sphere", "radius": 0.2})", 0.399, 0.399, 0.2));
BRIM_CONTACT(contact, sampled_stars,
             grid("rigid", R"("shape": {"kind": "star", "points": 5, "outer": 0.3, "inner": 0.15, "thickness": 0.3})",
                  0.499, 0.299, 0.15));
BRIM_CONTACT(contact, tetrahedra,
             grid("finite_elements", R"("shape": {"kind": "box", "size": [0.4, 0.4, 0.4]}, "lattice_spacing": 0.08)",
                  0.401, 0.401, 0.2));
BRIM_CONTACT(contact, sheets,
             grid("cloth", R"("grid": {"size": [0.4, 0.4], "cells": [10, 10]}, "thickness": 0.08)", 0.5, 0.079, 0.04));

BRIM_CONTACT(contact, soft_slabs, slabs());

}  // namespace
}  // namespace brim
