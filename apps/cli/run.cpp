#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/record/run_folder.h"
#include "brim/record/runner.h"
#include "brim/scene/scene.h"
#include "commands.h"
#include "hand.h"
#include "live_view.h"
#include "profile_table.h"
#include "progress.h"
#include "server/kept_scene.h"
#include "server/page_folder.h"
#include "settings.h"

#if defined(__unix__) || defined(__APPLE__)
#include <unistd.h>
#endif

namespace brim::cli {

namespace {

struct Options {
  std::string scene, folder, resume, levels;
  SettingOptions settings;
  std::int64_t frames = 0;
  int threads = 0;
  bool check = false, json = false, force = false, edit = false, quiet = false, view = false, profile = false,
       interactive = false;
};

constexpr std::int64_t kEndless = 10000000;

bool on_terminal() {
#if defined(__unix__) || defined(__APPLE__)
  return isatty(fileno(stderr)) != 0;
#else
  return false;
#endif
}

/// The scene that is named, or else the one that the run to go on with keeps.
Scene read_scene(const Options& o) {
  if (!o.scene.empty()) return load_scene(o.scene, o.settings.read());
  const viewer::KeptScene kept = viewer::kept_scene(o.resume);
  if (const std::string why = viewer::python_bodies(kept); !why.empty())
    throw InputError(fmt::format("--resume {}: {}", o.resume, why));
  return parse_scene(kept.text, kept.file, o.settings.read());
}

/// The folder of a run that is named by it or by its run.h5.
std::string folder_of_run(const std::string& path) {
  const std::filesystem::path given(path);
  if (given.filename() != "run.h5" || std::filesystem::is_directory(given)) return path;
  return given.has_parent_path() ? given.parent_path().string() : ".";
}

int run(const Options& o) {
  const auto start = std::chrono::steady_clock::now();
  const ThreadLimit limit(o.threads);
  const Scene scene = read_scene(o);
  RunPlan plan;
  plan.resume = !o.resume.empty();
  plan.folder = plan.resume         ? o.resume
                : !o.folder.empty() ? o.folder
                                    : (std::filesystem::path("out") / scene.name).string();
  plan.info = {scene.name, scene.text, scene.frame_time(), scene.steps_per_frame,
               std::filesystem::absolute(scene.file).lexically_normal().string()};
  plan.scene_file = scene.file;
  plan.scene_frames = scene.frames;
  plan.frames = o.frames > 0 ? o.frames : o.interactive ? kEndless : scene.frames;
  if (!o.interactive) plan.expect = scene.expect;  // what a person does is not what the scene expects
  plan.force = o.force;
  plan.edit = o.edit;
  plan.levels = o.levels;
  // Before the work of building, which may take a while.
  if (!plan.resume) check_run_folder(plan.folder, plan.force);
  const bool view = o.view || o.interactive;
  if (view) viewer::find_page_folder();
  World world = build_world(scene);
  plan.build_wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  Progress progress(o.json                      ? Progress::Style::Json
                    : on_terminal() && !o.quiet ? Progress::Style::Bar
                                                : Progress::Style::Quiet,
                    plan.frames == kEndless);
  watch_interrupts();
  std::optional<LiveView> live;
  std::optional<Hand> hand;
  if (o.interactive) {
    hand.emplace();
    plan.before_step = [&](World& w) { hand->before_step(w); };
  }
  plan.stop = interrupted;
  if (view)
    plan.started = [&] {
      if (hand) hand->write_to(plan.folder, plan.resume);
      live.emplace(plan.folder, o.json, hand ? hand->far_end() : -1);
    };
  progress.start(scene.name, plan.folder, plan, world);
  ProfileTable profile;
  set_profile(o.profile);
  const RunResult result = record_run(world, plan, [&](const RunProgress& p) {
    progress.frame(p);
    if (o.profile) profile.add(*p.report, scene.steps_per_frame);
    return !interrupted();
  });
  progress.end(result, plan.folder);
  if (hand) hand->finish();
  if (result.started_over)
    fmt::print(stderr,
               "brim: {}: its process ended before the first frame was on disk, so the run was made from its start\n",
               plan.folder);
  if (!o.json && (o.check || !result.findings.empty()))
    std::fputs(findings_table(result.findings, o.check).c_str(), stdout);
  if (o.profile) std::fputs(profile.text(thread_count()).c_str(), o.json ? stderr : stdout);
  if (live && result.end != RunEnd::Interrupted) {
    fmt::print(stderr, "brim: the viewer goes on; Ctrl-C ends it\n");
    live->stay();
  }
  switch (result.end) {
    case RunEnd::Interrupted:
      return kInterrupted;
    case RunEnd::Failed:
      if (!result.refused.empty()) {
        fmt::print(stderr, "brim: error: {}; the frames to {:.6g} s are in {}\n", result.refused,
                   static_cast<double>(result.totals.frames - 1) * plan.info.frame_time, plan.folder);
        return kFailed;
      }
      fmt::print(stderr, "brim: error: a step failed at {:.6g} s; the frames before it and its report are in {}\n",
                 world.state().time, plan.folder);
      return kFailed;
    case RunEnd::Completed:
      break;
  }
  return o.check && !result.ok() ? kFailed : kGood;
}

}  // namespace

void add_run(CLI::App& app, int& code) {
  CLI::App* command = app.add_subcommand("run", "simulate a scene and record the run");
  auto o = std::make_shared<Options>();
  command->add_option("scene", o->scene, "scene file (JSON); with --resume: absent takes the one that the run keeps");
  CLI::Option* folder =
      command->add_option("-o,--output", o->folder, "folder of the run; default out/<name of the scene>");
  o->settings.add_to(*command);
  command->add_option("--frames", o->frames, "record this many frames after the first, whatever the scene says")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{10000000}));
  command->add_option("--threads", o->threads, "use at most this many threads; default all cores")
      ->check(CLI::Range(1, 4096));
  command->add_flag(
      "--check", o->check,
      "exit with 1 when an expectation of the scene is not met, or one that is marked as a known miss is");
  command->add_option("--levels", o->levels, "take the levels of detail of this run, frame by frame");
  command->add_flag("--json", o->json, "report progress as lines of JSON on standard output");
  command->add_flag("--quiet", o->quiet, "no progress bar; the closing line and warnings stay");
  command->add_flag("--profile", o->profile,
                    "print where the time went: by phase, kind of body, solves and memory traffic");
  command->add_flag("--view", o->view, "serve the run to a browser while it is made, and after it until Ctrl-C");
  command->add_flag(
      "--interactive", o->interactive,
      "as --view, no faster than the clock and until Ctrl-C or --frames, with bodies that can be pulled in "
      "the browser");
  CLI::Option* force = command->add_flag("--force", o->force, "replace an old run in the folder");
  CLI::Option* resume = command->add_option(
      "--resume", o->resume, "go on with the run in this folder, or with its run.h5, after its last frame");
  resume->excludes(folder)->excludes(force);
  command
      ->add_flag("--edit", o->edit,
                 "with --resume: take the scene though it differs from that of the run, and record it")
      ->needs(resume);
  command->callback([o, &code] {
    if (o->scene.empty() && o->resume.empty()) throw CLI::RequiredError("scene, or --resume with the folder of a run,");
    o->resume = folder_of_run(o->resume);
    code = run(*o);
  });
}

}  // namespace brim::cli
