#include <algorithm>
#include <cmath>

#include "brim/core/parallel.h"
#include "brim/solve/strong_clusters.h"
#include "brim/world/contact_factor.h"

namespace brim {

namespace {

/// [blocks] processed by one thread at a time: clusters are added to a piece until it has this many.
constexpr std::size_t kPiece = 512;
/// The same for islands of bodies when nothing is cut.
constexpr std::size_t kWholePiece = 256;

}  // namespace

template <class F>
void ContactFactor::for_entries(const ContactRows& rows, const F& f) const {
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::int32_t e = rows.first[i]; e < rows.first[i + 1]; ++e)
      if (const std::int32_t t = local_[rows.offset[e]]; t >= 0) f(t, static_cast<std::int32_t>(i), e);
}

void ContactFactor::find_touched(const ContactRows& rows, const Limits& limits) {
  local_.assign(prescribed_.size(), -1);
  touched_.clear();
  contact_trace_.assign(prescribed_.size(), 0.0f);
  entry_trace_.resize(rows.offset.size());
  parallel_for(
      rows.size(),
      [&](std::size_t i) {
        for (std::int32_t e = rows.first[i]; e < rows.first[i + 1]; ++e)
          entry_trace_[e] = rows.blocks.trace(e, rows.stiffness[i]);
      },
      512);
  for (std::size_t e = 0; e < entry_trace_.size(); ++e) contact_trace_[rows.offset[e]] += entry_trace_[e];
  parallel_for(owner_.size(), [&](std::size_t b) {
    const Owner& o = owner_[b];
    for (std::size_t v = o.first_v; v < end_of(b); v += 3) {
      if (prescribed_[v] || !(contact_trace_[v] > 0.0f)) continue;
      const bool strong =
          !o.system ||
          contact_trace_[v] >
              limits.touch * static_cast<float>(diagonal_->block(o.first_block + (v - o.first_v) / 3).trace());
      if (strong) local_[v] = 0;
    }
  });
  take_blocks_of_six();
  take_thin_whole(limits.whole);
  for (std::size_t b = 0; b < owner_.size(); ++b) {
    const Owner& o = owner_[b];
    const std::size_t end = end_of(b);
    for (std::size_t v = o.first_v; v < end; ++v) {
      if (local_[v] < 0) continue;
      local_[v] = o.known ? static_cast<std::int32_t>(touched_.size()) : -1;
      if (o.known) touched_.push_back({static_cast<std::int32_t>(v), static_cast<std::int32_t>(b)});
    }
  }
}

void ContactFactor::take_blocks_of_six() {
  for (std::size_t b = 0; b < owner_.size(); ++b) {
    const Owner& o = owner_[b];
    if (!o.known || o.system) continue;
    for (std::size_t r = 0; r + 1 < o.sixes.first.size(); ++r)
      for (std::int32_t k = o.sixes.first[r]; k < o.sixes.first[r + 1]; ++k)
        local_[o.first_v + 6 * r] = local_[o.first_v + 6 * static_cast<std::size_t>(o.sixes.column[k])] = 0;
    // A block is touched as a whole, except for prescribed velocities.
    for (std::size_t v = o.first_v; v < end_of(b); v += 6)
      if (std::max(local_[v], local_[v + 3]) == 0)
        for (const std::size_t three : {v, v + 3}) local_[three] = prescribed_[three] ? -1 : 0;
  }
}

void ContactFactor::take_thin_whole(std::size_t most) {
  // Number of blocks touched so far, and those that thin bodies would add.
  std::size_t blocks = 0;
  std::vector<std::uint8_t> taken(owner_.size(), 0);
  for (std::size_t b = 0; b < owner_.size(); ++b) {
    const Owner& o = owner_[b];
    if (!o.known) continue;
    const auto own = std::span(local_).subspan(o.first_v, end_of(b) - o.first_v);
    const auto touched = static_cast<std::size_t>(std::count(own.begin(), own.end(), 0));
    taken[b] = touched > 0 && o.system && o.system->thin;
    blocks += taken[b] ? own.size() / 3 : touched;
  }
  if (blocks > most) return;
  for (std::size_t b = 0; b < owner_.size(); ++b)
    for (std::size_t v = owner_[b].first_v; taken[b] && v < end_of(b); v += 3)
      if (!prescribed_[v]) local_[v] = 0;
}

