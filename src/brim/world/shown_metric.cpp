#include "brim/world/shown_metric.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "brim/body/changing_surface.h"
#include "brim/core/error.h"

namespace brim {

namespace {

Shown shown_by(const Body& body) {
  Shown s;
  if (const ChangingSurface* surface = changing_surface(body)) {
    surface->display_surface(s.x, s.triangles);
    return s;
  }
  display_now(body, s.x);
  const Display& display = body.display();
  if (display.kind == Display::Kind::Triangles)
    s.triangles = display.triangles;
  else
    s.radius = display.radius;
  return s;
}

int find_body(const World& world, const std::string& name) {
  for (int b = 0; b < world.body_count(); ++b)
    if (world.body(b).name() == name) return b;
  throw InputError(fmt::format("there is no body \"{}\"; this metric must name one", name));
}

}  // namespace

const std::vector<std::string>& ShownMetric::names() {
  static const std::vector<std::string> all = {"leak", "draft", "level", "volume_kept", "front"};
  return all;
}

bool ShownMetric::knows(const std::string& metric) { return std::ranges::find(names(), metric) != names().end(); }

bool ShownMetric::needs_other(const std::string& metric) { return metric == "leak" || metric == "draft"; }

ShownMetric::ShownMetric(const World& world, const Expectation& expectation)
    : metric_(expectation.metric), body_(find_body(world, expectation.body)) {
  if (needs_other(metric_)) other_ = find_body(world, expectation.of);
  if (metric_ == "volume_kept") volume_start_ = enclosed_volume(shown_by(world.body(body_)));
  if (metric_ == "draft" || metric_ == "level")
    width_ = vertex_spacing(shown_by(world.body(metric_ == "draft" ? other_ : body_)));
}

double ShownMetric::now(const World& world) const {
  const Shown body = shown_by(world.body(body_));
  if (metric_ == "volume_kept") return enclosed_volume(body) / volume_start_;
  if (metric_ == "level") return surface_level(body, width_);
  if (metric_ == "leak") return count_under(body, shown_by(world.body(other_)));
  double front = -std::numeric_limits<double>::infinity(), lowest = std::numeric_limits<double>::infinity();
  for (const Vec3f& x : body.x) {
    front = std::max(front, static_cast<double>(x.x()));
    lowest = std::min(lowest, static_cast<double>(x.z()));
  }
  if (metric_ == "front") return front;
  return surface_level(shown_by(world.body(other_)), width_, &body) - lowest;
}

NumberFold::Take ShownMetric::take() const {
  if (metric_ == "leak") return NumberFold::Take::Largest;
  if (metric_ == "front") return NumberFold::Take::Last;
  return metric_ == "volume_kept" ? NumberFold::Take::FarthestFromOne : NumberFold::Take::Mean;
}

}  // namespace brim
