#include "brim/world/contact_factor.h"

#include <algorithm>

#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

/// Rows assembled by one thread at a time.
constexpr std::size_t kRows = 64;

using Block = BlockCholesky::Block;

}  // namespace

/// Sums blocks of one row by column.
class ContactFactor::RowSum {
 public:
  /// Allocates for columns below `columns`.
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
  /// Reserves only these columns, which are summed at `value`; forget releases them.
  void expect(std::span<const std::int32_t> column, Block* value) {
    for (std::size_t k = 0; k < column.size(); ++k) {
      slot_[column[k]] = static_cast<std::int32_t>(k);
      value[k].setZero();
    }
  }
  void add_expected(std::int32_t column, const Block& block, Block* value) const { value[slot_[column]] += block; }
  void forget(std::span<const std::int32_t> column) {
    for (const std::int32_t c : column) slot_[c] = -1;
  }
  /// Appends the row in ascending columns and clears it. @return its length
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
                          std::span<const std::uint8_t> sparse, std::span<const std::int32_t> island) {
  diagonal_ = &diagonal;
  owner_.resize(bodies.size()), rigid_.resize(bodies.size());
  all_rigid_ = true;
  free_ = 0;
  prescribed_.assign(first_v.back(), 0);
  touched_.clear();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    Owner& o = owner_[b];
    o.first_v = first_v[b], o.first_block = first_block[b];
    o.island = island.empty() ? 0 : island[b];
    o.system = bodies[b]->immobile() ? std::nullopt : bodies[b]->block_system();
    const bool one_of_six = first_block[b + 1] == first_block[b] + 1 && diagonal.block_size(first_block[b]) == 6;
    rigid_[b] = sparse[b] && one_of_six && !o.system && !bodies[b]->immobile();
    const auto* sixes = bodies[b]->immobile() ? nullptr : interface_of<BlocksOfSix>(*bodies[b]);
    o.sixes = sixes != nullptr ? sixes->couplings() : SixCouplings{};
    o.known = (sparse[b] && (o.system || sixes != nullptr)) || rigid_[b];
    all_rigid_ = all_rigid_ && (rigid_[b] || bodies[b]->immobile());
    if (!bodies[b]->immobile()) free_ += first_v[b + 1] - first_v[b];
    const auto prescribed = o.system ? o.system->prescribed : o.sixes.prescribed;
    free_ -= 3 * prescribed.size();
    for (const std::int32_t r : prescribed)
      std::fill_n(prescribed_.begin() + static_cast<std::ptrdiff_t>(o.first_v + 3 * static_cast<std::size_t>(r)), 3, 1);
  }
}

