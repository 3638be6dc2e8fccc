#include "brim/solve/strong_clusters.h"

#include <bit>
#include <numeric>
#include <utility>

namespace brim {

namespace {

/// Sign and exponent of a float and the highest bits of its mantissa: steps of 6 % or less.
constexpr int kDropped = 23 - 4;
constexpr std::size_t kKeys = std::size_t{1} << (32 - kDropped);

std::size_t key_of(float strength) { return std::bit_cast<std::uint32_t>(strength) >> kDropped; }

/// Sets of rows that know their size.
class Sets {
 public:
  explicit Sets(std::size_t n) : parent_(n), size_(n, 1) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::int32_t root(std::int32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::int32_t a, std::int32_t b, std::size_t most) {
    a = root(a), b = root(b);
    if (a == b || size_[a] + size_[b] > most) return;
    if (size_[a] < size_[b]) std::swap(a, b);
    parent_[b] = a, size_[a] += size_[b];
  }

 private:
  std::vector<std::int32_t> parent_;
  std::vector<std::size_t> size_;
};

}  // namespace

std::vector<std::int32_t> strong_clusters(std::size_t rows, std::span<const Coupling> couplings, std::size_t most,
                                          std::span<const Coupling> joined) {
  Sets sets(rows);
  for (const Coupling& c : joined) sets.join(c.a, c.b, rows);
  // By falling keys; the order of equal ones is kept.
  std::vector<std::size_t> first(kKeys + 1, 0);
  for (const Coupling& c : couplings) ++first[kKeys - key_of(c.strength)];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::uint32_t> order(couplings.size());
  for (std::size_t i = 0; i < couplings.size(); ++i)
    order[first[kKeys - key_of(couplings[i].strength) - 1]++] = static_cast<std::uint32_t>(i);
  for (const std::uint32_t i : order) sets.join(couplings[i].a, couplings[i].b, most);

  std::vector<std::int32_t> cluster(rows), number(rows, -1);
  std::int32_t count = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    std::int32_t& n = number[sets.root(static_cast<std::int32_t>(i))];
    if (n < 0) n = count++;
    cluster[i] = n;
  }
  return cluster;
}

}  // namespace brim
