#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <thread>

#include "brim/core/error.h"
#include "brim/io/regular_file.h"
#include "brim/record/scene_change.h"
#include "brim/scene/scene.h"
#include "commands.h"
#include "sweep_cases.h"

namespace brim::cli {

namespace {

namespace fs = std::filesystem;

struct SweepOptions {
  std::string scene, folder, seeds, emit;
  std::vector<std::string> set, plugins;
  std::int64_t frames = 0;
  int jobs = 0;
  bool check = false, force = false, join = false, quiet = false;
};

std::string program_path() {
  std::error_code error;
  const fs::path path = fs::read_symlink("/proc/self/exe", error);
  return error ? "brim" : path.string();
}

/// brim run SCENE ..., as words.
std::vector<std::string> run_words(const SweepOptions& o, const SweepCase& c, const std::string& program, bool resume) {
  std::vector<std::string> words = {program};
  for (const std::string& p : o.plugins) words.insert(words.end(), {"--plugin", p});
  words.insert(words.end(), {"run", o.scene});
  for (const std::string& w : c.arguments()) words.push_back(w);
  words.insert(words.end(),
               {"--threads", "1", "--quiet", resume ? "--resume" : "-o", (fs::path(o.folder) / c.name()).string()});
  if (o.frames > 0) words.insert(words.end(), {"--frames", std::to_string(o.frames)});
  if (o.force && !resume) words.push_back("--force");
  return words;
}

std::string quoted(const std::string& word) {
  const bool plain = !word.empty() && word.find_first_not_of(
                                          "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                          "_-./=:+,%@") == std::string::npos;
  if (plain) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string command_line(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& w : words) line += (line.empty() ? "" : " ") + quoted(w);
  return line;
}

/// Lines for GNU parallel, or a job array for Slurm's sbatch, of the cases that are not done.
void emit(const SweepOptions& o, const std::vector<SweepCase>& left, std::size_t all) {
  const std::string program = program_path();
  if (o.emit == "parallel") {
    for (const SweepCase& c : left)
      fmt::print("{}\n", command_line(run_words(o, c, program, sweep_state(o.folder, c) == "begun")));
    return;
  }
  fmt::print(
      "#!/bin/bash\n#SBATCH --job-name=brim\n#SBATCH --cpus-per-task=1\n#SBATCH --array=0-{}\n#SBATCH "
      "--output={}/%a.txt\n# {} of {} cases; afterwards the same brim sweep with --join writes the table.\ncd {}\ncase "
      "$SLURM_ARRAY_TASK_ID in\n",
      left.empty() ? 0 : left.size() - 1, quoted((fs::path(o.folder) / "logs").string()), left.size(), all,
      quoted(fs::current_path().string()));
  for (std::size_t i = 0; i < left.size(); ++i)
    fmt::print("{}) exec {} ;;\n", i,
               command_line(run_words(o, left[i], program, sweep_state(o.folder, left[i]) == "begun")));
  fmt::print("esac\n");
}

pid_t start(const std::vector<std::string>& words, const std::string& log) {
  std::vector<char*> argv;
  for (const std::string& w : words) argv.push_back(const_cast<char*>(w.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  pid_t child = 0;
  const int failed = posix_spawn(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed) throw InputError(fmt::format("{}: cannot be started: {}", words.front(), std::strerror(failed)));
  return child;
}

/// "17 of 40 done, 2 running, 1 failed, 3:20 left", in place on a terminal.
class SweepBar {
 public:
  SweepBar(std::size_t all, std::size_t done, bool quiet)
      : all_(all), before_(done), quiet_(quiet || isatty(fileno(stderr)) == 0) {}

  void show(std::size_t done, std::size_t running, std::size_t failed) const {
    if (quiet_) return;
    const double spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const std::size_t made = done - before_;
    const double left = made > 0 ? spent / static_cast<double>(made) * static_cast<double>(all_ - done) : NAN;
    const int full = all_ > 0 ? static_cast<int>(30 * done / all_) : 30;
    fmt::print(
        stderr, "\r\x1b[K[{}{}] {} of {} done, {} running{}{}", std::string(static_cast<std::size_t>(full), '#'),
        std::string(static_cast<std::size_t>(30 - full), ' '), done, all_, running,
        failed > 0 ? fmt::format(", {} failed", failed) : "",
        std::isfinite(left) ? fmt::format(", {:.0f}:{:02.0f} left", std::floor(left / 60), std::fmod(left, 60)) : "");
  }
  void end() const {
    if (!quiet_) fmt::print(stderr, "\n");
  }

 private:
  std::size_t all_, before_;
  bool quiet_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Runs the cases, `jobs` at a time. @return  names of those that ended badly
std::set<std::string> run_cases(const SweepOptions& o, const std::vector<SweepCase>& left, std::size_t all) {
  const std::string program = program_path();
  const std::size_t jobs =
      o.jobs > 0 ? static_cast<std::size_t>(o.jobs) : std::max(1u, std::thread::hardware_concurrency());
  std::map<pid_t, std::string> running;
  std::set<std::string> failed;
  const SweepBar bar(all, all - left.size(), o.quiet);
  std::size_t next = 0, done = all - left.size();
  bool told = false;
  while (next < left.size() || !running.empty()) {
    while (!interrupted() && next < left.size() && running.size() < jobs) {
      const SweepCase& c = left[next++];
      const bool resume = sweep_state(o.folder, c) == "begun" && !o.force;
      running[start(run_words(o, c, program, resume), (fs::path(o.folder) / "logs" / (c.name() + ".txt")).string())] =
          c.name();
    }
    if (interrupted() && !told) {
      told = true;
      for (const auto& [pid, unused] : running) ::kill(pid, SIGTERM);  // they keep their frames
    }
    if (interrupted() && running.empty()) break;
    bar.show(done, running.size(), failed.size());
    int status = 0;
    const pid_t ended = ::waitpid(-1, &status, WNOHANG);
    if (ended <= 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      continue;
    }
    const auto it = running.find(ended);
    if (it == running.end()) continue;
    const bool good = WIFEXITED(status) && WEXITSTATUS(status) == kGood;
    if (!good && !interrupted()) failed.insert(it->second);
    running.erase(it);
    ++done;
  }
  bar.show(done, 0, failed.size());
  bar.end();
  return failed;
}

/// A run that is there must be of the scene as it is now.
void need_same(const SweepOptions& o, const SweepCase& c, const Scene& scene) {
  const std::string kept = (fs::path(o.folder) / c.name() / "scene.json").string();
  const auto text = read_regular_file(kept);
  if (text && !same_scene(*text, scene.text))
    throw InputError(fmt::format("{}: a run of another scene is there; another -o, or --force to make all anew", kept));
}

bool expectations_hold(const std::string& folder, const SweepCase& c) {
  const auto text = read_regular_file((fs::path(folder) / c.name() / "summary.json").string());
  return text && text->find("\"expect_ok\": false") == std::string::npos;
}

int sweep(SweepOptions o) {
  const std::vector<SweepCase> cases = sweep_cases(o.set, o.seeds);
  std::vector<SweepCase> left;
  for (const SweepCase& c : cases) {
    const Scene scene = load_scene(o.scene, c.settings());
    if (o.folder.empty()) o.folder = (fs::path("out") / (scene.name + "_sweep")).string();
    if (!o.force) need_same(o, c, scene);
    const std::string state = o.force ? "" : sweep_state(o.folder, c);
    if (state.empty() || state == "begun") left.push_back(c);
  }
  if (!o.emit.empty()) {
    emit(o, left, cases.size());
    return kGood;
  }
  std::set<std::string> failed;
  if (!o.join) {
    std::error_code error;
    fs::create_directories(fs::path(o.folder) / "logs", error);
    if (error) throw InputError(fmt::format("{}: the folder cannot be made: {}", o.folder, error.message()));
    watch_interrupts();
    failed = run_cases(o, left, cases.size());
  }
  const std::string table = (fs::path(o.folder) / "summary.csv").string();
  std::ofstream file(table, std::ios::binary);
  file << sweep_table(o.folder, cases);
  file.close();
  if (!file) throw InputError(fmt::format("{}: the file cannot be written", table));
  std::size_t completed = 0, missed = 0;
  for (const SweepCase& c : cases) {
    const std::string state = sweep_state(o.folder, c);
    if (state == "completed") ++completed;
    if (state == "failed") failed.insert(c.name());
    if (state == "completed" && !expectations_hold(o.folder, c)) ++missed;
  }
  for (const std::string& name : failed)
    fmt::print(stderr, "brim: {} failed; see {}\n", name, (fs::path(o.folder) / "logs" / (name + ".txt")).string());
  fmt::print("{} of {} runs completed{}; {}\n", completed, cases.size(),
             missed > 0 ? fmt::format(", {} with expectations that are not met", missed) : "", table);
  if (interrupted()) return kInterrupted;
  return failed.empty() && !(o.check && missed > 0) ? kGood : kFailed;
}

}  // namespace

void add_sweep(CLI::App& app, int& code) {
  CLI::App* command =
      app.add_subcommand("sweep", "run a scene with many values of its parameters and join the results in one table");
  auto o = std::make_shared<SweepOptions>();
  command->add_option("scene", o->scene, "scene file (JSON)")->required();
  command
      ->add_option("--set", o->set,
                   "name=value,value,... of a parameter, or of any value (/world/time_step=0.01,0.005); "
                   "all combinations of several are run")
      ->allow_extra_args(false);
  command->add_option("--seeds", o->seeds, "random numbers: first:last, or numbers with commas");
  command->add_option("-o,--output", o->folder,
                      "folder of the runs and the table; default out/<name of the scene>_sweep");
  command->add_option("--jobs", o->jobs, "runs at a time, each a process with one thread; default all cores")
      ->check(CLI::Range(1, 4096));
  command->add_option("--frames", o->frames, "record this many frames after the first, whatever the scene says")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{10000000}));
  command->add_flag("--check", o->check, "exit with 1 when an expectation of a run is not met");
  command->add_flag("--force", o->force, "make all runs anew");
  command->add_flag("--quiet", o->quiet, "no progress bar");
  command->add_flag("--join", o->join, "run nothing; write the table of what is there");
  command
      ->add_option(
          "--emit", o->emit,
          "run nothing; print the commands that are left: for GNU parallel, one a line, or as a job array of Slurm")
      ->check(CLI::IsMember({"parallel", "slurm"}));
  command->callback([&app, o, &code] {
    if (const CLI::Option* plugins = app.get_option_no_throw("--plugin")) o->plugins = plugins->results();
    code = sweep(*o);
  });
}

}  // namespace brim::cli
