#include <cmath>
#include <optional>
#include <string>

#include "brim/io/file_cursor.h"
#include "brim/io/polygon_soup.h"

namespace brim {

namespace {

enum class Number { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };

struct Property {
  std::string name;
  Number type = Number::Float32;
  std::optional<Number> count;  ///< of a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

enum class Form { Text, Little, Big };

struct PlyHeader {
  Form form = Form::Text;
  std::vector<PlyElement> elements;
};

std::size_t bytes_of(Number type) {
  switch (type) {
    case Number::Int8:
    case Number::UInt8:
      return 1;
    case Number::Int16:
    case Number::UInt16:
      return 2;
    case Number::Int32:
    case Number::UInt32:
    case Number::Float32:
      return 4;
    case Number::Float64:
      return 8;
  }
  return 1;
}

Number number_named(const FileCursor& file, std::string_view word) {
  static constexpr std::pair<std::string_view, Number> kNames[] = {
      {"char", Number::Int8},      {"int8", Number::Int8},       {"uchar", Number::UInt8},
      {"uint8", Number::UInt8},    {"short", Number::Int16},     {"int16", Number::Int16},
      {"ushort", Number::UInt16},  {"uint16", Number::UInt16},   {"int", Number::Int32},
      {"int32", Number::Int32},    {"uint", Number::UInt32},     {"uint32", Number::UInt32},
      {"float", Number::Float32},  {"float32", Number::Float32}, {"double", Number::Float64},
      {"float64", Number::Float64}};
  for (const auto& [name, type] : kNames)
    if (word == name) return type;
  file.fail(fmt::format("'{}' is not a type of PLY", word.substr(0, 40)));
}

std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(" \t"));
  line.remove_prefix(word.size());
  return word;
}

Form form_named(const FileCursor& file, std::string_view word) {
  if (word == "ascii") return Form::Text;
  if (word == "binary_little_endian") return Form::Little;
  if (word == "binary_big_endian") return Form::Big;
  file.fail(fmt::format("'{}' is not a form of PLY", word.substr(0, 40)));
}

PlyHeader read_header(FileCursor& file) {
  if (file.line() != "ply") file.fail("not a readable ply mesh: it must begin with \"ply\"");
  PlyHeader header;
  bool has_form = false;
  while (true) {
    if (file.left() == 0) file.fail("the file ends in its header");
    std::string_view line = file.line();
    const std::string_view word = take_word(line);
    if (word == "end_header") break;
    if (word.empty() || word == "comment" || word == "obj_info") continue;
    if (word == "format") {
      header.form = form_named(file, take_word(line));
      has_form = true;
    } else if (word == "element") {
      PlyElement e;
      e.name = take_word(line);
      const std::string_view count = take_word(line);
      const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), e.count);
      if (error != std::errc() || end != count.data() + count.size())
        file.fail(fmt::format("'{}' stands where the number of an element should", count.substr(0, 40)));
      header.elements.push_back(std::move(e));
    } else if (word == "property") {
      if (header.elements.empty()) file.fail("a property stands before any element");
      Property p;
      std::string_view type = take_word(line);
      if (type == "list") {
        p.count = number_named(file, take_word(line));
        type = take_word(line);
      }
      p.type = number_named(file, type);
      p.name = take_word(line);
      header.elements.back().properties.push_back(std::move(p));
    } else {
      file.fail(fmt::format("'{}' is not a word of PLY's header", word.substr(0, 40)));
    }
  }
  if (!has_form) file.fail("does not say its format");
  return header;
}

/// Values one after another, in whichever form the file has.
class Values {
 public:
  Values(FileCursor& file, Form form) : file_(file), form_(form) {}

