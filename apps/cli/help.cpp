#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "brim/core/error.h"
#include "brim/scene/document.h"
#include "commands.h"

namespace brim::cli {

namespace {

/// Commands that are shown.
std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App* s) { return !s->get_group().empty(); }))
    names.push_back(sub->get_name());
  return names;
}

/// The first argument that is no option, nor the value of --plugin; "" where there is none.
std::string first_word(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string a = argv[i];
    if (a == "--plugin")
      ++i;
    else if (!a.starts_with("-"))
      return a;
  }
  return "";
}

std::string no_command(const CLI::App& app, const std::string& word) {
  const std::string near = nearest_word(word, command_names(app));
  return fmt::format("\"{}\" is not a command{}; brim help lists them", word,
                     near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near));
}

const CLI::App* find_command(const CLI::App& app, const std::string& name) {
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    if (sub->get_name() == name) return sub;
  return nullptr;
}

}  // namespace

std::string complaint(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
  const std::string word = first_word(argc, argv);
  if (word.empty()) return fmt::format("{}; brim help lists what is allowed", error.what());
  if (!find_command(app, word)) return no_command(app, word);
  return fmt::format("{}; brim {} --help says what is allowed", error.what(), word);
}

void add_help(CLI::App& app, int& code) {
  CLI::App* help = app.add_subcommand("help", "say what a command does, or which there are");
  auto name = std::make_shared<std::string>();
  help->add_option("command", *name, "one of the commands");
  help->callback([&app, name, &code] {
    const CLI::App* about = name->empty() ? &app : find_command(app, *name);
    if (!about) throw InputError(no_command(app, *name));
    // help() would go on to the command that was given, which is this one.
    const std::string usage = about == &app ? "brim" : "brim " + *name;
    std::fputs(about->get_formatter()->make_help(about, usage, CLI::AppFormatMode::Normal).c_str(), stdout);
    code = kGood;
  });
  CLI::App* version = app.add_subcommand("version", "print the version and the commit that was built");
  version->callback([&code] {
    fmt::print("brim {}\n", version_text());
    code = kGood;
  });
}

}  // namespace brim::cli
