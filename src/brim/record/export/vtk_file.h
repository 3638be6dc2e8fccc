#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "brim/math/types.h"

namespace brim::exporting {

/// Builds one VTK XML file: numbers are appended raw behind the XML.
class VtkFile {
 public:
  /// "<DataArray .../>" for the values. @param type  VTK's name of T
  template <class T>
  std::string array(const char* type, const char* name, int components, const std::vector<T>& values) {
    return append(type, name, components, values.data(), values.size() * sizeof(T));
  }
  std::string vectors(const char* name, const std::vector<Vec3f>& values);
  /// Cells of one size within a tag. @param corners  vertex indices, shape (cells, size)
  /// @param type  VTK's number of the cells' type, for unstructured grids; 0: none
  std::string cells(const char* tag, const std::vector<std::int32_t>& corners, int size, std::uint8_t type = 0);
  /// @param data  VTK's name of the data set  @param piece  its only "<Piece ...>...</Piece>"  @param time  [s]
  void write(const std::filesystem::path& path, const char* data, const std::string& piece, double time);

 private:
  std::string append(const char* type, const char* name, int components, const void* values, std::size_t bytes);

  std::string data_;
};

/// Indices of cells of any size, one after the other.
template <class Cell>
std::vector<std::int32_t> flat_cells(const std::vector<Cell>& cells) {
  std::vector<std::int32_t> list;
  for (const Cell& c : cells) list.insert(list.end(), c.begin(), c.end());
  return list;
}

/// 0, 1, ... n - 1.
std::vector<std::int32_t> each(std::size_t n);

}  // namespace brim::exporting
