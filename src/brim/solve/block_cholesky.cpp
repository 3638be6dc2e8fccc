#include "brim/solve/block_cholesky.h"

#include <algorithm>
#include <cmath>

#include "brim/core/parallel.h"

namespace brim {

namespace {

/// [blocks times blocks] products from which on the rows of a panel of the top are worth sharing, so many block rows to
/// a piece.
constexpr double kWorthSharing = 4000.0;
constexpr std::int32_t kSharedRows = 16;
constexpr std::size_t kSharedColumns = 4 * panel::kBlock;

/// Makes room for n at least; what was there means nothing.
void make_room(std::vector<float>& v, std::size_t n) {
  if (v.size() < n) v.resize(n + n / 4);
}

// Runs of rows, often of one block: shorter than what a call costs.
inline void add(const float* __restrict from, std::int32_t n, float* __restrict to) {
  for (std::int32_t i = 0; i < n; i += 3) to[i] += from[i], to[i + 1] += from[i + 1], to[i + 2] += from[i + 2];
}
inline void copy(const float* __restrict from, std::int32_t n, float* __restrict to) {
  for (std::int32_t i = 0; i < n; i += 3) to[i] = from[i], to[i + 1] = from[i + 1], to[i + 2] = from[i + 2];
}

}  // namespace

template <class F>
void BlockCholesky::with_stream(const Supernode& s, const F& f) {
  const std::size_t column = 3 * static_cast<std::size_t>(s.begin);
  float *columns = square_columns_.data() + panel::kSquare * column,
        *rows = square_rows_.data() + panel::kSquare * column, *step = step_.data() + column;
  if (compressed_)
    f(panel::Stream<panel::Triple>{triple_stream_.data() + s.stream, columns, rows, step});
  else
    f(panel::Stream<float>{stream_.data() + s.stream, columns, rows, step});
}

void BlockCholesky::load(const Supernode& s, std::span<const Block> value, Task& task) {
  float* panel = panel_.data() + s.panel;
  std::fill(panel, panel + s.stride * 3 * static_cast<std::size_t>(s.end - s.begin), 0.0f);
  for (std::int32_t i = 0; i < s.rows; ++i) task.local[row_[s.row + i]] = i;
  for (std::int32_t j = s.begin; j < s.end; ++j)
    for (std::int32_t e = entry_first_[j]; e < entry_first_[j + 1]; ++e) {
      const Entry& entry = entry_[e];
      const Block& block = value[entry.source];
      float* at = panel + 3 * static_cast<std::size_t>(j - s.begin) * s.stride + 3 * task.local[entry.row];
      const float *si = scale_.data() + 3 * entry.row, *sj = scale_.data() + 3 * j;
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r)
          at[c * s.stride + r] = si[r] * sj[c] * (entry.transposed ? block(c, r) : block(r, c));
    }
}

void BlockCholesky::take_updates(std::size_t k, Task& task) {
  const Supernode& s = supernode_[k];
  task.update.clear();
  double work = 0.0;
  for (std::int32_t d = head_[k]; d != -1;) {
    const std::int32_t after = next_[d];
    const Supernode& t = supernode_[d];
    const std::int32_t* rows = row_.data() + t.row;
    Update u{d, done_[d], done_[d]};
    while (u.to < t.rows && rows[u.to] < s.end) ++u.to;
    task.update.push_back(u);
    work += static_cast<double>(t.rows - u.from) * (u.to - u.from) * (t.end - t.begin);
    done_[d] = u.to;
    if (u.to < t.rows && task_of_[supernode_of_[rows[u.to]]] == task_of_[k]) hand_on(d);
    d = after;
  }
  if (&task != &task_.back() || work < kWorthSharing) return take_rows(s, task, 0, s.rows, task.scratch);
  const std::int32_t count = (s.rows + kSharedRows - 1) / kSharedRows;
  parallel_for(static_cast<std::size_t>(count), [&](std::size_t c) {
    auto scratch = scratch_->borrow();
    const auto begin = static_cast<std::int32_t>(c) * kSharedRows;
    take_rows(s, task, begin, std::min(s.rows, begin + kSharedRows), *scratch);
  });
}

