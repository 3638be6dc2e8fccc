#include "brim/world/contact_maps.h"

#include <algorithm>
#include <utility>

#include "brim/core/parallel.h"
#include "brim/core/profile.h"

namespace brim {

namespace {

/// Contacts processed by one thread at a time.
constexpr std::size_t kContactsOfStretch = 512;

const SparseMap* sparse(const Map& map) { return dynamic_cast<const SparseMap*>(&map); }

}  // namespace

template <class F>
void ContactMaps::for_movable(const F& f) const {
  parallel_for(first_side_.size() - 1, [&](std::size_t b) {
    for (std::size_t p = first_side_[b]; p < first_side_[b + 1]; ++p)
      if (side_[p].movable && side_[p].begin < side_[p].end) f(side_[p]);
  });
}

void ContactMaps::build(std::span<const WorldPart> parts, const ContactSet& contacts,
                        std::span<const std::size_t> first_v, std::span<const std::uint8_t> chosen,
                        const ContactMaps* all) {
  side_.resize(parts.size());
  first_side_.assign(first_v.size(), 0);
  for (const WorldPart& p : parts) ++first_side_[p.body_index + 1];
  for (std::size_t b = 1; b < first_side_.size(); ++b) first_side_[b] += first_side_[b - 1];
  // Ranges of a pair's contacts, and destinations of their chosen ones.
  struct Stretch {
    std::size_t pair, begin, end, chosen = 0, row_a = 0, row_b = 0;
  };
  std::vector<Stretch> stretch;
  for (std::size_t p = 0; p < contacts.pairs.size(); ++p)
    for (std::size_t c = contacts.pairs[p].begin; c < contacts.pairs[p].end; c += kContactsOfStretch)
      stretch.push_back({p, c, std::min(c + kContactsOfStretch, contacts.pairs[p].end)});
  const auto is_chosen = [&](std::size_t c) { return chosen.empty() || chosen[c] != 0; };
  parallel_for(
      stretch.size(),
      [&](std::size_t k) {
        for (std::size_t c = stretch[k].begin; c < stretch[k].end; ++c) stretch[k].chosen += is_chosen(c);
      },
      4);
  std::vector<std::size_t> count(parts.size() + 1, 0);
  for (const Stretch& k : stretch) {
    count[contacts.pairs[k.pair].part_a + 1] += k.chosen;
    count[contacts.pairs[k.pair].part_b + 1] += k.chosen;
  }
  std::size_t n = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    count[p + 1] += count[p];
    Side& s = side_[p];
    s.begin = count[p];
    s.end = count[p + 1];
    s.movable = !is_fixed(parts[p]);
    if (s.of != parts[p].body) s.map.reset(), s.of = parts[p].body;
    s.body = parts[p].body_index;
    s.first_v = first_v[s.body];
    s.v_size = first_v[s.body + 1] - s.first_v;
  }
  std::vector<std::size_t> next(count.begin(), count.end() - 1);
  for (Stretch& k : stretch) {
    const ContactPair& pair = contacts.pairs[k.pair];
    k.row_a = std::exchange(next[pair.part_a], next[pair.part_a] + k.chosen);
    k.row_b = std::exchange(next[pair.part_b], next[pair.part_b] + k.chosen);
    k.chosen = std::exchange(n, n + k.chosen);
  }
  chosen_.resize(n), contact_.resize(2 * n), point_.resize(2 * n), source_.resize(2 * n);
  whole_.resize(all != nullptr ? 2 * n : 0);
  row_a_.resize(n), row_b_.resize(n), part_a_.resize(n), part_b_.resize(n), row_vector_.resize(2 * n),
      row_matrix_.resize(2 * n);
  parallel_for(
      stretch.size(),
      [&](std::size_t k) {
        const ContactPair& pair = contacts.pairs[stretch[k].pair];
        std::size_t i = stretch[k].chosen, a = stretch[k].row_a, b = stretch[k].row_b;
        for (std::size_t c = stretch[k].begin; c < stretch[k].end; ++c) {
          if (!is_chosen(c)) continue;
          chosen_[i] = static_cast<std::uint32_t>(c);
          row_a_[i] = static_cast<std::uint32_t>(a), row_b_[i] = static_cast<std::uint32_t>(b);
          part_a_[i] = pair.part_a, part_b_[i] = pair.part_b;
          contact_[a] = contact_[b] = static_cast<std::uint32_t>(c);
          point_[a] = contacts.point[c], point_[b] = contacts.point_b(c);
          source_[a] = contacts.source_a[c], source_[b] = contacts.source_b[c];
          if (all != nullptr) {
            whole_[a] = all->row_a_[c] - static_cast<std::uint32_t>(all->side_[pair.part_a].begin);
            whole_[b] = all->row_b_[c] - static_cast<std::uint32_t>(all->side_[pair.part_b].begin);
          }
          ++i, ++a, ++b;
        }
      },
      4);
  parallel_for(parts.size(), [&](std::size_t p) {
    Side& s = side_[p];
    if (s.begin == s.end) return;
    if (all != nullptr && all->side_[p].map->select(std::span(whole_).subspan(s.begin, s.end - s.begin), s.map)) return;
    const ProfileScope scope("maps", *parts[p].body);
    parts[p].body->make_map(parts[p].index, std::span(point_).subspan(s.begin, s.end - s.begin),
                            std::span(source_).subspan(s.begin, s.end - s.begin), s.map);
  });
}

