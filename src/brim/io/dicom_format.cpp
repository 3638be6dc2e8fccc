// Without GDCM such files are refused with the reason.
#ifdef BRIM_HAS_GDCM
#include <gdcmImageReader.h>
#endif

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <numbers>

#include "brim/core/error.h"
#include "brim/io/child_reader.h"
#include "brim/io/dicom_files.h"
#include "brim/io/dicom_series.h"
#include "brim/io/slice_stack.h"
#include "brim/io/volume_formats.h"

namespace brim {

#ifdef BRIM_HAS_GDCM

namespace {

// ---- images ---------------------------------------------------------------------------------------

template <class T>
void widen(const char* from, std::size_t n, int unused_bits, double* out) {
  for (std::size_t i = 0; i < n; ++i) {
    T value;
    std::memcpy(&value, from + i * sizeof(T), sizeof(T));
    // What is above the bits that are stored is anything: overlays, or nothing.
    value = static_cast<T>(static_cast<T>(static_cast<std::make_unsigned_t<T>>(value) << unused_bits) >> unused_bits);
    out[i] = static_cast<double>(value);
  }
}

/// The frames of the file that was asked for last.
class OpenFile {
 public:
  VoxelType type(const DicomFrame& f) {
    open(f);
    return type_;
  }
  void read(const DicomFrame& f, std::vector<double>& out) {
    open(f);
    const std::size_t n = static_cast<std::size_t>(f.slice.width) * static_cast<std::size_t>(f.slice.height);
    out.resize(n);
    const char* from = buffer_.data() + static_cast<std::size_t>(f.number) * n * voxel_bytes(type_);
    switch (type_) {
      case VoxelType::UInt8:
        widen<std::uint8_t>(from, n, unused_, out.data());
        break;
      case VoxelType::Int8:
        widen<std::int8_t>(from, n, unused_, out.data());
        break;
      case VoxelType::UInt16:
        widen<std::uint16_t>(from, n, unused_, out.data());
        break;
      case VoxelType::Int16:
        widen<std::int16_t>(from, n, unused_, out.data());
        break;
      case VoxelType::UInt32:
        widen<std::uint32_t>(from, n, unused_, out.data());
        break;
      default:
        widen<std::int32_t>(from, n, unused_, out.data());
    }
    for (double& v : out) v = f.slope * v + f.intercept;
  }

 private:
  void open(const DicomFrame& f) {
    if (f.file == file_) return;
    file_.clear();
    gdcm::ImageReader reader;
    reader.SetFileName(f.file.c_str());
    if (!reader.Read())
      throw InputError(
          fmt::format("{}: the image cannot be read: it is damaged, or packed as GDCM reads it not", f.file));
    const gdcm::Image& image = reader.GetImage();
    const gdcm::PixelFormat& pixel = image.GetPixelFormat();
    const gdcm::PhotometricInterpretation& colours = image.GetPhotometricInterpretation();
    if (pixel.GetSamplesPerPixel() != 1 || (colours != gdcm::PhotometricInterpretation::MONOCHROME2 &&
                                            colours != gdcm::PhotometricInterpretation::MONOCHROME1))
      throw InputError(
          fmt::format("{}: a picture in colours ({}); a volume has one intensity", f.file, colours.GetString()));
    const std::map<int, VoxelType> types = {
        {gdcm::PixelFormat::UINT8, VoxelType::UInt8},   {gdcm::PixelFormat::INT8, VoxelType::Int8},
        {gdcm::PixelFormat::UINT16, VoxelType::UInt16}, {gdcm::PixelFormat::INT16, VoxelType::Int16},
        {gdcm::PixelFormat::UINT32, VoxelType::UInt32}, {gdcm::PixelFormat::INT32, VoxelType::Int32}};
    const auto type = types.find(pixel.GetScalarType());
    if (type == types.end())
      throw InputError(fmt::format("{}: pixels of type {} are not read", f.file, pixel.GetScalarTypeAsString()));
    type_ = type->second;
    unused_ = pixel.GetBitsAllocated() - pixel.GetBitsStored();
    if (pixel.GetHighBit() + 1 != pixel.GetBitsStored())
      throw InputError(fmt::format("{}: pixels whose highest bit is {} of {} stored are not read", f.file,
                                   pixel.GetHighBit(), pixel.GetBitsStored()));
    const double wanted = static_cast<double>(f.slice.width) * f.slice.height * f.of * voxel_bytes(type_);
    if (static_cast<double>(image.GetBufferLength()) != wanted ||
        image.GetColumns() != static_cast<unsigned>(f.slice.width))
      throw InputError(fmt::format("{}: the image has {} bytes where its header promises {:.0f}", f.file,
                                   image.GetBufferLength(), wanted));
    check_whole(f, image, wanted);
    buffer_.assign(image.GetBufferLength(), '\0');
    if (!image.GetBuffer(buffer_.data()))
      throw InputError(fmt::format("{}: the image cannot be unpacked; its syntax is {}", f.file,
                                   image.GetTransferSyntax().GetString()));
    file_ = f.file;
  }

