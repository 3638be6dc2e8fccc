#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "brim/core/error.h"
#include "brim/io/volume_reader.h"
#include "brim/scene/scene.h"
#include "io/dicom_writer.h"
#include "support/images.h"

namespace brim::image_volume_test {
namespace {

namespace fs = std::filesystem;

class ImageVolumes : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("brim_image_volumes_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    const VoxelImage ball = testing::scan({Vec3::Constant(-0.12), Vec3::Constant(0.12)}, 0.01,
                                          [](const Vec3& x) { return (x - Vec3(0.01, 0, 0)).norm() - 0.1; });
    write_nifti((folder_ / "ball.nii").string(), ball);
    std::ofstream(folder_ / "garbage.nii") << std::string(500, 'x');
    std::ofstream(folder_ / "short.nrrd") << "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 9 9 9\nencoding: raw\n\n12";
    std::ofstream(folder_ / "zero.nrrd")
        << "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 1\nspacings: 1 0 1\nencoding: raw\n\n1234";
    std::ofstream raw(folder_ / "ball.raw", std::ios::binary);
    raw.write(reinterpret_cast<const char*>(ball.values.data()), static_cast<std::streamsize>(4 * ball.values.size()));
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static World build(const std::string& body) {
    const std::string text = R"({"brim": 1, "name": "image", "duration": 1, "bodies": [
      {"kind": "image_volume", "name": "scan", )" +
                             body + "}]}";
    return build_world(parse_scene(text, (folder_ / "scene.json").string()));
  }
  static std::string message(const std::string& body) {
    try {
      build(body);
      return "";
    } catch (const InputError& e) {
      return e.what();
    }
  }
  static inline fs::path folder_;
};

TEST_F(ImageVolumes, LabelsOfASegmentationAreBodiesAndKeepChoosesPieces) {
  // Along x: a block of label 1 of 4 voxels, two of nothing, one of label 1, three of label 7.
  std::string values;
  for (int k = 0; k < 8; ++k)
    for (int j = 0; j < 8; ++j)
      for (int i = 0; i < 14; ++i) {
        const bool inside = k > 1 && k < 6 && j > 1 && j < 6;
        const int label = i < 2 || i > 11 ? 0 : i < 6 ? 1 : i < 8 ? 0 : i < 9 ? 1 : 7;
        values += static_cast<char>(inside ? label : 0);
      }
  std::ofstream(folder_ / "labels.nrrd", std::ios::binary)
      << "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 14 8 8\nspacings: 10 10 10\nencoding: raw\n\n"
      << values;
  const auto mass = [](const char* body) { return build(body).body(0).mass(); };
  const double voxel = 16 * 1e-6 * 1000.0;  // a slice of 4 x 4 voxels of a cubic centimetre
  const char* const common = R"("file": "labels.nrrd", "voxel_size": 0.01, )";
  const auto with = [&](const char* keys) { return mass((std::string(common) + keys).c_str()); };
  EXPECT_NEAR(with(R"("labels": [7])"), 3 * voxel, 0.3 * voxel);
  EXPECT_NEAR(with(R"("labels": [1])"), 5 * voxel, 0.4 * voxel);
  EXPECT_NEAR(with(R"("labels": [1, 7])"), 8 * voxel, 0.4 * voxel);
  const double all = with(R"("labels": [1])"), large = with(R"("labels": [1], "keep": "largest")");
  EXPECT_LT(large, all - 0.5 * voxel);
  EXPECT_NEAR(with(R"("labels": [1], "keep": {"seed": [0.02, 0.04, 0.04]})"), large, 1e-12);
  // Cells less than half filled that touch a piece at an edge alone go with the specks.
  EXPECT_NEAR(with(R"("labels": [1], "keep": {"seed": [0.085, 0.04, 0.04]})"), voxel, 0.2 * voxel);
  EXPECT_NEAR(with(R"("labels": [1], "keep": {"above": 3e-5})"), large, 1e-12);
  EXPECT_NE(message(std::string(common) + R"("labels": [1], "keep": {"above": 1})").find("more than any piece"),
            std::string::npos);
  EXPECT_NE(message(std::string(common) + R"("labels": [1], "window": [0, 1])").find("give one"), std::string::npos);
  EXPECT_NE(message(std::string(common) + R"("labels": [3])").find("/labels"), std::string::npos);
}

TEST_F(ImageVolumes, FileRawAndShapeOfTheSameBallGiveTheSameBody) {
  const double mass = 700.0 * 4.0 / 3.0 * 3.14159265358979 * 1e-3;
  for (const char* body : {R"("file": "ball.nii", "window": [0, 100], "density": 700)",
                           R"("file": "ball.raw", "window": [0, 100], "density": 700,
                              "raw": {"size": [25, 25, 25], "spacing": [0.01, 0.01, 0.01], "type": "float32"})",
                           R"("shape": {"kind": "sphere", "radius": 0.1}, "image_spacing": 0.01, "density": 700)"}) {
    SCOPED_TRACE(body);
    const World w = build(body);
    EXPECT_EQ(w.body(0).kind(), "image_volume");
    EXPECT_NEAR(w.body(0).mass(), mass, 0.01 * mass);
    EXPECT_LT(Vec3(w.q(0)[0], w.q(0)[1], w.q(0)[2]).norm(), 1e-3) << "centred";
    EXPECT_NEAR(w.body(0).bounds(0).extent().x(), 0.2, 0.03);
    EXPECT_GT(w.body(0).display().triangles.size(), 100u);
  }
}

