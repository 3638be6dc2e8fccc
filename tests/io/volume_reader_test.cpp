#include "brim/io/volume_reader.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include "brim/core/error.h"
#include "checkout_paths.h"
#include "io/temporary_folder.h"

namespace brim::volume_reader_test {
namespace {

/// Bytes of a NIfTI-1 file of int16 voxels, in either byte order.
class Nifti {
 public:
  explicit Nifti(bool big) : big_(big), bytes_(352, '\0') {
    put<std::int32_t>(0, 348);
    put<std::int16_t>(40, 3);
    for (int a = 0; a < 3; ++a) {
      put<std::int16_t>(42 + 2 * a, static_cast<std::int16_t>(2 + a));
      put<float>(80 + 4 * a, 1.5f);
    }
    put<float>(76, 1.0f);
    put<std::int16_t>(70, 4);
    put<std::int16_t>(72, 16);
    put<float>(108, 352.0f);
    bytes_[123] = 2;
    std::memcpy(bytes_.data() + 344, "n+1", 4);
    for (int i = 0; i < 24; ++i) append<std::int16_t>(static_cast<std::int16_t>(100 * i - 300));
  }
  template <class T>
  void put(std::size_t at, T value) {
    std::memcpy(bytes_.data() + at, &value, sizeof(T));
    if (big_) std::reverse(bytes_.begin() + at, bytes_.begin() + at + sizeof(T));
  }
  template <class T>
  void append(T value) {
    bytes_.resize(bytes_.size() + sizeof(T));
    put(bytes_.size() - sizeof(T), value);
  }
  std::string& bytes() { return bytes_; }

