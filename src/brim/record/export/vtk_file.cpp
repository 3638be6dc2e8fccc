#include "brim/record/export/vtk_file.h"

#include <fmt/format.h>

#include <numeric>

#include "brim/record/export/output_file.h"

namespace brim::exporting {

std::string VtkFile::append(const char* type, const char* name, int components, const void* values, std::size_t bytes) {
  const std::string tag =
      fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
                  type, name, components, data_.size());
  const std::uint64_t size = bytes;
  data_.append(reinterpret_cast<const char*>(&size), sizeof size);
  data_.append(static_cast<const char*>(values), bytes);
  return tag;
}

std::string VtkFile::vectors(const char* name, const std::vector<Vec3f>& values) {
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  return append("Float32", name, 3, values.data(), values.size() * sizeof(Vec3f));
}

std::string VtkFile::cells(const char* tag, const std::vector<std::int32_t>& corners, int size, std::uint8_t type) {
  std::vector<std::int32_t> ends(corners.size() / static_cast<std::size_t>(size));
  for (std::size_t c = 0; c < ends.size(); ++c) ends[c] = static_cast<std::int32_t>(c + 1) * size;
  std::string text =
      fmt::format("<{}>\n{}{}", tag, array("Int32", "connectivity", 1, corners), array("Int32", "offsets", 1, ends));
  if (type != 0) text += array("UInt8", "types", 1, std::vector<std::uint8_t>(ends.size(), type));
  return text + fmt::format("</{}>\n", tag);
}

void VtkFile::write(const std::filesystem::path& path, const char* data, const std::string& piece, double time) {
  OutputFile file(path);
  file.write(
      fmt::format("<?xml version=\"1.0\"?>\n<VTKFile type=\"{0}\" version=\"1.0\" byte_order=\"LittleEndian\" "
                  "header_type=\"UInt64\">\n<{0}>\n<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" "
                  "NumberOfTuples=\"1\" format=\"ascii\">{1}</DataArray>\n</FieldData>\n",
                  data, time));
  file.write(fmt::format("{}</{}>\n<AppendedData encoding=\"raw\">\n_", piece, data));
  file.write(data_);
  file.write("\n</AppendedData>\n</VTKFile>\n");
  file.close();
}

std::vector<std::int32_t> each(std::size_t n) {
  std::vector<std::int32_t> list(n);
  std::iota(list.begin(), list.end(), 0);
  return list;
}

}  // namespace brim::exporting
