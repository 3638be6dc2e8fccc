#include <bit>
#include <string>

#include "brim/io/tet_formats.h"

namespace brim {

namespace {

constexpr int kTetra = 10, kQuadraticTetra = 24;

class VtkParser {
 public:
  explicit VtkParser(FileCursor& file) : file_(file) {}

  RawTets parse() {
    const std::string_view head = file_.line();
    if (!head.starts_with("# vtk DataFile Version"))
      file_.fail("not a legacy VTK file: the first line says something else");
    file_.line();
    const std::string_view kind = file_.word();
    if (kind != "ASCII" && kind != "BINARY") file_.fail(fmt::format("'{}' stands where ASCII or BINARY should", kind));
    binary_ = kind == "BINARY";
    file_.line();
    bool has_points = false, has_cells = false, has_types = false;
    while (!(has_points && has_cells && has_types)) {
      const std::string_view section = file_.word();
      if (section.empty())
        file_.fail(fmt::format("the file ends before its {}; truncated, or without cells", !has_points ? "POINTS"
                                                                                           : !has_cells
                                                                                               ? "CELLS"
                                                                                               : "CELL_TYPES"));
      if (section == "DATASET") {
        const std::string_view set = file_.word();
        if (set != "UNSTRUCTURED_GRID")
          file_.fail(fmt::format("tetrahedra stand in an UNSTRUCTURED_GRID, not in a {}", set));
      } else if (section == "POINTS") {
        points();
        has_points = true;
      } else if (section == "CELLS") {
        cells();
        has_cells = true;
      } else if (section == "CELL_TYPES") {
        types();
        has_types = true;
      } else if (section == "FIELD") {
        fields();
      } else if (section == "METADATA") {
        file_.line();
        while (file_.left() > 0 && !file_.line().empty()) {
        }
      } else {
        file_.fail(fmt::format("unexpected section '{}'; the file is damaged", section.substr(0, 40)));
      }
    }
    return collect();
  }

 private:
  // One number of the given VTK type.
  double real(std::string_view type, const char* what) {
    if (!binary_) return file_.number<double>(what);
    if (type == "double") return file_.binary<double>(swapped_, what);
    if (type == "float") return file_.binary<float>(swapped_, what);
    return static_cast<double>(integer(type, what));
  }

  std::int64_t integer(std::string_view type, const char* what) {
    if (!binary_) return file_.number<std::int64_t>(what);
    switch (size_of(type)) {
      case 1:
        return file_.binary<std::int8_t>(swapped_, what);
      case 2:
        return file_.binary<std::int16_t>(swapped_, what);
      case 4:
        return file_.binary<std::int32_t>(swapped_, what);
      default:
        return file_.binary<std::int64_t>(swapped_, what);
    }
  }

  std::size_t size_of(std::string_view type) const {
    if (type == "double" || type == "long" || type == "unsigned_long" || type == "vtktypeint64" || type == "vtkIdType")
      return 8;
    if (type == "float" || type == "int" || type == "unsigned_int") return 4;
    if (type == "short" || type == "unsigned_short") return 2;
    if (type == "char" || type == "unsigned_char") return 1;
    file_.fail(fmt::format("numbers of type '{}' are not supported", type.substr(0, 40)));
  }

  void points() {
    const auto n = file_.number<std::size_t>("the number of points");
    const std::string type(file_.word());
    file_.line();
    file_.expect(n, binary_ ? 3 * size_of(type) : 6, "points");
    raw_.points.resize(n);
    for (Vec3& x : raw_.points)
      for (int k = 0; k < 3; ++k) x[k] = real(type, "a coordinate");
  }

  void cells() {
    const auto n = file_.number<std::size_t>("the number of cells");
    const auto size = file_.number<std::size_t>("the size of the cell list");
    file_.line();
    file_.expect(size, binary_ ? 4 : 2, "cell entries");
    const std::size_t before = file_.place();
    // From version 5.0 on: n offsets, one more than cells, then all corners.
    if (file_.word() == "OFFSETS") {
      const std::string type(file_.word());
      file_.line();
      for (std::size_t i = 0; i < n; ++i) first_.push_back(integer(type, "a cell offset"));
      if (file_.word() != "CONNECTIVITY") file_.fail("CONNECTIVITY is missing after the cell offsets");
      const std::string index_type(file_.word());
      file_.line();
      for (std::size_t i = 0; i < size; ++i) corners_.push_back(integer(index_type, "a cell corner"));
      return;
    }
    file_.go_to(before);
    for (std::size_t i = 0; i < n; ++i) {
      const std::int64_t count = integer("int", "the size of a cell");
      if (count < 0 || static_cast<std::size_t>(count) > size)
        file_.fail(fmt::format("cell {} claims {} corners", i, count));
      first_.push_back(static_cast<std::int64_t>(corners_.size()));
      for (std::int64_t k = 0; k < count; ++k) corners_.push_back(integer("int", "a cell corner"));
    }
    first_.push_back(static_cast<std::int64_t>(corners_.size()));
  }

  void types() {
    const auto n = file_.number<std::size_t>("the number of cell types");
    file_.line();
    file_.expect(n, binary_ ? 4 : 1, "cell types");
    for (std::size_t i = 0; i < n; ++i) types_.push_back(integer("int", "a cell type"));
  }

  void fields() {
    file_.word();
    const auto arrays = file_.number<std::size_t>("the number of field arrays");
    for (std::size_t a = 0; a < arrays; ++a) {
      file_.word();
      const auto components = file_.number<std::size_t>("the number of components");
      const auto tuples = file_.number<std::size_t>("the number of tuples");
      const std::string type(file_.word());
      file_.line();
      if (type == "string") file_.fail("text fields are not supported; save the mesh without them");
      file_.expect(tuples, std::max<std::size_t>(components, 1), "field values");
      for (std::size_t i = 0; i < components * tuples; ++i) real(type, "a field value");
    }
  }

  RawTets collect() {
    const std::size_t n = first_.empty() ? 0 : first_.size() - 1;
    if (types_.size() != n) file_.fail(fmt::format("{} cells have {} cell types", n, types_.size()));
    for (std::size_t i = 0; i < n; ++i) {
      if (types_[i] != kTetra && types_[i] != kQuadraticTetra) continue;
      const std::int64_t first = first_[i], wanted = types_[i] == kTetra ? 4 : 10;
      if (first < 0 || first_[i + 1] - first != wanted || first_[i + 1] > static_cast<std::int64_t>(corners_.size()))
        file_.fail(fmt::format("cell {} is a tetrahedron but does not have {} corners", i, wanted));
      raw_.tets.push_back({corners_[first], corners_[first + 1], corners_[first + 2], corners_[first + 3]});
    }
    return std::move(raw_);
  }

  FileCursor& file_;
  RawTets raw_;
  std::vector<std::int64_t> first_, corners_, types_;
  bool binary_ = false;
  const bool swapped_ = std::endian::native == std::endian::little;  // the format is big-endian
};

}  // namespace

RawTets parse_vtk(FileCursor& file) { return VtkParser(file).parse(); }

}  // namespace brim
