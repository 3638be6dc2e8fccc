#include "brim/io/dicom_series.h"

#ifdef BRIM_HAS_GDCM
#include <gdcmImageReader.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <set>

#include "brim/core/error.h"
#include "brim/core/printable.h"

namespace brim {

namespace {

// Elements by group and number, DICOM PS3.6.
const gdcm::Tag kSeriesUid(0x0020, 0x000e), kSeriesNumber(0x0020, 0x0011), kModality(0x0008, 0x0060),
    kDescription(0x0008, 0x103e), kRows(0x0028, 0x0010), kColumns(0x0028, 0x0011), kFrames(0x0028, 0x0008),
    kPosition(0x0020, 0x0032), kOrientation(0x0020, 0x0037), kPixelSpacing(0x0028, 0x0030), kThickness(0x0018, 0x0050),
    kBetweenSlices(0x0018, 0x0088), kSlope(0x0028, 0x1053), kIntercept(0x0028, 0x1052), kPixelData(0x7fe0, 0x0010),
    kShared(0x5200, 0x9229), kPerFrame(0x5200, 0x9230), kPlanePosition(0x0020, 0x9113),
    kPlaneOrientation(0x0020, 0x9116), kMeasures(0x0028, 0x9110), kTransform(0x0028, 0x9145);

constexpr std::size_t kMostFrames = 100'000;

// ---- elements -------------------------------------------------------------------------------------

const gdcm::ByteValue* bytes_of(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  return set.FindDataElement(tag) ? set.GetDataElement(tag).GetByteValue() : nullptr;
}

std::string text_of(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  const gdcm::ByteValue* bytes = bytes_of(set, tag);
  if (!bytes || !bytes->GetPointer()) return {};
  std::string text(bytes->GetPointer(), std::min<std::size_t>(bytes->GetLength(), 256));
  text.resize(std::min(text.size(), text.find('\0')));
  const auto first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
  return first == std::string::npos ? "" : printable(text.substr(first, last - first + 1));
}

/// Decimals separated by backslashes; NaN for words.
std::vector<double> decimals(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  std::vector<double> list;
  const gdcm::ByteValue* bytes = bytes_of(set, tag);
  if (!bytes || !bytes->GetPointer()) return list;
  std::string text(bytes->GetPointer(), std::min<std::size_t>(bytes->GetLength(), 4096));
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t to = std::min(text.find('\\', at), text.size());
    const std::string word = text.substr(at, to - at);
    char* end = nullptr;
    const double x = std::strtod(word.c_str(), &end);
    list.push_back(end != word.c_str() && (*end == '\0' || *end == ' ') ? x : std::nan(""));
    at = to + 1;
  }
  return list;
}

double decimal(const gdcm::DataSet& set, const gdcm::Tag& tag, double otherwise) {
  const auto list = decimals(set, tag);
  return list.empty() ? otherwise : list[0];
}

int whole16(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  const gdcm::ByteValue* bytes = bytes_of(set, tag);
  std::uint16_t value = 0;
  if (bytes && bytes->GetPointer() && bytes->GetLength() >= sizeof value)
    std::memcpy(&value, bytes->GetPointer(), sizeof value);
  return value;
}

/// Item n (from 0) of a sequence, or nothing.
const gdcm::DataSet* item(const gdcm::DataSet& set, const gdcm::Tag& tag, std::size_t n,
                          std::vector<gdcm::SmartPointer<gdcm::SequenceOfItems>>& held) {
  if (!set.FindDataElement(tag)) return nullptr;
  auto sequence = set.GetDataElement(tag).GetValueAsSQ();
  if (!sequence || n >= sequence->GetNumberOfItems()) return nullptr;
  held.push_back(sequence);
  return &sequence->GetItem(n + 1).GetNestedDataSet();
}

// ---- headers --------------------------------------------------------------------------------------

/// What says where a frame lies: of images of one frame the file itself, else groups of the frame or of all frames.
class FrameGroups {
 public:
  FrameGroups(const gdcm::DataSet& set, bool several) : set_(set), several_(several) {
    if (several_) shared_ = item(set_, kShared, 0, held_);
    if (several_ && set_.FindDataElement(kPerFrame)) per_frame_ = set_.GetDataElement(kPerFrame).GetValueAsSQ();
  }
  const gdcm::DataSet& group(const gdcm::Tag& tag, int frame) {
    if (!several_) return set_;
    if (per_frame_ && static_cast<std::size_t>(frame) < per_frame_->GetNumberOfItems())
      if (const auto* own =
              item(per_frame_->GetItem(static_cast<std::size_t>(frame) + 1).GetNestedDataSet(), tag, 0, held_))
        return *own;
    if (shared_)
      if (const auto* all = item(*shared_, tag, 0, held_)) return *all;
    return none_;
  }

