#include "brim/scene/pairs/pair_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "brim/scene/document.h"

namespace brim {

std::string pair_error_text(double x) { return x < 0.0 ? "untold" : x == 0.0 ? "0" : fmt::format("{:.0e}", x); }

std::string pair_failures(const PairResult& r) {
  std::string text;
  for (const std::string& f : r.failures) text += (text.empty() ? "" : "; ") + f;
  return text;
}

std::string pair_line_head() {
  return fmt::format("{:<16} {:<16} {:>8} {:>7} {:>7} {:>7} {:>7} {:>8} {:>7} {:>8} {:>8} {:>7}", "upper", "lower",
                     "contacts", "linear", "lever m", "drift", "overlap", "energy", "leaked", "N upper", "N lower",
                     "ms/step");
}

std::string pair_line(const PairResult& r) {
  if (!r.run) return fmt::format("{:<16} {:<16} not run: nothing moves either", r.upper, r.lower);
  return fmt::format(
      "{:<16} {:<16} {:>8} {:>7} {:>7} {:>7} {:>7.2f} {:>+7.2f}% {:>6.2f}% {:>8.3g} {:>8.3g} {:>7.1f}  {}", r.upper,
      r.lower, r.contacts, pair_error_text(r.linear), pair_error_text(r.lever), pair_error_text(r.drift), r.overlap,
      100.0 * r.energy, 100.0 * r.leak, r.force_upper, r.force_lower, 1e3 * r.seconds,
      r.ok() ? "good" : "FAILED: " + pair_failures(r));
}

std::string pairs_json(const PairTable& table, std::span<const PairResult> results) {
  Json root;
  root["name"] = table.name;
  root["drop"] = {{"speed", table.drop.speed}, {"gap", table.drop.gap}, {"steps", table.drop.steps}};
  root["world"] = Json::parse(table.world);
  root["bounds"] = {{"overlap", table.bounds.overlap}, {"energy", table.bounds.energy},
                    {"drift", table.bounds.drift},     {"leak", table.bounds.leak},
                    {"speed", table.bounds.speed},     {"carried", table.bounds.carried}};
  root["pairs"] = Json::array();
  for (const PairResult& r : results) {
    Json cell = {{"upper", r.upper}, {"lower", r.lower}, {"run", r.run}};
    if (r.run)
      cell.update({{"ok", r.ok()},
                   {"failures", r.failures},
                   {"contacts", r.contacts},
                   {"momentum_error", r.linear < 0.0 ? Json() : Json(r.linear)},
                   {"torque_lever", r.lever < 0.0 ? Json() : Json(r.lever)},
                   {"momentum_drift", r.drift},
                   {"overlap", r.overlap},
                   {"energy_growth", r.energy},
                   {"motion_growth", r.motion},
                   {"leaked", r.leak},
                   {"speed_at_end", r.speed},
                   {"carried", r.carried < 0.0 ? Json() : Json(r.carried)},
                   {"force_upper", r.force_upper},
                   {"force_lower", r.force_lower},
                   {"step_seconds", r.seconds},
                   {"steps", r.steps}});
    root["pairs"].push_back(std::move(cell));
  }
  return root.dump(2) + "\n";
}

}  // namespace brim
