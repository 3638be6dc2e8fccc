#include "brim/world/contact_factor.h"

#include <algorithm>

#include "brim/core/parallel.h"

namespace brim {

namespace {

/// Rows assembled by one thread at a time.
constexpr std::size_t kRows = 64;
/// Share of a node's own matrix below which contact does not touch it: block Jacobi knows as much.
constexpr float kTouch = 0.1f;

using Block = BlockCholesky::Block;

}  // namespace

/// Sums blocks of one row by column.
class ContactFactor::RowSum {
 public:
  /// Makes room for columns below `columns`.
  void begin(std::size_t columns) {
    if (slot_.size() < columns) slot_.resize(columns, -1);
  }
  void add(std::int32_t column, const Block& block) {
    std::int32_t& s = slot_[column];
    if (s < 0) {
      s = static_cast<std::int32_t>(column_.size());
      column_.push_back(column);
      value_.push_back(block);
    } else {
      value_[s] += block;
    }
  }
  /// Appends the row in ascending columns and forgets it. @return its length
  std::size_t take(std::vector<std::int32_t>& column, std::vector<Block>& value) {
    sorted_ = column_;
    std::sort(sorted_.begin(), sorted_.end());
    for (const std::int32_t c : sorted_) {
      column.push_back(c);
      value.push_back(value_[slot_[c]]);
      slot_[c] = -1;
    }
    const std::size_t n = sorted_.size();
    column_.clear(), value_.clear();
    return n;
  }

 private:
  std::vector<std::int32_t> slot_, column_, sorted_;
  std::vector<Block> value_;
};

ContactFactor::ContactFactor() : sums_(std::make_unique<WorkspacePool<RowSum>>()) {}
ContactFactor::~ContactFactor() = default;

void ContactFactor::begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
                          const BlockDiagonal& diagonal, std::span<const std::size_t> first_block,
                          std::span<const std::uint8_t> sparse) {
  diagonal_ = &diagonal;
  owner_.resize(bodies.size()), rigid_.resize(bodies.size());
  all_rigid_ = true;
  prescribed_.assign(first_v.back(), 0);
  touched_.clear();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    Owner& o = owner_[b];
    o.first_v = first_v[b], o.first_block = first_block[b];
    o.system = bodies[b]->immobile() ? std::nullopt : bodies[b]->block_system();
    const bool one_of_six = first_block[b + 1] == first_block[b] + 1 && diagonal.block_size(first_block[b]) == 6;
    rigid_[b] = sparse[b] && one_of_six && !o.system && !bodies[b]->immobile();
    o.known = (sparse[b] && o.system) || rigid_[b];
    all_rigid_ = all_rigid_ && (rigid_[b] || bodies[b]->immobile());
    if (!o.system) continue;
    for (const std::int32_t r : o.system->prescribed)
      std::fill_n(prescribed_.begin() + static_cast<std::ptrdiff_t>(o.first_v + 3 * static_cast<std::size_t>(r)), 3, 1);
  }
}

template <class F>
void ContactFactor::for_entries(const ContactRows& rows, const F& f) const {
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::int32_t e = rows.first[i]; e < rows.first[i + 1]; ++e)
      if (const std::int32_t t = local_[rows.offset[e]]; t >= 0) f(t, static_cast<std::int32_t>(i), e);
}

void ContactFactor::find_touched(const ContactRows& rows, std::size_t whole) {
  local_.assign(prescribed_.size(), -1);
  touched_.clear();
  contact_trace_.assign(prescribed_.size(), 0.0f);
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::int32_t e = rows.first[i]; e < rows.first[i + 1]; ++e)
      contact_trace_[rows.offset[e]] += (rows.stiffness[i] * rows.block[e]).cwiseProduct(rows.block[e]).sum();
  for (std::size_t b = 0; b < owner_.size(); ++b) {
    const Owner& o = owner_[b];
    for (std::size_t v = o.first_v; v < end_of(b); v += 3) {
      if (prescribed_[v] || !(contact_trace_[v] > 0.0f)) continue;
      const bool strong =
          !o.system || contact_trace_[v] >
                           kTouch * static_cast<float>(diagonal_->block(o.first_block + (v - o.first_v) / 3).trace());
      if (strong) local_[v] = 0;
    }
  }
  take_thin_whole(whole);
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

