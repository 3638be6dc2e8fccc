#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "brim/core/error.h"
#include "brim/record/h5.h"
#include "brim/record/packed.h"

namespace brim {

/// Columns of the tables of a run, with every number checked. All throw InputError, naming the file, the data set and
/// the row.

/// Reads a whole data set of rows of `width` numbers (0: scalars).
template <class T>
std::vector<T> read_column(const h5::File& file, const std::string& path, h5::Type type, std::uint64_t width = 0) {
  const h5::Dataset set = file.open(path);
  const std::uint64_t rows = set.shape()[0];
  const std::vector<std::uint64_t> row = width > 0 ? std::vector<std::uint64_t>{width} : std::vector<std::uint64_t>{};
  set.need_rows(0, rows, row);
  const std::uint64_t elements = rows * std::max<std::uint64_t>(width, 1);
  std::vector<T> values(elements * (type == h5::Type::Int32 ? 4 : 8) / sizeof(T));
  if (elements > 0) set.read(values.data(), elements, 0, rows, type);
  return values;
}

/// A column of one integer per body or part, each between least and most.
inline std::vector<std::int64_t> read_whole(const h5::File& file, const std::string& path, std::size_t rows,
                                            std::int64_t least, std::int64_t most) {
  std::vector<std::int64_t> values = read_column<std::int64_t>(file, path, h5::Type::Int64);
  if (values.size() != rows)
    throw InputError(fmt::format("{}:{}: has {} rows; it must have {}", file.path(), path, values.size(), rows));
  for (std::size_t i = 0; i < rows; ++i)
    if (values[i] < least || values[i] > most)
      throw InputError(
          fmt::format("{}:{}[{}]: is {}; it must be from {} to {}", file.path(), path, i, values[i], least, most));
  return values;
}

inline std::vector<double> read_real(const h5::File& file, const std::string& path, std::size_t rows) {
  std::vector<double> values = read_column<double>(file, path, h5::Type::Float64);
  if (values.size() != rows)
    throw InputError(fmt::format("{}:{}: has {} rows; it must have {}", file.path(), path, values.size(), rows));
  return values;
}

inline std::vector<std::string> read_names(const h5::File& file, const std::string& path, std::size_t rows) {
  std::vector<std::string> values = file.read_texts(path);
  if (values.size() != rows)
    throw InputError(fmt::format("{}:{}: has {} rows; it must have {}", file.path(), path, values.size(), rows));
  return values;
}

/// Concatenated lists: their starts must increase from 0 to the number of all items.
template <class T>
Packed<T> read_packed(const h5::File& file, const std::string& items, h5::Type type, std::uint64_t width,
                      const std::string& starts) {
  Packed<T> p{read_column<T>(file, items, type, width), read_column<std::int64_t>(file, starts, h5::Type::Int64)};
  if (p.first.empty() || p.first.front() != 0 || !std::is_sorted(p.first.begin(), p.first.end()) ||
      p.first.back() != static_cast<std::int64_t>(p.items.size()))
    throw InputError(
        fmt::format("{}:{}: must rise from 0 to the {} rows of {}", file.path(), starts, p.items.size(), items));
  return p;
}

template <std::size_t N>
void check_indices(const h5::File& file, std::span<const std::array<std::int32_t, N>> cells, std::size_t vertices,
                   const std::string& what) {
  for (const auto& cell : cells)
    for (const std::int32_t i : cell)
      if (i < 0 || static_cast<std::size_t>(i) >= vertices)
        throw InputError(fmt::format("{}:{}: names vertex {}; it must be from 0 to {}", file.path(), what, i,
                                     static_cast<std::int64_t>(vertices) - 1));
}

}  // namespace brim