std::vector<std::int32_t> ContactFactor::find_islands() const {
  std::vector<std::int32_t> number(owner_.size(), -1), island(touched_.size());
  std::int32_t count = 0;
  for (std::size_t t = 0; t < touched_.size(); ++t) {
    std::int32_t& n = number[owner_[touched_[t].body].island];
    if (n < 0) n = count++;
    island[t] = n;
  }
  return island;
}

std::vector<std::int32_t> ContactFactor::find_clusters(const Limits& limits) const {
  std::vector<Coupling> couplings, joined;
  std::vector<float> share(touched_.size());  // 1/√|A_tt|
  const auto for_rows_of_chunks = [&](const auto& f) {
    std::size_t t = 0;
    for (const Chunk& c : chunks_)
      for (std::size_t k = 0; k < c.column.size(); ++t) {
        f(t, c, k, k + static_cast<std::size_t>(length_[t]));
        k += static_cast<std::size_t>(length_[t]);
      }
  };
  for_rows_of_chunks([&](std::size_t t, const Chunk& c, std::size_t begin, std::size_t) {
    const float size = c.value[begin].norm();  // a row begins with its diagonal
    share[t] = size > 0.0f ? 1.0f / std::sqrt(size) : 0.0f;
  });
  for_rows_of_chunks([&](std::size_t t, const Chunk& c, std::size_t begin, std::size_t end) {
    for (std::size_t k = begin + 1; k < end; ++k)
      couplings.push_back(
          {static_cast<std::int32_t>(t), c.column[k], c.value[k].norm() * share[t] * share[c.column[k]]});
  });
  for (std::size_t t = 0; t + 1 < touched_.size(); ++t)
    if (const Owner& o = owner_[touched_[t].body];
        !o.system && (static_cast<std::size_t>(touched_[t].velocity) - o.first_v) % 6 == 0 &&
        touched_[t + 1].velocity == touched_[t].velocity + 3)
      joined.push_back({static_cast<std::int32_t>(t), static_cast<std::int32_t>(t + 1), 0.0f});
  return strong_clusters(touched_.size(), couplings, limits.cluster, joined);
}

void ContactFactor::cut(const Limits& limits) {
  cut_ = touched_.size() > limits.whole;
  const std::vector<std::int32_t> cluster = cut_ ? find_clusters(limits) : find_islands();
  std::vector<std::vector<std::int32_t>> members(
      static_cast<std::size_t>(*std::max_element(cluster.begin(), cluster.end())) + 1);
  for (std::size_t t = 0; t < touched_.size(); ++t) {
    touched_[t].cluster = cluster[t];
    members[cluster[t]].push_back(static_cast<std::int32_t>(t));
  }
  for (Piece& p : pieces_) p.touched.clear();
  piece_count_ = 0;
  const std::size_t piece = cut_ ? kPiece : kWholePiece;
  for (const auto& list : members) {
    if (piece_count_ == 0 || pieces_[piece_count_ - 1].touched.size() >= piece) ++piece_count_;
    if (pieces_.size() < piece_count_) pieces_.resize(piece_count_);
    Piece& open = pieces_[piece_count_ - 1];
    for (const std::int32_t t : list) {
      touched_[t].piece = static_cast<std::int32_t>(piece_count_ - 1);
      touched_[t].at = static_cast<std::int32_t>(open.touched.size());
      open.touched.push_back(t);
    }
  }
}

void ContactFactor::find_incidence(const ContactRows& rows) {
  incidence_first_.assign(touched_.size() + 1, 0);
  for_entries(rows, [&](std::int32_t t, std::int32_t, std::int32_t) { ++incidence_first_[t + 1]; });
  for (std::size_t t = 0; t < touched_.size(); ++t) incidence_first_[t + 1] += incidence_first_[t];
  incidence_.resize(incidence_first_.back());
  std::vector<std::int32_t> next(incidence_first_.begin(), incidence_first_.end() - 1);
  for_entries(rows, [&](std::int32_t t, std::int32_t i, std::int32_t e) { incidence_[next[t]++] = {i, e}; });
}

}  // namespace brim
