#include "brim/record/export/stress_grid.h"

#include <fmt/format.h>

#include <Eigen/LU>

namespace brim::exporting {

namespace {

constexpr std::uint8_t kVertex = 1, kTetrahedron = 10;  // VTK's cell types

void append_symmetric(const Mat3& a, std::vector<float>& list) {
  for (const double x : {a(0, 0), a(1, 1), a(2, 2), a(0, 1), a(1, 2), a(0, 2)}) list.push_back(static_cast<float>(x));
}

std::string material(const StressField& field, VtkFile& file) {
  std::vector<float> stress, strain, equivalent, volume_ratio;
  for (std::size_t e = 0; e < field.size(); ++e) {
    append_symmetric(field.stress[e], stress);
    append_symmetric(green_strain(field.deformation[e]), strain);
    equivalent.push_back(static_cast<float>(von_mises(field.stress[e])));
    volume_ratio.push_back(static_cast<float>(field.deformation[e].determinant()));
  }
  std::string text = file.array("Float32", "stress", 6, stress) + file.array("Float32", "von_mises", 1, equivalent) +
                     file.array("Float32", "strain", 6, strain) +
                     file.array("Float32", "volume_ratio", 1, volume_ratio);
  if (!field.filled.empty())
    text += file.array("Float32", "filled", 1, std::vector<float>(field.filled.begin(), field.filled.end()));
  return text;
}

}  // namespace

std::string stress_piece(const StressField& field, bool samples, std::optional<std::span<const double>> v,
                         VtkFile& file) {
  std::vector<Vec3f> x;
  for (const Vec3& place : field.place) x.push_back(place.cast<float>());
  std::string piece = fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", x.size(), field.size());
  piece += "<PointData>\n";
  if (v) piece += file.array("Float32", "velocity", 3, std::vector<float>(v->begin(), v->end()));
  if (samples) piece += material(field, file);
  piece += "</PointData>\n<CellData>\n";
  if (!samples) piece += material(field, file);
  piece += "</CellData>\n<Points>\n" + file.vectors("points", x) + "</Points>\n";
  piece += samples ? file.cells("Cells", each(x.size()), 1, kVertex)
                   : file.cells("Cells", flat_cells(field.tets), 4, kTetrahedron);
  return piece + "</Piece>\n";
}

}  // namespace brim::exporting