void ContactFactor::cut(const ContactRows& rows, std::size_t whole, std::size_t most) {
  piece_count_ = 1;
  if (touched_.size() > whole) {
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
      if (part.size() <= most) {
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

template <class Add>
void ContactFactor::add_own_blocks(std::int32_t t, const Add& add) const {
  const Owner& o = owner_[touched_[t].body];
  const std::size_t at = static_cast<std::size_t>(touched_[t].velocity) - o.first_v;
  if (!o.system) {
    const auto six = diagonal_->block(o.first_block);
    const auto i = static_cast<Eigen::Index>(at);
    add(t, Block(six.block<3, 3>(i, i).cast<float>()));
    if (at == 0) add(local_[o.first_v + 3], Block(six.block<3, 3>(0, 3).cast<float>()));
    return;
  }
  const BlockSystem& s = *o.system;
  const BlockMatrix& K = *s.stiffness;
  const std::size_t r = at / 3;
  for (std::int32_t k = K.row_first()[r]; k < K.row_first()[r + 1]; ++k) {
    const std::int32_t u = local_[o.first_v + 3 * static_cast<std::size_t>(K.columns()[k])];
    if (u < t) continue;
    Block block = static_cast<float>(s.stiffness_share) * K.block(k).cast<float>();
    if (u == t) block.diagonal().array() += static_cast<float>(s.mass_share * s.mass[r]);
    add(u, block);
  }
}

void ContactFactor::assemble(const ContactRows& rows) {
  const std::size_t n = touched_.size();
  chunks_.resize((n + kRows - 1) / kRows);
  length_.resize(n);
  parallel_for(chunks_.size(), [&](std::size_t c) {
    Chunk& out = chunks_[c];
    out.column.clear(), out.value.clear();
    auto workspace = sums_->borrow();
    RowSum& sum = *workspace;
    sum.begin(n);
    for (std::size_t row = c * kRows; row < std::min(n, (c + 1) * kRows); ++row) {
      const auto t = static_cast<std::int32_t>(row);
      const Piece& piece = pieces_[touched_[row].piece];
      const auto inside = [&](std::int32_t u) { return u >= t && u < static_cast<std::int32_t>(piece.end); };
      add_own_blocks(t, [&](std::int32_t u, const Block& b) {
        if (inside(u)) sum.add(u, b);
      });
      for (std::int32_t k = incidence_first_[row]; k < incidence_first_[row + 1]; ++k) {
        const auto [i, mine] = incidence_[k];
        const Block left = rows.block[mine].transpose() * rows.stiffness[i];
        for (std::int32_t e = rows.first[i]; e < rows.first[i + 1]; ++e)
          if (const std::int32_t u = local_[rows.offset[e]]; inside(u)) sum.add(u, left * rows.block[e]);
      }
      length_[row] = static_cast<std::int32_t>(sum.take(out.column, out.value));
    }
  });
}

void ContactFactor::factor(const ContactRows& rows, std::size_t whole, std::size_t most_in_a_piece) {
  find_touched(rows, whole);
  if (touched_.empty()) return;
  cut(rows, whole, most_in_a_piece);
  find_incidence(rows);
  refactor(rows);
}

void ContactFactor::refactor(const ContactRows& rows) {
  if (touched_.empty()) return;
  assemble(rows);
  // Rows lie one after another in the chunks; a piece is a run of them.
  std::size_t chunk = 0, at = 0;
  for (std::size_t p = 0; p < piece_count_; ++p) {
    Piece& piece = pieces_[p];
    Pattern& now = piece.pattern;
    now.first.assign(1, 0), now.column.clear(), piece.value.clear();
    for (std::size_t t = piece.begin; t < piece.end; ++t) {
      if (t / kRows != chunk) chunk = t / kRows, at = 0;
      const Chunk& c = chunks_[chunk];
      for (std::int32_t k = 0; k < length_[t]; ++k, ++at) {
        now.column.push_back(c.column[at] - static_cast<std::int32_t>(piece.begin));
        piece.value.push_back(c.value[at]);
      }
      now.first.push_back(static_cast<std::int32_t>(now.column.size()));
    }
  }
  parallel_for(piece_count_, [&](std::size_t p) {
    Piece& piece = pieces_[p];
    if (piece.pattern.first != piece.before.first || piece.pattern.column != piece.before.column) {
      std::swap(piece.pattern, piece.before);
      piece.factor.analyze(piece.before.first, piece.before.column);
    }
    piece.factor.factor(piece.value);
  });
}

void ContactFactor::apply(std::span<const double> r, std::span<double> z) {
  if (empty()) return;
  parallel_for(piece_count_, [&](std::size_t p) {
    Piece& piece = pieces_[p];
    const auto mine = std::span(touched_).subspan(piece.begin, piece.end - piece.begin);
    piece.x.resize(3 * mine.size());
    for (std::size_t i = 0; i < mine.size(); ++i)
      for (int a = 0; a < 3; ++a) piece.x[3 * i + a] = static_cast<float>(r[mine[i].velocity + a]);
    piece.factor.solve(piece.x);
    for (std::size_t i = 0; i < mine.size(); ++i)
      for (int a = 0; a < 3; ++a) z[mine[i].velocity + a] = piece.x[3 * i + a];
  });
}

std::size_t ContactFactor::entries() const {
  std::size_t sum = 0;
  for (std::size_t p = 0; p < (empty() ? 0 : piece_count_); ++p) sum += pieces_[p].factor.entries();
  return sum;
}

}  // namespace brim
