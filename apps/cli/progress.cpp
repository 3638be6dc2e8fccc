#include "progress.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "brim/core/printable.h"

namespace brim::cli {

namespace {

using Json = nlohmann::ordered_json;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// "3:07" or "1:02:45".
std::string clock_text(double seconds) {
  const auto s = static_cast<long long>(std::ceil(seconds));
  if (s >= 3600) return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
  return fmt::format("{}:{:02}", s / 60, s % 60);
}

void print_line(const Json& j) {
  const std::string text = j.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
}

std::string bounds_text(const Expectation& e) {
  if (std::isfinite(e.min) && std::isfinite(e.max)) return fmt::format("{:.6g} to {:.6g}", e.min, e.max);
  return std::isfinite(e.min) ? fmt::format(">= {:.6g}", e.min) : fmt::format("<= {:.6g}", e.max);
}

/// How a run stands to a bound. A bound that a shorter run did not get to, and a known miss that holds this once, fail
/// nobody who did not ask for a check.
const char* verdict(const ExpectationResult& f, bool check) {
  if (!check && !f.reached) return "open";
  if (f.as_expected()) return f.ok ? "ok" : "miss";
  return f.ok && !check ? "ok" : "FAIL";
}

}  // namespace

std::string findings_table(const std::vector<ExpectationResult>& findings, bool check) {
  std::string out;
  for (const ExpectationResult& f : findings) {
    const Expectation& e = f.expectation;
    std::string what = e.metric + (f.body.empty() ? "" : " of " + f.body);
    if (e.from > 0.0 || std::isfinite(e.to))
      what += fmt::format(" [{:.4g} s, {}]", e.from, std::isfinite(e.to) ? fmt::format("{:.4g} s", e.to) : "end");
    const std::string value = f.reached ? fmt::format("{:.6g}", f.value) : "not reached";
    out += fmt::format("  {:4}  {:<52} {:>12}   {}\n", verdict(f, check), what, value, bounds_text(e));
    if (!e.known_miss.empty())
      out += fmt::format("        {}: {}\n",
                         f.ok        ? "holds in this run, and is marked as a known miss"
                         : f.worse() ? fmt::format("worse than {:g}, and known", e.known_worst)
                                     : "known",
                         e.known_miss);
  }
  return out;
}

void Progress::start(const std::string& scene, const std::string& folder, const RunPlan& plan, const World& world) {
  if (style_ != Style::Json) return;
  print_line({{"event", "start"},
              {"scene", scene},
              {"folder", folder},
              {"frames", plan.frames},
              {"frame_time", plan.info.frame_time},
              {"bodies", world.body_count()}});
}

void Progress::frame(const RunProgress& p) {
  if (style_ == Style::Quiet) return;
  if (style_ == Style::Json) {
    print_line({{"event", "frame"},
                {"frame", p.frame},
                {"frames", p.frames},
                {"time", p.time},
                {"steps_per_second", p.steps_per_second},
                {"seconds_left", p.seconds_left},
                {"substeps", p.report->substeps},
                {"contacts", p.report->contacts},
                {"worst_overlap", p.report->worst_overlap},
                {"max_speed", p.report->max_speed},
                {"ok", p.report->ok}});
    return;
  }
  if (now() - last_shown_ < 0.1 && p.frame != p.frames) return;
  last_shown_ = now();
  if (endless_) {
    fmt::print(stderr, "\r\033[Kframe {}  {:.2f} s  {:.1f} steps/s  Ctrl-C ends", p.frame, p.time, p.steps_per_second);
    std::fflush(stderr);
    return;
  }
  constexpr int kWidth = 28;
  const int full = static_cast<int>(kWidth * p.frame / std::max<std::int64_t>(p.frames, 1));
  fmt::print(stderr, "\r\033[K[{}{}] frame {}/{}  {:.2f} s  {:.1f} steps/s  {} left", std::string(full, '#'),
             std::string(kWidth - full, '.'), p.frame, p.frames, p.time, p.steps_per_second,
             clock_text(p.seconds_left));
  std::fflush(stderr);
}

void Progress::end(const RunResult& result, const std::string& folder) {
  const RunTotals& t = result.totals;
  if (style_ == Style::Json) {
    Json expect = Json::array();
    for (const ExpectationResult& f : result.findings)
      expect.push_back({{"metric", f.expectation.metric},
                        {"body", f.body},
                        {"value", f.value},
                        {"reached", f.reached},
                        {"ok", f.ok},
                        {"known_miss", !f.expectation.known_miss.empty()}});
    print_line({{"event", "end"},
                {"end", run_end_word(result.end)},
                {"folder", folder},
                {"frames", t.frames},
                {"steps", t.steps},
                {"warnings", t.warning_count},
                {"expect", expect},
                {"ok", result.ok()}});
    return;
  }
  if (style_ == Style::Bar) fmt::print(stderr, "\r\033[K");
  fmt::print("{}: {} frames, {} steps in {:.1f} s; worst overlap {:.3g} voxels; {} warnings; run in {}\n",
             run_end_word(result.end), t.frames, t.steps, t.wall, t.worst_overlap, t.warning_count, folder);
  for (const auto& [code, count] : t.warning_codes)
    for (const Warning& w : t.warnings)
      if (w.code == code) {
        fmt::print(stderr, "brim: warning: {} s: {} ({} times)\n", w.time, printable(w.message), count);
        break;
      }
}

}  // namespace brim::cli
