#include <algorithm>

#include "brim/core/error.h"
#include "brim/record/export/format.h"
#include "brim/record/export/zip_file.h"
#include "brim/record/h5.h"

namespace brim::exporting {

namespace {

using h5::Type;

struct Element {
  const char* code;  ///< as NumPy writes it
  std::size_t bytes;
};

Element element_of(Type type) {
  switch (type) {
    case Type::Float64:
      return {"<f8", 8};
    case Type::Float32:
      return {"<f4", 4};
    case Type::Int64:
      return {"<i8", 8};
    case Type::Int32:
      return {"<i4", 4};
    case Type::UInt8:
      return {"|u1", 1};
  }
  return {"|u1", 1};
}

/// NumPy: run.npz holds what a run records in each frame under its path in run.h5 ("frames/q", "contacts/force", ...),
/// with the rows of the chosen frames; of the chosen bodies their positions and cells ("display/<b>/positions",
/// "bodies/<b>/triangles", ...), also where the run keeps poses instead; and of bodies and parts, by number, their
/// attributes ("bodies/name", "parts/body", ...). The same for runs of all versions of the format.
/// Lists of different length keep their "offset": rows of frame k are offset[k] to offset[k + 1] − 1.
class NpzWriter : public Writer {
 public:
  explicit NpzWriter(const Job& job)
      : job_(job), file_(job.run->path(), h5::File::Mode::Read), zip_(job.folder / "run.npz") {}

  void frame(const Frame&) override {}  // arrays are copied whole, at the end
  ItemPlace place(const Item& item) const override {
    return {.file = "run.npz", .path = fmt::format("display/{}", item.body)};
  }
  ItemPlace contacts_place() const override { return {.file = "run.npz", .path = "contacts"}; }

  void finish() override {
    const std::vector<std::string> sets = file_.datasets();
    for (const std::string& path : sets) {
      const std::string group = path.substr(0, path.rfind('/'));
      if (!framed(path)) continue;
      if (std::find(sets.begin(), sets.end(), group + "/offset") != sets.end())
        ragged(group, path);
      else
        per_frame(path);
    }
    for (const Item& item : job_.items) body(item);
    std::vector<std::int64_t> index;
    for (std::int64_t k = 0; k < job_.frames.count(); ++k) index.push_back(frame_at(k));
    numbers("frames/index", index);
    presence();
    attributes();
    zip_.close();
  }

 private:
  std::int64_t frame_at(std::int64_t k) const { return job_.frames.first + k * job_.frames.stride; }

  /// True for what is copied as it is: a row per frame or lists of rows, but not the displays of bodies.
  static bool framed(const std::string& path) {
    if (path == "/frames/count") return false;
    return std::ranges::any_of(kCopied, [&](const char* group) { return path.starts_with(group); });
  }
  static constexpr const char* kCopied[] = {"/frames/", "/series/", "/motion/",    "/contacts/", "/tiles/",
                                            "/pairs/",  "/links/",  "/link_ends/", "/memory/",   "/warnings/"};

  /// 1 where a frame has a body, 0 where it was removed, shape (frames, bodies).
  void presence() {
    const std::size_t bodies = job_.run->bodies().size();
    std::vector<std::uint8_t> present;
    for (std::int64_t k = 0; k < job_.frames.count(); ++k) {
      const std::size_t first = present.size();
      present.resize(first + bodies, 1);
      for (const int b : job_.run->removed(frame_at(k))) present[first + static_cast<std::size_t>(b)] = 0;
    }
    begin("frames/present", "|u1", {static_cast<std::uint64_t>(job_.frames.count()), bodies});
    zip_.write(present.data(), present.size());
    zip_.end();
  }

