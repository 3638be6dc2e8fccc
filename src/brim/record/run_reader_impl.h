#pragma once

#include <algorithm>
#include <sstream>
#include <unordered_map>

#include "brim/record/h5.h"
#include "brim/record/run_reader.h"
#include "brim/world/report_fields.h"

namespace brim {

/// More steps of a frame or run than this mean a damaged file.
inline constexpr std::int64_t kMostSteps = std::int64_t{1} << 30;

/// Shared state of the reader's files: the open file, its header, and checked access to rows.
struct RunReader::Impl {
  std::string path;
  h5::File file;
  std::string scene, version, scene_path;
  int format = 0;
  ProcessMark writer;
  double frame_time = 0.0;
  int steps_per_frame = 1;
  std::int64_t frames = 0;
  RunTables tables;
  std::vector<std::int64_t> still;                            ///< version 2, shape (bodies)
  mutable std::unordered_map<std::string, h5::Dataset> sets;  ///< open ones
  /// Rows of the last requested frame: displays are read body by body.
  struct Rows {
    std::int64_t frame = -1;
    std::vector<double> rotation, translation;
    std::vector<float> positions;
  };
  mutable Rows rows_now;

  explicit Impl(const std::string& p) : path(p), file(p, h5::File::Mode::Read) {}

  std::uint64_t need(std::int64_t frame) const {
    if (frame < 0 || frame >= frames)
      throw InputError(fmt::format("{}: frame {} is not there; it must be from 0 to {}", path, frame, frames - 1));
    return static_cast<std::uint64_t>(frame);
  }
  std::size_t need_body(int body) const {
    if (body < 0 || static_cast<std::size_t>(body) >= tables.bodies.size())
      throw InputError(fmt::format("{}: body {} is not there; it must be from 0 to {}", path, body,
                                   static_cast<std::int64_t>(tables.bodies.size()) - 1));
    return static_cast<std::size_t>(body);
  }
  const h5::Dataset& set(const std::string& name) const {
    const auto it = sets.find(name);
    return it != sets.end() ? it->second : sets.emplace(name, file.open(name)).first->second;
  }
  /// @param row  extents after the first
  template <class T>
  std::vector<T> rows(const std::string& name, std::uint64_t first, std::uint64_t count,
                      const std::vector<std::uint64_t>& row, h5::Type type) const {
    if (count == 0) return {};
    const h5::Dataset& s = set(name);
    s.need_rows(first, count, row);
    std::uint64_t width = 1;
    for (const std::uint64_t n : row) width *= n;
    std::vector<T> data(count * width);
    if (!data.empty()) s.read(data.data(), data.size(), first, count, type);
    return data;
  }
  template <class T>
  std::vector<T> rows(const std::string& name, std::uint64_t first, std::uint64_t count, std::size_t width,
                      h5::Type type) const {
    return rows<T>(name, first, count, width == 1 ? std::vector<std::uint64_t>{} : std::vector<std::uint64_t>{width},
                   type);
  }
  /// The lines of a text attribute that older runs may lack.
  std::vector<std::string> lines_of(const char* group, const char* attribute) const {
    std::vector<std::string> lines;
    if (!file.exists(group) || !file.has_attribute(group, attribute)) return lines;
    std::istringstream text(file.text(group, attribute));
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    return lines;
  }
  /// Rows of a frame in a ragged list.
  std::pair<std::uint64_t, std::uint64_t> range(const std::string& group, std::int64_t frame) const {
    const auto o = rows<std::int64_t>(group + "/offset", need(frame), 2, 1, h5::Type::Int64);
    if (o[0] < 0 || o[1] < o[0])
      throw InputError(
          fmt::format("{}:{}/offset: goes from {} to {} at frame {}; it must rise", path, group, o[0], o[1], frame));
    return {static_cast<std::uint64_t>(o[0]), static_cast<std::uint64_t>(o[1] - o[0])};
  }
  /// Scalars of some frames. Zeros for a present name that an older run does not have.
  std::vector<double> scalars(const std::string& name, std::uint64_t first, std::uint64_t count) const {
    const std::string at = "/series/" + name;
    const auto today = [&](const ReportField& f) { return name == f.name; };
    if (!sets.contains(at) && !file.exists(at) && std::ranges::any_of(report_fields(), today))
      return std::vector<double>(count, 0.0);
    return rows<double>(at, first, count, 1, h5::Type::Float64);
  }
  /// Part numbers of contacts and pairs, which are used as indices.
  std::vector<std::int32_t> parts_of(const std::string& name, std::uint64_t first, std::uint64_t n) const {
    const auto parts = rows<std::int32_t>(name, first, n, 2, h5::Type::Int32);
    for (const std::int32_t p : parts)
      if (p < 0 || static_cast<std::size_t>(p) >= tables.parts.size())
        throw InputError(fmt::format("{}:{}: names part {}; it must be from 0 to {}", path, name, p,
                                     static_cast<std::int64_t>(tables.parts.size()) - 1));
    return parts;
  }
  const Rows& rows_of(std::int64_t frame) const;
  std::vector<Vec3f> placed(std::size_t body, std::int64_t frame) const;
  void read_head();
  void count_frames();
  void check_slices() const;
};

}  // namespace brim
