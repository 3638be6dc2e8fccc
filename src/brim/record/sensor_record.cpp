#include "brim/record/sensor_record.h"

#include "brim/core/error.h"
#include "brim/record/h5.h"

namespace brim {

namespace {

using h5::Type;

/// Most rows that a list may say it has.
constexpr std::int64_t kMostRows = std::int64_t{1} << 40;

}  // namespace

const char* sensor_kind_word(SensorKind kind) {
  switch (kind) {
    case SensorKind::Force:
      return "force";
    case SensorKind::Contact:
      return "contact";
    case SensorKind::Pressure:
      return "pressure";
    case SensorKind::Motion:
      return "motion";
    case SensorKind::Strain:
      return "strain";
    case SensorKind::Distance:
      return "distance";
    case SensorKind::Level:
      return "level";
    case SensorKind::Link:
      return "link";
  }
  return "force";
}

std::string join_lines(const std::vector<std::string>& lines) {
  std::string text;
  for (std::size_t i = 0; i < lines.size(); ++i) text += (i > 0 ? "\n" : "") + lines[i];
  return text;
}

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines(1);
  for (const char c : text)
    if (c == '\n')
      lines.emplace_back();
    else
      lines.back() += c;
  return lines;
}

struct SensorRecord::Impl {
  std::int64_t frames = 0;
  std::size_t bodies = 0;
  h5::File file;
  std::vector<RecordedSensor> sensors;

  explicit Impl(const RunReader& run)
      : frames(run.frames()), bodies(run.bodies().size()), file(run.path(), h5::File::Mode::Read) {
    if (!file.exists("/sensors")) return;
    for (const std::string& name : split_lines(file.text("/sensors", "names"))) {
      const std::string group = group_of(name);
      RecordedSensor s;
      s.name = name;
      s.kind = file.text(group, "kind");
      s.channels = split_lines(file.text(group, "channels"));
      s.units = split_lines(file.text(group, "units"));
      if (s.units.size() != s.channels.size())
        throw InputError(
            fmt::format("{}:{}: has {} channels and {} units", run.path(), group, s.channels.size(), s.units.size()));
      s.every_step = file.exists(group + "/steps");
      if (file.exists(group + "/map")) {
        const auto shape = file.open(group + "/map").shape();
        if (shape.size() != 3 || shape[1] < 1 || shape[2] < 1 || shape[1] > 65536 || shape[2] > 65536)
          throw InputError(fmt::format("{}:{}/map: must have three axes: frames, rows, columns", run.path(), group));
        s.rows = static_cast<int>(shape[1]), s.columns = static_cast<int>(shape[2]);
        s.width = file.number(group, "width"), s.height = file.number(group, "height");
      }
      sensors.push_back(std::move(s));
    }
  }
  static std::string group_of(const std::string& name) { return "/sensors/" + name; }
  const RecordedSensor& sensor(std::size_t i) const {
    if (i >= sensors.size()) throw InputError(fmt::format("sensor {} is not there; the run has {}", i, sensors.size()));
    return sensors[i];
  }
  template <class T>
  std::vector<T> rows(const std::string& path, std::uint64_t first, std::uint64_t count,
                      const std::vector<std::uint64_t>& row, Type type) const {
    if (count == 0) return {};
    const h5::Dataset set = file.open(path);
    set.need_rows(first, count, row);
    std::size_t width = 1;
    for (const std::uint64_t n : row) width *= n;
    std::vector<T> data(count * width);
    if (!data.empty()) set.read(data.data(), data.size(), first, count, type);
    return data;
  }
  /// Rows of the frames [first, last) in a list.
  std::pair<std::uint64_t, std::uint64_t> range(const std::string& group, std::int64_t first, std::int64_t last) const {
    if (first < 0 || first > last || last > frames) throw InputError(fmt::format("frame {} is not there", first));
    const auto at = [&](std::int64_t f) {
      return rows<std::int64_t>(group + "/offset", static_cast<std::uint64_t>(f), 1, {}, Type::Int64)[0];
    };
    const std::int64_t a = at(first), b = at(last);
    if (a < 0 || b < a || b > kMostRows)
      throw InputError(fmt::format("{}/offset: goes from {} to {}; it must rise", group, a, b));
    return {static_cast<std::uint64_t>(a), static_cast<std::uint64_t>(b - a)};
  }
  std::vector<ContactEvent> events(std::int64_t first, std::int64_t last) const {
    if (sensors.empty()) return {};
    const auto [at, n] = range("/events", first, last);
    const auto sensor_of = rows<std::int32_t>("/events/sensor", at, n, {}, Type::Int32);
    const auto began = rows<std::int32_t>("/events/began", at, n, {}, Type::Int32);
    const auto time = rows<double>("/events/time", at, n, {}, Type::Float64);
    const auto body = rows<std::int32_t>("/events/bodies", at, n, {2}, Type::Int32);
    const auto duration = rows<double>("/events/duration", at, n, {}, Type::Float64);
    const auto impulse = rows<double>("/events/impulse", at, n, {3}, Type::Float64);
    const auto peak = rows<double>("/events/peak", at, n, {}, Type::Float64);
    std::vector<ContactEvent> list;
    for (std::size_t i = 0; i < n; ++i) {
      const auto inside = [](std::int32_t x, std::size_t most) { return x >= 0 && static_cast<std::size_t>(x) < most; };
      if (!inside(sensor_of[i], sensors.size()) || !inside(body[2 * i], bodies) || !inside(body[2 * i + 1], bodies))
        throw InputError("/events: names a sensor or body that is not there");
      list.push_back({sensor_of[i], began[i] != 0, time[i], body[2 * i], body[2 * i + 1], duration[i],
                      Vec3(&impulse[3 * i]), peak[i]});
    }
    return list;
  }
};

