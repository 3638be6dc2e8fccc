#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/scene/pairs/pair_log.h"
#include "brim/scene/pairs/pair_page.h"
#include "brim/scene/pairs/pair_report.h"
#include "brim/scene/pairs/pair_trial.h"
#include "commands.h"

namespace brim::cli {

namespace {

namespace fs = std::filesystem;

struct PairOptions {
  std::vector<std::string> only, with, worlds;
  std::string out, table, scenes, response, resume, command;
  int threads = 0, steps = 0;
  bool json = false;
};

PairTable read_table(const std::string& path) {
  if (path.empty()) return standard_pairs();
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(fmt::format("{}: the file cannot be read", path));
  return read_pair_table(std::string(std::istreambuf_iterator<char>(file), {}), path);
}

void write_text(const fs::path& path, const std::string& text) {
  std::error_code error;  // told by the stream below
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw InputError(fmt::format("{}: the file cannot be written", path.string()));
}

/// The table in each world that is wanted.
std::vector<PairTable> tables(const PairOptions& o) {
  PairTable table = read_table(o.table);
  for (const std::string& file : o.with) table.add_kinds(read_table(file));
  for (const std::string& name : o.only) table.find(name);
  if (!o.response.empty()) table.set_response(o.response);
  std::vector<std::string> names = o.worlds;
  if (names.empty()) names = {table.name};
  if (names == std::vector<std::string>{"all"}) {
    names = {table.name};
    for (const PairWorld& world : table.worlds) names.push_back(world.name);
  }
  std::vector<PairTable> chosen;
  for (const std::string& name : names) {
    chosen.push_back(name == table.name ? table : table.in_world(name));
    if (o.steps > 0) chosen.back().cut(o.steps);
  }
  if (o.json && chosen.size() > 1) throw InputError("--json prints the figures of one world; --world names several");
  return chosen;
}

/// @param log  of earlier runs, or nullptr
std::vector<PairResult> run_table(const PairTable& table, const PairOptions& o, PairLog* log) {
  if (!o.json) fmt::print("{} ({})\n{}\n", table.name, table.about, pair_line_head());
  const auto each = [&](const PairResult& r) {
    if (!o.json) {
      fmt::print("{}\n", pair_line(r));
      std::fflush(stdout);
    }
    if (!o.scenes.empty() && r.run)
      write_text(fs::path(o.scenes) /
                     fmt::format("{}{}_on_{}.json", o.worlds.empty() ? "" : table.name + "_", r.upper, r.lower),
                 pair_scene_text(table, table.find(r.lower), table.find(r.upper)));
    return !interrupted();
  };
  if (!log) return run_pairs(table, o.only, each);
  return run_pairs(table, o.only, each, [&](const PairTable& t, const PairKind& a, const PairKind& b) {
    if (const PairResult* kept = log->find(t, a, b)) return *kept;
    const PairResult result = run_pair(t, a, b);
    log->add(t, a, b, result);
    return result;
  });
}

int pairs(const PairOptions& o) {
  const ThreadLimit limit(o.threads);
  watch_interrupts();
  std::optional<PairLog> log;
  if (!o.resume.empty()) log.emplace(o.resume, version_text());
  std::vector<PairRun> runs;
  std::size_t run = 0, good = 0;
  for (const PairTable& table : tables(o)) {
    runs.push_back({table, run_table(table, o, log ? &*log : nullptr)});
    if (o.json) std::fputs(pairs_json(table, runs.back().results).c_str(), stdout);
    if (interrupted()) return kInterrupted;
    for (const PairResult& r : runs.back().results) {
      run += r.run ? 1 : 0;
      good += r.run && r.ok() ? 1 : 0;
    }
  }
  if (!o.out.empty()) write_text(o.out, pairs_markdown(runs, o.command));
  fmt::print(stderr, "brim: {} of {} pairs are good\n", good, run);
  return good == run ? kGood : kFailed;
}

}  // namespace

void add_pairs(CLI::App& app, int& code) {
  CLI::App* command = app.add_subcommand("pairs", "drop every kind of body on every other and tell how each pair does");
  auto o = std::make_shared<PairOptions>();
  command->add_option("--only", o->only, "only pairs that hold one of these kinds, separated by commas")
      ->delimiter(',');
  command->add_option("-o,--output", o->out, "write the table as a Markdown page");
  command->add_option("--kinds", o->table, "table of kinds to take (JSON) instead of brim's own");
  command->add_option("--with", o->with, "table (JSON) whose kinds are added, such as one's own (--plugin)");
  command->add_option("--response", o->response, "how contacts act: penalty or constraint; default as the table says")
      ->check(CLI::IsMember({"penalty", "constraint"}));
  command
      ->add_option("--world", o->worlds,
                   "worlds of the table in which they meet, separated by commas, or all; default blow. Of brim's own "
                   "table: blow, rest, fine, levels")
      ->delimiter(',');
  command->add_option("--steps", o->steps, "so many steps instead of those of the table")->check(CLI::Range(1, 100000));
  command->add_option("--scenes", o->scenes, "write the scene of each pair into this folder, for brim run");
  command->add_option(
      "--resume", o->resume,
      "keep the figures of each pair in this file, and take over those that this version of brim left there; "
      "make it anew where a plugin has changed");
  command->add_option("--threads", o->threads, "use at most this many threads; default all cores")
      ->check(CLI::Range(1, 4096));
  command->add_flag("--json", o->json, "print the figures as JSON");
  command->callback([o, &code, &app] {
    o->command = "brim pairs";
    for (const CLI::Option* plugin : app.get_options([](const CLI::Option* x) { return x->check_lname("plugin"); }))
      for (const std::string& path : plugin->results()) o->command += " --plugin " + path;
    for (const std::string& file : o->with) o->command += " --with " + file;
    if (!o->table.empty()) o->command += " --kinds " + o->table;
    if (!o->response.empty()) o->command += " --response " + o->response;
    if (!o->worlds.empty()) o->command += fmt::format(" --world {}", fmt::join(o->worlds, ","));
    if (!o->only.empty()) o->command += fmt::format(" --only {}", fmt::join(o->only, ","));
    if (o->steps > 0) o->command += fmt::format(" --steps {}", o->steps);
    if (o->threads > 0) o->command += fmt::format(" --threads {}", o->threads);
    if (!o->out.empty()) o->command += " -o " + o->out;
    code = pairs(*o);
  });
}

}  // namespace brim::cli