  /// GDCM fills up what is missing.
  static void check_whole(const DicomFrame& f, const gdcm::Image& image, double wanted) {
    const gdcm::TransferSyntax& syntax = image.GetTransferSyntax();
    if (const gdcm::ByteValue* plain = image.GetDataElement().GetByteValue();
        plain && !syntax.IsEncapsulated() && static_cast<double>(plain->GetLength()) < wanted)
      throw InputError(fmt::format("{}: {} bytes of pixels are there where {:.0f} are needed", f.file,
                                   static_cast<std::size_t>(plain->GetLength()), wanted));
    if (syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian) return;
    std::ifstream in(f.file, std::ios::binary);
    in.seekg(static_cast<std::streamoff>(f.pixels_at));
    const std::string rest{std::istreambuf_iterator<char>(in), {}};
    // Packed images end with a sequence delimiter of no length.
    const bool whole = syntax.IsEncapsulated() ? rest.rfind(std::string("\xfe\xff\xdd\xe0\0\0\0\0", 8)) != rest.npos
                                               : static_cast<double>(rest.size()) >= wanted;
    if (!whole) throw InputError(f.file + ": the file is cut short");
  }

  std::string file_;
  VoxelType type_ = VoxelType::Int16;
  int unused_ = 0;  // bits
  std::vector<char> buffer_;
};

// ---- in the child ---------------------------------------------------------------------------------

/// What the parent has to know of the series.
struct StackHead {
  VoxelType type;
  Vec3i size;
  Vec3 origin;
  Mat3 axes;
};

// Questions: slices from 0, the head, and before it every file, -2 - n.
constexpr int kStackHead = -1;

class SeriesServer {
 public:
  SeriesServer(std::string path, std::vector<std::string> files, std::string series)
      : path_(std::move(path)), files_(std::move(files)), wanted_(std::move(series)) {}

  void want(std::string series) { wanted_ = std::move(series); }
  void answer(int question, ChildReader::Answer& to) {
    if (question < kStackHead) return scan_.add(files_[static_cast<std::size_t>(-2 - question)]);
    if (question == kStackHead) return put_head(to);
    file_.read(series_.frames[stack_.order[static_cast<std::size_t>(question)]], values_);
    to.put(values_.data(), values_.size() * sizeof(double));
  }

