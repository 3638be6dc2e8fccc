#include "brim/record/export/format.h"

namespace brim::exporting {

std::vector<std::vector<std::int32_t>> chains(std::span<const std::array<std::int32_t, 2>> lines,
                                              std::size_t vertices) {
  // Segments at each vertex, two remembered: a chain goes on only where exactly two meet.
  std::vector<std::array<std::int32_t, 2>> at(vertices, {-1, -1});
  std::vector<std::int32_t> degree(vertices, 0);
  for (std::size_t s = 0; s < lines.size(); ++s)
    for (const std::int32_t v : lines[s]) {
      auto& d = degree[static_cast<std::size_t>(v)];
      if (d < 2) at[static_cast<std::size_t>(v)][static_cast<std::size_t>(d)] = static_cast<std::int32_t>(s);
      ++d;
    }
  std::vector<char> used(lines.size(), 0);
  std::vector<std::vector<std::int32_t>> list;
  const auto walk = [&](std::size_t segment, std::int32_t from) {
    std::vector<std::int32_t> chain = {from};
    for (;;) {
      used[segment] = 1;
      const auto [a, b] = lines[segment];
      const std::int32_t next = chain.back() == a ? b : a;
      chain.push_back(next);
      const auto n = static_cast<std::size_t>(next);
      if (degree[n] != 2) break;
      const auto other = static_cast<std::size_t>(at[n][0] == static_cast<std::int32_t>(segment) ? at[n][1] : at[n][0]);
      if (used[other]) break;
      segment = other;
    }
    list.push_back(std::move(chain));
  };
  // From ends and branchings first; what is left are closed chains.
  for (std::size_t s = 0; s < lines.size(); ++s)
    for (const std::int32_t v : lines[s])
      if (!used[s] && degree[static_cast<std::size_t>(v)] != 2) walk(s, v);
  for (std::size_t s = 0; s < lines.size(); ++s)
    if (!used[s]) walk(s, lines[s][0]);
  return list;
}

}  // namespace brim::exporting