template <class Add>
void ContactFactor::add_own_blocks(std::int32_t t, const Add& add) const {
  const Owner& o = owner_[touched_[t].body];
  const std::size_t at = static_cast<std::size_t>(touched_[t].velocity) - o.first_v;
  if (!o.system) return add_blocks_of_six(t, add);
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

template <class Add>
void ContactFactor::add_blocks_of_six(std::int32_t t, const Add& add) const {
  const Owner& o = owner_[touched_[t].body];
  const std::size_t at = static_cast<std::size_t>(touched_[t].velocity) - o.first_v, row = at / 6;
  const auto half = static_cast<Eigen::Index>(at % 6);
  const auto add_three = [&](std::size_t column, Eigen::Index other, const auto& six) {
    const std::int32_t u = local_[o.first_v + 6 * column + static_cast<std::size_t>(other)];
    if (u >= t) add(u, Block(six.template block<3, 3>(half, other).template cast<float>()));
  };
  const auto own = diagonal_->block(o.first_block + row);
  add_three(row, half, own);
  if (half == 0) add_three(row, 3, own);
  if (o.sixes.first.empty()) return;
  for (std::int32_t k = o.sixes.first[row]; k < o.sixes.first[row + 1]; ++k)
    for (const Eigen::Index other : {0, 3})
      add_three(static_cast<std::size_t>(o.sixes.column[k]), other, o.sixes.value[k]);
}

template <class Counts, class Add>
void ContactFactor::add_row(const ContactRows& rows, std::size_t row, const Counts& counts, const Add& add) const {
  add_own_blocks(static_cast<std::int32_t>(row), [&](std::int32_t u, const Block& b) {
    if (counts(u)) add(u, b);
  });
  for (std::int32_t k = incidence_first_[row]; k < incidence_first_[row + 1]; ++k) {
    const auto [i, mine] = incidence_[k];
    const Block left = rows.blocks.transposed_times(mine, rows.stiffness[i]);
    for (std::int32_t e = rows.first[i]; e < rows.first[i + 1]; ++e)
      if (const std::int32_t u = local_[rows.offset[e]]; counts(u)) add(u, rows.blocks.times(left, e));
  }
}

template <class F>
void ContactFactor::for_rows(const F& f) {
  const std::size_t n = touched_.size();
  parallel_for((n + kRows - 1) / kRows, [&](std::size_t c) {
    auto workspace = sums_->borrow();
    workspace->begin(n);
    for (std::size_t row = c * kRows; row < std::min(n, (c + 1) * kRows); ++row) f(c, row, *workspace);
  });
}

void ContactFactor::assemble(const ContactRows& rows) {
  const std::size_t n = touched_.size();
  chunks_.resize((n + kRows - 1) / kRows);
  for (Chunk& c : chunks_) c.column.clear(), c.value.clear();
  length_.resize(n);
  for_rows([&](std::size_t c, std::size_t row, RowSum& sum) {
    const auto t = static_cast<std::int32_t>(row);
    add_row(
        rows, row, [t](std::int32_t u) { return u >= t; }, [&](std::int32_t u, const Block& b) { sum.add(u, b); });
    length_[row] = static_cast<std::int32_t>(sum.take(chunks_[c].column, chunks_[c].value));
  });
}

void ContactFactor::fill_pieces() {
  // Start of each row in its chunk.
  std::vector<std::size_t> begin(touched_.size());
  for (std::size_t t = 0; t < touched_.size(); ++t)
    begin[t] = t % kRows == 0 ? 0 : begin[t - 1] + static_cast<std::size_t>(length_[t - 1]);
  parallel_for(piece_count_, [&](std::size_t p) {
    Piece& piece = pieces_[p];
    Pattern& now = piece.pattern;
    now.first.assign(1, 0), now.column.clear(), piece.value.clear();
    for (const std::int32_t t : piece.touched) {
      const Chunk& c = chunks_[static_cast<std::size_t>(t) / kRows];
      for (std::size_t k = begin[t]; k < begin[t] + static_cast<std::size_t>(length_[t]); ++k) {
        const Touched& u = touched_[c.column[k]];
        if (u.cluster != touched_[t].cluster) continue;
        now.column.push_back(u.at);
        piece.value.push_back(c.value[k]);
      }
      now.first.push_back(static_cast<std::int32_t>(now.column.size()));
    }
  });
}

void ContactFactor::assemble_again(const ContactRows& rows) {
  for_rows([&](std::size_t, std::size_t row, RowSum& sum) {
    const Touched& mine = touched_[row];
    const auto t = static_cast<std::int32_t>(row);
    Piece& piece = pieces_[mine.piece];
    const std::int32_t from = piece.before.first[mine.at], to = piece.before.first[mine.at + 1];
    const auto column = std::span(piece.before.column).subspan(from, to - from);
    Block* const value = piece.value.data() + from;
    sum.expect(column, value);
    add_row(
        rows, row, [&](std::int32_t u) { return u >= t && touched_[u].cluster == mine.cluster; },
        [&](std::int32_t u, const Block& b) { sum.add_expected(touched_[u].at, b, value); });
    sum.forget(column);
  });
}

template <class F>
void ContactFactor::for_pieces(const std::function<void()>& beside, const F& f) {
  const bool two = beside && !complete();
  // Ordering a large piece is single-threaded work.
  parallel_for(two ? 2 : 1, [&](std::size_t part) {
    if (part == 0)
      parallel_for(touched_.empty() ? 0 : piece_count_, [&](std::size_t p) { f(pieces_[p]); });
    else
      beside();
  });
}

void ContactFactor::factor(const ContactRows& rows, const Limits& limits, const std::function<void()>& beside) {
  find_touched(rows, limits);
  if (!touched_.empty()) {
    find_incidence(rows);
    assemble(rows);
    cut(limits);
    fill_pieces();
  }
  for_pieces(beside, [&](Piece& piece) {
    if (piece.pattern.first != piece.before.first || piece.pattern.column != piece.before.column) {
      std::swap(piece.pattern, piece.before);
      piece.factor.analyze(piece.before.first, piece.before.column, piece_count_);
    }
    piece.factor.factor(piece.value);
  });
}

void ContactFactor::refactor(const ContactRows& rows, const std::function<void()>& beside) {
  if (!touched_.empty()) assemble_again(rows);
  for_pieces(beside, [](Piece& piece) { piece.factor.factor(piece.value); });
}

void ContactFactor::apply(std::span<const double> r, std::span<double> z) {
  if (empty()) return;
  parallel_for(piece_count_, [&](std::size_t p) {
    Piece& piece = pieces_[p];
    const std::size_t n = piece.touched.size();
    piece.x.resize(3 * n);
    for (std::size_t i = 0; i < n; ++i) {
      const std::int32_t v = touched_[piece.touched[i]].velocity;
      for (int a = 0; a < 3; ++a) piece.x[3 * i + a] = static_cast<float>(r[v + a]);
    }
    piece.factor.solve(piece.x);
    for (std::size_t i = 0; i < n; ++i) {
      const std::int32_t v = touched_[piece.touched[i]].velocity;
      for (int a = 0; a < 3; ++a) z[v + a] = piece.x[3 * i + a];
    }
  });
}

std::size_t ContactFactor::entries() const {
  std::size_t sum = 0;
  for (std::size_t p = 0; p < (empty() ? 0 : piece_count_); ++p) sum += pieces_[p].factor.entries();
  return sum;
}

}  // namespace brim