TEST_F(ImageVolumes, AFolderOfDicomSlicesIsTheSameBodyAsOneFile) {
  const VoxelImage ball = testing::scan({Vec3::Constant(-0.12), Vec3::Constant(0.12)}, 0.01,
                                        [](const Vec3& x) { return (x - Vec3(0.02, 0.01, 0)).norm() - 0.08; });
  VoxelImage whole = ball;
  for (float& v : whole.values) v = std::round(v);
  write_nifti((folder_ / "twin.nii").string(), whole);
  fs::create_directories(folder_ / "slices");
  const Vec3i n = whole.size;
  for (int k = 0; k < n.z(); ++k) {
    test::DicomSlice s;
    s.width = static_cast<unsigned>(n.x()), s.height = static_cast<unsigned>(n.y());
    // Rows run to the right and to the front: the patient's left and back are the other way.
    s.orientation = {-1, 0, 0, 0, -1, 0};
    const Vec3 at = 1e3 * (whole.origin + whole.axes.col(2) * k);
    s.position = {-at.x(), -at.y(), at.z()};
    s.spacing = {10, 10};
    s.intercept = -200, s.slope = 0.5;
    for (int i = 0; i < n.x() * n.y(); ++i)
      s.pixels.push_back(static_cast<std::int16_t>(
          2 * (std::lround(whole.values[static_cast<std::size_t>(k * n.x() * n.y() + i)]) + 200)));
    std::ofstream(folder_ / fmt::format("slices/{}.dcm", (7 * k) % n.z()), std::ios::binary) << s.file();
  }
  const char* const keys = R"(, "window": [20, 80], "center": false)";
  const std::string text = message(fmt::format(R"("file": "slices"{})", keys));
  if (text.find("built without GDCM") != std::string::npos) GTEST_SKIP() << text;
  EXPECT_EQ(text, "");
  const World file = build(fmt::format(R"("file": "twin.nii"{})", keys));
  for (const char* path : {"slices", "slices/3.dcm"}) {
    const World folder = build(fmt::format(R"("file": "{}"{})", path, keys));
    EXPECT_NEAR(folder.body(0).mass(), file.body(0).mass(), 1e-6 * file.body(0).mass());
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(folder.q(0)[a], file.q(0)[a], 1e-6);
  }
  EXPECT_NE(message(fmt::format(R"("file": "slices", "series": "9"{})", keys)).find("/bodies/0/file"),
            std::string::npos);
  EXPECT_NE(message(fmt::format(R"("file": "twin.nii", "series": "9"{})", keys)).find("DICOM files only"),
            std::string::npos);
}

