#include <string_view>

#include "brim/io/file_cursor.h"
#include "brim/io/polygon_soup.h"

namespace brim {

namespace {

/// Lines of an OFF file without comments and empty ones, and the words of the line.
class OffLines {
 public:
  explicit OffLines(FileCursor& file) : file_(file) {}

  void next(const char* what) {
    do {
      if (file_.left() == 0) file_.fail(fmt::format("the file ends where {} should stand", what));
      rest_ = file_.line();
      rest_ = rest_.substr(0, rest_.find('#'));
      skip();
    } while (rest_.empty());
  }
  bool empty() const { return rest_.empty(); }
  std::string_view word() {
    const std::string_view w = rest_.substr(0, rest_.find_first_of(" \t"));
    rest_.remove_prefix(w.size());
    skip();
    return w;
  }
  template <class T>
  T number(const char* what) {
    std::string_view w = word();
    if (!w.empty() && w.front() == '+') w.remove_prefix(1);
    T value{};
    const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), value);
    if (error != std::errc() || end != w.data() + w.size() || w.empty())
      file_.fail(fmt::format("'{}' stands where {} should", w.substr(0, 40), what));
    return value;
  }

 private:
  void skip() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t"), rest_.size())); }
  FileCursor& file_;
  std::string_view rest_;
};

}  // namespace

PolygonSoup read_off(const std::filesystem::path& path) {
  FileCursor file(path);
  OffLines lines(file);
  lines.next("\"OFF\"");
  const std::string_view head = lines.word();
  // ST, C and N before it say that vertices have textures, colours and normals after their positions.
  if (!head.ends_with("OFF") || head.find_first_of("4n") != std::string_view::npos)
    file.fail("not a readable off mesh: it must begin with \"OFF\", in text and three dimensions");
  if (lines.empty()) lines.next("the number of vertices");
  const auto vertices = lines.number<std::uint32_t>("the number of vertices");
  const auto faces = lines.number<std::uint32_t>("the number of faces");
  file.expect(vertices, 6, "vertices");  // "0 0 0" and the end of the line
  file.expect(faces, 2, "faces");
  PolygonSoup soup;
  soup.vertices.reserve(vertices);
  for (std::uint32_t v = 0; v < vertices; ++v) {
    lines.next("a vertex");
    Vec3 x;
    for (int a = 0; a < 3; ++a) x[a] = lines.number<double>("a coordinate");
    soup.vertices.push_back(x);
  }
  std::vector<std::int32_t> corners;
  for (std::uint32_t f = 0; f < faces; ++f) {
    lines.next("a face");
    const auto count = lines.number<std::uint32_t>("the number of corners");
    if (count > PolygonSoup::kMostCorners)
      file.fail(fmt::format("face {} has {} corners; at most {} are taken", f, count, PolygonSoup::kMostCorners));
    corners.clear();
    for (std::uint32_t k = 0; k < count; ++k) {
      const auto i = lines.number<std::int64_t>("a vertex of a face");
      if (i < 0 || i >= vertices)
        file.fail(fmt::format("face {} names vertex {}; it must be from 0 to {}", f, i, std::int64_t{vertices} - 1));
      corners.push_back(static_cast<std::int32_t>(i));
    }
    soup.add(corners);
  }
  return soup;
}

}  // namespace brim
