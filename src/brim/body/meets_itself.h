#pragma once

#include <cstdint>

namespace brim {

class Body;

/// Optional interface of bodies that may touch themselves: a body in pieces, which touch each other where they are not
/// neighbours (the paper's section 8).
class MeetsItself {
 public:
  virtual ~MeetsItself() = default;
  /// A body whose parts are the pieces of part 0 of this one as of its last update, or null: it does not touch itself.
  /// Its velocities are those of this one; only what contact asks for before maps are made may be called.
  virtual const Body* pieces() const = 0;
  /// What a piece says of a point, as make_map of part 0 takes it; −1 where another piece lies nearer, which says it.
  /// @param source  as its rasterize wrote it
  virtual std::int32_t source_of(int piece, std::int32_t source) const = 0;
  /// False for sources that lie side by side along the body: they touch at all times.
  virtual bool may_meet(std::int32_t source, std::int32_t other) const = 0;
};

}  // namespace brim