  /// Every type fits into a double.
  double next(Number type) {
    if (form_ == Form::Text) return file_.number<double>("a value");
    const bool swapped = (form_ == Form::Big) == (std::endian::native == std::endian::little);
    switch (type) {
      case Number::Int8:
        return file_.binary<std::int8_t>(swapped, "a value");
      case Number::UInt8:
        return file_.binary<std::uint8_t>(swapped, "a value");
      case Number::Int16:
        return file_.binary<std::int16_t>(swapped, "a value");
      case Number::UInt16:
        return file_.binary<std::uint16_t>(swapped, "a value");
      case Number::Int32:
        return file_.binary<std::int32_t>(swapped, "a value");
      case Number::UInt32:
        return file_.binary<std::uint32_t>(swapped, "a value");
      case Number::Float32:
        return file_.binary<float>(swapped, "a value");
      case Number::Float64:
        return file_.binary<double>(swapped, "a value");
    }
    return 0.0;
  }
  /// The length of a list, no longer than what is left of the file.
  std::uint64_t length(const Property& list) {
    const double n = next(*list.count);
    if (!(n >= 0.0 && n <= 4294967295.0) || n != std::floor(n))
      file_.fail(fmt::format("'{}' stands where the length of a list should", n));
    file_.expect(static_cast<std::size_t>(n), least_bytes(list.type), "values of a list");
    return static_cast<std::uint64_t>(n);
  }
  /// Fewest bytes that an item takes: in text a digit (the space after the last one may be missing).
  std::size_t least_bytes(Number type) const { return form_ == Form::Text ? 1 : bytes_of(type); }
  std::size_t least_bytes(const PlyElement& e) const {
    std::size_t sum = 0;
    for (const Property& p : e.properties) sum += least_bytes(p.count.value_or(p.type));
    return sum;
  }

 private:
  FileCursor& file_;
  Form form_;
};

void read_vertices(const FileCursor& file, Values& values, const PlyElement& e, PolygonSoup& soup) {
  int axis_seen[3] = {0, 0, 0};
  for (const Property& p : e.properties)
    for (int a = 0; a < 3; ++a)
      if (!p.count && p.name == std::string(1, static_cast<char>('x' + a))) ++axis_seen[a];
  if (axis_seen[0] != 1 || axis_seen[1] != 1 || axis_seen[2] != 1) file.fail("its vertices have no x, y and z");
  if (!soup.vertices.empty()) file.fail("has vertices twice");
  soup.vertices.reserve(e.count);
  for (std::uint64_t i = 0; i < e.count; ++i) {
    Vec3 x = Vec3::Zero();
    for (const Property& p : e.properties) {
      const std::uint64_t n = p.count ? values.length(p) : 1;
      for (std::uint64_t k = 0; k < n; ++k) {
        const double value = values.next(p.type);
        if (!p.count && p.name.size() == 1 && p.name[0] >= 'x' && p.name[0] <= 'z') x[p.name[0] - 'x'] = value;
      }
    }
    soup.vertices.push_back(x);
  }
}

void read_faces(const FileCursor& file, Values& values, const PlyElement& e, PolygonSoup& soup) {
  const auto most = static_cast<double>(soup.vertices.size()) - 1.0;
  std::vector<std::int32_t> corners;
  for (std::uint64_t i = 0; i < e.count; ++i) {
    corners.clear();
    for (const Property& p : e.properties) {
      const bool wanted = p.count && (p.name == "vertex_indices" || p.name == "vertex_index");
      const std::uint64_t n = p.count ? values.length(p) : 1;
      if (wanted && n > PolygonSoup::kMostCorners)
        file.fail(fmt::format("face {} has {} corners; at most {} are taken", i, n, PolygonSoup::kMostCorners));
      for (std::uint64_t k = 0; k < n; ++k) {
        const double value = values.next(p.type);
        if (!wanted) continue;
        if (!(value >= 0.0 && value <= most) || value != std::floor(value))
          file.fail(fmt::format("face {} names vertex {}; it must be from 0 to {}", i, value, most));
        corners.push_back(static_cast<std::int32_t>(value));
      }
    }
    soup.add(corners);
  }
}

}  // namespace

PolygonSoup read_ply(const std::filesystem::path& path) {
  FileCursor file(path);
  const PlyHeader header = read_header(file);
  Values values(file, header.form);
  PolygonSoup soup;
  for (const PlyElement& e : header.elements) {
    if (e.properties.empty()) continue;
    file.expect(e.count, values.least_bytes(e), "elements");
    if (e.name == "vertex") {
      if (e.count > 0x7fffffffu) file.fail(fmt::format("has {} vertices; at most {} are taken", e.count, 0x7fffffff));
      read_vertices(file, values, e, soup);
    } else if (e.name == "face") {
      read_faces(file, values, e, soup);
    } else {
      for (std::uint64_t i = 0; i < e.count; ++i)
        for (const Property& p : e.properties) {
          const std::uint64_t n = p.count ? values.length(p) : 1;
          for (std::uint64_t k = 0; k < n; ++k) values.next(p.type);
        }
    }
  }
  return soup;
}

}  // namespace brim
