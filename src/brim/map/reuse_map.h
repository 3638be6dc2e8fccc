#pragma once

#include <memory>

#include "brim/map/map.h"

namespace brim {

/// The map of the given type to be filled anew; memory is kept when it was of that type before.
template <class M>
M& reuse_map(std::unique_ptr<Map>& map) {
  if (auto* same = dynamic_cast<M*>(map.get())) return *same;
  auto made = std::make_unique<M>();
  M& m = *made;
  map = std::move(made);
  return m;
}

}  // namespace brim
