#pragma once

#include <map>
#include <string>
#include <vector>

#include "brim/io/slice_stack.h"

namespace brim {

/// One image of a DICOM file.
struct DicomFrame {
  std::string file;
  int number = 0, of = 1;  ///< from 0, of all in the file
  StackSlice slice;
  double slope = 1.0, intercept = 0.0;
  std::size_t pixels_at = 0;  ///< [bytes] where the file's pixels begin
};

/// What a scanner wrote as one: images that belong together.
struct DicomSeries {
  std::string uid, number, modality, description;
  std::vector<DicomFrame> frames;
  std::string fault;  ///< why an image of it cannot be placed, or nothing
};

/// Collects the series of DICOM files. By GDCM; to be used in a process of its own (ChildReader).
class DicomScan {
 public:
  /// Files that belong to no series (directories of media) are passed over.
  /// @throws InputError  for a damaged file
  void add(const std::string& file);
  /// The series that is wanted, its frames in the order of the files.
  /// @param path    what the files are called together, in messages
  /// @param wanted  UID, or "largest"; empty: the only one of more than one slice
  /// @throws InputError  for an image of it without a place, for no series, and for several, which it lists
  DicomSeries take(const std::string& path, const std::string& wanted) const;

 private:
  std::map<std::string, DicomSeries> found_;  // by UID
  std::size_t frames_ = 0;
};

/// UID of the series that a file belongs to. @throws InputError  when it has none
std::string dicom_series_of(const std::string& file);

}  // namespace brim
