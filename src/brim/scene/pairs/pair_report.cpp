#include "brim/scene/pairs/pair_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "brim/scene/document.h"

namespace brim {

namespace {

std::string error_text(double x) { return x < 0.0 ? "untold" : x == 0.0 ? "0" : fmt::format("{:.0e}", x); }

std::string reasons(const PairResult& r) {
  std::string text;
  for (const std::string& f : r.failures) text += (text.empty() ? "" : "; ") + f;
  return text;
}

const PairResult* find(std::span<const PairResult> results, const std::string& a, const std::string& b) {
  for (const PairResult& r : results)
    if ((r.lower == a && r.upper == b) || (r.lower == b && r.upper == a)) return &r;
  return nullptr;
}

std::string matrix(const PairTable& table, std::span<const PairResult> results) {
  std::string text = "| |";
  for (std::size_t i = 0; i < table.kinds.size(); ++i) text += fmt::format(" {} |", i + 1);
  text += "\n|---|";
  for (std::size_t i = 0; i < table.kinds.size(); ++i) text += ":-:|";
  text += "\n";
  for (std::size_t i = 0; i < table.kinds.size(); ++i) {
    text += fmt::format("| {} {} |", i + 1, table.kinds[i].name);
    for (std::size_t j = 0; j < table.kinds.size(); ++j) {
      const PairResult* r = find(results, table.kinds[i].name, table.kinds[j].name);
      text += !r || !r->run ? " – |" : r->ok() ? " ✓ |" : " ✗ |";
    }
    text += "\n";
  }
  return text;
}

std::string figures(std::span<const PairResult> results, bool failed_alone) {
  std::string text =
      "| upper | lower | contacts | momentum error | lost lever [m] | drift | overlap [voxels] | energy | leaked | "
      "force up, down [N] | ms a step | |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const PairResult& r : results) {
    if (failed_alone && (!r.run || r.ok())) continue;
    if (!r.run) {
      text += fmt::format("| {} | {} | | | | | | | | | | not run: nothing moves either |\n", r.upper, r.lower);
      continue;
    }
    text +=
        fmt::format("| {} | {} | {} | {} | {} | {} | {:.2f} | {:+.1f} % | {:.1f} % | {:.3g}, {:.3g} | {:.1f} | {} |\n",
                    r.upper, r.lower, r.contacts, error_text(r.linear), error_text(r.lever), error_text(r.drift),
                    r.overlap, 100.0 * r.energy, 100.0 * r.leak, r.force_upper, r.force_lower, 1e3 * r.seconds,
                    r.ok() ? "✓" : "✗ " + reasons(r));
  }
  return text;
}

std::string kinds(const PairTable& table) {
  std::string text =
      "| | kind | what is dropped | stated momentum error | lost lever [m] | |\n|---|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < table.kinds.size(); ++i) {
    const PairKind& k = table.kinds[i];
    text += fmt::format("| {} | {} | {} | {:.0e} | {:g} | {} |\n", i + 1, k.name, k.about, k.linear, k.lever,
                        k.picture.empty() ? "" : fmt::format("![{}]({})", k.about, k.picture));
  }
  return text;
}

std::string notes(const PairTable& table) {
  std::string text;
  for (const std::string& note : table.notes) text += "- " + note + "\n";
  return text;
}

struct Count {
  std::size_t run = 0, good = 0, skipped = 0;
};
Count count(std::span<const PairResult> results) {
  Count c;
  for (const PairResult& r : results) {
    (r.run ? c.run : c.skipped) += 1;
    if (r.run && r.ok()) ++c.good;
  }
  return c;
}

}  // namespace

std::string pair_line_head() {
  return fmt::format("{:<16} {:<16} {:>8} {:>7} {:>7} {:>7} {:>7} {:>8} {:>7} {:>8} {:>8} {:>7}", "upper", "lower",
                     "contacts", "linear", "lever m", "drift", "overlap", "energy", "leaked", "N upper", "N lower",
                     "ms/step");
}

