#pragma once

#include <memory>

#include "brim/map/map.h"

namespace brim {

/// A map of the given type, to be refilled; its memory is kept when `map` already holds that type.
template <class M>
M& reuse_map(std::unique_ptr<Map>& map) {
  if (auto* same = dynamic_cast<M*>(map.get())) return *same;
  auto made = std::make_unique<M>();
  M& m = *made;
  map = std::move(made);
  return m;
}

}  // namespace brim
