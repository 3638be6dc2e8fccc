#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/meeting_region.h"
#include "brim/body/octant_presence.h"
#include "brim/body/particles/element_pieces.h"
#include "brim/body/stand_in.h"

namespace brim {

/// Pieces of a sheet or a line of particles, for its self-contact (MeetsItself): part p is piece p, with a density of
/// its own. Matter of a body of thickness t may touch matter at least 2.5 t away along the body. Neighbouring pieces
/// are searched only where their directions deviate by more than 60° from their common mean: up to that, points 2.5 t
/// apart along the body are t apart in space (Volino and Magnenat-Thalmann 1994, with a cone of 90°). Within a piece,
/// at most 3 t wide, nothing touches. The density of a piece includes a border around it, so that its slope at the rim
/// is that of the whole; points nearest to the border are left to the piece that owns it, and octants with no other
/// points are taken back (DensityBlock::octants). Of two pieces only the region is searched in which some of their
/// elements, not neighbours along the body, are near each other: a cell wider than the thickness is a piece by itself,
/// and at every fold many of them overlap with the neighbours of their neighbours.
/// Tests: tests/body/body_pieces_test.cpp
class BodyPieces final : public StandIn, public OctantPresence, public MeetingRegion {
 public:
  /// @param rest   [m] of the particles
  /// @param whole  the body's contact, of elements that are triangles or segments; kept by reference
  /// @param part   contact parameters of the body; its thickness is finite
  BodyPieces(std::span<const Vec3> rest, const ParticleContact& whole, PartInfo part);

  /// Sets the body's positions. @param x  [m] of its particles; kept by reference
  void follow(std::span<const Vec3> x);
  /// See MeetsItself.
  std::int32_t source_of(int piece, std::int32_t source) const;
  bool may_meet(std::int32_t source, std::int32_t other) const { return !cut_.elements_beside(source, other); }

  std::string_view kind() const override { return "piece"; }
  int part_count() const override { return static_cast<int>(piece_.size()); }
  PartInfo part(int) const override { return part_; }
  bool parts_collide(int p, int q) const override;
  Aabb meeting_region(int p, int q, double beyond, double gap) const override;
  Aabb bounds(int p) const override { return piece_[p].box; }
  Vec3 mean_velocity(int p, std::span<const double> v) const override;
  double relative_speed_bound(int p, std::span<const double> v) const override;
  void presence(int p, double h, double w, const Aabb& region, std::vector<TileKey>& out) const override;
  void octant_presence(int p, double h, double w, const Aabb& region, std::vector<OctantTile>& out) const override;
  void rasterize(int p, double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const override;

  // ---- properties of the whole body; not called for its pieces
  void make_map(int, std::span<const Vec3>, std::span<const std::int32_t>, std::unique_ptr<Map>& map) const override;
  double mass() const override { return 0.0; }

 private:
  struct Piece {
    std::unique_ptr<const ParticleContact> own, bordered;
    std::vector<std::int32_t> source;  ///< per element of bordered: its number in the body, or −1
    std::vector<std::int32_t> nodes;   ///< of its own elements
    Aabb box;                          ///< [m] of its own matter
    Vec3 axis = Vec3::Zero();          ///< mean direction of its elements
    double turn = 0.0;                 ///< [rad] largest deviation of an element's direction from it
  };
  /// True when a node of the octant's own is nearest to an element of the piece.
  bool owns_any(int p, const DensityBlock& block, int octant) const;
  using Corners = std::array<Vec3, 3>;
  /// Those of an element of the body. @param x  where they are put
  std::span<const Vec3> corners_of(std::int32_t e, Corners& x) const;
  /// Normal of a triangle, or direction of a segment; zero when degenerate.
  Vec3 direction(const ParticleContact::Elements& elements, std::size_t e) const;

  ElementPieces cut_;
  std::vector<Piece> piece_;
  std::vector<Aabb> element_box_;  ///< [m] of the corners of each element
  double reach_;                   ///< [m] of matter beyond them
  ParticleContact::Elements all_;  ///< of the body
  PartInfo part_;
  std::span<const Vec3> x_;
};

}  // namespace brim