  /// Cells and positions of a body.
  void body(const Item& item) {
    const Display& d = item.recorded->display;
    const std::string at = fmt::format("display/{}/", item.body), cells = fmt::format("bodies/{}/", item.body);
    if (d.kind == Display::Kind::Triangles && !item.recorded->changing)
      array(cells + "triangles", "<i4", {d.triangles.size(), 3}, d.triangles.data());
    if (d.kind == Display::Kind::Lines) array(cells + "lines", "<i4", {d.lines.size(), 2}, d.lines.data());
    if (item.recorded->changing) return surface(item.body, at);
    const std::int64_t count = item.still ? 1 : job_.frames.count();
    begin(at + "positions", "<f4", {static_cast<std::uint64_t>(count), d.vertices, 3});
    for (std::int64_t k = 0; k < count; ++k) {
      const std::vector<Vec3f> x = job_.run->positions(item.body, frame_at(k));
      zip_.write(x.data(), x.size() * sizeof(Vec3f));
    }
    zip_.end();
  }
  /// Lists of vertices and of triangles, frame after frame.
  void surface(int body, const std::string& at) {
    std::vector<std::int64_t> vertex = {0}, corner = {0};
    std::vector<Vec3f> x;
    std::vector<Triangle> triangles;
    for (std::int64_t k = 0; k < job_.frames.count(); ++k) {
      const std::vector<Vec3f> now = job_.run->positions(body, frame_at(k));
      const std::vector<Triangle> cells = job_.run->triangles(body, frame_at(k));
      x.insert(x.end(), now.begin(), now.end());
      triangles.insert(triangles.end(), cells.begin(), cells.end());
      vertex.push_back(static_cast<std::int64_t>(x.size()));
      corner.push_back(static_cast<std::int64_t>(triangles.size()));
    }
    numbers(at + "vertices/offset", vertex);
    array(at + "vertices/position", "<f4", {x.size(), 3}, x.data());
    numbers(at + "triangles/offset", corner);
    array(at + "triangles/corner", "<i4", {triangles.size(), 3}, triangles.data());
  }

  static std::string header(const std::string& code, const std::vector<std::uint64_t>& shape) {
    std::string size;
    for (const std::uint64_t n : shape) size += std::to_string(n) + ",";
    std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", code, size);
    text.resize((10 + text.size() + 1 + 63) / 64 * 64 - 10 - 1, ' ');
    text += '\n';
    const auto length = static_cast<std::uint16_t>(text.size());
    std::string out("\x93NUMPY\x01\x00", 8);
    out.append(reinterpret_cast<const char*>(&length), sizeof length);
    return out + text;
  }
  void begin(const std::string& path, const std::string& code, const std::vector<std::uint64_t>& shape) {
    zip_.begin((path.starts_with('/') ? path.substr(1) : path) + ".npy");
    const std::string head = header(code, shape);
    zip_.write(head.data(), head.size());
  }
  template <class T>
  void array(const std::string& path, const std::string& code, const std::vector<std::uint64_t>& shape, const T* data) {
    begin(path, code, shape);
    zip_.write(data, shape[0] * sizeof(T));
    zip_.end();
  }
  template <class T>
  void numbers(const std::string& path, const std::vector<T>& values) {
    begin(path, std::is_same_v<T, double> ? "<f8" : "<i8", {values.size()});
    zip_.write(values.data(), values.size() * sizeof(T));
    zip_.end();
  }
  /// Text as NumPy's fixed-width UTF-32.
  void words(const std::string& path, const std::vector<std::string>& list) {
    std::vector<std::u32string> wide;
    std::size_t width = 1;
    for (const std::string& s : list) {
      wide.push_back(decoded(s));
      width = std::max(width, wide.back().size());
    }
    begin(path, fmt::format("<U{}", width), {list.size()});
    for (std::u32string& s : wide) {
      s.resize(width, U'\0');
      zip_.write(s.data(), width * sizeof(char32_t));
    }
    zip_.end();
  }
  static std::u32string decoded(const std::string& utf8) {
    std::u32string out;
    for (std::size_t i = 0; i < utf8.size();) {
      const auto c = static_cast<unsigned char>(utf8[i]);
      std::size_t more = c >= 0xf0 ? 3 : c >= 0xe0 ? 2 : c >= 0xc0 ? 1 : 0;
      more = std::min(more, utf8.size() - i - 1);
      char32_t point = more == 3 ? c & 0x07u : more == 2 ? c & 0x0fu : more == 1 ? c & 0x1fu : c;
      for (std::size_t k = 1; k <= more; ++k) point = (point << 6) | (static_cast<unsigned char>(utf8[i + k]) & 0x3fu);
      out += point;
      i += more + 1;
    }
    return out;
  }

