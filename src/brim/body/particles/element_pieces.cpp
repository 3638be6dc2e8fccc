#include "brim/body/particles/element_pieces.h"

#include <algorithm>
#include <limits>
#include <queue>
#include <utility>

#include "brim/core/parallel.h"

namespace brim {

namespace {

/// The ways between elements that share a particle.
class Paths {
 public:
  Paths(std::span<const Vec3> rest, const ParticleContact::Elements& elements)
      : elements_(elements),
        corners_(static_cast<std::size_t>(elements.per_element)),
        middle_(elements.node.size() / corners_, Vec3::Zero()),
        radius_(middle_.size(), 0.0),
        first_(rest.size() + 1, 0) {
    for (const std::int32_t i : elements.node) ++first_[static_cast<std::size_t>(i) + 1];
    for (std::size_t i = 0; i < rest.size(); ++i) first_[i + 1] += first_[i];
    around_.resize(elements.node.size());
    std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t k = 0; k < elements.node.size(); ++k)
      around_[next[elements.node[k]]++] = static_cast<std::int32_t>(k / corners_);
    for (std::size_t e = 0; e < middle_.size(); ++e) {
      for (const std::int32_t i : nodes(e)) middle_[e] += rest[i] / static_cast<double>(corners_);
      for (const std::int32_t i : nodes(e)) radius_[e] = std::max(radius_[e], (rest[i] - middle_[e]).norm());
    }
  }

  std::size_t size() const { return middle_.size(); }
  /// [m] that an element reaches from its middle.
  double radius(std::size_t e) const { return radius_[e]; }
  double largest_radius() const { return radius_.empty() ? 0.0 : *std::max_element(radius_.begin(), radius_.end()); }

  struct Scratch {
    std::vector<double> way;
    std::vector<std::int32_t> seen;
  };
  /// Calls f(e, way) for the elements whose way from one is at most `limit` [m], nearest first.
  template <class F>
  void from(std::int32_t start, double limit, Scratch& s, const F& f) const {
    s.way.resize(size(), std::numeric_limits<double>::infinity());
    using Entry = std::pair<double, std::int32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    const auto reach = [&](std::int32_t e, double way) {
      if (!(way < s.way[e]) || way > limit) return;
      if (s.way[e] == std::numeric_limits<double>::infinity()) s.seen.push_back(e);
      s.way[e] = way;
      queue.emplace(way, e);
    };
    reach(start, 0.0);
    while (!queue.empty()) {
      const auto [way, e] = queue.top();
      queue.pop();
      if (way > s.way[e]) continue;
      f(e, way);
      for (const std::int32_t i : nodes(static_cast<std::size_t>(e)))
        for (std::int32_t k = first_[i]; k < first_[i + 1]; ++k)
          reach(around_[k], way + (middle_[around_[k]] - middle_[e]).norm());
    }
    for (const std::int32_t e : s.seen) s.way[e] = std::numeric_limits<double>::infinity();
    s.seen.clear();
  }

 private:
  std::span<const std::int32_t> nodes(std::size_t e) const { return elements_.node.subspan(corners_ * e, corners_); }

  ParticleContact::Elements elements_;
  std::size_t corners_;
  std::vector<Vec3> middle_;
  std::vector<double> radius_;
  std::vector<std::int32_t> first_, around_;  ///< elements around each particle
};

/// Lists one after the other.
void join(const std::vector<std::vector<std::int32_t>>& lists, std::vector<std::int32_t>& first,
          std::vector<std::int32_t>& all) {
  first.assign(1, 0), all.clear();
  for (const auto& list : lists) {
    all.insert(all.end(), list.begin(), list.end());
    first.push_back(static_cast<std::int32_t>(all.size()));
  }
}

void sort_unique(std::vector<std::int32_t>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

constexpr std::size_t kElementsOfWork = 256;

}  // namespace

ElementPieces::ElementPieces(std::span<const Vec3> rest, const ParticleContact::Elements& elements, const Ways& ways) {
  const Paths paths(rest, elements);
  const std::size_t n = paths.size();
  const double largest = paths.largest_radius();
  std::vector<std::vector<std::int32_t>> beside_of(n), near(n);
  parallel_blocks(n, kElementsOfWork, [&](std::size_t begin, std::size_t end) {
    Paths::Scratch scratch;
    for (std::size_t e = begin; e < end; ++e) {
      paths.from(static_cast<std::int32_t>(e), ways.beside + paths.radius(e) + largest, scratch,
                 [&](std::int32_t f, double way) {
                   const double left = way - paths.radius(e) - paths.radius(static_cast<std::size_t>(f));
                   if (left < ways.beside) beside_of[e].push_back(f);
                   if (left < ways.border) near[e].push_back(f);
                 });
      std::sort(beside_of[e].begin(), beside_of[e].end());
    }
  });
  join(beside_of, first_beside_, beside_);

  // The first element that no piece reaches begins a new one; each belongs to the piece whose first is nearest.
  std::vector<std::int32_t> piece(n, -1);
  std::vector<double> way_to(n, std::numeric_limits<double>::infinity());
  std::int32_t count = 0;
  Paths::Scratch scratch;
  for (std::size_t e = 0; e < n; ++e) {
    if (piece[e] >= 0) continue;
    paths.from(static_cast<std::int32_t>(e), ways.reach, scratch, [&](std::int32_t f, double way) {
      if (way < way_to[f]) way_to[f] = way, piece[f] = count;
    });
    ++count;
  }
  std::vector<std::vector<std::int32_t>> members(static_cast<std::size_t>(count)), touching(members.size()),
      around(members.size());
  for (std::size_t e = 0; e < n; ++e) {
    members[piece[e]].push_back(static_cast<std::int32_t>(e));
    for (const std::int32_t f : beside_of[e])
      if (piece[f] != piece[e]) touching[piece[e]].push_back(piece[f]);
    for (const std::int32_t f : near[e])
      if (piece[f] != piece[e]) around[piece[e]].push_back(f);
  }
  for (std::size_t p = 0; p < members.size(); ++p) {
    // Others are listed once per pair of elements beside each other.
    std::vector<std::int32_t>& list = touching[p];
    std::sort(list.begin(), list.end());
    for (std::size_t i = 0, next = 0; i < list.size(); i = next) {
      while (next < list.size() && list[next] == list[i]) ++next;
      how_.push_back(next - i == members[p].size() * members[list[i]].size() ? Beside::All : Beside::Some);
    }
    sort_unique(list);
  }
  for (auto& list : around) sort_unique(list);
  join(members, first_, element_);
  join(touching, first_touching_, touching_);
  join(around, first_border_, border_);
}

bool ElementPieces::elements_beside(std::int32_t e, std::int32_t f) const {
  return std::ranges::binary_search(list(first_beside_, beside_, static_cast<std::size_t>(e)), f);
}

ElementPieces::Beside ElementPieces::pieces_beside(std::int32_t p, std::int32_t q) const {
  const auto others = list(first_touching_, touching_, static_cast<std::size_t>(p));
  const auto at = std::ranges::lower_bound(others, q);
  return at == others.end() || *at != q ? Beside::None : how_[static_cast<std::size_t>(&*at - touching_.data())];
}

}  // namespace brim
