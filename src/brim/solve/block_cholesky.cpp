#include "brim/solve/block_cholesky.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "brim/solve/panel.h"

namespace brim {

namespace {

/// Zeros that joining two supernodes may add, over the entries of both: panels of few columns are slow.
constexpr double kZeros = 0.25;
/// [block columns] panels are joined more freely up to this width.
constexpr std::int32_t kNarrow = 4;
constexpr double kNarrowZeros = 0.5;

/// Parent of each column in the elimination tree of a lower triangle given by rows (Liu 1986).
std::vector<std::int32_t> elimination_tree(std::span<const std::vector<std::int32_t>> below_diagonal) {
  const auto n = static_cast<std::int32_t>(below_diagonal.size());
  std::vector<std::int32_t> parent(n, -1), ancestor(n, -1);
  for (std::int32_t i = 0; i < n; ++i)
    for (std::int32_t j : below_diagonal[i])
      while (j != -1 && j < i) {
        const std::int32_t next = ancestor[j];
        ancestor[j] = i;
        if (next == -1) parent[j] = i;
        j = next;
      }
  return parent;
}

/// Children before parents, each subtree in one run; the order of children is kept.
std::vector<std::int32_t> postorder(std::span<const std::int32_t> parent) {
  const auto n = static_cast<std::int32_t>(parent.size());
  std::vector<std::int32_t> child(n + 1, -1), sibling(n, -1), order, stack;
  for (std::int32_t j = n; j-- > 0;) {
    const std::int32_t p = parent[j] < 0 ? n : parent[j];
    sibling[j] = child[p];
    child[p] = j;
  }
  order.reserve(n);
  for (std::int32_t root = child[n]; root != -1; root = sibling[root]) {
    stack.push_back(root);
    while (!stack.empty()) {
      const std::int32_t j = stack.back();
      if (child[j] != -1) {
        stack.push_back(child[j]);
        child[j] = -1;
        // The siblings of a child follow once it is done.
        continue;
      }
      stack.pop_back();
      order.push_back(j);
      if (j != root && sibling[j] != -1) stack.push_back(sibling[j]);
    }
  }
  return order;
}

}  // namespace

void BlockCholesky::analyze(std::span<const std::int32_t> first, std::span<const std::int32_t> column) {
  find_order(first, column);
  find_structure(first, column);
}

void BlockCholesky::find_order(std::span<const std::int32_t> first, std::span<const std::int32_t> column) {
  const auto n = static_cast<Eigen::Index>(first.size()) - 1;
  using Pattern = Eigen::SparseMatrix<char, Eigen::ColMajor, std::int32_t>;
  // The whole pattern, as the ordering wants it.
  std::vector<std::int32_t> count(n + 1, 0);
  for (Eigen::Index r = 0; r < n; ++r)
    for (std::int32_t e = first[r]; e < first[r + 1]; ++e) {
      ++count[r + 1];
      if (column[e] != r) ++count[column[e] + 1];
    }
  for (Eigen::Index r = 0; r < n; ++r) count[r + 1] += count[r];
  std::vector<std::int32_t> next(count.begin(), count.end() - 1), index(count[n]);
  std::vector<char> one(count[n], 1);
  for (Eigen::Index r = 0; r < n; ++r)
    for (std::int32_t e = first[r]; e < first[r + 1]; ++e) {
      index[next[column[e]]++] = static_cast<std::int32_t>(r);
      if (column[e] != r) index[next[r]++] = column[e];
    }
  const Eigen::Map<const Pattern> pattern(n, n, count[n], count.data(), index.data(), one.data());
  Pattern matrix = pattern;
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, std::int32_t> minimum;
  Eigen::AMDOrdering<std::int32_t>()(matrix, minimum);
  order_.assign(minimum.indices().data(), minimum.indices().data() + n);
}

void BlockCholesky::find_structure(std::span<const std::int32_t> first, std::span<const std::int32_t> column) {
  const auto n = static_cast<std::int32_t>(order_.size());
  place_.resize(n);
  std::vector<std::vector<std::int32_t>> lower(n);  // by rows, in the order at hand
  const auto arrange = [&] {
    for (std::int32_t i = 0; i < n; ++i) place_[order_[i]] = i;
    for (auto& row : lower) row.clear();
    for (std::int32_t r = 0; r < n; ++r)
      for (std::int32_t e = first[r]; e < first[r + 1]; ++e) {
        const std::int32_t a = place_[r], b = place_[column[e]];
        if (a != b) lower[std::max(a, b)].push_back(std::min(a, b));
      }
    for (auto& row : lower) std::sort(row.begin(), row.end());
  };
  arrange();
  const std::vector<std::int32_t> post = postorder(elimination_tree(lower));
  std::vector<std::int32_t> renewed(n);
  for (std::int32_t i = 0; i < n; ++i) renewed[i] = order_[post[i]];
  order_ = renewed;
  arrange();
  const std::vector<std::int32_t> parent = elimination_tree(lower);

  // Entries by columns, and the rows of each column of the factor: its own and those of its children.
  entry_first_.assign(n + 1, 0);
  for (std::int32_t r = 0; r < n; ++r)
    for (std::int32_t e = first[r]; e < first[r + 1]; ++e) ++entry_first_[std::min(place_[r], place_[column[e]]) + 1];
  for (std::int32_t j = 0; j < n; ++j) entry_first_[j + 1] += entry_first_[j];
  entry_.resize(entry_first_[n]);
  std::vector<std::int32_t> next(entry_first_.begin(), entry_first_.end() - 1);
  for (std::int32_t r = 0; r < n; ++r)
    for (std::int32_t e = first[r]; e < first[r + 1]; ++e) {
      const std::int32_t a = place_[r], b = place_[column[e]];
      // The pattern has block (r, column); the lower triangle wants (max, min).
      entry_[next[std::min(a, b)]++] = {std::max(a, b), e, a < b};
    }

  std::vector<std::vector<std::int32_t>> rows(n), children(n);
  std::vector<std::int32_t> mark(n, -1), count(n);
  for (std::int32_t j = 0; j < n; ++j) {
    std::vector<std::int32_t>& mine = rows[j];
    mark[j] = j;
    const auto add = [&](std::int32_t i) {
      if (i > j && mark[i] != j) mark[i] = j, mine.push_back(i);
    };
    for (std::int32_t e = entry_first_[j]; e < entry_first_[j + 1]; ++e) add(entry_[e].row);
    for (const std::int32_t c : children[j]) {
      for (const std::int32_t i : rows[c]) add(i);
      // A child whose pattern is that of its parent lives on in it.
      if (c != j - 1) rows[c].shrink_to_fit();
    }
    std::sort(mine.begin(), mine.end());
    count[j] = static_cast<std::int32_t>(mine.size()) + 1;
    if (parent[j] >= 0) children[parent[j]].push_back(j);
  }

  // Supernodes: a column joins the one before it where that costs few zeros.
  supernode_.clear(), row_.clear();
  std::int32_t begin = 0;
  double zeros = 0.0;
  const auto close = [&](std::int32_t end) {
    Supernode s;
    s.begin = begin, s.end = end;
    s.row = row_.size();
    for (std::int32_t j = begin; j < end; ++j) row_.push_back(j);
    row_.insert(row_.end(), rows[end - 1].begin(), rows[end - 1].end());
    s.rows = static_cast<std::int32_t>(row_.size() - s.row);
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
  std::size_t total = 0;
  std::int32_t most = 0;
  supernode_of_.resize(n);
  for (std::size_t k = 0; k < supernode_.size(); ++k) {
    Supernode& s = supernode_[k];
    for (std::int32_t j = s.begin; j < s.end; ++j) supernode_of_[j] = static_cast<std::int32_t>(k);
    s.stride = panel::padded(3 * static_cast<std::size_t>(s.rows));
    s.panel = total;
    total += s.stride * 3 * static_cast<std::size_t>(s.end - s.begin);
    most = std::max(most, s.rows);
  }
  panel_.resize(total + 2 * panel::kPad);
  const std::size_t widest = panel::padded(3 * static_cast<std::size_t>(most));
  product_.resize(widest * std::max<std::size_t>(12, 3 * static_cast<std::size_t>(most)) + 2 * panel::kPad);
  below_.resize(widest + panel::kPad);
  local_.assign(n, 0);
  scale_.resize(3 * static_cast<std::size_t>(n));
  x_.resize(3 * static_cast<std::size_t>(n));
}

void BlockCholesky::load(const Supernode& s, std::span<const Block> value) {
  float* panel = panel_.data() + s.panel;
  std::fill(panel, panel + s.stride * 3 * static_cast<std::size_t>(s.end - s.begin), 0.0f);
  for (std::int32_t i = 0; i < s.rows; ++i) local_[row_[s.row + i]] = i;
  for (std::int32_t j = s.begin; j < s.end; ++j)
    for (std::int32_t e = entry_first_[j]; e < entry_first_[j + 1]; ++e) {
      const Entry& entry = entry_[e];
      const Block& block = value[entry.source];
      float* at = panel + 3 * static_cast<std::size_t>(j - s.begin) * s.stride + 3 * local_[entry.row];
      const float *si = scale_.data() + 3 * entry.row, *sj = scale_.data() + 3 * j;
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r)
          at[c * s.stride + r] = si[r] * sj[c] * (entry.transposed ? block(c, r) : block(r, c));
    }
}

void BlockCholesky::take_updates(std::size_t k) {
  const Supernode& s = supernode_[k];
  float* panel = panel_.data() + s.panel;
  for (std::int32_t d = head_[k]; d != -1;) {
    const std::int32_t after = next_[d];
    const Supernode& t = supernode_[d];
    const std::int32_t* rows = row_.data() + t.row;
    const std::int32_t from = done_[d];
    std::int32_t to = from;
    while (to < t.rows && rows[to] < s.end) ++to;
    const float* a = panel_.data() + t.panel + 3 * from;
    const std::size_t height = 3 * static_cast<std::size_t>(t.rows - from), out = panel::padded(height);
    panel::multiply_transposed(a, a, t.stride, height, 3 * static_cast<std::size_t>(to - from),
                               3 * static_cast<std::size_t>(t.end - t.begin), product_.data());
    for (std::int32_t j = from; j < to; ++j)
      for (int c = 0; c < 3; ++c) {
        float* column = panel + (3 * static_cast<std::size_t>(rows[j] - s.begin) + c) * s.stride;
        const float* p = product_.data() + (3 * static_cast<std::size_t>(j - from) + c) * out;
        for (std::int32_t i = j; i < t.rows; ++i) {
          float* y = column + 3 * local_[rows[i]];
          const float* x = p + 3 * (i - from);
          y[0] -= x[0], y[1] -= x[1], y[2] -= x[2];
        }
      }
    done_[d] = to;
    if (to < t.rows) {
      const std::int32_t target = supernode_of_[rows[to]];
      next_[d] = head_[target];
      head_[target] = d;
    }
    d = after;
  }
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
  int lifted = 0;
  for (std::size_t k = 0; k < supernode_.size(); ++k) {
    const Supernode& s = supernode_[k];
    const std::int32_t width = s.end - s.begin;
    load(s, value);
    take_updates(k);
    lifted += panel::factor(panel_.data() + s.panel, s.stride, 3 * static_cast<std::size_t>(s.rows),
                            3 * static_cast<std::size_t>(width), product_.data());
    done_[k] = width;
    if (width < s.rows) {
      const std::int32_t target = supernode_of_[row_[s.row + width]];
      next_[k] = head_[target];
      head_[target] = static_cast<std::int32_t>(k);
    }
  }
  return lifted;
}

void BlockCholesky::solve(std::span<float> x) {
  const std::size_t n = order_.size();
  for (std::size_t j = 0; j < n; ++j)
    for (int a = 0; a < 3; ++a) x_[3 * j + a] = scale_[3 * j + a] * x[3 * order_[j] + a];
  const auto parts = [&](const Supernode& s, auto&& f) {
    f(panel_.data() + s.panel, 3 * static_cast<std::size_t>(s.rows), 3 * static_cast<std::size_t>(s.end - s.begin),
      row_.data() + s.row + (s.end - s.begin), static_cast<std::size_t>(s.rows - (s.end - s.begin)));
  };
  for (const Supernode& s : supernode_)
    parts(s, [&](const float* panel, std::size_t rows, std::size_t width, const std::int32_t* under, std::size_t m) {
      panel::solve_forward(panel, s.stride, rows, width, x_.data() + 3 * s.begin, below_.data());
      for (std::size_t i = 0; i < m; ++i)
        for (int a = 0; a < 3; ++a) x_[3 * static_cast<std::size_t>(under[i]) + a] -= below_[3 * i + a];
    });
  for (std::size_t k = supernode_.size(); k-- > 0;) {
    const Supernode& s = supernode_[k];
    parts(s, [&](const float* panel, std::size_t rows, std::size_t width, const std::int32_t* under, std::size_t m) {
      for (std::size_t i = 0; i < m; ++i)
        for (int a = 0; a < 3; ++a) below_[3 * i + a] = x_[3 * static_cast<std::size_t>(under[i]) + a];
      panel::solve_backward(panel, s.stride, rows, width, x_.data() + 3 * s.begin, below_.data());
    });
  }
  for (std::size_t j = 0; j < n; ++j)
    for (int a = 0; a < 3; ++a) x[3 * order_[j] + a] = scale_[3 * j + a] * x_[3 * j + a];
}

}  // namespace brim
