#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "brim/core/error.h"
#include "support/soft_worlds.h"

/// Worlds whose bodies are removed, moved and edited.
namespace brim::testing {

inline WorldOptions told(Response response = Response::Penalty) {
  WorldOptions o = options_at(0.1);
  o.stiffness = 2e5;
  o.response = response;
  return o;
}

inline void add_soft(World& w) {
  w.add(jelly("jelly", 0.5, Vec3(-0.25, -0.25, 0.0)));
  w.add(sheet("sheet", 0.8, Vec3(0, 0, 0.56)));
  w.add(box("box", {Vec3(0.02, 0.01, 0.78)}, 0.5, 0.3, 300));
  w.add(springs("springs", 0.4, Vec3(0.8, -0.2, 0.0)));
  w.add(rope("rope", Vec3(1.0, -0.5, 0.47), Vec3(1.0, 0.5, 0.48)));
  w.add(blob("fluid", 5, 0.1, Vec3(0.2, -0.3, 0.75)));
}

inline void add_rigid(World& w) {
  for (int i = 0; i < 4; ++i) w.add(box("box" + std::to_string(i), {Vec3(0.03 * i, 0, 0.25 + 0.5 * i)}, 0.5, 0.5));
  w.add(ball("ball", {Vec3(1.5, 0, 0.3)}, 0.5, 0.3));
}

inline std::vector<double> copy(std::span<const double> x) { return {x.begin(), x.end()}; }

inline std::string message(const std::function<void()>& f) {
  try {
    f();
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

}  // namespace brim::testing
