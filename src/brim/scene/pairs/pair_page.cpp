#include "brim/scene/pairs/pair_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "brim/core/error.h"
#include "brim/scene/document.h"
#include "brim/scene/pairs/pair_report.h"

namespace brim {

namespace {

const PairResult* find(std::span<const PairResult> results, const std::string& a, const std::string& b) {
  for (const PairResult& r : results)
    if ((r.lower == a && r.upper == b) || (r.lower == b && r.upper == a)) return &r;
  return nullptr;
}

std::string matrix(const PairRun& run) {
  const std::vector<PairKind>& kinds = run.table.kinds;
  std::string text = "| |";
  for (std::size_t i = 0; i < kinds.size(); ++i) text += fmt::format(" {} |", i + 1);
  text += "\n|---|";
  for (std::size_t i = 0; i < kinds.size(); ++i) text += ":-:|";
  text += "\n";
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    text += fmt::format("| {} {} |", i + 1, kinds[i].name);
    for (const PairKind& other : kinds) {
      const PairResult* r = find(run.results, kinds[i].name, other.name);
      text += !r || !r->run ? " – |" : r->ok() ? " ✓ |" : " ✗ |";
    }
    text += "\n";
  }
  return text + "\n";
}

std::string figures(const PairRun& run, bool failed_alone) {
  std::string text =
      "| upper | lower | contacts | momentum error | lost lever [m] | drift | overlap [voxels] | energy | leaked | "
      "force up, down [N] | ms a step | |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const PairResult& r : run.results) {
    if (failed_alone && (!r.run || r.ok())) continue;
    if (!r.run) {
      text += fmt::format("| {} | {} | | | | | | | | | | not run: nothing moves either |\n", r.upper, r.lower);
      continue;
    }
    // Above a floor the bound is that of the energy without contact's.
    text += fmt::format(
        "| {} | {} | {} | {} | {} | {} | {:.2f} | {:+.1f} % | {:.1f} % | {:.3g}, {:.3g} | {:.1f} | {} |\n", r.upper,
        r.lower, r.contacts, pair_error_text(r.linear), run.table.floor ? "" : pair_error_text(r.lever),
        pair_error_text(r.drift), r.overlap, 100.0 * (run.table.floor ? r.motion : r.energy), 100.0 * r.leak,
        r.force_upper, r.force_lower, 1e3 * r.seconds, r.ok() ? "✓" : "✗ " + pair_failures(r));
  }
  return text;
}

std::string kinds(const PairTable& table) {
  std::string text =
      "## The kinds\n| | kind | what is dropped | stated momentum error | lost lever [m] | "
      "|\n|---|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < table.kinds.size(); ++i) {
    const PairKind& k = table.kinds[i];
    text += fmt::format("| {} | {} | {} | {:.0e} | {:g} | {} |\n", i + 1, k.name, k.about, k.linear, k.lever,
                        k.picture.empty() ? "" : fmt::format("![{}]({})", k.about, k.picture));
  }
  return text + "\n";
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

std::string bounds(const PairBounds& b) {
  return fmt::format(
      "A pair is good when there was contact and both felt it; every solve converged; the worst overlap is at most "
      "{:g} "
      "voxels; the total energy (motion, elastic, contact) never grew by more than {:g} % of that at the start; at "
      "most "
      "{:g} % of the impulse is momentum that does not come from contact; at most {:g} % of either body came to the "
      "other's wrong side; and the maps of both bodies keep linear and angular momentum as well as they state.\n\n",
      b.overlap, 100.0 * b.energy, 100.0 * b.drift, 100.0 * b.leak);
}

