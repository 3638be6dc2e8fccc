#include "brim/body/particles/body_pieces.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/math/least_distance.h"

namespace brim {

namespace {

/// [thicknesses] ways along the body: between matter that may touch, from the first element of a piece to its others,
/// and of the border around it, which a stencil of contact reaches half a thickness into.
constexpr double kBeside = 2.5, kOfPiece = 1.5, kBorder = 0.75;
/// [rad] from a common direction up to which neighbours cannot touch.
constexpr double kFlatTurn = std::numbers::pi / 3.0;

/// Pairs of elements of two pieces that are looked at one by one.
constexpr std::size_t kMostElementPairs = 1024;

bool contains(const Aabb& box, const Aabb& other) {
  return (box.lo.array() <= other.lo.array()).all() && (other.hi.array() <= box.hi.array()).all();
}

double angle_between(const Vec3& a, const Vec3& b) { return std::acos(std::clamp(a.dot(b), -1.0, 1.0)); }

Eigen::Map<const Vec3> velocity(std::span<const double> v, std::int32_t node) {
  return Eigen::Map<const Vec3>(v.data() + 3 * static_cast<std::size_t>(node));
}

}  // namespace

BodyPieces::BodyPieces(std::span<const Vec3> rest, const ParticleContact& whole, PartInfo part)
    : cut_(rest, whole.elements(), {kOfPiece * part.thickness, kBeside * part.thickness, kBorder * part.thickness}),
      piece_(cut_.size()),
      reach_(whole.reach()),
      all_(whole.elements()),
      part_(std::move(part)) {
  const auto corners = static_cast<std::size_t>(all_.per_element);
  element_box_.resize(all_.node.size() / corners);
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
      for (std::size_t k = 0; k < corners; ++k) nodes.push_back(all_.node[corners * static_cast<std::size_t>(e) + k]);
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
        const ParticleContact::Elements own = piece.own->elements();
        const auto corners = static_cast<std::size_t>(own.per_element);
        const std::size_t n = own.node.size() / corners;
        piece.box = Aabb{};
        for (std::size_t e = 0; e < n; ++e) {
          Aabb box;
          for (const std::int32_t i : own.node.subspan(corners * e, corners)) box.extend(x_[i]);
          element_box_[cut_.of(static_cast<std::size_t>(p))[e]] = box;
          piece.box.extend(box);
        }
        piece.box = piece.box.inflated(reach_);
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
  if (cut_.pieces_beside(p, q) == ElementPieces::Beside::None) return true;
  const Piece &a = piece_[p], &b = piece_[q];
  return 0.5 * angle_between(a.axis, b.axis) + std::max(a.turn, b.turn) > kFlatTurn;
}

Aabb BodyPieces::meeting_region(int p, int q, double beyond, double gap) const {
  if (cut_.pieces_beside(p, q) == ElementPieces::Beside::All) return {};
  // A place where two elements touch is at most so far from each, and from both together.
  const double from_one = reach_ + std::min(beyond, gap + reach_), from_both = 2.0 * reach_ + gap;
  // The elements of each piece that come near the other.
  const auto box_of = [&](std::span<const std::int32_t> elements) {
    Aabb box;
    for (const std::int32_t e : elements) box.extend(element_box_[e]);
    return box.inflated(from_one);
  };
  const auto near = [&](int own, const Aabb& other) {
    std::vector<std::int32_t> found;
    for (const std::int32_t e : cut_.of(static_cast<std::size_t>(own)))
      if (element_box_[e].inflated(from_one).overlaps(other)) found.push_back(e);
    return found;
  };
  const std::vector<std::int32_t> of_p = near(p, box_of(cut_.of(static_cast<std::size_t>(q)))),
                                  of_q = near(q, box_of(of_p));
  if (of_p.size() * of_q.size() > kMostElementPairs) return box_of(of_p).intersection(box_of(of_q));
  // Their pairs that may touch.
  Aabb region;
  for (const std::int32_t e : of_p)
    for (const std::int32_t f : of_q) {
      const Aabb &a = element_box_[e], &b = element_box_[f];
      const Vec3 apart = (a.lo - b.hi).cwiseMax(b.lo - a.hi).cwiseMax(0.0);
      if (apart.squaredNorm() > from_both * from_both) continue;
      const Aabb place = a.inflated(from_one).intersection(b.inflated(from_one));
      if (contains(region, place) || !may_meet(e, f)) continue;
      Corners of_e, of_f;
      if (least_distance(corners_of(e, of_e), corners_of(f, of_f), from_both) <= from_both) region.extend(place);
    }
  return region;
}

std::span<const Vec3> BodyPieces::corners_of(std::int32_t e, Corners& x) const {
  const auto n = static_cast<std::size_t>(all_.per_element);
  for (std::size_t k = 0; k < n; ++k) x[k] = x_[all_.node[n * static_cast<std::size_t>(e) + k]];
  return std::span(x).first(n);
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
  // Places of which all belong to other pieces are theirs to search.
  for (DensityBlock& block : out)
    for (int o = 0; o < 8; ++o)
      if ((block.octants >> o & 1) && !owns_any(p, block, o)) block.octants &= static_cast<Octants>(~(1 << o));
}

bool BodyPieces::owns_any(int p, const DensityBlock& block, int octant) const {
  constexpr int kOctant = kTileSize / 2;
  const int i = kHalo + kOctant * (octant & 1), j = kHalo + kOctant * (octant >> 1 & 1),
            k = kHalo + kOctant * (octant >> 2);
  const std::vector<std::int32_t>& source = piece_[static_cast<std::size_t>(p)].source;
  for (int dk = 0; dk < kOctant; ++dk)
    for (int dj = 0; dj < kOctant; ++dj) {
      const int row = block_index(i, j + dj, k + dk);
      for (int n = row; n < row + kOctant; ++n)
        if (block.rho[n] > 0.0 && source[static_cast<std::size_t>(block.source[n])] >= 0) return true;
    }
  return false;
}

void BodyPieces::make_map(int, std::span<const Vec3>, std::span<const std::int32_t>, std::unique_ptr<Map>&) const {
  throw InputError("pieces of a body have no maps of their own");
}

}  // namespace brim
