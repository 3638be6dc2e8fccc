#include "commands.h"
#include "commit.h"

namespace brim::cli {

const std::string& version_text() {
  static const std::string commit = BRIM_COMMIT;
  static const std::string text = BRIM_VERSION + (commit.empty() ? "" : " (" + commit + ")");
  return text;
}

}  // namespace brim::cli
