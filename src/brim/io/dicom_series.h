#pragma once

#include <map>
#include <string>
#include <vector>

#include "brim/io/slice_stack.h"

namespace brim {

/// One image of a DICOM file.
struct DicomFrame {
  std::string file;
  int number = 0, of = 1;  ///< index from 0, number of images in the file
  StackSlice slice;
  double slope = 1.0, intercept = 0.0;
  std::size_t pixels_at = 0;  ///< [bytes] offset of the file's pixels
};

/// A series: images that a scanner wrote as belonging together.
struct DicomSeries {
  std::string uid, number, modality, description;
  std::vector<DicomFrame> frames;
  std::string fault;  ///< reason why one of its images has no position, or empty
};

/// Collects the series of DICOM files, using GDCM; to be run in a separate process (ChildReader).
class DicomScan {
 public:
  /// Files that belong to no series (directories of media) are skipped.
  /// @throws InputError  for a damaged file
  void add(const std::string& file);
  /// Returns the wanted series, its frames in the order of the files.
  /// @param path    common name of the files in messages
  /// @param wanted  UID, or "largest"; empty: the only one of more than one slice
  /// @throws InputError  for an image of it without a position, for no series, and for several, which it lists
  DicomSeries take(const std::string& path, const std::string& wanted) const;

 private:
  std::map<std::string, DicomSeries> found_;  // by UID
  std::size_t frames_ = 0;
};

/// UID of the series that a file belongs to. @throws InputError  when it has none
std::string dicom_series_of(const std::string& file);

}  // namespace brim
