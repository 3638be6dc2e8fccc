#include <cstdio>

#include "brim/scene/scene.h"
#include "commands.h"

namespace brim::cli {

void add_schema(CLI::App& app, int& code) {
  CLI::App* command = app.add_subcommand("schema", "print the JSON Schema of scene files");
  command->callback([&code] {
    std::fputs(known_schema_text().c_str(), stdout);
    code = kGood;
  });
}

}  // namespace brim::cli
