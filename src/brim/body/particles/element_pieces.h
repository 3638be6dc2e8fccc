#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/particles/particle_contact.h"

namespace brim {

/// The elements of a sheet or a line in pieces of neighbours, by ways along the body at rest: from middle to middle of
/// elements that share a particle (Dijkstra 1959). What is near in space alone, as the layers of a folded sheet, is not
/// near here.  Tests: tests/body/element_pieces_test.cpp
class ElementPieces {
 public:
  struct Ways {
    double reach;   ///< [m] of a piece from its first element
    double beside;  ///< [m] elements between which less is left of a way are beside each other
    double border;  ///< [m] likewise those of others that a piece has around it; at most `beside`
  };
  /// @param rest  [m] of the particles
  ElementPieces(std::span<const Vec3> rest, const ParticleContact::Elements& elements, const Ways& ways);

  std::size_t size() const { return first_.size() - 1; }
  /// Elements of a piece, ascending.
  std::span<const std::int32_t> of(std::size_t piece) const { return list(first_, element_, piece); }
  /// Elements of others around a piece, ascending.
  std::span<const std::int32_t> border(std::size_t piece) const { return list(first_border_, border_, piece); }
  bool elements_beside(std::int32_t e, std::int32_t f) const;
  /// True for pieces of which some elements are beside each other.
  bool pieces_beside(std::int32_t p, std::int32_t q) const;

 private:
  using List = std::vector<std::int32_t>;
  static std::span<const std::int32_t> list(const List& first, const List& of, std::size_t i) {
    return std::span(of).subspan(static_cast<std::size_t>(first[i]), static_cast<std::size_t>(first[i + 1] - first[i]));
  }

  List first_, element_;            ///< elements by piece
  List first_beside_, beside_;      ///< elements beside each element, ascending
  List first_touching_, touching_;  ///< pieces beside each piece, ascending
  List first_border_, border_;      ///< elements around each piece
};

}  // namespace brim