  /// Copies rows [first, first + rows) of a set into the member that is open.
  void copy(const h5::Dataset& set, std::uint64_t first, std::uint64_t rows) {
    std::size_t row = element_of(set.type()).bytes;
    const std::vector<std::uint64_t> shape = set.shape();
    for (std::size_t a = 1; a < shape.size(); ++a) row *= shape[a];
    set.need_rows(first, rows, std::span(shape).subspan(1));
    const std::uint64_t at_once = std::max<std::uint64_t>(1, (std::size_t{16} << 20) / std::max<std::size_t>(row, 1));
    for (std::uint64_t done = 0; done < rows; done += at_once) {
      const std::uint64_t n = std::min(at_once, rows - done);
      bytes_.resize(n * row);
      set.read(bytes_.data(), bytes_.size() / element_of(set.type()).bytes, first + done, n, set.type());
      zip_.write(bytes_.data(), bytes_.size());
    }
  }
  /// A row for each chosen frame.
  void per_frame(const std::string& path) {
    const h5::Dataset set = file_.open(path);
    std::vector<std::uint64_t> shape = set.shape();
    shape[0] = static_cast<std::uint64_t>(job_.frames.count());
    begin(path, element_of(set.type()).code, shape);
    for (std::int64_t k = 0; k < job_.frames.count(); ++k) copy(set, static_cast<std::uint64_t>(frame_at(k)), 1);
    zip_.end();
  }
  void ragged(const std::string& group, const std::string& path) {
    const h5::Dataset offsets = file_.open(group + "/offset");
    offsets.need_rows(0, offsets.shape()[0], {});
    std::vector<std::int64_t> offset(offsets.shape()[0]), own = {0};
    offsets.read(offset.data(), offset.size(), 0, offset.size(), Type::Int64);
    const auto frame = [&](std::int64_t k) { return static_cast<std::size_t>(frame_at(k)); };
    for (std::int64_t k = 0; k < job_.frames.count(); ++k) {
      const std::size_t f = frame(k);
      if (f + 1 >= offset.size() || offset[f] < 0 || offset[f + 1] < offset[f])
        throw InputError(fmt::format("{}/offset: does not rise at frame {}; the file is damaged", group, f));
      own.push_back(own.back() + offset[f + 1] - offset[f]);
    }
    if (path == group + "/offset") return numbers(path, own);
    const h5::Dataset set = file_.open(path);
    std::vector<std::uint64_t> shape = set.shape();
    shape[0] = static_cast<std::uint64_t>(own.back());
    begin(path, element_of(set.type()).code, shape);
    for (std::int64_t k = 0; k < job_.frames.count(); ++k)
      copy(set, static_cast<std::uint64_t>(offset[frame(k)]),
           static_cast<std::uint64_t>(offset[frame(k) + 1] - offset[frame(k)]));
    zip_.end();
  }

  void attributes() {
    std::vector<std::string> name, kind, part_name, material;
    std::vector<double> mass, radius, voxel;
    std::vector<std::int64_t> q_offset, q_size, v_offset, v_size, body, part;
    for (const RecordedBody& b : job_.run->bodies()) {
      name.push_back(b.name), kind.push_back(b.kind), mass.push_back(b.mass), radius.push_back(b.display.radius);
      q_offset.push_back(static_cast<std::int64_t>(b.q_offset)), q_size.push_back(static_cast<std::int64_t>(b.q_size));
      v_offset.push_back(static_cast<std::int64_t>(b.v_offset)), v_size.push_back(static_cast<std::int64_t>(b.v_size));
    }
    for (const RecordedPart& p : job_.run->parts()) {
      part_name.push_back(p.name), material.push_back(p.material), voxel.push_back(p.voxel_size);
      body.push_back(p.body), part.push_back(p.part);
    }
    words("bodies/name", name), words("bodies/kind", kind), words("parts/name", part_name);
    words("parts/material", material);
    numbers("bodies/mass", mass), numbers("bodies/radius", radius), numbers("parts/voxel_size", voxel);
    numbers("bodies/q_offset", q_offset), numbers("bodies/q_size", q_size), numbers("bodies/v_offset", v_offset);
    numbers("bodies/v_size", v_size), numbers("parts/body", body), numbers("parts/part", part);
  }

  const Job& job_;
  h5::File file_;
  ZipFile zip_;
  std::vector<char> bytes_;
};

}  // namespace

std::unique_ptr<Writer> make_npz(const Job& job) { return std::make_unique<NpzWriter>(job); }

}  // namespace brim::exporting
