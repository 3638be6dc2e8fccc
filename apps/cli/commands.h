#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace brim::cli {

/// What the program returns.
enum ExitCode { kGood = 0, kFailed = 1, kBadInput = 2, kInterrupted = 130 };

/// Each adds one command; when it is chosen, `code` becomes the program's exit code. InputErrors reach main().
void add_run(CLI::App& app, int& code);
void add_validate(CLI::App& app, int& code);
void add_info(CLI::App& app, int& code);
void add_schema(CLI::App& app, int& code);
void add_view(CLI::App& app, int& code);
void add_render(CLI::App& app, int& code);
void add_plot(CLI::App& app, int& code);
void add_export(CLI::App& app, int& code);
void add_pairs(CLI::App& app, int& code);
void add_sweep(CLI::App& app, int& code);
/// `help` and `version`, as words.
void add_help(CLI::App& app, int& code);
/// `completion` and `manual`: what the program says of its own commands, for shells and man.
void add_describe(CLI::App& app, int& code);

/// What is wrong with a command line that CLI11 refused, with the help that fits: "brim run --help".
std::string complaint(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv);

/// Version, and the commit that was built where it is known: "0.1.0 (1a2b3c4d5e6f)".
const std::string& version_text();

/// Adds --plugin, before or after any command.
void add_plugins(CLI::App& app);

/// True once Ctrl-C or a request to end has come. The first is taken in; a second ends the process at once.
void watch_interrupts();
bool interrupted();

}  // namespace brim::cli
