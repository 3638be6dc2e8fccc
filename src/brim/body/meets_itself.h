#pragma once

#include <cstdint>

namespace brim {

class Body;

/// Optional interface of bodies with self-contact: a body in pieces, which touch each other unless they are neighbours
/// (paper, section 8).
class MeetsItself {
 public:
  virtual ~MeetsItself() = default;
  /// A body whose parts are the pieces of part 0 of this one at its last update, or null for no self-contact. Its
  /// velocities are those of this body; only functions that contact calls before maps are made may be used.
  virtual const Body* pieces() const = 0;
  /// Source for make_map of part 0 of a point of a piece; −1 when another piece is nearer, which then reports it.
  /// @param source  as written by the piece's rasterize
  virtual std::int32_t source_of(int piece, std::int32_t source) const = 0;
  /// False for neighbouring sources along the body, which always touch.
  virtual bool may_meet(std::int32_t source, std::int32_t other) const = 0;
};

}  // namespace brim
