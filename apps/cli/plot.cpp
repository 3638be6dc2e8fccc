#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "brim/core/error.h"
#include "brim/record/run_reader.h"
#include "brim/world/step_report.h"
#include "commands.h"
#include "outside_program.h"

namespace brim::cli {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct PlotOptions {
  std::string run, out;
};

/// What plot_run.py returns where this Python has no Matplotlib.
constexpr int kNoMatplotlib = 3;

/// The script beside an installed program, else that of the sources.
fs::path find_plot_script() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed = program.parent_path().parent_path() / "share/brim/plot_run.py";
  if (!error && fs::is_regular_file(installed, error)) return installed;
  if (fs::path source = BRIM_PLOT_SOURCE; fs::is_regular_file(source, error)) return source;
  throw InputError(fmt::format("plot_run.py of brim is neither {} nor {}; install brim again", installed.string(),
                               BRIM_PLOT_SOURCE));
}

/// Series of a run that a diagram shows, a value per frame from frame 1 on: frame 0 has no step.
Json series_of(const RunReader& run) {
  const std::int64_t frames = run.frames();
  if (frames < 2)
    throw InputError(fmt::format("{}: has {} frames, and a diagram needs two or more", run.path(), frames));
  const auto take = [&](const std::string& name) {
    std::vector<double> x = run.series(name);
    x.resize(static_cast<std::size_t>(frames), 0.0);
    x.erase(x.begin());
    return x;
  };
  std::vector<double> time;
  for (std::int64_t f = 1; f < frames; ++f) time.push_back(run.time(f));
  Json seconds = Json::object(), series = Json::object();
  for (const char* phase : kPhaseNames) seconds[phase] = take(std::string("seconds_") + phase);
  for (const char* name : {"wall", "kinetic_energy", "potential_energy", "contact_energy", "worst_overlap", "contacts",
                           "cg_iterations", "sweeps", "substeps"})
    series[name] = take(name);
  return {{"scene", run.scene_name()},
          {"version", run.brim_version()},
          {"frame_time", run.frame_time()},
          {"time", time},
          {"seconds", seconds},
          {"series", series}};
}

/// A file that is removed with this.
class PassingFile {
 public:
  explicit PassingFile(const std::string& text) {
    std::string name = (fs::temp_directory_path() / "brim_plot_XXXXXX").string();
    const int file = mkstemp(name.data());
    if (file < 0) throw InputError(fmt::format("no file can be made in {}", fs::temp_directory_path().string()));
    close(file);
    path_ = name;
    std::ofstream(path_) << text;
  }
  ~PassingFile() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  PassingFile(const PassingFile&) = delete;
  PassingFile& operator=(const PassingFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

int plot(const PlotOptions& options) {
  const RunReader run(options.run);
  const fs::path out = options.out.empty() ? fs::path(run.path()).parent_path() / "plot.svg" : fs::path(options.out);
  if (out.extension() != ".svg" && out.extension() != ".png")
    throw InputError(fmt::format("-o {}: must end in .svg or .png", out.string()));
  const PassingFile data(series_of(run).dump());
  const std::string script = find_plot_script().string();
  const char* set = std::getenv("BRIM_PYTHON");
  const std::vector<std::string> names =
      set && *set ? std::vector<std::string>{set} : std::vector<std::string>{"python3", "/usr/bin/python3"};
  for (const std::string& name : names) {
    const std::string python = find_program({name});
    if (python.empty()) continue;
    const int answer = run_program(python, {script, data.path(), out.string()});
    if (answer == kNoMatplotlib) continue;
    if (answer == 0) fmt::print("{}\n", out.string());
    return answer == 0 ? kGood : kFailed;
  }
  throw InputError(fmt::format(
      "brim plot draws with Matplotlib (Debian: apt install python3-matplotlib), which {} not have; BRIM_PYTHON may "
      "name another Python",
      set && *set ? fmt::format("{} does", set) : std::string("python3 and /usr/bin/python3 do")));
}

}  // namespace

void add_plot(CLI::App& app, int& code) {
  CLI::App* command = app.add_subcommand("plot", "draw a run's time per phase, energies, overlap and iterations");
  auto options = std::make_shared<PlotOptions>();
  command->add_option("run", options->run, "run folder, or its run.h5")->required();
  command->add_option("-o,--output", options->out, "diagram (.svg or .png) to write; without it, plot.svg of the run");
  command->callback([options, &code] { code = plot(*options); });
}

}  // namespace brim::cli
