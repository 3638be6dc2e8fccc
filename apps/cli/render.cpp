#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "brim/core/error.h"
#include "brim/scene/document.h"
#include "brim/world/measures.h"
#include "commands.h"
#include "number_range.h"
#include "outside_program.h"
#include "server/page_folder.h"
#include "server/recorded_run.h"
#include "server/viewer_server.h"

namespace brim::cli {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct RenderOptions {
  std::string run, out, size = "1280x720", camera = "fit", contacts, slice, stress, surface, colour;
  long long frame = 0;
  double fps = 0.0;  ///< 0: the run's own
  bool tiles = false, no_links = false;
};

constexpr std::size_t kNamesShown = 20;

/// Numbers between separators. @throws InputError  with the given text when there is anything else
std::vector<double> numbers(const std::string& text, char separator, const std::string& usage) {
  std::vector<double> list;
  const char* at = text.data();
  const char* const end = at + text.size();
  for (;;) {
    double x = 0.0;
    const auto [next, error] = std::from_chars(at, end, x);
    if (error != std::errc() || !std::isfinite(x)) throw InputError(usage);
    list.push_back(x);
    if (next == end) return list;
    if (*next != separator) throw InputError(usage);
    at = next + 1;
  }
}

Json camera_pose(const std::string& text) {
  if (text == "fit") return {{"azimuth", -62}, {"elevation", 20}};
  const std::string usage = fmt::format(
      "--camera {}: must be \"fit\", or azimuth,elevation in degrees, or azimuth,elevation,distance in metres", text);
  const std::vector<double> x = numbers(text, ',', usage);
  if (x.size() < 2 || x.size() > 3 || (x.size() == 3 && x[2] <= 0)) throw InputError(usage);
  Json pose = {{"azimuth", x[0]}, {"elevation", x[1]}};
  if (x.size() == 3) pose["distance"] = x[2];
  return pose;
}

/// "y", "y=0.25" or either with ",body".
Json slice_wish(const std::string& text) {
  const std::string usage =
      fmt::format("--slice {}: must be x, y or z, then perhaps =place in metres, then perhaps ,name of a body", text);
  if (text.empty() || text[0] < 'x' || text[0] > 'z') throw InputError(usage);
  Json wish = {{"axis", text[0] - 'x'}};
  const std::size_t comma = std::min(text.find(','), text.size());
  if (comma > 1) {
    if (text[1] != '=') throw InputError(usage);
    wish["at"] = numbers(text.substr(2, comma - 2), '\0', usage)[0];
  }
  if (comma < text.size()) wish["body"] = text.substr(comma + 1);
  return wish;
}

/// [Pa] of the last colour; 0 for "auto", the largest of each frame; null without any.
Json stress_wish(const std::string& text) {
  if (text.empty()) return {};
  if (text == "auto") return 0;
  const std::string usage =
      fmt::format("--stress {}: must be auto, or the stress of the last colour in Pa, a number above 0", text);
  const double top = numbers(text, '\0', usage)[0];
  if (!(top > 0.0)) throw InputError(usage);
  return top;
}

/// Pieces between commas.
std::vector<std::string> pieces(const std::string& text) {
  std::vector<std::string> list;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    list.push_back(text.substr(at, comma - at));
    at = comma + 1;
  }
  return list;
}

/// "all", or a list of names of bodies; null without any.
Json surface_wish(const std::string& text) {
  if (text.empty()) return {};
  return text == "all" ? Json(text) : Json(pieces(text));
}

/// "water=#4f9fd0,gear=#808080" as an object; null without any.
Json colour_wish(const std::string& text) {
  if (text.empty()) return {};
  Json wish = Json::object();
  for (const std::string& piece : pieces(text)) {
    const std::size_t equal = piece.find('=');
    const std::string colour = equal == std::string::npos ? "" : piece.substr(equal + 1);
    if (equal == 0 || colour.size() != 7 || colour[0] != '#' ||
        colour.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos)
      throw InputError(fmt::format("--colour {}: must be NAME=#rrggbb, several of them between commas", text));
    wish[piece.substr(0, equal)] = colour;
  }
  return wish;
}