TEST_F(ImageVolumes, DensityAndModulusGoByTheIntensity) {
  // Two blocks side by side, of intensities 100 and 300, in nothing.
  const auto write = [&](const char* name, int n) {
    VoxelImage image;
    image.size = Vec3i(3 * n, n, n);
    image.axes = (0.1 / n) * Mat3::Identity();
    image.origin = Vec3::Constant(0.05 / n);
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < 3 * n; ++i) image.values.push_back(i < n ? 0.0f : i < 2 * n ? 100.0f : 300.0f);
    write_nifti((folder_ / name).string(), image);
  };
  write("blocks.nii", 10);
  write("fine.nii", 40);
  const double block = 1e-3, table = block * (1200.0 + 2000.0);  // [m³], [kg]
  const std::string keys =
      R"(, "window": [50, 50], "voxel_size": 0.02, "density": {"table": [[0, 1000], [100, 1200], [300, 2000]]})";
  for (const char* file : {R"("file": "blocks.nii")", R"("file": "fine.nii")"}) {
    SCOPED_TRACE(file);
    const World w = build(file + keys + R"(, "center": false)");
    // Between the blocks the intensity goes over within a voxel, and there is some of the first in what is nothing.
    EXPECT_NEAR(w.body(0).mass(), table, 0.03 * table);
    EXPECT_NEAR(w.q(0)[0], (0.15 * 1200 + 0.25 * 2000) / 3200, 2e-3) << "centre of mass";
    EXPECT_NEAR(build(file + keys + R"(, "motion": "deformable", "lattice_spacing": 0.05)").body(0).mass(), table,
                0.03 * table);
  }
  // A constant is a table of one point; of a segmentation each label has its own.
  const double flat = build(R"("file": "blocks.nii", "window": [50, 50], "density": 700)").body(0).mass();
  EXPECT_NEAR(build(R"("file": "blocks.nii", "window": [50, 50], "density": {"table": [[0, 700]]})").body(0).mass(),
              flat, 2e-3 * flat);
  EXPECT_NEAR(build(R"("file": "blocks.nii", "labels": [300], "density": {"table": [[100, 1200], [300, 2000]]})")
                  .body(0)
                  .mass(),
              2000 * block, 0.06 * 2000 * block);
  EXPECT_GT(build(R"("file": "blocks.nii", "window": [50, 50], "preset": "Hounsfield")").body(0).mass(), 2100 * block);
  const World soft = build(R"("file": "blocks.nii", "window": [50, 50], "voxel_size": 0.02, "motion": "deformable",
                              "lattice_spacing": 0.05, "young_modulus": {"table": [[100, 1e4], [300, 3e4]]})");
  EXPECT_NEAR(soft.body(0).part(0).modulus, 1.5e4, 0.1e4);
}

TEST_F(ImageVolumes, ScaleUnitMassAndOwnPlaceAreHeeded) {
  const World w = build(R"("file": "ball.nii", "window": [0, 100], "unit": 1e-2, "mass": 3, "center": false,
                           "transform": {"scale": 0.5, "position": [0, 0, 2]})");
  EXPECT_NEAR(w.body(0).mass(), 3.0, 1e-12);
  EXPECT_NEAR(w.body(0).bounds(0).extent().x(), 0.2 * 10 * 0.5, 0.15);
  EXPECT_NEAR(w.q(0)[0], 0.05, 0.005);
  EXPECT_NEAR(w.q(0)[2], 2.0, 0.005);
}

TEST_F(ImageVolumes, ADeformableOneHoldsTheSameMatterAndMayBeHeld) {
  const World w = build(R"("file": "ball.nii", "window": [0, 100], "density": 700, "motion": "deformable",
                           "voxel_size": 0.02, "lattice_spacing": 0.06,
                           "constraints": [{"select": {"kind": "plane", "point": [0, 0, -0.05], "normal": [0, 0, 1]}}])");
  EXPECT_EQ(w.body(0).kind(), "image_volume");
  EXPECT_NEAR(w.body(0).mass(), 700.0 * 4.0 / 3.0 * 3.14159265358979 * 1e-3, 0.02 * 2.93);
  EXPECT_GT(w.body(0).v_size(), 30u);
  std::vector<double> v(w.body(0).v_size(), 1.0);
  w.body(0).filter(v);
  EXPECT_GT(std::count(v.begin(), v.end(), 0.0), 0);
}

TEST_F(ImageVolumes, ADeformableOneIsNotFinerThanTheFinestStepOfTheWorld) {
  const auto mass = [](const char* world, const char* voxel) {
    const std::string text = std::string(R"({"brim": 1, "name": "image", "duration": 1, "world": {)") + world +
                             R"(}, "bodies": [{"kind": "image_volume", "name": "scan", "motion": "deformable",
                               "shape": {"kind": "sphere", "radius": 0.1}, "image_spacing": 0.01, "lattice_spacing": 0.08)" +
                             voxel + "}]}";
    const World w = build_world(parse_scene(text, (folder_ / "scene.json").string()));
    return std::pair{w.body(0).part(0).voxel_size, w.body(0).mass()};
  };
  EXPECT_LT(mass("", "").first, 0.01);
  EXPECT_EQ(mass(R"("voxel_size": 0.03)", ""), mass("", R"(, "voxel_size": 0.03)"));
  EXPECT_EQ(mass(R"("voxel_size": 0.03)", R"(, "voxel_size": 0.01)"), mass("", R"(, "voxel_size": 0.03)"));
  EXPECT_EQ(mass(R"("voxel_size": 0.01)", R"(, "voxel_size": 0.03)"), mass("", R"(, "voxel_size": 0.03)"));
}