bool ContactMaps::serves(std::span<const std::uint8_t> chosen) const {
  std::size_t held = 0;
  for (const std::uint32_t c : chosen_) held += chosen[c] != 0;
  const auto wanted = static_cast<std::size_t>(std::count_if(chosen.begin(), chosen.end(), [](auto f) { return f; }));
  return held == wanted && 4 * chosen_.size() <= 5 * wanted;
}

void ContactMaps::velocities(std::span<const double> v, std::span<Vec3> a, std::span<Vec3> b) const {
  parallel_for(side_.size(), [&](std::size_t p) {
    const Side& s = side_[p];
    if (s.begin < s.end)
      s.map->apply(v.subspan(s.first_v, s.v_size), std::span(row_vector_).subspan(s.begin, s.end - s.begin));
  });
  parallel_for(
      a.size(),
      [&](std::size_t c) {
        a[c] = row_vector_[row_a_[c]];
        b[c] = row_vector_[row_b_[c]];
      },
      1024);
}

void ContactMaps::row_velocities(std::span<const double> v) const {
  parallel_for(side_.size(), [&](std::size_t p) {
    const Side& s = side_[p];
    if (s.begin == s.end) return;
    const auto rows = std::span(row_vector_).subspan(s.begin, s.end - s.begin);
    if (s.movable)
      s.map->apply(v.subspan(s.first_v, s.v_size), rows);
    else
      std::fill(rows.begin(), rows.end(), Vec3::Zero());
  });
}

void ContactMaps::add_row_forces(std::span<double> Q) const {
  for_movable([&](const Side& s) {
    s.map->apply_transpose(std::span<const Vec3>(row_vector_).subspan(s.begin, s.end - s.begin),
                           Q.subspan(s.first_v, s.v_size));
  });
}

void ContactMaps::relative(std::span<const double> v, std::span<Vec3> out) const {
  row_velocities(v);
  parallel_for(
      out.size(), [&](std::size_t c) { out[c] = row_vector_[row_a_[c]] - row_vector_[row_b_[c]]; }, 1024);
}

void ContactMaps::add_forces(std::span<const Vec3> force, std::span<double> Q) const {
  parallel_for(
      chosen_.size(),
      [&](std::size_t i) {
        row_vector_[row_a_[i]] = force[chosen_[i]];
        row_vector_[row_b_[i]] = -force[chosen_[i]];
      },
      1024);
  add_row_forces(Q);
}

bool ContactMaps::sparse_rows(std::size_t body) const {
  return std::all_of(side_.begin() + static_cast<std::ptrdiff_t>(first_side_[body]),
                     side_.begin() + static_cast<std::ptrdiff_t>(first_side_[body + 1]),
                     [](const Side& s) { return s.begin == s.end || sparse(*s.map) != nullptr; });
}

void ContactMaps::gather_rows(ContactRows& out) const {
  map_rows_.resize(side_.size());
  std::vector<std::uint8_t> known(side_.size(), 0);
  parallel_for(side_.size(), [&](std::size_t p) {
    map_rows_[p].clear();
    const Side& s = side_[p];
    known[p] = s.movable && s.begin < s.end && sparse(*s.map) && sparse(*s.map)->append_rows(map_rows_[p]);
  });
  const std::size_t n = chosen_.size();
  out.contact.assign(chosen_.begin(), chosen_.end());
  out.stiffness.resize(n);
  out.first.resize(n + 1);
  // Start of each contact's entries, and its number of general blocks (not multiples of the identity).
  std::vector<std::int32_t> general(n + 1, 0);
  out.first[0] = 0;
  const auto for_sides = [&](std::size_t i, const auto& f) {
    const auto side = [&](std::int32_t part, std::uint32_t row, float sign) {
      if (known[part]) f(side_[part], map_rows_[part], row - side_[part].begin, sign);
    };
    side(part_a_[i], row_a_[i], 1.0f);
    side(part_b_[i], row_b_[i], -1.0f);
  };
  parallel_for(
      n,
      [&](std::size_t i) {
        out.first[i + 1] = 0;
        for_sides(i, [&](const Side&, const MapRows& m, std::size_t r, float) {
          out.first[i + 1] += m.first[r + 1] - m.first[r];
          general[i + 1] += m.blocks.general(m.first[r], m.first[r + 1]);
        });
      },
      512);
  for (std::size_t i = 0; i < n; ++i) out.first[i + 1] += out.first[i], general[i + 1] += general[i];
  out.offset.resize(static_cast<std::size_t>(out.first[n]));
  out.blocks.resize(out.offset.size(), static_cast<std::size_t>(general[n]));
  parallel_for(
      n,
      [&](std::size_t i) {
        std::int32_t to = out.first[i], block = general[i];
        for_sides(i, [&](const Side& s, const MapRows& m, std::size_t r, float sign) {
          for (std::int32_t e = m.first[r]; e < m.first[r + 1]; ++e, ++to) {
            out.offset[to] = static_cast<std::int32_t>(s.first_v) + 3 * m.column[e];
            out.blocks.put(to, block, m.blocks, e, sign);
          }
        });
      },
      512);
}

void ContactMaps::add_block_diagonal(const std::function<Mat3(std::size_t)>& block,
                                     std::span<const std::size_t> first_block, BlockDiagonal& D) const {
  for_movable([&](const Side& s) {
    for (std::size_t r = s.begin; r < s.end; ++r) row_matrix_[r] = block(contact_[r]);
    s.map->add_block_diagonal(std::span<const Mat3>(row_matrix_).subspan(s.begin, s.end - s.begin), first_block[s.body],
                              D);
  });
}

}  // namespace brim
