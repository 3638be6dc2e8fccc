#include <algorithm>

#include "brim/world/contact_factor.h"

namespace brim {

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
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::int32_t e = rows.first[i]; e < rows.first[i + 1]; ++e)
      contact_trace_[rows.offset[e]] += rows.blocks.trace(e, rows.stiffness[i]);
  for (std::size_t b = 0; b < owner_.size(); ++b) {
    const Owner& o = owner_[b];
    for (std::size_t v = o.first_v; v < end_of(b); v += 3) {
      if (prescribed_[v] || !(contact_trace_[v] > 0.0f)) continue;
      const bool strong =
          !o.system ||
          contact_trace_[v] >
              limits.touch * static_cast<float>(diagonal_->block(o.first_block + (v - o.first_v) / 3).trace());
      if (strong) local_[v] = 0;
    }
  }
  take_thin_whole(limits.whole);
  for (std::size_t b = 0; b < owner_.size(); ++b) {
    const Owner& o = owner_[b];
    const std::size_t end = end_of(b);
    // A block of six counts whole.
    if (o.known && !o.system && std::max(local_[o.first_v], local_[o.first_v + 3]) == 0)
      local_[o.first_v] = local_[o.first_v + 3] = 0;
    for (std::size_t v = o.first_v; v < end; ++v) {
      if (local_[v] < 0) continue;
      local_[v] = o.known ? static_cast<std::int32_t>(touched_.size()) : -1;
      if (o.known) touched_.push_back({static_cast<std::int32_t>(v), static_cast<std::int32_t>(b), 0, {0, 0, 0}});
    }
  }
}

void ContactFactor::take_thin_whole(std::size_t most) {
  // What is touched already, and what thin bodies would add.
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

void ContactFactor::cut(const ContactRows& rows, const Limits& limits) {
  piece_count_ = 1;
  if (touched_.size() > limits.whole) {
    std::vector<float> count(touched_.size(), 0.0f);
    for_entries(rows, [&](std::int32_t t, std::int32_t i, std::int32_t) {
      touched_[t].place += rows.point[i];
      count[t] += 1.0f;
    });
    for (std::size_t t = 0; t < touched_.size(); ++t) {
      const Owner& o = owner_[touched_[t].body];
      if (o.system && !o.system->place.empty())
        touched_[t].place =
            o.system->place[(static_cast<std::size_t>(touched_[t].velocity) - o.first_v) / 3].cast<float>();
      else
        touched_[t].place /= std::max(count[t], 1.0f);
    }
    // Halves across the longest side, until they are small enough.
    std::vector<std::pair<std::size_t, std::size_t>> open = {{0, touched_.size()}};
    piece_count_ = 0;
    while (!open.empty()) {
      const auto [begin, end] = open.back();
      open.pop_back();
      const auto part = std::span(touched_).subspan(begin, end - begin);
      if (part.size() <= limits.piece) {
        for (Touched& t : part) t.piece = static_cast<std::int32_t>(piece_count_);
        ++piece_count_;
        continue;
      }
      Eigen::Vector3f lo = part[0].place, hi = lo;
      for (const Touched& t : part) lo = lo.cwiseMin(t.place), hi = hi.cwiseMax(t.place);
      Eigen::Index axis = 0;
      (hi - lo).maxCoeff(&axis);
      const std::size_t half = part.size() / 2;
      std::nth_element(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(half), part.end(),
                       [axis](const Touched& a, const Touched& b) {
                         return a.place[axis] != b.place[axis] ? a.place[axis] < b.place[axis]
                                                               : a.velocity < b.velocity;
                       });
      open.emplace_back(begin, begin + half);
      open.emplace_back(begin + half, end);
    }
    std::sort(touched_.begin(), touched_.end(), [](const Touched& a, const Touched& b) {
      return a.piece != b.piece ? a.piece < b.piece : a.velocity < b.velocity;
    });
    for (std::size_t t = 0; t < touched_.size(); ++t) local_[touched_[t].velocity] = static_cast<std::int32_t>(t);
  }
  if (pieces_.size() < piece_count_) pieces_.resize(piece_count_);
  for (std::size_t p = 0; p < piece_count_; ++p) pieces_[p].begin = pieces_[p].end = 0;
  for (std::size_t t = 0; t < touched_.size(); ++t) {
    Piece& p = pieces_[touched_[t].piece];
    if (p.end == 0) p.begin = t;
    p.end = t + 1;
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