SensorRecord::SensorRecord(const RunReader& run) : impl_(std::make_unique<Impl>(run)) {}
SensorRecord::~SensorRecord() = default;

const std::vector<RecordedSensor>& SensorRecord::sensors() const { return impl_->sensors; }

std::vector<double> SensorRecord::values(std::size_t i) const {
  const RecordedSensor& s = impl_->sensor(i);
  return impl_->rows<double>(Impl::group_of(s.name) + "/values", 0, static_cast<std::uint64_t>(impl_->frames),
                             {s.channels.size()}, Type::Float64);
}

std::vector<float> SensorRecord::map(std::size_t i, std::int64_t frame) const {
  const RecordedSensor& s = impl_->sensor(i);
  if (s.rows == 0) throw InputError(fmt::format("sensor '{}' has no map", s.name));
  if (frame < 0 || frame >= impl_->frames) throw InputError(fmt::format("frame {} is not there", frame));
  return impl_->rows<float>(Impl::group_of(s.name) + "/map", static_cast<std::uint64_t>(frame), 1,
                            {static_cast<std::uint64_t>(s.rows), static_cast<std::uint64_t>(s.columns)}, Type::Float32);
}

std::vector<double> SensorRecord::steps(std::size_t i) const {
  const RecordedSensor& s = impl_->sensor(i);
  if (!s.every_step) throw InputError(fmt::format("sensor '{}' was not recorded after every step", s.name));
  const std::string group = Impl::group_of(s.name) + "/steps";
  const auto [first, n] = impl_->range(group, 0, impl_->frames);
  return impl_->rows<double>(group + "/value", first, n, {s.channels.size() + 1}, Type::Float64);
}

std::vector<ContactEvent> SensorRecord::events(std::int64_t frame) const { return impl_->events(frame, frame + 1); }
std::vector<ContactEvent> SensorRecord::all_events() const { return impl_->events(0, impl_->frames); }

}  // namespace brim
