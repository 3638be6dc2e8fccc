#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/particles/particle_contact.h"

namespace brim {

/// The elements of a sheet or a line in pieces of neighbours, by path lengths along the body at rest, between centres
/// of elements that share a particle (Dijkstra 1959). Layers of a folded sheet, near only in space, are not neighbours.
/// Tests: tests/body/element_pieces_test.cpp
class ElementPieces {
 public:
  struct Ways {
    double reach;   ///< [m] radius of a piece from its first element
    double beside;  ///< [m] elements with a shorter path between them are beside each other
    double border;  ///< [m] likewise for elements of others in a piece's border; at most `beside`
  };
  /// @param rest  [m] of the particles
  ElementPieces(std::span<const Vec3> rest, const ParticleContact::Elements& elements, const Ways& ways);

  std::size_t size() const { return first_.size() - 1; }
  /// Elements of a piece, ascending.
  std::span<const std::int32_t> of(std::size_t piece) const { return list(first_, element_, piece); }
  /// Elements of others in the border of a piece, ascending.
  std::span<const std::int32_t> border(std::size_t piece) const { return list(first_border_, border_, piece); }
  bool elements_beside(std::int32_t e, std::int32_t f) const;
  enum class Beside : std::uint8_t { None, Some, All };
  /// How many pairs of elements of two pieces are beside each other.
  Beside pieces_beside(std::int32_t p, std::int32_t q) const;

 private:
  using List = std::vector<std::int32_t>;
  static std::span<const std::int32_t> list(const List& first, const List& of, std::size_t i) {
    return std::span(of).subspan(static_cast<std::size_t>(first[i]), static_cast<std::size_t>(first[i + 1] - first[i]));
  }

  List first_, element_;            ///< elements by piece
  List first_beside_, beside_;      ///< elements beside each element, ascending
  List first_touching_, touching_;  ///< pieces beside each piece, ascending
  std::vector<Beside> how_;         ///< Some or All, of each entry of `touching_`
  List first_border_, border_;      ///< elements around each piece
};

}  // namespace brim