std::string pair_line(const PairResult& r) {
  if (!r.run) return fmt::format("{:<16} {:<16} not run: nothing moves either", r.upper, r.lower);
  return fmt::format(
      "{:<16} {:<16} {:>8} {:>7} {:>7} {:>7} {:>7.2f} {:>+7.2f}% {:>6.2f}% {:>8.3g} {:>8.3g} {:>7.1f}  {}", r.upper,
      r.lower, r.contacts, error_text(r.linear), error_text(r.lever), error_text(r.drift), r.overlap, 100.0 * r.energy,
      100.0 * r.leak, r.force_upper, r.force_lower, 1e3 * r.seconds, r.ok() ? "good" : "FAILED: " + reasons(r));
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

std::string pairs_markdown(const PairTable& table, std::span<const PairResult> results, const std::string& command) {
  const Count c = count(results);
  const bool rows = Json::parse(table.world).value("response", "") == "constraint";
  std::string text = fmt::format("# Every kind meets every kind{}\n\n", rows ? ", by constraints" : "");
  text += fmt::format(
      "`{}` made this page. Each pair of kinds, each kind with itself included, meets {}: the "
      "upper body flies down at {:g} m/s on the lower one, which is at rest, for {} steps. **{} of {} pairs are "
      "good**; {} "
      "pairs of two obstacles were not run, as nothing moves either.\n\n",
      command, table.about, table.drop.speed, table.drop.steps, c.good, c.run, c.skipped);
  text += "The world of all of them: `" + table.world + "`\n\n";
  text += matrix(table, results) + "\n";
  text += fmt::format(
      "A pair is good when there was contact and both felt it; every solve converged; the worst overlap is at most "
      "{:g} "
      "voxels; the total energy (motion, elastic, contact) never grew by more than {:g} % of that at the start; at "
      "most "
      "{:g} % of the impulse is momentum that does not come from contact; at most {:g} % of either body came to the "
      "other's wrong side; and the maps of both bodies keep linear and angular momentum as well as they state.\n\n",
      table.bounds.overlap, 100.0 * table.bounds.energy, 100.0 * table.bounds.drift, 100.0 * table.bounds.leak);
  text += "## The kinds\n" + kinds(table) + "\n";
  if (!table.notes.empty()) text += "## Why some fail\n" + notes(table) + "\n";
  text += "## Figures\n";
  text +=
      "*Momentum error*: what a body's map makes of the contact forces, against their sum over all nodes, relative to "
      "the sum of their sizes; worst step and body. *Angular*: likewise of their torque, over the reach of the "
      "contacts. "
      "*Drift*: how far a body's momentum is from what contact gave it, over the whole impulse; what a body's own "
      "motion "
      "loses, as a fluid against the walls of its grid, counts here alone. *Force*: largest gain of momentum in a "
      "step, "
      "over the step.\n\n";
  return text + figures(results, false);
}

std::string pairs_section(const PairTable& table, std::span<const PairResult> results) {
  const Count c = count(results);
  std::string text = fmt::format(
      "\n## In another world: {}\n\nThe same pairs meet {}, for {} steps. **{} of {} are good**.\n\nThe world of all "
      "of "
      "them: `{}`\n\n",
      table.name, table.about, table.drop.steps, c.good, c.run, table.world);
  text += matrix(table, results) + "\n";
  if (table.floor) {
    double speed = 0.0;
    for (const PairResult& r : results) speed = std::max(speed, r.speed);
    text += fmt::format(
        "What the two bring into the blow is what the energy is measured against. Held to its bound is that of motion, "
        "height and deformation: bodies that fall off strike the floor too, and energy of contact that a step finds "
        "but "
        "did not foresee is shown by the first table. Nothing may come under the floor. Pairs of kinds that neither "
        "roll nor "
        "flow do not leak, are at rest at the end (at most {:g} m/s), and the upper one's weight is carried within "
        "{:g} %. "
        "The fastest of all moves at {:.2f} m/s at the end.\n\n",
        table.bounds.speed, 100.0 * table.bounds.carried, speed);
  }
  if (c.good == c.run) return text;
  if (!table.notes.empty()) text += "Why some fail:\n\n" + notes(table) + "\n";
  return text + "Those that fail:\n\n" + figures(results, true);
}

}  // namespace brim