/// The bodies of a run that a name means; numbered copies of it only where a stem is allowed.
/// @throws InputError  where there is none
std::vector<Json> named(const std::vector<Json>& bodies, const std::string& name, bool stem,
                        const std::string& option) {
  std::vector<Json> found;
  std::vector<std::string> names;
  for (const Json& body : bodies) {
    names.push_back(body.at("name").get<std::string>());
    if (stem ? concerns(name, names.back()) : name == names.back()) found.push_back(body);
  }
  if (!found.empty()) return found;
  const std::string near = nearest_word(name, names);
  std::string known;
  for (std::size_t i = 0; i < std::min(names.size(), kNamesShown); ++i) known += (i ? ", " : "") + names[i];
  if (names.size() > kNamesShown) known += fmt::format(" and {} more", names.size() - kNamesShown);
  throw InputError(fmt::format("{}: \"{}\" is not a body of the run, which has {}{}", option, name, known,
                               near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
}

/// What of a picture can be shown of the run. @throws InputError  for what cannot
void check_wishes(const Json& run, const RenderOptions& options, const Json& slice, const Json& surface,
                  const Json& colours) {
  const auto bodies = run.at("bodies").get<std::vector<Json>>();
  for (const auto& [name, unused] : colours.items()) named(bodies, name, true, "--colour " + options.colour);
  if (surface.is_array())
    for (const Json& name : surface)
      for (const Json& body : named(bodies, name.get<std::string>(), true, "--surface " + options.surface))
        if (body.at("display") != "points")
          throw InputError(fmt::format("--surface {}: \"{}\" is not made of particles; a surface is shown around those",
                                       options.surface, body.at("name").get<std::string>()));
  const bool rebuilt = run.at("slices").get<bool>();
  if (!options.stress.empty() && !rebuilt)
    throw InputError(fmt::format("--stress {}: the run keeps no scene.json to find stress from", options.stress));
  if (slice.is_null()) return;
  if (slice.contains("body")) named(bodies, slice.at("body").get<std::string>(), false, "--slice " + options.slice);
  if (!rebuilt)
    throw InputError(fmt::format("--slice {}: the run keeps no scene.json to make densities from", options.slice));
}

struct Tools {
  std::string node, chromium, ffmpeg;
};

/// The programs that draw; ffmpeg may be missing.
Tools find_tools() {
  Tools tools;
  tools.node = find_program({"node", "nodejs"});
  if (tools.node.empty())
    throw InputError("brim render needs Node (Debian: apt install nodejs); there is no node on the PATH");
  std::vector<std::string> browsers = {"chromium", "chromium-browser", "google-chrome", "google-chrome-stable"};
  if (const char* set = std::getenv("BRIM_CHROMIUM"); set && *set) browsers = {set};
  tools.chromium = find_program(browsers);
  if (tools.chromium.empty())
    throw InputError(
        "brim render draws with Chromium (Debian: apt install chromium); none is on the PATH, or the one that "
        "BRIM_CHROMIUM names cannot be run");
  tools.ffmpeg = find_program({"ffmpeg"});
  return tools;
}

int render(const RenderOptions& options) {
  const std::string usage =
      fmt::format("--size {}: must be WIDTHxHEIGHT in pixels, from 16x16 to 8192x8192", options.size);
  const std::vector<double> size = numbers(options.size, 'x', usage);
  if (size.size() != 2) throw InputError(usage);
  for (const double s : size)
    if (s < 16 || s > 8192 || s != std::floor(s)) throw InputError(usage);
  const Json pose = camera_pose(options.camera);
  const Json slice = options.slice.empty() ? Json() : slice_wish(options.slice);
  const Json stress = stress_wish(options.stress);
  const Json colours = colour_wish(options.colour), surface = surface_wish(options.surface);
  const fs::path out = fs::absolute(options.out);
  if (out.extension() != ".png" && out.extension() != ".mp4")
    throw InputError(fmt::format("-o {}: must end in .png or .mp4", options.out));

  viewer::RecordedRun run(options.run);
  if (const std::int64_t frames = run.progress().frames;
      out.extension() == ".png" && (options.frame >= frames || options.frame < -frames))
    throw InputError(
        fmt::format("--frame {}: is not there; it must be from {} to {}", options.frame, -frames, frames - 1));
  check_wishes(Json(run.info()), options, slice, surface, colours);
  const Tools tools = find_tools();
  const std::string script = viewer::find_render_script().string();
  viewer::ViewerServer server(run, viewer::find_page_folder());
  const int port = server.bind("127.0.0.1", 0);
  const Json job = {{"url", fmt::format("http://127.0.0.1:{}/", port)},
                    {"out", out.string()},
                    {"chromium", tools.chromium},
                    {"ffmpeg", tools.ffmpeg},
                    {"frame", options.frame},
                    {"width", static_cast<int>(size[0])},
                    {"height", static_cast<int>(size[1])},
                    {"camera", pose},
                    {"contacts", options.contacts},
                    {"tiles", options.tiles},
                    {"links", !options.no_links},
                    {"slice", slice},
                    {"stress", stress},
                    {"colours", colours},
                    {"surface", surface},
                    {"fps", options.fps > 0 ? options.fps : run.frame_rate()}};
  const std::jthread serving([&server] { server.listen(); });
  const int code = run_program(tools.node, {script, job.dump()});
  server.stop();
  return code;
}

}  // namespace

void add_render(CLI::App& app, int& code) {
  CLI::App* command = app.add_subcommand("render", "make a picture or a film of a run, as the viewer shows it");
  auto options = std::make_shared<RenderOptions>();
  command->add_option("run", options->run, "run folder, or its run.h5")->required();
  command->add_option("-o,--output", options->out, "picture (.png) or film (.mp4) to write")->required();
  command->add_option("--frame", options->frame, "frame of a picture, from 0; negative counts from the end")
      ->capture_default_str();
  command->add_option("--size", options->size, "width and height in pixels")->capture_default_str();
  command
      ->add_option("--camera", options->camera,
                   "azimuth,elevation[,distance] in degrees and metres around the middle of the scene, or fit")
      ->capture_default_str();
  command->add_option("--contacts", options->contacts, "show contacts: points, forces, all (both) or voxels")
      ->check(CLI::IsMember({"points", "forces", "all", "voxels"}));
  command->add_option("--slice", options->slice,
                      "show the densities on a plane: x, y or z, then perhaps =place [m], then perhaps ,body");
  command->add_option("--stress", options->stress,
                      "colour elastic solids by their von Mises stress: auto (up to the largest of each frame), or the "
                      "stress of the last colour [Pa]");
  command->add_option("--surface", options->surface,
                      "show particles as the surface around them: all, or names of bodies separated by commas");
  command->add_option("--colour", options->colour, "colours of bodies: NAME=#rrggbb, several between commas");
  command->add_flag("--tiles", options->tiles, "show active tiles");
  command->add_flag("--no-attachments", options->no_links, "leave out attachments and joints");
  command->add_option("--fps", options->fps, "frames per second of a film; without it, the run plays in its own time")
      ->check(number_range(0.01, 1000.0));
  command->callback([options, &code] { code = render(*options); });
}

}  // namespace brim::cli