TEST_F(ImageVolumes, BadInputIsRefusedWithAMessage) {
  const auto expect = [](const std::string& body, const std::vector<std::string>& words) {
    const std::string text = message(body);
    for (const std::string& word : words)
      EXPECT_NE(text.find(word), std::string::npos) << body << ": \"" << text << "\" lacks \"" << word << "\"";
  };
  const std::string good = R"("file": "ball.nii", "window": [0, 100])";
  EXPECT_EQ(message(good), "");
  expect(good + R"(, "density": {"table": []})", {"/bodies/0/density/table"});
  expect(good + R"(, "density": {"table": [[0, 1], [0, 2]]})", {"/bodies/0/density/table/1", "must ascend"});
  expect(good + R"(, "density": {"table": [[0, 1], [1, 0]]})", {"/bodies/0/density/table/1", "must be positive"});
  expect(good + R"(, "density": {"table": [[0, 1]]}, "mass": 2)", {"give one"});
  expect(R"("shape": {"kind": "sphere", "radius": 1}, "image_spacing": 0.1, "density": {"table": [[0, 1]]})",
         {"/bodies/0/density", "intensities for a table"});
  expect(R"("window": [0, 100])", {"/bodies/0", "\"file\" or \"shape\""});
  expect(good + R"(, "shape": {"kind": "sphere", "radius": 1}, "image_spacing": 0.1)", {"give one"});
  expect(R"("file": "ball.nii")", {"\"window\" is missing"});
  expect(R"("file": "ball.nii", "window": [5, 4])", {"/bodies/0/window", "at most the second"});
  expect(R"("file": "gone.nii", "window": [0, 1])", {"/bodies/0/file", "no such file"});
  expect(R"("file": "garbage.nii", "window": [0, 1])", {"/bodies/0/file", "is not a NIfTI-1"});
  expect(R"("file": "short.nrrd", "window": [0, 1])", {"/bodies/0/file", "cut short"});
  expect(R"("file": "zero.nrrd", "window": [0, 1])", {"/bodies/0/file", "voxel steps"});
  expect(R"("file": "ball.nii", "window": [500, 600])", {"/bodies/0/window", "no matter is left", "0 to 100"});
  expect(good + R"(, "voxel_size": 1e-6)", {"/bodies/0/voxel_size", "memory_limit"});
  expect(good + R"(, "density": 5, "mass": 5)", {"/bodies/0/mass", "give one"});
  expect(good + R"(, "density": -5)", {"/bodies/0/density", "above 0"});
  expect(good + R"(, "image_spacing": 0.1)", {"image_spacing", "only \"shape\""});
  expect(R"("shape": {"kind": "sphere", "radius": 1})", {"\"image_spacing\" is missing"});
  expect(R"("shape": {"kind": "sphere", "radius": 1}, "image_spacing": 1e-6)", {"image_spacing", "memory_limit"});
  expect(R"("shape": {"kind": "plane"}, "image_spacing": 0.1)", {"no finite volume"});
  expect(
      R"("file": "ball.raw", "window": [0, 1], "raw": {"size": [25, 25, 26], "spacing": [1, 1, 1], "type": "float32"})",
      {"/bodies/0/file", "62500 bytes", "needs 65000"});
  expect(good + R"(, "raw": {"size": [25, 25, 25], "spacing": [1, 1, 1], "type": "float32"})",
         {"/bodies/0/file", "leave \"raw\" out"});
  expect(
      R"("file": "ball.raw", "window": [0, 1], "raw": {"size": [25, 25, 25], "spacing": [1, 0, 1], "type": "float32"})",
      {"/bodies/0/raw/spacing/1", "above 0"});
  expect(R"("file": "ball.raw", "window": [0, 1])", {"must end in .nii"});
  expect(good + R"(, "lattice_spacing": 0.1)", {"lattice_spacing", "deformable"});
  for (const char* key :
       {R"("young_modulus": 1e5)", R"("young_modulus": {"table": [[0, 1], [9, 2]]})", R"("poisson_ratio": 0.3)",
        R"("law": "corotational")", R"("averaging": 0.5)", R"("stiffness_damping": 0.1)", R"("mass_damping": 0)"})
    expect(good + ", " + key,
           {std::string(key).substr(1, std::string(key).find('"', 1) - 1), "only a deformable volume"});
  EXPECT_EQ(message(good + R"(, "preset": "bone")"), "") << "presets may know more than the body needs";
  const std::string soft = good + R"(, "motion": "deformable")";
  expect(soft, {"\"lattice_spacing\" is missing"});
  expect(soft + R"(, "lattice_spacing": 9)", {"/bodies/0/lattice_spacing", "largest extent"});
  expect(soft + R"(, "lattice_spacing": 1e-4)", {"/bodies/0/lattice_spacing", "memory_limit"});
  expect(soft + R"(, "lattice_spacing": 0.1, "mass": 2)", {"/bodies/0/mass", "\"density\""});
}

