#include "brim/record/sensor_csv.h"

#include <cmath>
#include <filesystem>

#include "brim/core/error.h"
#include "brim/record/run_folder.h"
#include "brim/record/sensor_record.h"

namespace brim {

namespace {

/// A number that is read back as it was; nothing where it is none.
std::string number_text(double x) { return std::isfinite(x) ? fmt::format("{}", x) : ""; }

/// In quotes where a name holds what separates columns.
std::string word_text(const std::string& s) {
  if (s.find_first_of(",\"\n\r") == std::string::npos) return s;
  std::string out = "\"";
  for (const char c : s) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

std::string head_of(const RecordedSensor& s) {
  std::string text;
  for (std::size_t c = 0; c < s.channels.size(); ++c) {
    const std::string unit = s.units[c].empty() ? "" : " [" + s.units[c] + "]";
    text.append(",").append(word_text(s.name + "." + s.channels[c] + unit));
  }
  return text;
}

std::string frames_text(const RunReader& run, const SensorRecord& record) {
  std::string text = "frame,time [s]";
  std::vector<std::vector<double>> values;
  for (std::size_t i = 0; i < record.sensors().size(); ++i) {
    text += head_of(record.sensors()[i]);
    values.push_back(record.values(i));
  }
  text += "\n";
  for (std::int64_t f = 0; f < run.frames(); ++f) {
    text += fmt::format("{},{}", f, run.time(f));
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::size_t n = record.sensors()[i].channels.size();
      for (std::size_t c = 0; c < n; ++c)
        text.append(",").append(number_text(values[i][static_cast<std::size_t>(f) * n + c]));
    }
    text += "\n";
  }
  return text;
}

/// A line for each step; sensors that were added later begin with empty columns.
std::string steps_text(const SensorRecord& record) {
  std::string text = "time [s]";
  std::vector<std::vector<double>> rows;
  std::vector<std::size_t> width;
  std::size_t most = 0;
  for (std::size_t i = 0; i < record.sensors().size(); ++i) {
    const RecordedSensor& s = record.sensors()[i];
    if (!s.every_step) continue;
    text += head_of(s);
    rows.push_back(record.steps(i));
    width.push_back(s.channels.size() + 1);
    most = std::max(most, rows.back().size() / width.back());
  }
  text += "\n";
  for (std::size_t step = 0; step < most; ++step) {
    std::string line, time;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const std::size_t n = rows[i].size() / width[i], missing = most - n;
      for (std::size_t c = 1; c < width[i]; ++c) {
        line.append(",");
        if (step >= missing) line.append(number_text(rows[i][(step - missing) * width[i] + c]));
      }
      if (step >= missing) time = number_text(rows[i][(step - missing) * width[i]]);
    }
    text.append(time).append(line).append("\n");
  }
  return text;
}

std::string events_text(const RunReader& run, const SensorRecord& record) {
  std::string text =
      "time [s],sensor,event,body,other,duration [s],impulse_x [N s],impulse_y [N s],impulse_z [N s],peak [N]\n";
  for (const ContactEvent& e : record.all_events()) {
    const auto name = [&](int body) { return word_text(run.bodies()[static_cast<std::size_t>(body)].name); };
    text += fmt::format("{},{},{},{},{}", e.time, word_text(record.sensors()[static_cast<std::size_t>(e.sensor)].name),
                        e.began ? "began" : "ended", name(e.body_a), name(e.body_b));
    text += e.began ? ",,,,,\n"
                    : fmt::format(",{},{},{},{},{}\n", e.duration, e.impulse.x(), e.impulse.y(), e.impulse.z(), e.peak);
  }
  return text;
}

}  // namespace

const std::vector<std::string>& sensor_csv_files() {
  static const std::vector<std::string> names = {"sensors.csv", "sensor_steps.csv", "events.csv"};
  return names;
}

void write_sensor_csv(const RunReader& run, const std::string& folder) {
  const SensorRecord record(run);
  if (record.sensors().empty()) return;
  const auto path = [&](std::size_t i) { return (std::filesystem::path(folder) / sensor_csv_files()[i]).string(); };
  write_whole(path(0), frames_text(run, record));
  bool steps = false, contacts = false;
  for (const RecordedSensor& s : record.sensors())
    steps = steps || s.every_step, contacts = contacts || s.kind == "contact";
  if (steps) write_whole(path(1), steps_text(record));
  if (contacts) write_whole(path(2), events_text(run, record));
}

}  // namespace brim