void BlockCholesky::take_rows(const Supernode& s, const Task& task, std::int32_t begin, std::int32_t end,
                              Scratch& scratch) {
  float* panel = panel_.data() + s.panel;
  for (const Update& u : task.update) {
    const Supernode& t = supernode_[u.supernode];
    const std::int32_t* rows = row_.data() + t.row;
    const auto place = [&](std::int32_t row) { return task.local[row]; };
    const auto first = std::ranges::lower_bound(rows + u.from, rows + t.rows, begin, {}, place),
               last = std::ranges::lower_bound(first, rows + t.rows, end, {}, place);
    if (first == last) continue;
    const auto at = [&](const std::int32_t* row) {
      return panel_.data() + t.panel + 3 * static_cast<std::size_t>(row - rows);
    };
    const std::size_t height = 3 * static_cast<std::size_t>(last - first), out = panel::padded(height),
                      columns = 3 * static_cast<std::size_t>(u.to - u.from);
    make_room(scratch.product, out * columns + 2 * panel::kPad);
    panel::multiply_transposed(at(first), at(rows + u.from), t.stride, height, columns,
                               3 * static_cast<std::size_t>(t.end - t.begin), scratch.product.data());
    // Rows that follow one another here and there are taken together. What lies above the diagonal means nothing.
    scratch.run.clear(), scratch.column.clear();
    for (const std::int32_t* row = first; row != last; ++row) {
      const std::size_t in_panel = 3 * static_cast<std::size_t>(place(*row));
      if (row == first || in_panel != scratch.run.back().in_panel + scratch.run.back().length)
        scratch.run.push_back({3 * static_cast<std::size_t>(row - first), in_panel, 0});
      scratch.run.back().length += 3;
    }
    for (std::int32_t j = u.from; j < u.to; ++j)
      for (std::size_t c = 0; c < 3; ++c)
        scratch.column.push_back(panel + (3 * static_cast<std::size_t>(rows[j] - s.begin) + c) * s.stride);
    panel::subtract_runs(scratch.product.data(), out, scratch.run.data(), scratch.run.size(), scratch.column.data(),
                         scratch.column.size());
  }
}

void BlockCholesky::hand_on(std::int32_t k) {
  const Supernode& s = supernode_[k];
  const std::int32_t target = supernode_of_[row_[s.row + done_[k]]];
  next_[k] = head_[target];
  head_[target] = k;
}

void BlockCholesky::write_stream(const Supernode& s) {
  with_stream(s, [&](const auto& stream) {
    panel::make_stream(panel_.data() + s.panel, s.stride, 3 * static_cast<std::size_t>(s.rows),
                       3 * static_cast<std::size_t>(s.end - s.begin), stream);
  });
}

void BlockCholesky::factor(Task& task, std::span<const Block> value) {
  task.lifted = 0;
  const bool top = &task == &task_.back();
  for (const std::int32_t k : task.supernode) {
    const Supernode& s = supernode_[k];
    const std::int32_t width = s.end - s.begin;
    load(s, value, task);
    take_updates(k, task);
    const std::size_t rows = 3 * static_cast<std::size_t>(s.rows), columns = 3 * static_cast<std::size_t>(width);
    if (top && static_cast<double>(s.rows) * width * width > 2.0 * kWorthSharing) {
      task.lifted += factor_shared(s);
    } else {
      make_room(task.scratch.product, panel::padded(rows) * panel::kBlock + 2 * panel::kPad);
      task.lifted += panel::factor(panel_.data() + s.panel, s.stride, rows, columns, task.scratch.product.data());
    }
    if (!top) write_stream(s);
    done_[k] = width;
    if (width < s.rows && task_of_[supernode_of_[row_[s.row + width]]] == task_of_[k]) hand_on(k);
  }
  if (top) parallel_for(task.supernode.size(), [&](std::size_t i) { write_stream(supernode_[task.supernode[i]]); });
}

int BlockCholesky::factor_shared(const Supernode& s) {
  float* panel = panel_.data() + s.panel;
  const std::size_t rows = 3 * static_cast<std::size_t>(s.rows), width = 3 * static_cast<std::size_t>(s.end - s.begin);
  constexpr std::size_t kRows = 3 * static_cast<std::size_t>(kSharedRows);
  const auto with_room = [&](std::size_t n, const auto& f) {
    auto scratch = scratch_->borrow();
    make_room(scratch->product, panel::padded(n) * panel::kBlock + 2 * panel::kPad);
    f(scratch->product.data());
  };
  int lifted = 0;
  for (std::size_t first = 0; first < width; first += kSharedColumns) {
    // A square by one thread, then the rows below it by all.
    const std::size_t end = std::min(width, first + kSharedColumns);
    const auto for_blocks = [&](const auto& f) {
      for (std::size_t c = first; c < end; c += panel::kBlock) f(c, std::min(panel::kBlock, end - c));
    };
    with_room(end - first, [&](float* room) {
      for_blocks([&](std::size_t c, std::size_t block) {
        lifted += panel::factor_square(panel, s.stride, c, block, room);
        if (c + block < end) panel::factor_rows(panel, s.stride, c, block, c + block, end - c - block, room);
      });
    });
    parallel_for((rows - end + kRows - 1) / kRows, [&](std::size_t k) {
      const std::size_t from = end + k * kRows, n = std::min(kRows, rows - from);
      with_room(n, [&](float* room) {
        for_blocks(
            [&](std::size_t c, std::size_t block) { panel::factor_rows(panel, s.stride, c, block, from, n, room); });
      });
    });
  }
  return lifted;
}

