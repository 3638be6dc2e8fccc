#include "brim/body/particles/body_pieces.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

/// [thicknesses] ways along the body: between matter that may touch, from the first element of a piece to its others,
/// and of the border around it, which a stencil of contact reaches half a thickness into.
constexpr double kBeside = 2.5, kOfPiece = 1.5, kBorder = 0.75;
/// [rad] from a common direction up to which neighbours cannot touch.
constexpr double kFlatTurn = std::numbers::pi / 3.0;

double angle_between(const Vec3& a, const Vec3& b) { return std::acos(std::clamp(a.dot(b), -1.0, 1.0)); }

Eigen::Map<const Vec3> velocity(std::span<const double> v, std::int32_t node) {
  return Eigen::Map<const Vec3>(v.data() + 3 * static_cast<std::size_t>(node));
}

}  // namespace

BodyPieces::BodyPieces(std::span<const Vec3> rest, const ParticleContact& whole, PartInfo part)
    : cut_(rest, whole.elements(), {kOfPiece * part.thickness, kBeside * part.thickness, kBorder * part.thickness}),
      piece_(cut_.size()),
      part_(std::move(part)) {
  const ParticleContact::Elements all = whole.elements();
  const auto corners = static_cast<std::size_t>(all.per_element);
  for (std::size_t p = 0; p < piece_.size(); ++p) {
    piece_[p].own = whole.piece(cut_.of(p));
    BRIM_CHECK(piece_[p].own != nullptr, ==, true);
    // Ascending, so that of elements that are as near each piece names the same.
    std::vector<std::int32_t>& source = piece_[p].source;
    std::ranges::merge(cut_.of(p), cut_.border(p), std::back_inserter(source));
    piece_[p].bordered = whole.piece(source);
    for (std::int32_t& e : source)
      if (!std::ranges::binary_search(cut_.of(p), e)) e = -1;
    auto& nodes = piece_[p].nodes;
    for (const std::int32_t e : cut_.of(p))
      for (std::size_t k = 0; k < corners; ++k) nodes.push_back(all.node[corners * static_cast<std::size_t>(e) + k]);
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  }
  follow(rest);
}

Vec3 BodyPieces::direction(const ParticleContact::Elements& elements, std::size_t e) const {
  const auto corners = static_cast<std::size_t>(elements.per_element);
  const auto x = [&](std::size_t k) -> const Vec3& { return x_[elements.node[corners * e + k]]; };
  const Vec3 d = corners == 3 ? Vec3((x(1) - x(0)).cross(x(2) - x(0))) : Vec3(x(1) - x(0));
  const double length = d.norm();
  return length > 0.0 ? Vec3(d / length) : Vec3(Vec3::Zero());
}

void BodyPieces::follow(std::span<const Vec3> x) {
  x_ = x;
  parallel_for(
      piece_.size(),
      [&](std::size_t p) {
        Piece& piece = piece_[p];
        piece.box = Aabb{};
        for (const std::int32_t i : piece.nodes) piece.box.extend(x_[i]);
        piece.box = piece.box.inflated(piece.own->reach());
        const ParticleContact::Elements own = piece.own->elements();
        const std::size_t n = own.node.size() / static_cast<std::size_t>(own.per_element);
        Vec3 sum = Vec3::Zero();
        for (std::size_t e = 0; e < n; ++e) sum += direction(own, e);
        piece.axis = sum.norm() > 0.0 ? Vec3(sum.normalized()) : Vec3(Vec3::UnitX());
        piece.turn = 0.0;
        for (std::size_t e = 0; e < n; ++e)
          piece.turn = std::max(piece.turn, angle_between(piece.axis, direction(own, e)));
      },
      16);
}

std::int32_t BodyPieces::source_of(int piece, std::int32_t source) const {
  return piece_[static_cast<std::size_t>(piece)].source[static_cast<std::size_t>(source)];
}

bool BodyPieces::parts_collide(int p, int q) const {
  if (p == q) return false;
  if (!cut_.pieces_beside(p, q)) return true;
  const Piece &a = piece_[p], &b = piece_[q];
  return 0.5 * angle_between(a.axis, b.axis) + std::max(a.turn, b.turn) > kFlatTurn;
}

Vec3 BodyPieces::mean_velocity(int p, std::span<const double> v) const {
  Vec3 sum = Vec3::Zero();
  for (const std::int32_t i : piece_[p].nodes) sum += velocity(v, i);
  return sum / static_cast<double>(piece_[p].nodes.size());
}

double BodyPieces::relative_speed_bound(int p, std::span<const double> v) const {
  const Vec3 mean = mean_velocity(p, v);
  double most = 0.0;
  for (const std::int32_t i : piece_[p].nodes) most = std::max(most, (velocity(v, i) - mean).squaredNorm());
  return std::sqrt(most);
}

void BodyPieces::presence(int p, double h, double w, const Aabb& region, std::vector<TileKey>& out) const {
  piece_[p].own->presence(x_, h, w, region, out);
}

void BodyPieces::octant_presence(int p, double h, double w, const Aabb& region, std::vector<OctantTile>& out) const {
  piece_[p].own->octant_presence(x_, h, w, region, out);
}

void BodyPieces::rasterize(int p, double h, double w, std::span<const TileKey> tiles,
                           std::span<DensityBlock> out) const {
  piece_[p].bordered->rasterize(x_, h, w, tiles, out);
}

void BodyPieces::make_map(int, std::span<const Vec3>, std::span<const std::int32_t>, std::unique_ptr<Map>&) const {
  throw InputError("pieces of a body have no maps of their own");
}

}  // namespace brim
