#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <utility>

#include "brim/core/error.h"
#include "brim/solve/block_cholesky.h"
#include "brim/solve/elimination_tree.h"

namespace brim {

namespace {

/// Zeros that joining two supernodes may add, over the entries of both: panels of few columns are slow.
constexpr double kZeros = 0.25;
/// [block columns] panels are joined more freely up to this width.
constexpr std::int32_t kNarrow = 4;
constexpr double kNarrowZeros = 0.5;
/// Tasks at most: what threads can share.
constexpr std::size_t kTasks = 8;
/// [floats] factors smaller than this are not worth dividing.
constexpr double kWorthDividing = 30000;
/// [floats] factors larger than this do not stay in the cache of a core.
constexpr std::size_t kWorthCompressing = 200000;
/// Subtrees are divided until each is less than this share of the work.
constexpr double kShare = 1.0 / 12;

/// Resizes with room for a little more, so that memory does not follow every change of a pattern.
template <class T>
void grow(std::vector<T>& v, std::size_t n) {
  if (v.capacity() < n) v.reserve(n + n / 4);
  v.resize(n);
}

/// The lower triangle of the pattern in the new order, by rows, without the diagonal. @param place  of each old block
LowerRows lower_rows(std::span<const std::int32_t> first, std::span<const std::int32_t> column,
                     std::span<const std::int32_t> place) {
  const auto n = static_cast<std::int32_t>(place.size());
  const auto for_lower = [&](const auto& f) {
    for (std::int32_t r = 0; r < n; ++r)
      for (std::int32_t e = first[r]; e < first[r + 1]; ++e)
        if (column[e] != r) f(std::max(place[r], place[column[e]]), std::min(place[r], place[column[e]]));
  };
  LowerRows lower;
  lower.first.assign(n + 1, 0);
  for_lower([&](std::int32_t i, std::int32_t) { ++lower.first[i + 1]; });
  for (std::int32_t i = 0; i < n; ++i) lower.first[i + 1] += lower.first[i];
  lower.column.resize(static_cast<std::size_t>(lower.first[n]));
  std::vector<std::int32_t> next(lower.first.begin(), lower.first.end() - 1);
  for_lower([&](std::int32_t i, std::int32_t j) { lower.column[next[i]++] = j; });
  return lower;
}

}  // namespace

void BlockCholesky::analyze(std::span<const std::int32_t> first, std::span<const std::int32_t> column,
                            std::size_t in_turn) {
  find_order(first, column);
  find_structure(first, column, in_turn);
}

void BlockCholesky::find_order(std::span<const std::int32_t> first, std::span<const std::int32_t> column) {
  const auto n = static_cast<Eigen::Index>(first.size()) - 1;
  using Pattern = Eigen::SparseMatrix<char, Eigen::ColMajor, std::int32_t>;
  // The rows of the upper triangle are the columns of the lower one.
  const std::vector<char> one(column.size(), 1);
  const Eigen::Map<const Pattern> lower(n, n, first[n], first.data(), column.data(), one.data());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, std::int32_t> minimum;
  Eigen::AMDOrdering<std::int32_t>()(lower.selfadjointView<Eigen::Lower>(), minimum);
  order_.assign(minimum.indices().data(), minimum.indices().data() + n);
}

void BlockCholesky::find_structure(std::span<const std::int32_t> first, std::span<const std::int32_t> column,
                                   std::size_t in_turn) {
  const std::vector<std::int32_t> parent = find_tree(first, column);
  find_entries(first, column);
  const std::vector<std::int32_t> count = column_counts(parent, [&](std::int32_t j, const auto& f) {
    for (std::int32_t e = entry_first_[j]; e < entry_first_[j + 1]; ++e)
      if (entry_[e].row != j) f(entry_[e].row);
  });
  find_rows(find_supernodes(parent, count));
  compressed_ = in_turn * lay_out_panels() > kWorthCompressing;
  lay_out_stream();
  const std::size_t n = 3 * order_.size();
  square_columns_.resize(panel::kSquare * n + panel::kPad);
  square_rows_.resize(square_columns_.size());
  step_.resize(n);
  scale_.resize(n);
  x_.resize(n);
  find_tasks();
  find_runs();
}

void BlockCholesky::number_places() {
  const auto n = static_cast<std::int32_t>(order_.size());
  place_.resize(n);
  for (std::int32_t i = 0; i < n; ++i) place_[order_[i]] = i;
}

std::vector<std::int32_t> BlockCholesky::find_tree(std::span<const std::int32_t> first,
                                                   std::span<const std::int32_t> column) {
  const auto n = static_cast<std::int32_t>(order_.size());
  number_places();
  const std::vector<std::int32_t> tree = elimination_tree(lower_rows(first, column, place_)), post = postorder(tree);
  std::vector<std::int32_t> renewed(n), after(n), parent(n);
  for (std::int32_t i = 0; i < n; ++i) renewed[i] = order_[post[i]], after[post[i]] = i;
  // The tree stays the same, with other numbers.
  for (std::int32_t i = 0; i < n; ++i) parent[i] = tree[post[i]] < 0 ? -1 : after[tree[post[i]]];
  order_ = renewed;
  number_places();
  return parent;
}

void BlockCholesky::find_entries(std::span<const std::int32_t> first, std::span<const std::int32_t> column) {
  const auto n = static_cast<std::int32_t>(order_.size());
  entry_first_.assign(n + 1, 0);
  for (std::int32_t r = 0; r < n; ++r)
    for (std::int32_t e = first[r]; e < first[r + 1]; ++e) ++entry_first_[std::min(place_[r], place_[column[e]]) + 1];
  for (std::int32_t j = 0; j < n; ++j) entry_first_[j + 1] += entry_first_[j];
  grow(entry_, static_cast<std::size_t>(entry_first_[n]));
  std::vector<std::int32_t> next(entry_first_.begin(), entry_first_.end() - 1);
  for (std::int32_t r = 0; r < n; ++r)
    for (std::int32_t e = first[r]; e < first[r + 1]; ++e) {
      const std::int32_t a = place_[r], b = place_[column[e]];
      // The pattern has block (r, column); the lower triangle wants (max, min).
      entry_[next[std::min(a, b)]++] = {std::max(a, b), e, a < b};
    }
}

std::size_t BlockCholesky::find_supernodes(std::span<const std::int32_t> parent, std::span<const std::int32_t> count) {
  const auto n = static_cast<std::int32_t>(order_.size());
  supernode_.clear();
  std::int32_t begin = 0;
  std::size_t room = 0;
  double zeros = 0.0;
  const auto close = [&](std::int32_t end) {
    Supernode s;
    s.begin = begin, s.end = end;
    s.row = room;
    s.rows = end - begin + count[end - 1] - 1;
    room += static_cast<std::size_t>(s.rows);
    supernode_.push_back(s);
  };
  for (std::int32_t j = 1; j <= n; ++j) {
    if (j < n && parent[j - 1] == j) {
      const std::int32_t width = j - begin;
      // The rows of the joined panel are those of column j; columns before it get the ones they lack.
      const double more = static_cast<double>(count[j] + 1 - count[j - 1]) * width;
      double whole = 0.0;
      for (std::int32_t k = 0; k <= width; ++k) whole += count[j] + k;
      if (zeros + more <= (width <= kNarrow ? kNarrowZeros : kZeros) * whole) {
        zeros += more;
        continue;
      }
    }
    if (j <= n && begin < n) close(j);
    begin = j;
    zeros = 0.0;
  }
  return room;
}

std::size_t BlockCholesky::lay_out_panels() {
  std::size_t total = 0;
  for (Supernode& s : supernode_) {
    s.stride = panel::padded(3 * static_cast<std::size_t>(s.rows));
    s.panel = total;
    // What kernels read past the last row is not what another thread writes.
    total += s.stride * 3 * static_cast<std::size_t>(s.end - s.begin) + panel::kPad;
  }
  grow(panel_, total + 2 * panel::kPad);
  return total;
}

void BlockCholesky::lay_out_stream() {
  std::size_t streamed = 0;
  for (Supernode& s : supernode_) {
    const std::size_t rows = 3 * static_cast<std::size_t>(s.rows),
                      width = 3 * static_cast<std::size_t>(s.end - s.begin);
    s.stream = streamed;
    streamed += compressed_ ? panel::stream_size<panel::Triple>(rows, width) : panel::stream_size<float>(rows, width);
  }
  if (compressed_)
    grow(triple_stream_, streamed);
  else
    grow(stream_, streamed);
}

void BlockCholesky::find_rows(std::size_t room) {
  const auto count = static_cast<std::int32_t>(supernode_.size());
  grow(row_, room);
  supernode_of_.resize(order_.size());
  for (std::int32_t k = 0; k < count; ++k)
    for (std::int32_t j = supernode_[k].begin; j < supernode_[k].end; ++j) supernode_of_[j] = k;
  // Own columns, and below them what the matrix has there and what the children have handed on.
  std::vector<std::int32_t> seen(order_.size(), -1), child(count, -1), sibling(count, -1);
  for (std::int32_t k = 0; k < count; ++k) {
    const Supernode& s = supernode_[k];
    std::int32_t* const own = row_.data() + s.row;
    std::int32_t* to = own;
    for (std::int32_t j = s.begin; j < s.end; ++j) *to++ = j;
    std::int32_t* const below = to;
    const auto take = [&](std::int32_t row) {
      if (row >= s.end && seen[row] != k) seen[row] = k, *to++ = row;
    };
    for (std::int32_t j = s.begin; j < s.end; ++j)
      for (std::int32_t e = entry_first_[j]; e < entry_first_[j + 1]; ++e) take(entry_[e].row);
    for (std::int32_t c = child[k]; c != -1; c = sibling[c]) {
      const Supernode& t = supernode_[c];
      const std::int32_t* rows = row_.data() + t.row;
      for (std::int32_t i = t.end - t.begin; i < t.rows; ++i) take(rows[i]);
    }
    std::sort(below, to);
    BRIM_CHECK(to - own, ==, s.rows);
    if (below == to) continue;
    const std::int32_t parent = supernode_of_[*below];
    sibling[k] = std::exchange(child[parent], k);
  }
}

void BlockCholesky::find_tasks() {
  const auto count = static_cast<std::int32_t>(supernode_.size());
  const auto above = [&](std::int32_t k) {
    const Supernode& s = supernode_[k];
    const std::int32_t width = s.end - s.begin;
    return width < s.rows ? supernode_of_[row_[s.row + width]] : -1;
  };
  // Entries of each subtree: what a solve reads. Children come before their parents.
  std::vector<double> work(count);
  std::vector<std::vector<std::int32_t>> children(count);
  std::vector<std::int32_t> open;
  double whole = 0.0;
  for (std::int32_t k = 0; k < count; ++k) {
    const Supernode& s = supernode_[k];
    const double own = 9.0 * s.rows * (s.end - s.begin);
    work[k] += own, whole += own;
    if (const std::int32_t p = above(k); p >= 0)
      work[p] += work[k], children[p].push_back(k);
    else
      open.push_back(k);
  }
  std::vector<std::uint8_t> top(count, 0);
  const auto less = [&](std::int32_t a, std::int32_t b) { return work[a] != work[b] ? work[a] < work[b] : a < b; };
  std::make_heap(open.begin(), open.end(), less);
  while (whole > kWorthDividing && work[open.front()] > kShare * whole) {
    std::pop_heap(open.begin(), open.end(), less);
    const std::int32_t k = open.back();
    open.pop_back();
    top[k] = 1;
    for (const std::int32_t c : children[k]) open.push_back(c), std::push_heap(open.begin(), open.end(), less);
    if (open.empty()) break;
  }
  // The largest first, each to the task that has least.
  std::sort(open.begin(), open.end(), [&](std::int32_t a, std::int32_t b) { return less(b, a); });
  const std::size_t tasks = whole > kWorthDividing ? kTasks : 1;
  task_.resize(tasks + 1);
  std::vector<double> dealt(tasks, 0.0);
  task_of_.assign(count, static_cast<std::int32_t>(tasks));
  for (const std::int32_t k : open) {
    const auto t = std::min_element(dealt.begin(), dealt.end()) - dealt.begin();
    dealt[t] += work[k];
    task_of_[k] = static_cast<std::int32_t>(t);
  }
  for (std::int32_t k = count; k-- > 0;)
    if (const std::int32_t p = above(k); p >= 0 && !top[p]) task_of_[k] = task_of_[p];
  for (Task& t : task_) t.supernode.clear();
  for (std::int32_t k = 0; k < count; ++k) task_[task_of_[k]].supernode.push_back(k);
  std::int32_t blocks = 0;
  top_place_.assign(order_.size(), -1);
  for (const std::int32_t k : task_.back().supernode)
    for (std::int32_t j = supernode_[k].begin; j < supernode_[k].end; ++j) top_place_[j] = blocks++;
  for (Task& t : task_) {
    t.above.resize(&t == &task_.back() ? 0 : 3 * static_cast<std::size_t>(blocks));
    if (t.supernode.empty()) continue;
    std::size_t rows = 0;
    for (const std::int32_t k : t.supernode)
      rows = std::max(rows, panel::padded(3 * static_cast<std::size_t>(supernode_[k].rows)));
    grow(t.rows, rows + panel::kPad);
    grow(t.local, order_.size());
  }
}

void BlockCholesky::find_runs() {
  row_run_.clear();
  const auto top = static_cast<std::int32_t>(task_.size()) - 1;
  for (std::size_t k = 0; k < supernode_.size(); ++k) {
    Supernode& s = supernode_[k];
    const std::size_t first = row_run_.size();
    for (std::int32_t i = s.end - s.begin; i < s.rows; ++i) {
      const std::int32_t row = row_[s.row + static_cast<std::size_t>(i)];
      const bool hands_up = task_of_[k] != top && top_place_[row] >= 0;
      const RowRun one{3 * row, hands_up ? 3 * top_place_[row] : -1, 3};
      if (row_run_.size() > first) {
        RowRun& last = row_run_.back();
        const bool follows = one.place == last.place + last.floats &&
                             (hands_up ? last.above >= 0 && one.above == last.above + last.floats : last.above < 0);
        if (follows) {
          last.floats += 3;
          continue;
        }
      }
      row_run_.push_back(one);
    }
    s.runs = row_run_.size();
  }
}

}  // namespace brim