TEST_F(ImageVolumes, WhereNoMatterIsLeftTheMessageNamesTheCause) {
  const auto expect = [](const std::string& body, const std::vector<std::string>& words) {
    const std::string text = message(body);
    for (const std::string& word : words) EXPECT_NE(text.find(word), std::string::npos) << text << " lacks " << word;
    return text;
  };
  std::string values;
  for (int i = 0; i < 1000; ++i) values += static_cast<char>(i % 100 < 11 ? 0 : i < 500 ? 3 : 5);
  std::ofstream(folder_ / "organs.nrrd", std::ios::binary)
      << "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 10 10 10\nspacings: 10 10 10\nencoding: raw\n\n"
      << values;
  const std::string organs = R"("file": "organs.nrrd", "labels": )";
  EXPECT_EQ(message(organs + "[3]"), "");
  EXPECT_EQ(message(organs + "[3, 5, 3]"), "");
  expect(organs + "[3, 6, 4, 6]", {"/bodies/0/labels", "no voxel has the labels 6, 4; the image holds 0, 3, 5"});
  expect(organs + "[5, 6]", {"/bodies/0/labels", "no voxel has the label 6; the image holds 0, 3, 5"});
  EXPECT_EQ(expect(organs + "[4, 6]", {"/bodies/0/labels", "labels [4,6]", "the image holds 0, 3, 5"}).find("window"),
            std::string::npos);
  // Voxels in millimetres: shares of such voxels say nothing of the intensities.
  const std::string text = expect(R"("file": "ball.nii", "window": [50, 50], "voxel_size": 2)",
                                  {"/bodies/0/voxel_size", "2 m, are larger than the volume, 0.25 x 0.25 x 0.25 m"});
  EXPECT_EQ(text.find("image holds"), std::string::npos) << text;
  expect(organs + R"([3], "voxel_size": 1)", {"/bodies/0/voxel_size", "larger than the volume"});
  expect(R"("shape": {"kind": "sphere", "radius": 0.1}, "image_spacing": 0.01, "voxel_size": 2)",
         {"/bodies/0/voxel_size", "larger than the volume"});
  expect(R"("file": "ball.nii", "window": [500, 600], "voxel_size": 2)", {"/bodies/0/window", "0 to 100"});
  expect(R"("file": "ball.nii", "window": [500, 600])", {"/bodies/0/window", "[500,600]", "0 to 100"});
}

TEST_F(ImageVolumes, ASeedLiesInTheVolume) {
  const std::string ball = R"("file": "ball.nii", "window": [0, 100], "keep": {"seed": )";
  EXPECT_EQ(message(ball + "[0.01, 0, 0]}"), "");
  EXPECT_EQ(message(ball + R"([0.1, -0.1, 0.1]}, "transform": {"scale": 0.1})"), "") << "lengths are those of the file";
  const std::string text = message(ball + R"([10, 0, 0]}, "transform": {"scale": 3})");
  for (const char* word :
       {"/bodies/0/keep/seed", "[10,0,0] m lies outside", "[-0.125, -0.125, -0.125] to [0.125, 0.125, 0.125] m"})
    EXPECT_NE(text.find(word), std::string::npos) << text;
}

}  // namespace
}  // namespace brim::image_volume_test