std::string first_world(const PairRun& run, const std::string& command) {
  const PairTable& table = run.table;
  const Count c = count(run.results);
  const bool rows = Json::parse(table.world).value("response", "") == "constraint";
  std::string text = fmt::format("# Every kind meets every kind{}\n\n", rows ? ", by constraints" : "");
  text += fmt::format(
      "`{}` made this page. Each pair of kinds, each kind with itself included, meets {}: the upper body flies down at "
      "{:g} m/s on the lower one, which is at rest, for {} steps. **{} of {} pairs are good**; {} pairs of two "
      "obstacles "
      "were not run, as nothing moves either.\n\n",
      command, table.about, table.drop.speed, table.drop.steps, c.good, c.run, c.skipped);
  text += "The world of all of them: `" + table.world + "`\n\n" + matrix(run) + bounds(table.bounds) + kinds(table);
  if (c.good < c.run) text += "## Why some fail\n" + why_some_fail(run) + "\n";
  text +=
      "## Figures\n"
      "*Momentum error*: what a body's map makes of the contact forces, against their sum over all nodes, relative to "
      "the sum of their sizes; worst step and body. *Lost lever*: likewise of their torque; the error over the sum of "
      "the "
      "sizes of the forces. *Drift*: how far a body's momentum is from what contact gave it, over the whole impulse; "
      "what "
      "a body's own motion loses, as a fluid against the walls of its grid, counts here alone. *Energy*: largest "
      "growth "
      "over that of the blow. *Force*: largest gain of momentum in a step, over the step. *ms a step*: wall time, "
      "whatever else the machine did.\n\n";
  return text + figures(run, false);
}

std::string further_world(const PairRun& run) {
  const PairTable& table = run.table;
  const Count c = count(run.results);
  std::string text = fmt::format(
      "\n### {}\nThe same pairs meet {}, for {} steps. **{} of {} are good**.\n\nThe world of all of them: `{}`\n\n",
      table.name, table.about, table.drop.steps, c.good, c.run, table.world);
  text += matrix(run);
  if (table.floor) {
    double speed = 0.0;
    for (const PairResult& r : run.results) speed = std::max(speed, r.speed);
    text += fmt::format(
        "What the two bring into the blow is what the energy is measured against. Held to its bound, and shown, is "
        "that of "
        "motion, height and deformation: bodies that fall off strike the floor too, and energy of contact that a step "
        "finds but did not foresee is shown by the first table. Nothing may come under the floor. Pairs of kinds that "
        "neither roll nor flow do not leak, are at rest at the end (at most {:g} m/s), and the upper one's weight is "
        "carried within {:g} %. Torque is not looked at: the report tells the worst body, not which. The fastest of "
        "all "
        "moves at {:.2f} m/s at the end.\n\n",
        table.bounds.speed, 100.0 * table.bounds.carried, speed);
  }
  if (c.good == c.run) return text;
  return text + "Why some fail:\n\n" + why_some_fail(run) + "\nThose that fail:\n\n" + figures(run, true);
}

std::string names(const std::vector<const PairResult*>& results) {
  std::string text;
  for (const PairResult* r : results) text += fmt::format("{}{} on {}", text.empty() ? "" : ", ", r->upper, r->lower);
  return text;
}

}  // namespace

std::string why_some_fail(const PairRun& run) {
  std::vector<const PairResult*> failed;
  for (const PairResult& r : run.results)
    if (r.run && !r.ok()) failed.push_back(&r);
  std::string text;
  for (const PairNote& note : run.table.notes) {
    std::vector<const PairResult*> told;
    std::erase_if(failed, [&](const PairResult* r) {
      if (!note.about(r->lower, r->upper)) return false;
      told.push_back(r);
      return true;
    });
    if (!told.empty()) text += fmt::format("- **{}**: {}\n", names(told), note.why);
  }
  if (!failed.empty()) text += fmt::format("- **{}**: the table of kinds does not say why.\n", names(failed));
  return text;
}

std::string pairs_markdown(std::span<const PairRun> runs, const std::string& command) {
  BRIM_CHECK(runs.size(), >, 0u);
  std::string text = first_world(runs.front(), command);
  if (runs.size() > 1)
    text +=
        "\n## Other worlds\nThe same pairs meet otherwise: each world is a change to that above (`\"worlds\"` of a "
        "table "
        "of kinds).\n";
  for (const PairRun& run : runs.subspan(1)) text += further_world(run);
  return text;
}

}  // namespace brim
