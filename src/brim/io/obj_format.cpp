#include <string>
#include <string_view>

#include "brim/io/file_cursor.h"
#include "brim/io/polygon_soup.h"

namespace brim {

namespace {

/// Lines of an OBJ file, those that end with a backslash joined to the next, and the words of the line.
class ObjLines {
 public:
  explicit ObjLines(FileCursor& file) : file_(file) {}

  /// @return false at the end of the file
  bool next() {
    if (file_.left() == 0) return false;
    rest_ = take();
    if (rest_.ends_with('\\')) {
      joined_.clear();
      while (rest_.ends_with('\\')) {
        joined_.append(rest_.substr(0, rest_.size() - 1)).push_back(' ');
        rest_ = file_.left() > 0 ? take() : std::string_view();
      }
      joined_.append(rest_);
      rest_ = joined_;
    }
    rest_ = rest_.substr(0, rest_.find('#'));
    return true;
  }
  std::string_view word() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t"), rest_.size()));
    const std::string_view w = rest_.substr(0, rest_.find_first_of(" \t"));
    rest_.remove_prefix(w.size());
    return w;
  }
  [[noreturn]] void fail(const std::string& reason) const { file_.fail(fmt::format("line {}: {}", line_, reason)); }
  template <class T>
  T number(std::string_view w, const char* what) const {
    const std::string_view digits = w.starts_with('+') ? w.substr(1) : w;
    T value{};
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size())
      fail(fmt::format("'{}' stands where {} should", w.substr(0, 40), what));
    return value;
  }

 private:
  std::string_view take() {
    ++line_;
    return file_.line();
  }
  FileCursor& file_;
  std::string joined_;
  std::string_view rest_;
  std::size_t line_ = 0;
};

/// "v x y z", "v x y z w" or colours after the position.
Vec3 vertex_of(ObjLines& lines) {
  Vec3 x;
  for (int a = 0; a < 3; ++a) x[a] = lines.number<double>(lines.word(), "a coordinate");
  const std::string_view w = lines.word();
  if (w.empty() || !lines.word().empty()) return x;
  const double weight = lines.number<double>(w, "the weight of a vertex");
  if (weight == 0.0) lines.fail("the weight of a vertex is 0");
  return x / weight;
}

}  // namespace

PolygonSoup read_obj(const std::filesystem::path& path) {
  FileCursor file(path);
  ObjLines lines(file);
  PolygonSoup soup;
  // Faces may stand before their vertices: they are split at the end. Indices count from 0 here.
  std::vector<std::int64_t> corner;
  std::vector<std::size_t> first{0};
  while (lines.next()) {
    const std::string_view kind = lines.word();
    if (kind == "v") {
      soup.vertices.push_back(vertex_of(lines));
    } else if (kind == "f") {
      for (std::string_view w = lines.word(); !w.empty(); w = lines.word()) {
        // Position, texture and normal: "1", "1/2", "1/2/3", "1//3".
        const auto i = lines.number<std::int32_t>(w.substr(0, w.find('/')), "a vertex of a face");
        if (i == 0) lines.fail("a face names vertex 0; they are counted from 1, or from -1 backwards");
        const std::int64_t at = i > 0 ? std::int64_t{i} - 1 : static_cast<std::int64_t>(soup.vertices.size()) + i;
        if (at < 0) lines.fail(fmt::format("a face names vertex {}; there are {} so far", i, soup.vertices.size()));
        corner.push_back(at);
      }
      if (corner.size() - first.back() > PolygonSoup::kMostCorners)
        lines.fail(fmt::format("a face has {} corners; at most {} are taken", corner.size() - first.back(),
                               PolygonSoup::kMostCorners));
      first.push_back(corner.size());
    }
  }
  std::vector<std::int32_t> face;
  for (std::size_t f = 0; f + 1 < first.size(); ++f) {
    face.clear();
    for (std::size_t k = first[f]; k < first[f + 1]; ++k) {
      if (corner[k] >= static_cast<std::int64_t>(soup.vertices.size()))
        file.fail(fmt::format("face {} names vertex {}; there are {}", f + 1, corner[k] + 1, soup.vertices.size()));
      face.push_back(static_cast<std::int32_t>(corner[k]));
    }
    soup.add(face);
  }
  return soup;
}

}  // namespace brim
