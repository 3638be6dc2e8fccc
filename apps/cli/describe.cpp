#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "brim/core/error.h"
#include "commands.h"

namespace brim::cli {

namespace {

std::vector<const CLI::App*> shown_commands(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* s) { return !s->get_group().empty(); });
}

std::vector<const CLI::Option*> shown_options(const CLI::App& app) {
  return app.get_options([](const CLI::Option* o) { return !o->get_group().empty(); });
}

/// "--frames", "-o --output": the words that may be typed.
std::vector<std::string> words_of(const CLI::Option& o) {
  std::vector<std::string> words;
  for (const std::string& s : o.get_snames()) words.push_back("-" + s);
  for (const std::string& l : o.get_lnames()) words.push_back("--" + l);
  return words;
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string text;
  for (const std::string& w : words) text += (text.empty() ? "" : between) + w;
  return text;
}

std::string option_words(const CLI::App& app) {
  std::vector<std::string> words;
  for (const CLI::Option* o : shown_options(app))
    for (const std::string& w : words_of(*o)) words.push_back(w);
  return joined(words, " ");
}

std::string command_words(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* c : shown_commands(app)) names.push_back(c->get_name());
  return joined(names, " ");
}

/// Text between single quotes of a shell, without what would end them.
std::string quiet(std::string text) {
  for (char& c : text)
    if (c == '\n') c = ' ';
  std::erase_if(text, [](char c) { return c == '\'' || c == '[' || c == ']' || c == '\\'; });
  return text;
}

std::string bash(const CLI::App& app) {
  std::string cases;
  for (const CLI::App* c : shown_commands(app))
    cases += fmt::format("    {}) words=\"{}\" ;;\n", c->get_name(), option_words(*c) + " " + option_words(app));
  return fmt::format(R"(# Completion of brim for bash; made by: brim completion bash
_brim() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} command="" words i
  for ((i = 1; i < COMP_CWORD; i++)); do
    if [[ ${{COMP_WORDS[i]}} == --plugin ]]; then ((i++)); continue; fi
    [[ ${{COMP_WORDS[i]}} == -* ]] || {{ command=${{COMP_WORDS[i]}}; break; }}
  done
  case $command in
    "") words="{} {}" ;;
    help) words="{}" ;;
{}  esac
  COMPREPLY=()
  if [[ -z $command || $command == help || $word == -* ]]; then
    COMPREPLY=($(compgen -W "$words" -- "$word"))
  fi
}}
complete -o default -F _brim brim
)",
                     command_words(app), option_words(app), command_words(app), cases);
}

std::string zsh(const CLI::App& app) {
  std::string names, cases;
  for (const CLI::App* c : shown_commands(app)) {
    names += fmt::format("    '{}:{}'\n", c->get_name(), quiet(c->get_description()));
    std::string options;
    for (const CLI::Option* o : shown_options(*c))
      for (const std::string& w : words_of(*o))
        options += fmt::format(" '{}[{}]{}'", w, quiet(o->get_description()),
                               o->get_items_expected() > 0 ? ":value:_files" : "");
    cases += fmt::format("    {}) _arguments{} '*:file:_files' ;;\n", c->get_name(), options);
  }
  return fmt::format(R"(#compdef brim
# Completion of brim for zsh; made by: brim completion zsh
_brim() {{
  local -a commands=(
{}  )
  if ((CURRENT == 2)); then
    _describe command commands
    return
  fi
  local command=$words[2]
  shift words
  ((CURRENT--))
  case $command in
{}    *) _files ;;
  esac
}}
_brim "$@"
)",
                     names, cases);
}

std::string fish(const CLI::App& app) {
  std::string text = "# Completion of brim for fish; made by: brim completion fish\n";
  for (const CLI::App* c : shown_commands(app)) {
    text += fmt::format("complete -c brim -n __fish_use_subcommand -f -a {} -d '{}'\n", c->get_name(),
                        quiet(c->get_description()));
    for (const CLI::Option* o : shown_options(*c))
      for (const std::string& l : o->get_lnames())
        text += fmt::format("complete -c brim -n '__fish_seen_subcommand_from {}' -l {} -d '{}'{}\n", c->get_name(), l,
                            quiet(o->get_description()), o->get_items_expected() > 0 ? " -r" : "");
  }
  return text;
}

