#pragma once

#include <span>
#include <vector>

#include "brim/body/posed_shape.h"

namespace brim {

/// Optional interface of bodies whose display moves in rigid pieces. The display's vertices are those of the pieces'
/// surfaces, concatenated, each at
///   x = R_i r + t_i,   r: vertex of piece i in its shape's frame, (R_i, t_i): its pose in the last updated state
/// Records store r once and the poses of every frame, and measures need not visit every vertex.
/// Tests: tests/record/posed_display_test.cpp
class PosedDisplay {
 public:
  virtual ~PosedDisplay() = default;
  virtual std::size_t piece_count() const = 0;
  virtual const PosedShape& piece(std::size_t i) const = 0;
};

/// The body's pieces, or null when its display deforms.
const PosedDisplay* posed_display(const Body& body);

/// x = R r + t, rounded to float. @param x  [m], shape (rest.size())
void place_vertices(std::span<const Vec3> rest, const Pose& pose, std::span<Vec3f> x);

}  // namespace brim