 private:
  bool big_;
  std::string bytes_;
};

std::string packed(const std::string& plain) {
  const std::string path = (std::filesystem::temp_directory_path() / "brim_packed.gz").string();
  gzFile f = gzopen(path.c_str(), "wb");
  gzwrite(f, plain.data(), static_cast<unsigned>(plain.size()));
  gzclose(f);
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string message(const std::string& path) {
  try {
    read_volume(read_volume_info(path));
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

TEST(VolumeReader, BothByteOrdersOfNiftiPlainAndPackedGiveTheSameVoxels) {
  const test::TemporaryFolder folder;
  for (const bool big : {false, true})
    for (const bool gzip : {false, true}) {
      Nifti n(big);
      n.put<float>(112, 2.0f);    // scl_slope
      n.put<float>(116, -10.0f);  // scl_inter
      const std::string path = folder.write(gzip ? "a.nii.gz" : "a.nii", gzip ? packed(n.bytes()) : n.bytes());
      const VolumeInfo info = read_volume_info(path);
      EXPECT_EQ(info.size, Vec3i(2, 3, 4));
      EXPECT_EQ(info.big_endian, big);
      EXPECT_EQ(info.type, VoxelType::Int16);
      const VoxelImage image = read_volume(info);
      ASSERT_EQ(image.values.size(), 24u);
      for (int i = 0; i < 24; ++i) EXPECT_EQ(image.values[i], 2.0f * (100 * i - 300) - 10.0f);
      EXPECT_TRUE(image.axes.isApprox(1.5e-3 * Mat3::Identity(), 1e-6));
    }
}

TEST(VolumeReader, SformGoesBeforeQformWhichGoesBeforeSteps) {
  const test::TemporaryFolder folder;
  Nifti n(false);
  // qform: half a turn about z, third axis turned round.
  n.put<std::int16_t>(252, 1);
  n.put<float>(264, 1.0f);
  n.put<float>(76, -1.0f);
  n.put<float>(268, 7.0f);
  VolumeInfo info = read_volume_info(folder.write("q.nii", n.bytes()));
  EXPECT_TRUE(info.axes.isApprox(1.5 * Vec3(-1, -1, -1).asDiagonal().toDenseMatrix(), 1e-6)) << info.axes;
  EXPECT_EQ(info.origin, Vec3(7, 0, 0));
  // sform: a shear.
  n.put<std::int16_t>(254, 1);
  const float rows[12] = {0, 2, 0.5f, 1, 3, 0, 0, 2, 0, 0, 4, 3};
  for (std::size_t i = 0; i < 12; ++i) n.put<float>(280 + 4 * i, rows[i]);
  info = read_volume_info(folder.write("s.nii", n.bytes()));
  Mat3 axes;
  axes << 0, 2, 0.5, 3, 0, 0, 0, 0, 4;
  EXPECT_TRUE(info.axes.isApprox(axes));
  EXPECT_EQ(info.origin, Vec3(1, 2, 3));
}

TEST(VolumeReader, NrrdOfEveryEncodingGivesTheSameVoxels) {
  const test::TemporaryFolder folder;
  const std::string head =
      "NRRD0004\n# made by hand\ntype: short\ndimension: 3\nsizes: 2 1 2\nendian: little\n"
      "space: left-posterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n"
      "space origin: (1,2,3)\n";
  const std::int16_t values[4] = {-5, 7, 300, -32000};
  std::string raw(reinterpret_cast<const char*>(values), sizeof values), swapped = raw;
  for (int i = 0; i < 4; ++i) std::swap(swapped[2 * i], swapped[2 * i + 1]);
  std::string big = head;
  big.replace(big.find("little"), 6, "big");
  folder.write("voxels.raw", "xxx" + raw);
  const std::vector<std::string> paths = {
      folder.write("raw.nrrd", head + "encoding: raw\n\n" + raw),
      folder.write("big.nrrd", big + "encoding: raw\n\n" + swapped),
      folder.write("gzip.nrrd", head + "encoding: gzip\n\n" + packed(raw)),
      folder.write("text.nrrd", head + "encoding: ascii\n\n-5 7\n300 -32000\n"),
      folder.write("detached.nhdr", head + "encoding: raw\nbyte skip: 3\ndata file: voxels.raw\n")};
  for (const std::string& path : paths) {
    SCOPED_TRACE(path);
    const VoxelImage image = read_volume(read_volume_info(path));
    EXPECT_EQ(image.values, (std::vector<float>{-5, 7, 300, -32000}));
    EXPECT_TRUE(image.axes.isApprox(1e-3 * Vec3(-2, -3, 4).asDiagonal().toDenseMatrix()));
    EXPECT_TRUE(image.origin.isApprox(1e-3 * Vec3(-1, -2, 3)));
  }
}

TEST(VolumeReader, RawFilesTakeTheirLayoutFromTheCaller) {
  const test::TemporaryFolder folder;
  const float values[2] = {1.5f, -2.0f};
  const std::string path =
      folder.write("x.raw", std::string("head") + std::string(reinterpret_cast<const char*>(values), 8));
  RawLayout layout;
  layout.size = Vec3i(2, 1, 1);
  layout.spacing = Vec3(0.1, 0.2, 0.3);
  layout.type = VoxelType::Float32;
  layout.skip = 4;
  const VoxelImage image = read_volume(raw_volume_info(path, layout));
  EXPECT_EQ(image.values, (std::vector<float>{1.5f, -2.0f}));
  EXPECT_EQ(image.axes(2, 2), 0.3);
}

TEST(VolumeReader, RawLayoutsFitTheirFileToTheByte) {
  const test::TemporaryFolder folder;
  const auto refused = [&](const std::string& name, const RawLayout& layout) {
    try {
      raw_volume_info(folder.write(name, std::string(48, 'x')).string(), layout);
      return std::string();
    } catch (const InputError& e) {
      return std::string(e.what());
    }
  };
  RawLayout layout;
  layout.size = Vec3i(2, 3, 4);
  layout.type = VoxelType::Int16;
  EXPECT_EQ(refused("x.raw", layout), "");
  EXPECT_EQ(refused("x", layout), "");
  const auto expect = [&](const std::string& name, const RawLayout& given, const std::vector<std::string>& words) {
    const std::string text = refused(name, given);
    for (const std::string& word : words) EXPECT_NE(text.find(word), std::string::npos) << text << " lacks " << word;
  };
  RawLayout bytes = layout, thin = layout, late = layout;
  bytes.type = VoxelType::Int8;
  thin.size.z() = 3;
  late.skip = 1;
  expect("x.raw", bytes, {"x.raw", "48 bytes", "needs 24", "2 x 3 x 4 voxels of int8"});
  expect("x.raw", thin, {"48 bytes", "needs 36"});
  expect("x.raw", late, {"48 bytes", "needs 49", "1 to skip"});
  // Files that say themselves how their voxels lie.
  for (const char* name : {"x.nrrd", "x.NHDR", "x.nii", "x.nii.gz", "x.vdb"})
    expect(name, layout, {name, "leave \"raw\" out"});
}

TEST(VolumeReader, UnitsOfNrrdAreKnownOnesOrRefused) {
  const test::TemporaryFolder folder;
  const auto file = [&](const std::string& units) {
    return folder.write("u.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n" + units + "\n1")
        .string();
  };
  const auto unit = [&](const std::string& units) { return read_volume_info(file(units)).unit; };
  EXPECT_EQ(unit("space units: \"mm\" \"mm\" \"mm\"\n"), 1e-3);
  EXPECT_EQ(unit("space units: \"m\" \"m\" \"m\"\n"), 1.0);
  EXPECT_EQ(unit("units: \"cm\" \"\" \"cm\"\n"), 1e-2);
  EXPECT_EQ(unit("space units: \"microns\" \"um\" \"\u00b5m\"\n"), 1e-6);
  EXPECT_FALSE(read_volume_info(file("")).unit_given);
  EXPECT_FALSE(read_volume_info(file("space units: \"\" \"none\" \"\"\n")).unit_given);
  for (const char* bad : {"\"furlong\" \"furlong\" \"furlong\"", "\"mm\" \"mm\" \"m\""}) {
    const std::string text = message(file(std::string("space units: ") + bad + "\n"));
    EXPECT_NE(text.find(bad), std::string::npos) << text;
    EXPECT_NE(text.find("mm, um"), std::string::npos) << text;
  }
}

TEST(VolumeReader, VolumesWithoutAFiniteIntensityAreRefused) {
  const test::TemporaryFolder folder;
  const std::string path = folder.write("none.nii", "");
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  VoxelImage image;
  image.size = Vec3i(2, 2, 2);
  image.axes = 0.01 * Mat3::Identity();
  image.values = {nan, nan, inf, nan, nan, -inf, nan, nan};
  write_nifti(path, image);
  EXPECT_NE(message(path).find("none.nii: no voxel has a finite intensity"), std::string::npos) << message(path);
  VolumeReadOptions options;
  options.transfer = [](double) { return 1.0; };
  EXPECT_THROW(read_volume(read_volume_info(path), options), InputError);
  image.values[3] = 1.0f;
  write_nifti(path, image);
  EXPECT_EQ(message(path), "");
}

TEST(VolumeReader, SummariesTellRangeLabelsAndShare) {
  const test::TemporaryFolder folder;
  const std::string path = folder.write("s.nii", "");
  VoxelImage image;
  image.size = Vec3i(30, 1, 2);
  image.axes = 0.01 * Mat3::Identity();
  for (int i = 0; i < 60; ++i) image.values.push_back(static_cast<float>(i % 3 == 0 ? 5 : i % 3 == 1 ? -2 : 0));
  image.values[7] = std::numeric_limits<float>::quiet_NaN();
  write_nifti(path, image);
  const auto share = [](double v) { return v > 0 ? 0.25 : 0.0; };
  IntensitySummary s = summarize_intensities(read_volume_info(path), share);
  EXPECT_EQ(s.least, -2.0);
  EXPECT_EQ(s.most, 5.0);
  EXPECT_EQ(s.fullest, 0.25);
  EXPECT_EQ(s.labels, (std::vector<int>{-2, 0, 5}));
  EXPECT_FALSE(s.more_labels);
  for (int i = 0; i < 60; ++i) image.values[i] = static_cast<float>(60 - i);
  write_nifti(path, image);
  s = summarize_intensities(read_volume_info(path), share);
  EXPECT_EQ(s.labels.size(), IntensitySummary::kMostLabels);
  EXPECT_EQ(s.labels.back(), 20);
  EXPECT_TRUE(s.more_labels);
}

TEST(VolumeReader, WhatIsWrittenIsReadBack) {
  const test::TemporaryFolder folder;
  std::mt19937 rng(4);
  std::uniform_real_distribution<float> u(-1, 1);
  VoxelImage image;
  image.size = Vec3i(5, 3, 4);
  image.axes << 0.001, 0, 0.0005, 0, -0.002, 0, 0, 0, 0.003;
  image.origin = Vec3(0.01, -0.02, 0.5);
  for (int i = 0; i < 60; ++i) image.values.push_back(u(rng));
  const std::string path = folder.write("w.nii", "");
  write_nifti(path, image);
  const VoxelImage back = read_volume(read_volume_info(path));
  EXPECT_EQ(back.values, image.values);
  EXPECT_TRUE(back.axes.isApprox(image.axes, 1e-6));
  EXPECT_TRUE(back.origin.isApprox(image.origin, 1e-6));
}

TEST(VolumeReader, VoxelsWithoutANumberAreAsEmptyAsTheEmptiest) {
  const test::TemporaryFolder folder;
  VoxelImage image;
  image.size = Vec3i(4, 2, 2);
  image.axes = 0.01 * Mat3::Identity();
  image.values.assign(16, 40.0f);
  image.values[3] = -1000.0f;
  for (const std::size_t i : {0, 1, 4, 5, 8, 9, 12, 13}) image.values[i] = std::numeric_limits<float>::quiet_NaN();
  image.values[6] = std::numeric_limits<float>::infinity(), image.values[7] = -image.values[6];
  const std::string path = folder.write("n.nii", "");
  write_nifti(path, image);
  const VoxelImage back = read_volume(read_volume_info(path));
  const float lowest = back.values[7];
  EXPECT_LE(lowest, -1e29f);
  EXPECT_GE(back.values[6], 1e29f);
  EXPECT_EQ(back.values[2], 40.0f);
  for (const std::size_t i : {0, 1, 4, 5, 8, 9, 12, 13}) EXPECT_EQ(back.values[i], lowest);
  // As shares of matter, of which such voxels have none.
  VolumeReadOptions options;
  options.coarsen = Vec3i(2, 2, 2);
  const IntensityWindow window{-300, -300};
  options.transfer = [&](double v) { return window.share(v); };
  const VoxelImage joined = read_volume(read_volume_info(path), options);
  EXPECT_EQ(joined.values[0], 0.0f);
  EXPECT_NEAR(joined.values[1], 6.0f / 8.0f, 1e-6f);
}

TEST(VolumeReader, JoinedVoxelsHoldTheMeanAndKeepTheMatter) {
  const test::TemporaryFolder folder;
  std::mt19937 rng(8);
  std::uniform_real_distribution<float> u(0, 100);
  VoxelImage image;
  image.size = Vec3i(7, 5, 6);
  image.axes = 0.01 * Mat3::Identity();
  for (std::size_t i = 0; i < image.count(); ++i) image.values.push_back(u(rng));
  const std::string path = folder.write("j.nii", "");
  write_nifti(path, image);
  VolumeReadOptions options;
  options.coarsen = Vec3i(2, 3, 4);
  const IntensityWindow window{50, 50};
  options.transfer = [&](double v) { return window.share(v); };
  const VoxelImage joined = read_volume(read_volume_info(path), options);
  EXPECT_EQ(joined.size, Vec3i(4, 2, 2));
  EXPECT_TRUE(joined.axes.isApprox(0.01 * Vec3(2, 3, 4).asDiagonal().toDenseMatrix(), 1e-6));
  EXPECT_TRUE(joined.origin.isApprox(Vec3(0.005, 0.01, 0.015), 1e-6));
  double fine = 0.0, coarse = 0.0;
  for (const float v : image.values) fine += window.share(v);
  for (const float v : joined.values) coarse += 24.0 * v;
  EXPECT_NEAR(coarse, fine, 1e-4);
  options.max_bytes = 10;
  EXPECT_THROW(read_volume(read_volume_info(path), options), InputError);
}

TEST(VolumeReader, BadFilesAreRefusedWithAMessage) {
  const test::TemporaryFolder folder;
  const auto expect = [&](const std::string& name, const std::string& bytes, const std::string& words) {
    const std::string text = message(folder.write(name, bytes));
    EXPECT_NE(text.find(words), std::string::npos) << name << ": \"" << text << "\" lacks \"" << words << "\"";
    EXPECT_NE(text.find(name), std::string::npos) << text;
  };
  const auto broken = [](auto change) {
    Nifti n(false);
    change(n);
    return n.bytes();
  };
  expect("empty.nii", "", "0 bytes");
  expect("magic.nii", broken([](Nifti& n) { n.bytes()[344] = 'x'; }), "is not a NIfTI-1");
  expect("pair.nii", broken([](Nifti& n) { n.bytes()[345] = 'i'; }), "another file");
  expect("zero.nii", broken([](Nifti& n) { n.put<float>(84, 0.0f); }), "voxel steps of 1.5, 0, 1.5");
  expect("nan.nii", broken([](Nifti& n) { n.put<float>(84, std::nanf("")); }), "voxel steps");
  expect("short.nii", broken([](Nifti& n) { n.bytes().resize(390); }), "cut short: 390 bytes are there where 400");
  expect("huge.nii", broken([](Nifti& n) {
           for (int a = 0; a < 3; ++a) n.put<std::int16_t>(42 + 2 * a, 32767);
         }),
         "3.52e+13 voxels");
  expect("none.nii", broken([](Nifti& n) { n.put<std::int16_t>(42, 0); }), "size 0 x 3 x 4");
  expect("minus.nii", broken([](Nifti& n) { n.put<std::int16_t>(42, -2); }), "size -2 x 3 x 4");
  expect("time.nii", broken([](Nifti& n) { n.put<std::int16_t>(40, 4), n.put<std::int16_t>(48, 9); }),
         "9 values along axis 4");
  expect("colour.nii", broken([](Nifti& n) { n.put<std::int16_t>(70, 128); }), "type 128");
  expect("flat.nii", broken([](Nifti& n) {
           n.put<std::int16_t>(254, 1);
           const float rows[12] = {1, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0};
           for (std::size_t i = 0; i < 12; ++i) n.put<float>(280 + 4 * i, rows[i]);
         }),
         "in one plane");
  expect("offset.nii", broken([](Nifti& n) { n.put<float>(108, 12.0f); }), "start at byte 12");
  const std::string whole = packed(Nifti(false).bytes());
  expect("short.nii.gz", whole.substr(0, whole.size() - 20), "short.nii.gz");
  const std::string head = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\n";
  expect("magic.nrrd", "NRD0004\n", "is not an NRRD");
  expect("missing.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\n\n", "no \"sizes\"");
  expect("short.nrrd", head + "encoding: raw\n\n1234567", "cut short");
  expect("text.nrrd", head + "encoding: ascii\n\n1 2 3 4 5 6 7", "fewer numbers");
  expect("word.nrrd", head + "encoding: ascii\n\n1 2 x 4 5 6 7 8", "\"x\" is not a number");
  expect("bzip.nrrd", head + "encoding: bzip2\n\n", "encoding \"bzip2\"");
  expect("type.nrrd", "NRRD0004\ntype: block\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n", "type \"block\"");
  expect("step.nrrd", head + "spacings: 1 0 1\nencoding: raw\n\n12345678", "voxel steps of 1, 0, 1");
  expect("endian.nrrd", "NRRD0004\ntype: short\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\n12", "\"endian\"");
  expect("absurd.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1000000 1000000 1000000\nencoding: raw\n\n1",
         "1e+18 voxels");
  expect("name.mhd", "", "must end in .nii");
  EXPECT_NE(message((folder.path / "gone.nii").string()).find("cannot be opened"), std::string::npos);
}

TEST(VolumeReader, RealVolumesAreReadAsTheyAre) {
  namespace fs = std::filesystem;
  const char* env = std::getenv("BRIM_DATA");
  const fs::path data = env != nullptr ? fs::path(env) : fs::path(BRIM_SOURCE_DIR) / "../shared/data";
  if (!fs::exists(data / "anatomical.nii")) GTEST_SKIP() << "no data";
  const VolumeInfo mri = read_volume_info((data / "anatomical.nii").string());
  EXPECT_TRUE(mri.big_endian);
  EXPECT_EQ(mri.size, Vec3i(33, 41, 25));
  EXPECT_TRUE(mri.axes.isApprox(Vec3(-2, 2, 2).asDiagonal().toDenseMatrix()));
  EXPECT_TRUE(mri.origin.isApprox(Vec3(32, -40, -16)));
  const VoxelImage image = read_volume(mri);
  const auto [least, most] = std::minmax_element(image.values.begin(), image.values.end());
  EXPECT_EQ(*least, -610.0f);  // these three by another program
  EXPECT_EQ(*most, 30393.0f);
  double sum = 0.0;
  for (const float v : image.values) sum += v;
  EXPECT_NEAR(sum / 33825.0, 8401.066726, 1e-5);
  const VolumeInfo ct = read_volume_info((data / "CT_AVM.nii.gz").string());
  EXPECT_EQ(ct.size, Vec3i(256, 242, 154));
  const VoxelImage head = read_volume(ct);
  std::size_t bright = 0;
  for (const float v : head.values) bright += v > 2.208627f * 20.5f;
  EXPECT_NEAR(static_cast<double>(bright) / static_cast<double>(head.values.size()), 0.024307, 1e-5);
}

}  // namespace
}  // namespace brim::volume_reader_test