int BlockCholesky::factor(std::span<const Block> value) {
  const std::size_t n = order_.size();
  for (std::size_t j = 0; j < n; ++j)
    for (std::int32_t e = entry_first_[j]; e < entry_first_[j + 1]; ++e)
      if (entry_[e].row == static_cast<std::int32_t>(j))
        for (int a = 0; a < 3; ++a) {
          const float d = value[entry_[e].source](a, a);
          scale_[3 * j + a] = d > 0.0f ? 1.0f / std::sqrt(d) : 1.0f;
        }
  head_.assign(supernode_.size(), -1);
  next_.assign(supernode_.size(), -1);
  done_.resize(supernode_.size());
  Task& top = task_.back();
  parallel_for(task_.size() - 1, [&](std::size_t t) { factor(task_[t], value); });
  for (std::size_t t = 0; t + 1 < task_.size(); ++t)
    for (const std::int32_t k : task_[t].supernode)
      if (done_[k] < supernode_[k].rows) hand_on(k);
  factor(top, value);
  int lifted = 0;
  for (const Task& t : task_) lifted += t.lifted;
  return lifted;
}

void BlockCholesky::solve_forward(Task& task) {
  std::fill(task.above.begin(), task.above.end(), 0.0f);
  float* y = task.rows.data();
  for (const std::int32_t k : task.supernode) {
    const Supernode& s = supernode_[k];
    const std::size_t width = static_cast<std::size_t>(s.end - s.begin), rows = static_cast<std::size_t>(s.rows);
    float* x = x_.data() + 3 * static_cast<std::size_t>(s.begin);
    std::copy(x, x + 3 * width, y);
    std::fill(y + 3 * width, y + 3 * rows + panel::kPad, 0.0f);
    with_stream(s, [&](const auto& stream) { panel::solve_forward(stream, 3 * rows, 3 * width, y); });
    std::copy(y, y + 3 * width, x);
    const float* below = y + 3 * width;
    for (const RowRun& run : runs_of(k)) {
      add(below, run.floats, run.above < 0 ? x_.data() + run.place : task.above.data() + run.above);
      below += run.floats;
    }
  }
}

void BlockCholesky::solve_backward(Task& task) {
  float* y = task.rows.data();
  for (std::size_t n = task.supernode.size(); n-- > 0;) {
    const Supernode& s = supernode_[task.supernode[n]];
    const std::size_t width = static_cast<std::size_t>(s.end - s.begin), rows = static_cast<std::size_t>(s.rows);
    std::copy_n(x_.data() + 3 * static_cast<std::size_t>(s.begin), 3 * width, y);
    float* below = y + 3 * width;
    for (const RowRun& run : runs_of(task.supernode[n])) {
      copy(x_.data() + run.place, run.floats, below);
      below += run.floats;
    }
    std::fill_n(y + 3 * rows, panel::kPad, 0.0f);
    with_stream(s, [&](const auto& stream) { panel::solve_backward(stream, 3 * rows, 3 * width, y); });
    std::copy(y, y + 3 * width, x_.data() + 3 * static_cast<std::size_t>(s.begin));
  }
}

void BlockCholesky::solve(std::span<float> x) {
  const std::size_t n = order_.size();
  for (std::size_t j = 0; j < n; ++j)
    for (int a = 0; a < 3; ++a) x_[3 * j + a] = scale_[3 * j + a] * x[3 * order_[j] + a];
  Task& top = task_.back();
  parallel_for(task_.size() - 1, [&](std::size_t t) { solve_forward(task_[t]); });
  for (std::size_t t = 0; t + 1 < task_.size(); ++t)
    for (const std::int32_t k : top.supernode)
      for (std::size_t j = 3 * supernode_[k].begin, at = 3 * top_place_[supernode_[k].begin];
           j < 3 * static_cast<std::size_t>(supernode_[k].end); ++j, ++at)
        x_[j] += task_[t].above[at];
  solve_forward(top);
  solve_backward(top);
  parallel_for(task_.size() - 1, [&](std::size_t t) { solve_backward(task_[t]); });
  for (std::size_t j = 0; j < n; ++j)
    for (int a = 0; a < 3; ++a) x[3 * order_[j] + a] = scale_[3 * j + a] * x_[3 * j + a];
}

}  // namespace brim
