#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/core/parallel.h"
#include "brim/math/types.h"

namespace brim {

/// Order in which elements (tetrahedra, triangles, hinges, springs) may scatter to shared nodes, in parallel and
/// without atomics:
///
///   elements sorted along a Morton curve -> chunks of neighbours -> chunks coloured so that no two of a colour
///   share a node; colours run one after the other, the chunks of a colour in parallel, a chunk in order.
///
/// Each node receives its contributions in the same order for any number of threads, hence the same bits.
class ElementSchedule {
 public:
  /// @param node_of  nodes of all elements, shape (elements · per_element)
  /// @param x        positions of the nodes, [m], to find neighbours
  void build(std::span<const std::int32_t> node_of, int per_element, std::span<const Vec3> x);

  /// order()[k] is the element at place k. Store element data by place, so that memory is read in order.
  std::span<const std::int32_t> order() const { return order_; }
  std::size_t size() const { return order_.size(); }
  int colors() const { return static_cast<int>(color_first_.size()) - 1; }

  /// Calls f(begin, end) for every chunk of places. All chunks but one have kChunk elements.
  static constexpr std::size_t kChunk = 64;
  template <class F>
  void for_chunks(const F& f) const {
    for (std::size_t c = 0; c + 1 < color_first_.size(); ++c) {
      const std::size_t first = color_first_[c];
      parallel_for(color_first_[c + 1] - first, [&](std::size_t i) {
        f(static_cast<std::size_t>(chunk_first_[first + i]), static_cast<std::size_t>(chunk_first_[first + i + 1]));
      });
    }
  }

  /// Calls f(k) for every place k.
  template <class F>
  void for_each(const F& f) const {
    for_chunks([&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) f(k);
    });
  }

 private:
  std::vector<std::int32_t> order_, chunk_first_, color_first_;
};

}  // namespace brim
