#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "brim/core/error.h"
#include "brim/io/regular_file.h"
#include "brim/io/volume_formats.h"

namespace brim {

namespace {

std::string lower(std::string s) {
  std::transform(s.begin(), s.end(), s.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return s;
}

std::string trimmed(const std::string& s) {
  const auto first = s.find_first_not_of(" \t\r"), last = s.find_last_not_of(" \t\r");
  return first == std::string::npos ? "" : s.substr(first, last - first + 1);
}

/// The words that NRRD allows for each type.
const std::map<std::string, VoxelType> kNrrdTypes = {{"signed char", VoxelType::Int8},
                                                     {"int8", VoxelType::Int8},
                                                     {"int8_t", VoxelType::Int8},
                                                     {"uchar", VoxelType::UInt8},
                                                     {"unsigned char", VoxelType::UInt8},
                                                     {"uint8", VoxelType::UInt8},
                                                     {"uint8_t", VoxelType::UInt8},
                                                     {"short", VoxelType::Int16},
                                                     {"short int", VoxelType::Int16},
                                                     {"signed short", VoxelType::Int16},
                                                     {"signed short int", VoxelType::Int16},
                                                     {"int16", VoxelType::Int16},
                                                     {"int16_t", VoxelType::Int16},
                                                     {"ushort", VoxelType::UInt16},
                                                     {"unsigned short", VoxelType::UInt16},
                                                     {"unsigned short int", VoxelType::UInt16},
                                                     {"uint16", VoxelType::UInt16},
                                                     {"uint16_t", VoxelType::UInt16},
                                                     {"int", VoxelType::Int32},
                                                     {"signed int", VoxelType::Int32},
                                                     {"int32", VoxelType::Int32},
                                                     {"int32_t", VoxelType::Int32},
                                                     {"uint", VoxelType::UInt32},
                                                     {"unsigned int", VoxelType::UInt32},
                                                     {"uint32", VoxelType::UInt32},
                                                     {"uint32_t", VoxelType::UInt32},
                                                     {"longlong", VoxelType::Int64},
                                                     {"int64", VoxelType::Int64},
                                                     {"int64_t", VoxelType::Int64},
                                                     {"long long", VoxelType::Int64},
                                                     {"ulonglong", VoxelType::UInt64},
                                                     {"uint64", VoxelType::UInt64},
                                                     {"uint64_t", VoxelType::UInt64},
                                                     {"unsigned long long", VoxelType::UInt64},
                                                     {"float", VoxelType::Float32},
                                                     {"double", VoxelType::Float64}};

/// The fields of a header and where the data after it start.
struct Fields {
  std::string path;
  std::map<std::string, std::string> value;
  std::size_t end = 0;  ///< [bytes] after the blank line

  bool has(const char* key) const { return value.count(key) > 0; }
  std::string get(const char* key, const std::string& otherwise = "") const {
    const auto it = value.find(key);
    return it == value.end() ? otherwise : it->second;
  }
  /// Numbers of a field, in any of the forms "1 2 3" and "(1,0,0) (0,1,0)"; words become NaN.
  std::vector<double> numbers(const char* key) const {
    std::string text = get(key);
    for (char& c : text)
      if (c == '(' || c == ')' || c == ',') c = ' ';
    std::istringstream words(text);
    std::vector<double> list;
    for (std::string w; words >> w;) {
      double x = std::nan("");
      const auto [end_, error] = std::from_chars(w.data(), w.data() + w.size(), x);
      if (error != std::errc() || end_ != w.data() + w.size()) x = std::nan("");
      list.push_back(x);
    }
    return list;
  }
};

Fields read_fields(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path + ": cannot be opened");
  Fields f;
  f.path = path;
  std::string line;
  if (!std::getline(in, line) || line.rfind("NRRD000", 0) != 0)
    throw InputError(path + ": is not an NRRD volume; its first line must be \"NRRD0004\" or another version");
  std::size_t read = 0;
  while (std::getline(in, line)) {
    if ((read += line.size()) > (std::size_t{1} << 20)) throw InputError(path + ": the NRRD header has no end");
    line = trimmed(line);
    if (line.empty()) break;
    if (line[0] == '#') continue;
    const auto colon = line.find(':');
    if (colon == std::string::npos || line.compare(colon, 2, ":=") == 0) continue;  // ":=" are remarks of the writer
    f.value[lower(trimmed(line.substr(0, colon)))] = trimmed(line.substr(colon + 1));
  }
  const auto at = in.tellg();
  f.end = at < 0 ? 0 : static_cast<std::size_t>(at);
  return f;
}

/// Units of length, [m].
const std::map<std::string, double> kUnits = {
    {"m", 1.0},           {"meter", 1.0},        {"meters", 1.0},       {"metre", 1.0},       {"metres", 1.0},
    {"cm", 1e-2},         {"centimeter", 1e-2},  {"centimeters", 1e-2}, {"centimetre", 1e-2}, {"centimetres", 1e-2},
    {"mm", 1e-3},         {"millimeter", 1e-3},  {"millimeters", 1e-3}, {"millimetre", 1e-3}, {"millimetres", 1e-3},
    {"um", 1e-6},         {"\u00b5m", 1e-6},     {"\u03bcm", 1e-6},     {"micrometer", 1e-6}, {"micrometers", 1e-6},
    {"micrometre", 1e-6}, {"micrometres", 1e-6}, {"micron", 1e-6},      {"microns", 1e-6},    {"nm", 1e-9},
    {"nanometer", 1e-9},  {"nanometers", 1e-9},  {"nanometre", 1e-9},   {"nanometres", 1e-9}};

/// The unit of length, if the header says one; the same on all axes.
void read_unit(const Fields& f, VolumeInfo& info) {
  const char* const key = f.has("space units") ? "space units" : "units";
  std::string text = lower(f.get(key));
  std::replace(text.begin(), text.end(), '"', ' ');
  std::istringstream words(text);
  for (std::string w; words >> w;) {
    if (w == "none" || w == "unknown" || w == "???") continue;
    const auto unit = kUnits.find(w);
    if (unit == kUnits.end() || (info.unit_given && unit->second != info.unit))
      throw InputError(
          fmt::format("{}: the {} {} are not read; they must be one of m, cm, mm, um, nm, the same on all axes", f.path,
                      key, f.get(key)));
    info.unit = unit->second;
    info.unit_given = true;
  }
}

void read_place(const Fields& f, VolumeInfo& info) {
  if (f.has("space directions")) {
    const auto d = f.numbers("space directions");
    if (d.size() != 9)
      throw InputError(fmt::format("{}: \"space directions: {}\" must be three vectors of three", f.path,
                                   f.get("space directions")));
    for (int a = 0; a < 3; ++a) info.axes.col(a) = Vec3(d[3 * a], d[3 * a + 1], d[3 * a + 2]);
    if (const auto o = f.numbers("space origin"); o.size() == 3) info.origin = Vec3(o[0], o[1], o[2]);
  } else if (f.has("spacings")) {
    const auto s = f.numbers("spacings");
    if (s.size() != 3)
      throw InputError(fmt::format("{}: \"spacings: {}\" must be three numbers", f.path, f.get("spacings")));
    info.axes = Vec3(s[0], s[1], s[2]).asDiagonal();
  }
  // To right, front, up.
  const std::string space = lower(f.get("space"));
  Vec3 sign = Vec3::Ones();
  if (space.find("left") == 0 || space == "lps" || space == "las") sign.x() = -1.0;
  if (space.find("posterior") != std::string::npos || space == "lps") sign.y() = -1.0;
  info.axes = sign.asDiagonal() * info.axes;
  info.origin = sign.cwiseProduct(info.origin);
  read_unit(f, info);
}

/// First byte of the data in their file, after the lines and bytes that the header wants skipped.
void read_data_place(const Fields& f, VolumeInfo& info) {
  info.data_path = f.path;
  info.file_offset = f.end;
  std::string file = f.get("data file", f.get("datafile"));
  if (!file.empty()) {
    if (file.rfind("LIST", 0) == 0 || file.find('%') != std::string::npos)
      throw InputError(f.path + ": \"data file\" names many files; join them to one volume");
    namespace fs = std::filesystem;
    info.data_path = (fs::path(file).is_absolute() ? fs::path(file) : fs::path(f.path).parent_path() / file).string();
    info.file_offset = 0;
  } else if (f.end == 0) {
    throw InputError(f.path + ": the header ends without data and names no \"data file\"");
  }
  const auto skip = [&](const char* key, const char* other) {
    const auto n = f.numbers(f.has(key) ? key : other);
    if (n.empty()) return 0L;
    if (n.size() != 1 || !(n[0] >= -1.0 && n[0] < 1e15))
      throw InputError(fmt::format("{}: \"{}\" must be a whole number", f.path, key));
    return std::lround(n[0]);
  };
  if (long lines = skip("line skip", "lineskip"); lines > 0) {
    need_regular_file(info.data_path);
    std::ifstream in(info.data_path, std::ios::binary);
    in.seekg(static_cast<std::streamoff>(info.file_offset));
    std::string line;
    while (lines-- > 0 && std::getline(in, line)) {
    }
    if (in) info.file_offset = static_cast<std::size_t>(in.tellg());
  }
  const long bytes = skip("byte skip", "byteskip");
  if (bytes < 0) throw InputError(f.path + ": \"byte skip: -1\" is not read; write the number of bytes");
  info.data_offset = static_cast<std::size_t>(bytes);
}

}  // namespace

VolumeInfo read_nrrd_info(const std::string& path) {
  const Fields f = read_fields(path);
  VolumeInfo info;
  info.path = path;
  info.format = "NRRD";
  for (const char* key : {"type", "dimension", "sizes", "encoding"})
    if (!f.has(key)) throw InputError(fmt::format("{}: the NRRD header has no \"{}\"", path, key));
  if (f.get("dimension") != "3")
    throw InputError(fmt::format("{}: has {} axes; a volume has three", path, f.get("dimension")));
  const auto sizes = f.numbers("sizes");
  if (sizes.size() != 3)
    throw InputError(fmt::format("{}: \"sizes: {}\" must be three whole numbers", path, f.get("sizes")));
  for (int a = 0; a < 3; ++a) info.size[a] = sizes[a] >= 1.0 && sizes[a] < 2e9 ? static_cast<int>(sizes[a]) : 0;
  const auto type = kNrrdTypes.find(lower(f.get("type")));
  if (type == kNrrdTypes.end())
    throw InputError(
        fmt::format("{}: voxels are of type \"{}\"; they must be whole numbers or floats", path, f.get("type")));
  info.type = type->second;
  const std::string encoding = lower(f.get("encoding"));
  if (encoding == "raw")
    info.encoding = VolumeInfo::Encoding::Plain;
  else if (encoding == "gzip" || encoding == "gz")
    info.encoding = VolumeInfo::Encoding::Gzip;
  else if (encoding == "ascii" || encoding == "text" || encoding == "txt")
    info.encoding = VolumeInfo::Encoding::Text;
  else
    throw InputError(
        fmt::format("{}: encoding \"{}\" is not read; it must be raw, gzip or ascii", path, f.get("encoding")));
  const std::string endian = lower(f.get("endian"));
  info.big_endian = endian == "big";
  if (endian.empty() && voxel_bytes(info.type) > 1 && info.encoding != VolumeInfo::Encoding::Text)
    throw InputError(path + ": the NRRD header has no \"endian\"; voxels of several bytes need one");
  read_place(f, info);
  read_data_place(f, info);
  return info;
}

}  // namespace brim
