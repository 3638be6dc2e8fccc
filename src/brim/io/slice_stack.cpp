#include "brim/io/slice_stack.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "brim/core/error.h"

namespace brim {

namespace {

// Directions are written with six digits or so; places often with one.
constexpr double kSameDirection = 1e-3, kSameStep = 1e-3, kEvenPlace = 0.1, kSamePlace = 0.01;
constexpr std::size_t kMostPlaces = 3;  // named in one message

std::string shown(const Vec3& v) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x(), v.y(), v.z()); }

void check_slice(const std::string& whole, const StackSlice& s) {
  const double off_unit = std::max(std::abs(s.row.norm() - 1.0), std::abs(s.column.norm() - 1.0));
  if (!s.position.allFinite() || !(off_unit < 0.01) || !(std::abs(s.row.dot(s.column)) < 0.01))
    throw InputError(
        fmt::format("{}: {}: the place {} with directions {} and {} is not allowed; all must be finite, and "
                    "the directions unit vectors at right angles",
                    whole, s.name, shown(s.position), shown(s.row), shown(s.column)));
  if (!s.step.allFinite() || !(s.step.minCoeff() > 0.0))
    throw InputError(fmt::format("{}: {}: pixels of {:.6g} x {:.6g} mm are not allowed; must be positive and finite",
                                 whole, s.name, s.step.x(), s.step.y()));
}

void check_alike(const std::string& whole, const StackSlice& a, const StackSlice& b) {
  if (a.width != b.width || a.height != b.height)
    throw InputError(fmt::format("{}: {} has {} x {} pixels, {} has {} x {}; slices of a volume are of one size", whole,
                                 a.name, a.width, a.height, b.name, b.width, b.height));
  if ((a.row - b.row).norm() > kSameDirection || (a.column - b.column).norm() > kSameDirection)
    throw InputError(fmt::format("{}: {} and {} are not parallel: directions {}, {} and {}, {}", whole, a.name, b.name,
                                 shown(a.row), shown(a.column), shown(b.row), shown(b.column)));
  if (!((a.step - b.step).cwiseAbs().maxCoeff() <= kSameStep * a.step.minCoeff()))
    throw InputError(fmt::format("{}: {} has pixels of {:.6g} x {:.6g} mm, {} of {:.6g} x {:.6g} mm", whole, a.name,
                                 a.step.x(), a.step.y(), b.name, b.step.x(), b.step.y()));
}

/// Gaps along the normal that an even stack has not, each with its slices. @param at  [mm] sorted
void check_gaps(const std::string& whole, std::span<const StackSlice> slices, std::span<const std::size_t> order,
                std::span<const double> at) {
  std::vector<double> gap(at.size() - 1);
  for (std::size_t k = 0; k < gap.size(); ++k) gap[k] = at[k + 1] - at[k];
  const double mean = (at.back() - at.front()) / static_cast<double>(gap.size());
  std::vector<double> sorted;  // without the doubled
  for (const double g : gap)
    if (g > kSamePlace * mean) sorted.push_back(g);
  if (sorted.empty())
    throw InputError(fmt::format("{}: all slices lie at one place along their normal; it is no volume", whole));
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
  const double usual = sorted[sorted.size() / 2];
  std::string places;
  std::size_t count = 0;
  for (std::size_t k = 0; k < gap.size(); ++k) {
    const double steps = gap[k] / usual, missing = std::round(steps) - 1.0;
    if (std::abs(steps - 1.0) <= 2.0 * kEvenPlace) continue;
    if (++count > kMostPlaces) continue;
    const std::string &a = slices[order[k]].name, &b = slices[order[k + 1]].name;
    if (gap[k] <= kSamePlace * mean)
      places += fmt::format("; {} and {} are at the same place, {:.6g} mm along the normal", a, b, at[k]);
    else if (missing >= 1.0 && std::abs(steps - std::round(steps)) <= 2.0 * kEvenPlace)
      places +=
          fmt::format("; {:.0f} missing between {} at {:.6g} mm and {} at {:.6g} mm", missing, a, at[k], b, at[k + 1]);
    else
      places += fmt::format("; {:.6g} mm between {} at {:.6g} mm and {} at {:.6g} mm", gap[k], a, at[k], b, at[k + 1]);
  }
  if (count == 0) return;
  if (count > kMostPlaces) places += fmt::format("; and {} more", count - kMostPlaces);
  throw InputError(fmt::format("{}: its {} slices are no even stack, with steps of {:.6g} mm as a rule{}", whole,
                               slices.size(), usual, places));
}

}  // namespace

SliceStack stack_slices(const std::string& whole, std::span<const StackSlice> slices) {
  if (slices.empty()) throw InputError(whole + ": no slices");
  for (const StackSlice& s : slices) {
    check_slice(whole, s);
    check_alike(whole, slices[0], s);
  }
  const StackSlice& first = slices[0];
  const Vec3 row = first.row.normalized(), column = first.column.normalized(), normal = row.cross(column).normalized();
  SliceStack stack;
  stack.order.resize(slices.size());
  std::iota(stack.order.begin(), stack.order.end(), std::size_t{0});
  std::stable_sort(stack.order.begin(), stack.order.end(), [&](std::size_t a, std::size_t b) {
    return slices[a].position.dot(normal) < slices[b].position.dot(normal);
  });
  stack.origin = slices[stack.order.front()].position;
  Vec3 step = first.thickness * normal;
  if (slices.size() > 1) {
    std::vector<double> at;
    for (const std::size_t s : stack.order) at.push_back(slices[s].position.dot(normal));
    check_gaps(whole, slices, stack.order, at);
    step = (slices[stack.order.back()].position - stack.origin) / static_cast<double>(slices.size() - 1);
    // What is even along the normal may still wander across it.
    for (std::size_t k = 0; k < slices.size(); ++k) {
      const StackSlice& s = slices[stack.order[k]];
      const double away = (s.position - stack.origin - static_cast<double>(k) * step).norm();
      if (away > kEvenPlace * step.norm())
        throw InputError(
            fmt::format("{}: {} lies {:.4g} mm from its place in an even stack of steps {} mm; at most a tenth of a "
                        "step is allowed",
                        whole, s.name, away, shown(step)));
    }
  } else if (!(first.thickness > 0.0)) {
    throw InputError(fmt::format("{}: {} is a single slice without a thickness; it is no volume", whole, first.name));
  }
  stack.axes.col(0) = first.step.x() * row;
  stack.axes.col(1) = first.step.y() * column;
  stack.axes.col(2) = step;
  stack.tilt = std::acos(std::clamp(step.normalized().dot(normal), -1.0, 1.0));
  return stack;
}

}  // namespace brim
