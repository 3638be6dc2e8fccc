#include "brim/record/export/export.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "brim/core/error.h"
#include "brim/record/export/format.h"
#include "commands.h"
#include "number_range.h"
#include "server/rebuilt_world.h"

namespace brim::cli {

namespace {

struct ExportOptions {
  std::string run;
  ExportRequest request;
};

int export_to(const ExportOptions& options) {
  const RunReader run(options.run);
  ExportRequest request = options.request;
  if (request.folder.empty())
    request.folder =
        (std::filesystem::absolute(run.path()).lexically_normal().parent_path() / "export" / request.format).string();
  std::optional<viewer::RebuiltWorld> world;
  const WorldAt world_at = [&](std::int64_t frame) -> const World& {
    if (!world) world.emplace(run);
    return world->at(run, frame);
  };
  watch_interrupts();
  const ExportResult result =
      export_run(run, request, world_at, [](std::int64_t, std::int64_t) { return !interrupted(); });
  fmt::print("{} frames in {} files in {}\n", result.frames, result.files.size(), request.folder);
  return kGood;
}

std::string format_help() {
  std::string text = "format to write:";
  for (const exporting::Format& f : exporting::formats()) text += fmt::format("\n  {:5} {}", f.name, f.text);
  return text;
}

}  // namespace

void add_export(CLI::App& app, int& code) {
  CLI::App* command = app.add_subcommand("export", "write a run in the formats of other programs");
  auto o = std::make_shared<ExportOptions>();
  command->add_option("run", o->run, "run folder, or its run.h5")->required();
  command->add_option("--format", o->request.format, format_help())->required();
  command->add_option("-o,--output", o->request.folder, "folder to write; default RUN/export/FORMAT");
  command->add_option(
      "--frames", o->request.frames,
      "frames first:last or first:last:stride, both included, from 0; negative ones count from the end");
  command->add_option("--bodies", o->request.bodies, "names of bodies, or of all numbered copies; default all")
      ->delimiter(',');
  command->add_option("--voxel-size", o->request.voxel_size, "[m] grid step of densities (vdb); default the body's own")
      ->check(number_range(2e-5, 1e5));  // below, OpenVDB takes the cube of it for zero
  command->add_flag("--force", o->request.force, "replace an older export in the folder");
  command->callback([o, &code] {
    try {
      code = export_to(*o);
    } catch (const InputError&) {
      if (!interrupted()) throw;
      std::fputs("brim: the export was stopped; nothing of it is left\n", stderr);
      code = kInterrupted;
    }
  });
}

}  // namespace brim::cli