 private:
  void put_head(ChildReader::Answer& to) {
    series_ = scan_.take(path_, wanted_);
    std::vector<StackSlice> slices;
    for (const DicomFrame& f : series_.frames) slices.push_back(f.slice);
    stack_ = stack_slices(fmt::format("{}: series {}", path_, series_.uid), slices);
    const DicomFrame& first = series_.frames[stack_.order[0]];
    to.put(StackHead{file_.type(first),
                     {first.slice.width, first.slice.height, static_cast<int>(slices.size())},
                     stack_.origin,
                     stack_.axes});
    const std::string modality = series_.modality.empty() ? "" : " " + series_.modality;
    std::string format = fmt::format("DICOM{}, series {}", modality, series_.uid);
    if (!series_.description.empty()) format += fmt::format(" '{}'", series_.description);
    constexpr double kDegrees = 180.0 / std::numbers::pi;
    if (stack_.tilt * kDegrees > 0.1) format += fmt::format(", tilted by {:.1f} degrees", stack_.tilt * kDegrees);
    to.put_text(format);
    for (const std::size_t s : stack_.order) to.put_text(series_.frames[s].file);
  }

  std::string path_;
  std::vector<std::string> files_;
  std::string wanted_;
  DicomScan scan_;
  DicomSeries series_;
  SliceStack stack_;
  OpenFile file_;
  std::vector<double> values_;
};

bool same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  return std::filesystem::equivalent(a, b, error);
}

class DicomSlices final : public SliceSource {
 public:
  /// @param of_file  the path is that of a file, whose series is meant
  DicomSlices(const std::string& path, const DicomFiles& files, const std::string& series, bool of_file)
      : path_(path),
        reader_(path, files.load,
                [path, of_file, server = SeriesServer(path, files.paths, series)](int question,
                                                                                  ChildReader::Answer& answer) mutable {
                  if (question == kStackHead && of_file) server.want(dicom_series_of(path));
                  server.answer(question, answer);
                }) {
    for (std::size_t n = 0; n < files.paths.size(); ++n) {
      reader_.about(files.paths[n]);
      try {
        reader_.ask(-2 - static_cast<int>(n));
      } catch (const InputError& error) {
        if (!of_file || same_file(files.paths[n], path)) throw;
        throw InputError(
            fmt::format("{}; it may be a slice of the series of {}, which lies in the same folder: take the "
                        "damaged file away, or the other one elsewhere",
                        error.what(), path));
      }
    }
  }

  /// Its place and voxels, as info. @throws InputError
  void describe(VolumeInfo& info) {
    reader_.about(path_);
    ChildReader::Received received = reader_.ask(kStackHead);
    const auto head = received.get<StackHead>();
    info.format = received.get_text();
    for (int k = 0; k < head.size.z(); ++k) file_.push_back(received.get_text());
    info.data_path = file_[0];
    info.type = head.type;
    info.size = head.size;
    // To right, front, up from left, back, up.
    const Vec3 sign(-1.0, -1.0, 1.0);
    info.origin = sign.cwiseProduct(head.origin);
    info.axes = sign.asDiagonal() * head.axes;
  }
  void read(int k, std::span<double> out) override {
    reader_.about(file_[static_cast<std::size_t>(k)]);
    reader_.ask(k).get(out.data(), out.size_bytes());
  }

 private:
  std::string path_;
  ChildReader reader_;
  std::vector<std::string> file_;  // of each slice
};

}  // namespace

VolumeInfo read_dicom_info(const std::string& path, const std::string& series) {
  namespace fs = std::filesystem;
  std::error_code error;
  const bool folder = fs::is_directory(path, error);
  const fs::path parent = fs::path(path).parent_path();
  const DicomFiles files = find_dicom_files(folder ? path : parent.empty() ? "." : parent.string(), folder);
  const auto slices = std::make_shared<DicomSlices>(path, files, series, !folder && series.empty());
  VolumeInfo info;
  info.path = path;
  info.encoding = VolumeInfo::Encoding::Slices;
  info.unit_given = true;  // millimetres, always
  slices->describe(info);
  info.slices = slices;
  return info;
}

#else

VolumeInfo read_dicom_info(const std::string& path, const std::string&) {
  throw InputError(path + ": this brim was built without GDCM and cannot read DICOM files (docs/dependencies.md)");
}

#endif

}  // namespace brim
