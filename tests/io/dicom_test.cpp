#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "brim/core/error.h"
#include "brim/io/volume_reader.h"
#include "io/dicom_writer.h"
#include "io/temporary_folder.h"

#ifdef BRIM_HAS_GDCM
#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>
#endif

namespace brim::dicom_test {
namespace {

using test::DicomSlice;
using test::DicomWriter;

std::string refusal(const std::string& path, const std::string& series = {}) {
  try {
    read_volume(read_volume_info(path, {}, series));
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

#define EXPECT_SAYS(text, words) EXPECT_NE(std::string(text).find(words), std::string::npos) << (text)

#ifdef BRIM_HAS_GDCM

constexpr int kSlices = 5;

/// Slice k of a CT; its values tell it apart.
DicomSlice slice_of(int k) {
  DicomSlice s;
  s.position = {1.0, 2.0, 3.0 + 1.5 * k};
  for (int i = 0; i < 12; ++i) s.pixels.push_back(static_cast<std::int16_t>(100 * k + i - 50));
  return s;
}

/// Written in an order of names that is not that of places. @return the folder
std::string write_series(const test::TemporaryFolder& folder, const std::string& name, const auto& change) {
  std::filesystem::create_directories(folder.path / name);
  for (int k = 0; k < kSlices; ++k) {
    DicomSlice s = slice_of(k);
    change(s, k);
    folder.write(fmt::format("{}/IM{}", name, (k * 3) % kSlices), s.file());
  }
  return (folder.path / name).string();
}
std::string write_series(const test::TemporaryFolder& folder, const std::string& name) {
  return write_series(folder, name, [](DicomSlice&, int) {});
}

void expect_values(const VoxelImage& image, double slope = 1.0, double intercept = 0.0) {
  ASSERT_EQ(image.size, Vec3i(4, 3, kSlices));
  for (int k = 0; k < kSlices; ++k)
    for (int i = 0; i < 12; ++i)
      EXPECT_EQ(image.values[static_cast<std::size_t>(12 * k + i)],
                static_cast<float>(slope * (100 * k + i - 50) + intercept));
}

TEST(Dicom, SlicesAreSortedByPlaceAndTurnedToRightFrontUp) {
  const test::TemporaryFolder folder;
  const VolumeInfo info = read_volume_info(write_series(folder, "ct"));
  EXPECT_EQ(info.type, VoxelType::Int16);
  EXPECT_TRUE(info.unit_given);
  EXPECT_SAYS(info.format, "DICOM CT, series 1.2.3 'made by hand'");
  EXPECT_EQ(info.format.find("tilted"), std::string::npos);
  EXPECT_EQ(info.origin, Vec3(-1, -2, 3));
  EXPECT_EQ(info.axes, Vec3(-0.25, -0.5, 1.5).asDiagonal().toDenseMatrix());
  const VoxelImage image = read_volume(info);
  expect_values(image);
  EXPECT_TRUE(image.axes.isApprox(1e-3 * info.axes, 1e-15));
}

TEST(Dicom, ASeriesThatSaysNothingOfItsModalityIsNamedWithout) {
  const test::TemporaryFolder folder;
  DicomSlice s = slice_of(0);
  std::string bytes = s.file();
  const auto at = bytes.find(std::string("CS\x02\0CT", 6));
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at + 4, 2, "  ");
  EXPECT_SAYS(read_volume_info(folder.write("a.dcm", bytes)).format, "DICOM, series 1.2.3");
}

TEST(Dicom, DirectionsAndATiltedGantryAreApplied) {
  const test::TemporaryFolder folder;
  // Sagittal slices from left to right, columns up: rows run to the back.
  VolumeInfo info = read_volume_info(write_series(folder, "sagittal", [](DicomSlice& s, int k) {
    s.orientation = {0, 1, 0, 0, 0, -1};
    s.position = {20.0 - 2.0 * k, -30, 40};
  }));
  EXPECT_EQ(info.axes.col(0), Vec3(0, -0.25, 0));
  EXPECT_EQ(info.axes.col(1), Vec3(0, 0, -0.5));
  EXPECT_EQ(info.axes.col(2), Vec3(2, 0, 0));
  EXPECT_EQ(info.origin, Vec3(-20, 30, 40));
  expect_values(read_volume(info));
  // The table moves along z; the planes are turned about x by 20 degrees.
  const double c = std::cos(M_PI / 9), s = std::sin(M_PI / 9);
  info = read_volume_info(
      write_series(folder, "tilted", [&](DicomSlice& slice, int) { slice.orientation = {1, 0, 0, 0, c, s}; }));
  EXPECT_SAYS(info.format, "tilted by 20.0 degrees");
  EXPECT_TRUE(info.axes.col(1).isApprox(0.5 * Vec3(0, -c, s), 1e-9));
  EXPECT_TRUE(info.axes.col(2).isApprox(Vec3(0, 0, 1.5), 1e-12));
}

TEST(Dicom, ValuesAreRescaledSliceBySlice) {
  const test::TemporaryFolder folder;
  expect_values(read_volume(read_volume_info(write_series(folder, "ct",
                                                          [](DicomSlice& s, int k) {
                                                            s.intercept = -1024.0 + 100 * k;
                                                            for (std::int16_t& v : s.pixels)
                                                              v = static_cast<std::int16_t>(v - 100 * k);
                                                          }))),
                1.0, -1024.0);
  const VoxelImage pet = read_volume(
      read_volume_info(write_series(folder, "pet", [](DicomSlice& s, int k) { s.slope = 0.25 * (k + 1); })));
  EXPECT_EQ(pet.values[12 * 3], 1.0f * (300 - 50));
}

TEST(Dicom, UnusedBitsAndBothByteOrdersAreRead) {
  const test::TemporaryFolder folder;
  expect_values(read_volume(read_volume_info(write_series(folder, "big", [](DicomSlice& s, int) { s.big = true; }))));
  // Twelve bits with a sign, and something else above them.
  expect_values(read_volume(read_volume_info(write_series(folder, "twelve", [](DicomSlice& s, int k) {
    s.stored = 12;
    for (std::int16_t& v : s.pixels) v = static_cast<std::int16_t>((v & 0x0fff) | (k % 2 ? 0x3000 : 0));
  }))));
}

TEST(Dicom, PackedImagesGiveTheSameValues) {
  const test::TemporaryFolder folder;
  const struct {
    const char* name;
    gdcm::TransferSyntax::TSType syntax;
  } kinds[] = {{"rle", gdcm::TransferSyntax::RLELossless},
               {"jpeg", gdcm::TransferSyntax::JPEGLosslessProcess14_1},
               {"jpeg_ls", gdcm::TransferSyntax::JPEGLSLossless},
               {"jpeg_2000", gdcm::TransferSyntax::JPEG2000Lossless},
               {"deflated", gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian}};
  for (const auto& kind : kinds) {
    SCOPED_TRACE(kind.name);
#ifdef __SANITIZE_THREAD__
    // OpenJPEG starts threads, which that sanitizer forbids in a process that was forked from one with threads.
    if (kind.syntax == gdcm::TransferSyntax::JPEG2000Lossless) continue;
#endif
    // Large enough for wavelets.
    const auto value = [](int k, int i) { return 500 * k + (i * i) % 911; };
    const std::string path = write_series(folder, kind.name, [&](DicomSlice& s, int k) {
      s.width = 64, s.height = 48, s.is_signed = 0, s.intercept = -1024;
      s.pixels.clear();
      for (int i = 0; i < 64 * 48; ++i) s.pixels.push_back(static_cast<std::int16_t>(value(k, i)));
    });
    for (const auto& entry : std::filesystem::directory_iterator(path)) {
      const std::string file = entry.path().string();
      gdcm::ImageReader reader;
      reader.SetFileName(file.c_str());
      ASSERT_TRUE(reader.Read());
      gdcm::ImageWriter writer;
      writer.SetFileName(file.c_str());
      writer.SetFile(reader.GetFile());
      if (kind.syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian) {
        reader.GetFile().GetHeader().SetDataSetTransferSyntax(kind.syntax);
        gdcm::Writer plain;
        plain.SetFileName(file.c_str());
        plain.SetFile(reader.GetFile());
        ASSERT_TRUE(plain.Write());
        continue;
      }
      gdcm::ImageChangeTransferSyntax change;
      change.SetTransferSyntax(kind.syntax);
      change.SetInput(reader.GetImage());
      ASSERT_TRUE(change.Change());
      writer.SetImage(change.GetOutput());
      ASSERT_TRUE(writer.Write());
    }
    const auto size = std::filesystem::file_size(path + "/IM3");
    const VoxelImage image = read_volume(read_volume_info(path));
    ASSERT_EQ(image.size, Vec3i(64, 48, kSlices));
    for (int k = 0, at = 0; k < kSlices; ++k)
      for (int i = 0; i < 64 * 48; ++i, ++at)
        ASSERT_EQ(image.values[static_cast<std::size_t>(at)], static_cast<float>(value(k, i) - 1024));
    std::filesystem::resize_file(path + "/IM3", size - 100);
    EXPECT_SAYS(refusal(path), "IM3");
  }
}

TEST(Dicom, AnEnhancedFileOfManyFramesIsTheSameVolume) {
  const test::TemporaryFolder folder;
  DicomWriter shared, measures, turn, transform;
  measures.text(0x0018, 0x0050, "DS", "5");
  measures.text(0x0028, 0x0030, "DS", "0.5\\0.25");
  turn.text(0x0020, 0x0037, "DS", "1\\0\\0\\0\\1\\0");
  transform.text(0x0028, 0x1052, "DS", "-1024");
  transform.text(0x0028, 0x1053, "DS", "2");
  shared.sequence(0x0020, 0x9116, {turn});
  shared.sequence(0x0028, 0x9110, {measures});
  shared.sequence(0x0028, 0x9145, {transform});
  std::vector<DicomWriter> frames;
  DicomSlice all = slice_of(0);
  all.pixels.clear();
  for (int k = kSlices; k-- > 0;) {  // from the top down
    DicomWriter place, frame;
    const DicomSlice s = slice_of(k);
    place.text(0x0020, 0x0032, "DS", test::decimals(s.position));
    frame.sequence(0x0020, 0x9113, {place});
    frames.push_back(frame);
    all.pixels.insert(all.pixels.end(), s.pixels.begin(), s.pixels.end());
  }
  DicomWriter w;
  w.text(0x0008, 0x0016, "UI", "1.2.840.10008.5.1.4.1.1.2.1");
  w.text(0x0008, 0x0018, "UI", "1.2.3.4");
  w.text(0x0008, 0x0060, "CS", "CT");
  w.text(0x0020, 0x000e, "UI", "1.2.3");
  all.image(w, false);
  w.sequence(0x5200, 0x9229, {shared});
  w.sequence(0x5200, 0x9230, frames);
  w.pixels(all.pixels);
  const VolumeInfo info = read_volume_info(folder.write("enhanced.dcm", w.file()));
  EXPECT_EQ(info.axes, Vec3(-0.25, -0.5, 1.5).asDiagonal().toDenseMatrix());
  EXPECT_EQ(info.origin, Vec3(-1, -2, 3));
  expect_values(read_volume(info), 2.0, -1024.0);
}

TEST(Dicom, OfSeveralSeriesOneMustBeChosen) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path.string();
  write_series(folder, "a/1");
  // One picture alone is an overview, and does not count; what is no DICOM file neither.
  DicomSlice overview = slice_of(0);
  overview.series = "1.2.9", overview.orientation = {0, 1, 0, 0, 0, -1};
  folder.write("a/overview", overview.file());
  folder.write("a/README", "a text");
  EXPECT_SAYS(read_volume_info(path).format, "series 1.2.3 ");
  // A second one.
  write_series(folder, "b", [](DicomSlice& s, int k) {
    s.series = "1.2.4";
    s.position[2] = 10.0 * k;
  });
  std::string text = refusal(path);
  EXPECT_SAYS(text, "several series");
  EXPECT_SAYS(text, "1.2.3: number 7, CT 'made by hand', 5 slices of 4 x 3");
  EXPECT_SAYS(text, "1.2.4: number 7");
  EXPECT_EQ(read_volume_info(path, {}, "1.2.4").axes(2, 2), 10.0);
  EXPECT_EQ(read_volume_info(path, {}, "1.2.3").axes(2, 2), 1.5);
  EXPECT_SAYS(refusal(path, "largest"), "several series");
  EXPECT_SAYS(refusal(path, "1.2.5"), "no series '1.2.5'");
  // A file of a series stands for it, in its folder.
  EXPECT_EQ(read_volume_info(path + "/b/IM1").axes(2, 2), 10.0);
  DicomSlice more = slice_of(kSlices);
  folder.write("a/1/IM5", more.file());
  EXPECT_EQ(read_volume_info(path, {}, "largest").size.z(), kSlices + 1);
}

TEST(Dicom, WhatIsNotWholeIsRefusedWithItsPlace) {
  const test::TemporaryFolder folder;
  const std::string gap = write_series(folder, "gap");
  std::filesystem::remove(gap + "/IM1");  // slice 2
  EXPECT_SAYS(refusal(gap), "1 missing between IM3 at 4.5 mm and IM4 at 7.5 mm");
  EXPECT_SAYS(refusal(write_series(folder, "nowhere", [](DicomSlice& s, int k) { s.placed = k != 3; })),
              "IM4 has no Image Position");
  EXPECT_SAYS(refusal(write_series(folder, "flat", [](DicomSlice& s, int) { s.slope = 0.0; })), "rescale slope of 0");
  EXPECT_SAYS(refusal(write_series(folder, "short",
                                   [](DicomSlice& s, int k) {
                                     if (k == 2) s.pixels.resize(7);
                                   })),
              "IM1");
  const std::string cut = write_series(folder, "cut");
  const std::string whole = slice_of(4).file();
  for (std::size_t size = 140; size < whole.size(); size += 23) {
    folder.write("cut/IM2", whole.substr(0, size));
    EXPECT_SAYS(refusal(cut), "IM2") << size;
  }
  // A file that was asked for by name lies beside the damaged one.
  folder.write("cut/IM2", whole.substr(0, 200));
  const std::string text = refusal(cut + "/IM0");
  EXPECT_SAYS(text, "IM2");
  EXPECT_SAYS(text, "may be a slice of the series of " + cut + "/IM0");
  std::filesystem::create_directories(folder.path / "empty");
  EXPECT_SAYS(refusal((folder.path / "empty").string()), "without DICOM files");
  EXPECT_SAYS(refusal(folder.write("a.txt", "text")), "DICOM file or folder");
  EXPECT_SAYS(refusal(folder.write("a.nii", std::string(400, 'x')), "1.2.3"), "a.nii");
}

TEST(Dicom, DamagedFilesAreReadOrRefused) {
  const test::TemporaryFolder folder;
  std::mt19937 rng(21);
  const std::string whole = slice_of(0).file();
  for (int round = 0; round < 60; ++round) {
    std::string bytes = whole;
    for (int n = 0; n < 4; ++n) bytes[132 + rng() % (bytes.size() - 132)] = static_cast<char>(rng());
    EXPECT_NO_THROW(refusal(folder.write("a.dcm", bytes)));
  }
}

#else

TEST(Dicom, WithoutGdcmItIsRefusedWithTheReason) {
  const test::TemporaryFolder folder;
  DicomSlice s;
  s.pixels.assign(12, 0);
  EXPECT_SAYS(refusal(folder.write("a.dcm", s.file())), "built without GDCM");
}

#endif

}  // namespace
}  // namespace brim::dicom_test