 private:
  const gdcm::DataSet& set_;
  bool several_;
  std::vector<gdcm::SmartPointer<gdcm::SequenceOfItems>> held_;
  const gdcm::DataSet* shared_ = nullptr;
  gdcm::SmartPointer<gdcm::SequenceOfItems> per_frame_;
  gdcm::DataSet none_;
};

DicomFrame read_frame(FrameGroups& groups, const std::string& file, int number, int of) {
  DicomFrame f;
  f.file = file;
  f.number = number, f.of = of;
  f.slice.name = std::filesystem::path(file).filename().string();
  if (of > 1) f.slice.name += fmt::format(", frame {}", number + 1);
  const auto position = decimals(groups.group(kPlanePosition, number), kPosition);
  const auto turn = decimals(groups.group(kPlaneOrientation, number), kOrientation);
  const gdcm::DataSet& measures = groups.group(kMeasures, number);
  const auto spacing = decimals(measures, kPixelSpacing);
  if (position.size() != 3 || turn.size() != 6 || spacing.size() != 2)
    throw InputError(fmt::format("{}: {} has no {}; without it its place is not known", file, f.slice.name,
                                 position.size() != 3 ? "Image Position (Patient)"
                                 : turn.size() != 6   ? "Image Orientation (Patient)"
                                                      : "Pixel Spacing"));
  f.slice.position = Vec3(position[0], position[1], position[2]);
  f.slice.row = Vec3(turn[0], turn[1], turn[2]);
  f.slice.column = Vec3(turn[3], turn[4], turn[5]);
  f.slice.step = {spacing[1], spacing[0]};  // the first is that between rows
  f.slice.thickness = decimal(measures, kBetweenSlices, decimal(measures, kThickness, 0.0));
  const gdcm::DataSet& transform = groups.group(kTransform, number);
  f.slope = decimal(transform, kSlope, 1.0);
  f.intercept = decimal(transform, kIntercept, 0.0);
  if (!std::isfinite(f.slope) || f.slope == 0.0 || !std::isfinite(f.intercept))
    throw InputError(
        fmt::format("{}: {} has a rescale slope of {} and intercept of {}; the one must not be zero, and "
                    "both finite",
                    file, f.slice.name, f.slope, f.intercept));
  return f;
}

/// All elements of a file but its pixels.
std::unique_ptr<gdcm::Reader> read_elements(const std::string& file) {
  // In a deflated file nothing can be passed over.
  for (const std::set<gdcm::Tag>& skip : {std::set<gdcm::Tag>{kPixelData}, std::set<gdcm::Tag>{}}) {
    auto reader = std::make_unique<gdcm::Reader>();
    reader->SetFileName(file.c_str());
    if (reader->ReadUpToTag(kPixelData, skip)) return reader;
  }
  throw InputError(file + ": a damaged DICOM file");
}

double voxels(const DicomSeries& series) {
  double sum = 0.0;
  for (const DicomFrame& f : series.frames) sum += static_cast<double>(f.slice.width) * f.slice.height;
  return sum;
}

std::string text_of(const DicomSeries& s) {
  return fmt::format("{}: number {}, {} '{}', {} slices of {} x {}", s.uid, s.number.empty() ? "-" : s.number,
                     s.modality.empty() ? "-" : s.modality, s.description, s.frames.size(), s.frames[0].slice.width,
                     s.frames[0].slice.height);
}

}  // namespace

void DicomScan::add(const std::string& file) {
  // A damaged file is never passed over: it may be the slice at the end of the wanted series.
  const auto reader = read_elements(file);
  const gdcm::DataSet& set = reader->GetFile().GetDataSet();
  const std::string uid = text_of(set, kSeriesUid);
  if (uid.empty()) return;
  DicomSeries& series = found_[uid];
  if (series.uid.empty()) {
    series.uid = uid;
    series.number = text_of(set, kSeriesNumber);
    series.modality = text_of(set, kModality);
    series.description = text_of(set, kDescription);
  }
  const double said = decimal(set, kFrames, 1.0);
  const int of = said >= 1.0 && said <= static_cast<double>(kMostFrames) ? static_cast<int>(said) : 1;
  if ((frames_ += static_cast<std::size_t>(of)) > kMostFrames)
    throw InputError(
        fmt::format("{}: more than {} images with this one; name the folder of one series", file, kMostFrames));
  try {
    const int width = whole16(set, kColumns), height = whole16(set, kRows);
    if (width == 0 || height == 0) throw InputError(file + ": a DICOM file without an image, or cut short");
    FrameGroups groups(set, set.FindDataElement(kPerFrame));
    for (int n = 0; n < of; ++n) {
      DicomFrame frame = read_frame(groups, file, n, of);
      frame.pixels_at = reader->GetStreamCurrentPosition();
      frame.slice.width = width, frame.slice.height = height;
      series.frames.push_back(std::move(frame));
    }
  } catch (const InputError& error) {
    if (series.fault.empty()) series.fault = error.what();
  }
}

DicomSeries DicomScan::take(const std::string& path, const std::string& wanted) const {
  const bool largest = wanted == "largest";
  std::vector<const DicomSeries*> list;
  std::string fault;
  for (const auto& [uid, series] : found_) {
    if (!wanted.empty() && !largest && uid != wanted) continue;
    if (fault.empty()) fault = series.fault;
    if (!series.frames.empty()) list.push_back(&series);
  }
  if (list.empty())
    throw InputError(!fault.empty()              ? fault
                     : wanted.empty() || largest ? path + ": DICOM files, but no images among them"
                                                 : fmt::format("{}: no series '{}' there", path, wanted));
  const auto size = [&](const DicomSeries* s) { return largest ? voxels(*s) : s->frames.size() > 1 ? 1.0 : 0.0; };
  std::stable_sort(list.begin(), list.end(), [&](auto* a, auto* b) { return size(a) > size(b); });
  if (list.size() > 1 && size(list[0]) == size(list[1])) {
    std::string all;
    for (const DicomSeries* s : list) all += "; " + text_of(*s);
    throw InputError(fmt::format("{}: several series; choose one by its UID, \"series\": \"{}\"{}{}", path,
                                 list[0]->uid, largest ? "" : ", or \"largest\"", all));
  }
  if (!list[0]->fault.empty()) throw InputError(list[0]->fault);
  return *list[0];
}

std::string dicom_series_of(const std::string& file) {
  const std::string uid = text_of(read_elements(file)->GetFile().GetDataSet(), kSeriesUid);
  if (uid.empty()) throw InputError(file + ": a DICOM file that belongs to no series of images");
  return uid;
}

}  // namespace brim
#endif
