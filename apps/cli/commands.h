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

/// Adds --plugin, before or after any command.
void add_plugins(CLI::App& app);

/// True once Ctrl-C or a request to end has come. The first is taken in; a second ends the process at once.
void watch_interrupts();
bool interrupted();

}  // namespace brim::cli
