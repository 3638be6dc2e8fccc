#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <string>

#include "brim/core/error.h"
#include "brim/core/printable.h"
#include "brim/scene/errors.h"
#include "commands.h"

namespace {

/// A message as one line for a terminal: what a file said may hold control characters, or be very long.
std::string one_line(const std::string& text) {
  constexpr std::size_t kMost = 2000;
  if (text.size() <= kMost) return brim::printable(text);
  return brim::printable(text.substr(0, kMost / 2) + " ... " + text.substr(text.size() - kMost / 2));
}

/// What was printed has to arrive: a full disk is an error of the command. @return its exit code
int after_output(int code) {
  errno = 0;
  std::cout.flush();
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good()) return code;
  if (errno == EBADF) return code;  // closed on purpose
  std::fprintf(stderr, "brim: error: standard output could not be written; is the disk full?\n");
  return code == brim::cli::kGood ? brim::cli::kFailed : code;
}

}  // namespace

int main(int argc, char** argv) {
#ifdef SIGXFSZ
  std::signal(SIGXFSZ, SIG_IGN);  // a limit on the size of files is then an error of writing, with its message
#endif
  CLI::App app("brim: bodies of any kind in contact through a grid of densities", "brim");
  app.set_version_flag("--version", "brim " + brim::cli::version_text());
  app.require_subcommand(1);
  app.fallthrough();
  brim::cli::add_plugins(app);
  int code = brim::cli::kGood;
  brim::cli::add_run(app, code);
  brim::cli::add_validate(app, code);
  brim::cli::add_info(app, code);
  brim::cli::add_schema(app, code);
  brim::cli::add_view(app, code);
  brim::cli::add_render(app, code);
  brim::cli::add_plot(app, code);
  brim::cli::add_export(app, code);
  brim::cli::add_pairs(app, code);
  brim::cli::add_sweep(app, code);
  brim::cli::add_help(app, code);
  brim::cli::add_describe(app, code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return after_output(app.exit(e));
    std::fprintf(stderr, "brim: error: %s\n", one_line(brim::cli::complaint(app, e, argc, argv)).c_str());
    return brim::cli::kBadInput;
  } catch (const brim::InputErrors& e) {
    for (const std::string& message : e.messages())
      std::fprintf(stderr, "brim: error: %s\n", one_line(message).c_str());
    return brim::cli::kBadInput;
  } catch (const brim::InputError& e) {
    std::fprintf(stderr, "brim: error: %s\n", one_line(e.what()).c_str());
    return brim::cli::kBadInput;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "brim: error: out of memory; a coarser voxel_size or lattice_spacing needs less\n");
    return brim::cli::kFailed;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "brim: error: %s (a defect of brim; please report it)\n", one_line(e.what()).c_str());
    return brim::cli::kFailed;
  }
  return after_output(code);
}
