#include "brim/scene/body_names.h"

namespace brim {

void need_body(const Node& n, const std::string& name, const std::set<std::string>& bodies) {
  if (bodies.contains(name)) return;
  const std::string near = nearest_word(name, bodies);
  throw n.error(fmt::format("\"{}\" is not a body of this scene{}; must be the name of one", name,
                            near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
}

}  // namespace brim