/// Text for troff: no line begins with a control character, no backslash speaks.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if (c == '\n')
      out += "\n.br\n\\&";
    else
      out += c;
  }
  return "\\&" + out;
}

std::string roff_options(const CLI::App& app) {
  std::string text;
  for (const CLI::Option* o : shown_options(app)) {
    const bool positional = o->get_positional();
    const std::string name = positional ? o->get_name(true) : joined(words_of(*o), ", ");
    const bool value = !positional && o->get_items_expected() > 0;
    text += fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", roff(name), value ? " \\fI" + roff(o->get_type_name()) + "\\fR" : "",
                        roff(o->get_description()));
  }
  return text;
}

std::string manual_head(const std::string& title, const std::string& about) {
  return fmt::format(".TH {} 1 \"\" \"brim {}\" \"brim\"\n.SH NAME\n{} \\- {}\n", title, BRIM_VERSION, roff(title),
                     roff(about));
}

constexpr const char* kExitStatus =
    ".SH EXIT STATUS\n.TP\n0\nall went well\n.TP\n1\na step failed, an expectation was not met, or brim has a defect\n"
    ".TP\n2\nthe command line, the scene or a file is wrong; the message says what\n.TP\n130\nCtrl\\-C\n";

std::string manual(const CLI::App& app, const CLI::App* command) {
  if (command) {
    std::string positional;
    for (const CLI::Option* o : shown_options(*command))
      if (o->get_positional())
        positional +=
            fmt::format(fmt::runtime(o->get_required() ? " \\fI{}\\fR" : " [\\fI{}\\fR]"), roff(o->get_name(true)));
    return manual_head("brim-" + command->get_name(), command->get_description()) +
           fmt::format(".SH SYNOPSIS\n\\fBbrim {}\\fR [options]{}\n.SH OPTIONS\n{}{}.SH SEE ALSO\nbrim(1)\n",
                       command->get_name(), positional, roff_options(*command), kExitStatus);
  }
  std::string commands;
  for (const CLI::App* c : shown_commands(app))
    commands += fmt::format(".TP\n\\fBbrim\\-{}\\fR(1)\n{}\n", c->get_name(), roff(c->get_description()));
  return manual_head("brim", "bodies of any kind in contact through a grid of densities") +
         fmt::format(
             ".SH SYNOPSIS\n\\fBbrim\\fR [\\-\\-plugin FILE] \\fIcommand\\fR ...\n.SH COMMANDS\n{}.SH OPTIONS\n{}{}",
             commands, roff_options(app), kExitStatus);
}

}  // namespace

void add_describe(CLI::App& app, int& code) {
  CLI::App* completion = app.add_subcommand("completion", "print the script that completes brim's words in a shell");
  auto shell = std::make_shared<std::string>();
  completion->add_option("shell", *shell, "bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  completion->callback([&app, shell, &code] {
    std::fputs((*shell == "bash" ? bash(app) : *shell == "zsh" ? zsh(app) : fish(app)).c_str(), stdout);
    code = kGood;
  });
  CLI::App* page = app.add_subcommand("manual", "print the page for man of brim, or of a command");
  auto name = std::make_shared<std::string>();
  page->add_option("command", *name, "one of the commands");
  page->callback([&app, name, &code] {
    const CLI::App* command = nullptr;
    for (const CLI::App* c : shown_commands(app))
      if (c->get_name() == *name) command = c;
    if (!command && !name->empty())
      throw InputError(fmt::format("\"{}\" is not a command; brim help lists them", *name));
    std::fputs(manual(app, command).c_str(), stdout);
    code = kGood;
  });
}

}  // namespace brim::cli
