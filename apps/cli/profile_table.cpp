#include "profile_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include "brim/core/profile.h"
#include "brim/world/report_fields.h"

namespace brim::cli {

namespace {

double per(double a, double b) { return b > 0.0 ? a / b : 0.0; }

double find(std::span<const double> total, std::string_view name) {
  const auto fields = report_fields();
  for (std::size_t i = 0; i < fields.size(); ++i)
    if (fields[i].name == name) return total[i];
  return 0.0;
}

}  // namespace

ProfileTable::ProfileTable() : total_(report_fields().size(), 0.0) {}

void ProfileTable::add(const StepReport& frame, int steps) {
  if (frame.substeps == 0) return;
  const auto fields = report_fields();
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const double x = fields[i].get(frame);
    switch (fields[i].joining) {
      case Joining::Sum:
        total_[i] += x;
        break;
      case Joining::Largest:
        total_[i] = std::max(total_[i], x);
        break;
      case Joining::Least:
        total_[i] = steps_ > 0.0 ? std::min(total_[i], x) : x;
        break;
      case Joining::Last:
        total_[i] = x;
        break;
    }
  }
  contact_ += contact_seconds(frame);
  steps_ += steps;
}

std::string ProfileTable::text(int threads) const {
  const double wall = find(total_, "wall"), substeps = find(total_, "substeps");
  std::string out = fmt::format("\n{:.0f} steps, {:.0f} sub-steps, {:.3f} s of wall time in steps, {} threads\n",
                                steps_, substeps, wall, threads);
  return out + phases(wall) + kinds() + counters();
}

std::string ProfileTable::phases(double wall) const {
  std::string out = fmt::format("\n{:<24}{:>12}{:>12}{:>10}\n", "phase", "seconds", "ms a step", "share");
  const auto line = [&](std::string_view name, double seconds) {
    out += fmt::format("{:<24}{:>12.3f}{:>12.3f}{:>9.1f}%\n", name, seconds, per(1e3 * seconds, steps_),
                       per(100.0 * seconds, wall));
  };
  double told = 0.0;
  for (const char* const phase : kPhaseNames) {
    const std::string_view name = phase;
    const double seconds = find(total_, fmt::format("seconds_{}", name));
    line(name == "solve_contact" ? "  of it for contact" : name == "record" ? "record (beside steps)" : name, seconds);
    if (name != "solve_contact" && name != "record") told += seconds;
  }
  line("in no phase", wall - told);
  line("contact, all of it", contact_);
  for (const ProfileCount& c : profile_counts())
    if (c.name == kSecondsInLoops) line("threads may share", c.sum);
  return out;
}

std::string ProfileTable::kinds() {
  const std::vector<ProfileEntry> entries = profile_entries();
  if (entries.empty()) return {};
  std::set<std::string> kinds;
  std::map<std::string, double> seconds;
  double all = 0.0;
  for (const ProfileEntry& e : entries) kinds.insert(e.kind), seconds[e.phase] += e.seconds, all += e.seconds;
  std::vector<std::string> phases;
  for (const auto& [phase, s] : seconds) phases.push_back(phase);
  std::ranges::sort(phases, [&](const auto& a, const auto& b) { return seconds[a] > seconds[b]; });

  std::string out = fmt::format("\n{:<24}{:<18}{:>12}{:>10}{:>12}{:>10}{:>8}\n", "inside, by kind of body", "",
                                "thread-s", "share", "calls", "GB", "GB/s");
  for (const std::string& phase : phases)
    for (const std::string& kind : kinds)
      for (const ProfileEntry& e : entries)
        if (e.phase == phase && e.kind == kind)
          out += fmt::format("{:<24}{:<18}{:>12.3f}{:>9.1f}%{:>12}{:>10}{:>8}\n", phase, kind, e.seconds,
                             per(100.0 * e.seconds, all), e.calls,
                             e.bytes > 0.0 ? fmt::format("{:.2f}", 1e-9 * e.bytes) : "",
                             e.bytes > 0.0 ? fmt::format("{:.1f}", per(1e-9 * e.bytes, e.seconds)) : "");
  return out + "GB: read and written, estimated from the sizes of arrays; what is not estimated is blank\n";
}

std::string ProfileTable::counters() const {
  std::string out = fmt::format("\n{:<24}{:>16}{:>14}{:>14}\n", "count", "of the run", "a step", "a solve");
  const double solves = find(total_, "solves");
  const auto fields = report_fields();
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string_view name = fields[i].name, unit = fields[i].unit;
    if (fields[i].joining == Joining::Sum && unit != "s" && total_[i] != 0.0)
      out += fmt::format("{:<24}{:>16.6g}{:>14.4g}{:>14.4g}\n", name, total_[i], per(total_[i], steps_),
                         per(total_[i], solves));
    else if (fields[i].joining == Joining::Largest)
      out += fmt::format("{:<24}{:>16.3g}  {} (largest)\n", name, total_[i], unit);
  }
  for (const ProfileCount& c : profile_counts())
    if (c.name != kSecondsInLoops)
      out += fmt::format("{:<24}{:>16.6g}{:>14.4g}   {} times, largest {:.6g}\n", c.name, c.sum, per(c.sum, steps_),
                         c.times, c.largest);
  return out;
}

}  // namespace brim::cli
