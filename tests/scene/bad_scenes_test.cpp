#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "brim/core/error.h"
#include "brim/scene/scene.h"

namespace brim {
namespace {

namespace fs = std::filesystem;

/// A scene that is good, each line of which some mistake below replaces.
const char* const kGood = R"({
  // Two boxes on a floor, a jelly and a cloth.
  "brim": 1,
  "name": "good",
  "world": {"time_step": 0.01, "voxel_size": 0.125},
  "duration": 1.0,
  "materials": {"ice": {"friction": 0.02}, "rubber": {"friction": 1.0}},
  "pairs": [{"materials": ["ice", "rubber"], "friction": 0.1}],
  "bodies": [
    {"kind": "obstacle", "name": "floor", "material": "ice", "shape": {"kind": "plane"}},
    {"kind": "rigid", "name": "box", "shape": {"kind": "box", "size": [1, 1, 1]}, "density": 500,
     "repeat": {"count": [1, 1, 2], "spacing": [1, 1, 1.2]}},
    {"kind": "finite_elements", "name": "jelly", "shape": {"kind": "torus", "radius": 0.5, "tube": 0.2},
     "lattice_spacing": 0.15, "young_modulus": 1e5, "transform": {"position": [3, 0, 1]}},
    {"kind": "cloth", "name": "sheet", "grid": {"size": [1, 1], "cells": [8, 8]},
     "constraints": [{"select": {"kind": "corners", "which": [0, 1]}}], "transform": {"position": [0, 3, 1]}}
  ],
  "expect": [{"metric": "worst_overlap", "max": 0.1}]
}
)";

struct Mistake {
  const char* what;  ///< name of the case
  const char* find;  ///< in the good scene
  const char* replace;
  const char* place;               ///< "line: pointer" in the message
  std::vector<const char*> words;  ///< other things that the message must say
};

std::string spoilt(const Mistake& m) {
  std::string text = kGood;
  const auto at = text.find(m.find);
  EXPECT_NE(at, std::string::npos) << m.what << ": \"" << m.find << "\" is not in the good scene";
  if (at != std::string::npos) text.replace(at, std::string(m.find).size(), m.replace);
  return text;
}

/// A folder with the mesh files that the mistakes name.
class BadScenes : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("brim_bad_scenes_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    write("empty.obj", "");
    write("garbage.obj", "f 1 2 x\nthis is no mesh\n");
    write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    write("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    // The second tetrahedron is inside out.
    write("inverted.msh",
          "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n"
          "$Elements\n2\n1 4 2 0 0 1 2 3 4\n2 4 2 0 0 2 4 3 5\n$EndElements\n");
    write("flat.msh",
          "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n$EndNodes\n"
          "$Elements\n1\n1 4 2 0 0 1 2 3 4\n$EndElements\n");
    write("index.msh",
          "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
          "$Elements\n1\n1 4 2 0 0 1 2 3 9\n$EndElements\n");
    write("short.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n");
    ::unsetenv("BRIM_NO_SUCH_FOLDER");
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  static void write(const char* name, const char* text) { std::ofstream(folder_ / name) << text; }

  /// The message that loading and building a text ends with; "" when it is accepted.
  static std::string message(const std::string& text) {
    try {
      const Scene scene = parse_scene(text, (folder_ / "scene.json").string());
      build_world(scene);
      return "";
    } catch (const InputError& e) {
      return e.what();
    }
  }
  static inline fs::path folder_;
};

const std::vector<Mistake> kMistakes = {
    // Not JSON at all.
    {"EmptyFile", kGood, "", "1: /", {"not valid JSON"}},
    {"OnlyAString", kGood, "\"scene\"", "1: /", {"\"scene\"", "must be an object"}},
    {"MissingComma", "\"name\": \"good\",", "\"name\": \"good\"", "5: /", {"not valid JSON"}},
    {"TextAfterTheEnd", "\"max\": 0.1}]\n}", "\"max\": 0.1}]\n} more", "19: /", {"not valid JSON"}},
    {"NotANumber", "\"duration\": 1.0", "\"duration\": NaN", "6: /", {"NaN and Infinity are not allowed"}},
    {"Infinity", "\"duration\": 1.0", "\"duration\": Infinity", "6: /", {"NaN and Infinity are not allowed"}},
    {"NumberOverflow", "\"duration\": 1.0", "\"duration\": 1e999", "6: /", {"must be finite"}},
    {"KeyTwice", "\"duration\": 1.0", "\"name\": \"again\", \"duration\": 1.0", "6: /name", {"given twice", "line 4"}},
    {"NotUtf8", "\"good\"", "\"\xff\xfe\"", "4: /", {"not valid JSON"}},
    // Against the schema.
    {"UnknownKey", "\"duration\"", "\"durration\"", "6: /durration", {"unknown key", "did you mean \"duration\"?"}},
    {"UnknownWorldKey", "\"time_step\"", "\"timestep\"", "5: /world/timestep", {"did you mean \"time_step\"?"}},
    {"UnknownBodyKey", "\"density\"", "\"densty\"", "11: /bodies/1/densty", {"did you mean \"density\"?"}},
    {"UnknownShapeKey",
     "\"size\": [1, 1, 1]",
     "\"sizes\": [1, 1, 1]",
     "11: /bodies/1/shape/sizes",
     {"did you mean \"size\"?"}},
    {"VersionMissing", "\"brim\": 1,", "", "1: /", {"\"brim\" is missing", "1"}},
    {"VersionUnknown", "\"brim\": 1", "\"brim\": 7", "3: /brim", {"7", "must be 1"}},
    {"NameMissing", "\"name\": \"good\",", "", "1: /", {"\"name\" is missing"}},
    {"NameEmpty", "\"name\": \"good\"", "\"name\": \"\"", "4: /name", {"at least 1"}},
    {"NameIsAPath", "\"name\": \"good\"", "\"name\": \"../good\"", "4: /name", {"\"../good\"", "must have no /"}},
    {"NameNoString", "\"name\": \"good\"", "\"name\": 5", "4: /name", {"5", "must be a string"}},
    {"TimeStepZero", "\"time_step\": 0.01", "\"time_step\": 0", "5: /world/time_step", {"above 0"}},
    {"TimeStepNegative", "\"time_step\": 0.01", "\"time_step\": -0.01", "5: /world/time_step", {"-0.01", "above 0"}},
    {"TimeStepText", "\"time_step\": 0.01", "\"time_step\": \"fast\"", "5: /world/time_step", {"\"fast\"", "a number"}},
    {"VoxelSizeNegative", "\"voxel_size\": 0.125", "\"voxel_size\": -1", "5: /world/voxel_size", {"from 0"}},
    {"StiffnessWord",
     "\"time_step\": 0.01",
     "\"stiffness\": \"hard\"",
     "5: /world/stiffness",
     {"\"auto\"", "a number above 0"}},
    {"StiffnessNegative", "\"time_step\": 0.01", "\"stiffness\": -5", "5: /world/stiffness", {"a number above 0"}},
    {"SubstepsNotWhole", "\"time_step\": 0.01", "\"max_substeps\": 2.5", "5: /world/max_substeps", {"a whole number"}},
    {"SubstepsContradict",
     "\"time_step\": 0.01",
     "\"max_substeps\": 2, \"min_substeps\": 3",
     "5: /world/min_substeps",
     {"at most max_substeps, 2"}},
    {"GravityTwoNumbers",
     "\"time_step\": 0.01",
     "\"gravity\": [0, -9.81]",
     "5: /world/gravity",
     {"list of 2", "exactly 3"}},
    {"ToleranceTooLoose", "\"time_step\": 0.01", "\"cg_tolerance\": 2", "5: /world/cg_tolerance", {"0.1"}},
    {"DurationZero", "\"duration\": 1.0", "\"duration\": 0", "6: /duration", {"above 0"}},
    {"DurationBelowAFrame", "\"duration\": 1.0", "\"duration\": 1e-9", "6: /duration", {"0.01 s"}},
    {"DurationAndFrames", "\"duration\": 1.0", "\"duration\": 1.0, \"frames\": 5", "1: /", {"both"}},
    {"NoDuration", "\"duration\": 1.0,", "", "1: /", {"\"frames\"", "\"duration\""}},
    {"BodiesMissing", "\"bodies\": [", "\"bodys\": [", "9: /bodys", {"did you mean \"bodies\"?"}},
    {"KindUnknown",
     "\"kind\": \"rigid\"",
     "\"kind\": \"rigit\"",
     "11: /bodies/1/kind",
     {"\"rigit\"", "did you mean \"rigid\"?", "\"cloth\""}},
    {"BodyIsNull",
     "{\"kind\": \"obstacle\", \"name\": \"floor\", \"material\": \"ice\", \"shape\": {\"kind\": \"plane\"}}",
     "null",
     "10: /bodies/0",
     {"null is not allowed; must be an object with \"kind\""}},
    {"BodyIsAWord",
     "{\"kind\": \"obstacle\", \"name\": \"floor\", \"material\": \"ice\", \"shape\": {\"kind\": \"plane\"}}",
     "\"floor\"",
     "10: /bodies/0",
     {"\"floor\" is not allowed; must be an object with \"kind\""}},
    {"BodyIsAList", "\"bodies\": [", "\"bodies\": [[], ", "9: /bodies/0", {"a list of 0", "an object with \"kind\""}},
    {"KindInCapitals",
     "\"kind\": \"rigid\"",
     "\"kind\": \"Rigid\"",
     "11: /bodies/1/kind",
     {"\"Rigid\"", "did you mean \"rigid\"?"}},
    {"ExpectIsAnObject",
     "[{\"metric\": \"worst_overlap\", \"max\": 0.1}]",
     "{\"metric\": \"worst_overlap\"}",
     "18: /expect",
     {"an object", "must be a list"}},
    {"ExpectBoundIsText", "\"max\": 0.1", "\"max\": \"0.1\"", "18: /expect/0/max", {"\"0.1\"", "must be a number"}},
    {"VelocityAbsurd",
     "\"density\": 500",
     "\"density\": 500, \"velocity\": [0, 0, -1e9]",
     "11: /bodies/1/velocity",
     {"-1e+09 m/s", "to 100000"}},
    {"SpinAbsurd",
     "\"density\": 500",
     "\"density\": 500, \"angular_velocity\": [0, 0, 1e6]",
     "11: /bodies/1/angular_velocity",
     {"1e+06 rad/s", "to 100000"}},
    {"UnitsInANumber",
     "\"density\": 500",
     "\"density\": \"500 kg/m3\"",
     "11: /bodies/1/density",
     {"\"500 kg/m3\"", "a number above 0"}},
    {"UnitsInAPosition",
     "[3, 0, 1]",
     "[\"3m\", 0, 1]",
     "14: /bodies/2/transform/position/0",
     {"\"3m\"", "must be a number"}},
    {"ScaleZero",
     "{\"position\": [3, 0, 1]}",
     "{\"scale\": 0}",
     "14: /bodies/2/transform/scale",
     {"0 is not", "above 0"}},
    {"ScaleOfAxes",
     "{\"position\": [3, 0, 1]}",
     "{\"scale\": [1, 1, 2]}",
     "14: /bodies/2/transform/scale",
     {"a list of 3", "a number above 0"}},
    {"QuaternionOfLengthZero",
     "{\"position\": [3, 0, 1]}",
     "{\"rotation\": {\"quaternion\": [0, 0, 0, 0]}}",
     "14: /bodies/2/transform/rotation/quaternion",
     {"[0,0,0,0]", "of some length"}},
    {"SeedNegative",
     "\"spacing\": [1, 1, 1.2]",
     "\"spacing\": [1, 1, 1.2], \"seed\": -1",
     "12: /bodies/1/repeat/seed",
     {"-1", "from 0"}},
    {"FrictionIsAWord",
     "\"friction\": 0.02",
     "\"friction\": \"slippery\"",
     "7: /materials/ice/friction",
     {"\"slippery\"", "a number"}},
    {"FrictionIsTrue", "\"friction\": 0.02", "\"friction\": true", "7: /materials/ice/friction", {"true", "a number"}},
    {"MaterialInPlace",
     "\"material\": \"ice\"",
     "\"material\": {\"friction\": 1}",
     "10: /bodies/0/material",
     {"an object", "a string"}},
    {"PairOfOne", "[\"ice\", \"rubber\"]", "[\"ice\"]", "8: /pairs/0/materials", {"a list of 1", "exactly 2 entries"}},
    {"ResponseOfTheWorldUnknown",
     "\"time_step\": 0.01",
     "\"response\": \"glue\"",
     "5: /world/response",
     {"\"glue\"", "\"penalty\" or \"constraint\""}},
    {"GravityIsAWord",
     "\"time_step\": 0.01",
     "\"gravity\": \"earth\"",
     "5: /world/gravity",
     {"\"earth\"", "3 numbers"}},
    {"VersionIsText", "\"brim\": 1", "\"brim\": \"1\"", "3: /brim", {"\"1\"", "must be 1"}},
    {"FramesWithoutEnd", "\"duration\": 1.0", "\"frames\": 1e30", "6: /frames", {"1e+30", "to 10000000"}},
    {"GridWithoutCells",
     "\"cells\": [8, 8]",
     "\"cells\": [0, 8]",
     "15: /bodies/3/grid/cells/0",
     {"0 is not", "from 1"}},
    {"KindMissing", "\"kind\": \"rigid\", ", "", "11: /bodies/1", {"\"kind\" is missing", "\"rigid\""}},
    {"ShapeUnknown", "\"kind\": \"box\"", "\"kind\": \"cube\"", "11: /bodies/1/shape/kind", {"\"cube\"", "\"box\""}},
    {"ShapeMissing",
     "\"shape\": {\"kind\": \"plane\"}",
     "\"velocity\": [0, 0, 0]",
     "10: /bodies/0",
     {"\"shape\" is missing"}},
    {"SizeZero", "\"size\": [1, 1, 1]", "\"size\": [1, 0, 1]", "11: /bodies/1/shape/size/1", {"above 0"}},
    {"SizeMissing",
     "\"kind\": \"box\", \"size\": [1, 1, 1]",
     "\"kind\": \"box\"",
     "11: /bodies/1/shape",
     {"\"size\" is missing"}},
    {"FrictionNegative", "\"friction\": 0.02", "\"friction\": -0.1", "7: /materials/ice/friction", {"from 0"}},
    {"PoissonTooLarge",
     "\"young_modulus\": 1e5",
     "\"poisson_ratio\": 0.5",
     "14: /bodies/2/poisson_ratio",
     {"below 0.5"}},
    {"YoungZero", "\"young_modulus\": 1e5", "\"young_modulus\": 0", "14: /bodies/2/young_modulus", {"above 0"}},
    {"DensityNegative", "\"density\": 500", "\"density\": -500", "11: /bodies/1/density", {"above 0"}},
    {"CountZero", "\"count\": [1, 1, 2]", "\"count\": [1, 1, 0]", "12: /bodies/1/repeat/count/2", {"from 1"}},
    // What the schema cannot say.
    {"NegativeMass", "\"density\": 500", "\"mass\": -1", "11: /bodies/1/mass", {"above 0"}},
    {"MassAndDensity", "\"density\": 500", "\"density\": 500, \"mass\": 3", "11: /bodies/1/mass", {"give one"}},
    {"RigidPlane",
     "\"kind\": \"box\", \"size\": [1, 1, 1]",
     "\"kind\": \"plane\"",
     "11: /bodies/1/shape/kind",
     {"obstacle"}},
    {"NameTaken", "\"name\": \"jelly\"", "\"name\": \"floor\"", "13: /bodies/2/name", {"\"floor\"", "unique"}},
    {"NameTakenByACopy", "\"name\": \"jelly\"", "\"name\": \"box.1\"", "13: /bodies/2/name", {"\"box.1\"", "unique"}},
    {"MaterialUnknown",
     "\"material\": \"ice\"",
     "\"material\": \"icy\"",
     "10: /bodies/0/material",
     {"\"icy\"", "ice", "rubber", "did you mean"}},
    {"PairUnknown",
     "[\"ice\", \"rubber\"]",
     "[\"ice\", \"ruber\"]",
     "8: /pairs/0/materials/1",
     {"did you mean \"rubber\"?"}},
    {"PairTwice",
     "\"friction\": 0.1}]",
     "\"friction\": 0.1}, {\"materials\": [\"rubber\", \"ice\"], \"friction\": 1}]",
     "8: /pairs/1",
     {"given twice"}},
    {"PairSaysNothing",
     "\"rubber\"], \"friction\": 0.1",
     "\"rubber\"]",
     "8: /pairs/0",
     {"says nothing", "\"response\""}},
    {"ResponseUnknown",
     "\"time_step\": 0.01",
     "\"response\": \"constraints\"",
     "5: /world/response",
     {"\"penalty\"", "\"constraint\""}},
    {"ResponseOfABodyUnknown", "\"density\": 500", "\"response\": 1", "11: /bodies/1/response", {"one of"}},
    {"RestitutionTooLarge",
     "\"friction\": 0.02",
     "\"restitution\": 1.5",
     "7: /materials/ice/restitution",
     {"from 0 to 1"}},
    {"TooManyBodies", "\"count\": [1, 1, 2]", "\"count\": [1000, 1000, 1000]", "11: /bodies/1", {"at most 1000000"}},
    {"AxisOfLengthZero",
     "\"position\": [3, 0, 1]",
     "\"rotation\": {\"axis\": [0, 0, 0], \"degrees\": 5}",
     "14: /bodies/2/transform/rotation/axis",
     {"direction"}},
    {"RotationOfNoKind",
     "\"position\": [3, 0, 1]",
     "\"rotation\": {\"angle\": 5}",
     "14: /bodies/2/transform/rotation",
     {"\"axis\"", "\"quaternion\"", "\"euler_degrees\""}},
    {"TubeThickerThanTorus", "\"tube\": 0.2", "\"tube\": 0.6", "13: /bodies/2/shape/tube", {"below \"radius\", 0.5"}},
    {"LatticeMissing", "\"lattice_spacing\": 0.15, ", "", "13: /bodies/2", {"\"lattice_spacing\" is missing"}},
    {"LatticeAbsurd",
     "\"lattice_spacing\": 0.15",
     "\"lattice_spacing\": 1e-5",
     "14: /bodies/2/lattice_spacing",
     {"memory_limit"}},
    {"LatticeTooCoarse",
     "\"lattice_spacing\": 0.15",
     "\"lattice_spacing\": 50",
     "14: /bodies/2/lattice_spacing",
     {"extent"}},
    {"VoxelAbsurd", "\"density\": 500", "\"voxel_size\": 1e-7", "11: /bodies/1/voxel_size", {"memory_limit"}},
    {"GridAbsurd", "\"cells\": [8, 8]", "\"cells\": [4000, 4000]", "15: /bodies/3/grid/cells", {"memory_limit"}},
    {"GridMissing", "\"grid\": {\"size\": [1, 1], \"cells\": [8, 8]},", "", "15: /bodies/3", {"\"grid\"", "\"mesh\""}},
    {"CornersOfAMesh",
     "\"grid\": {\"size\": [1, 1], \"cells\": [8, 8]}",
     "\"mesh\": \"open.obj\"",
     "16: /bodies/3/constraints/0/select",
     {"grid"}},
    {"NothingSelected",
     "{\"kind\": \"corners\", \"which\": [0, 1]}",
     "{\"kind\": \"sphere\", \"center\": [99, 0, 0], \"radius\": 1}",
     "16: /bodies/3/constraints/0/select",
     {"no point"}},
    {"KeyframesOutOfOrder",
     "\"material\": \"ice\", ",
     "\"keyframes\": [{\"time\": 1}, {\"time\": 1}], ",
     "10: /bodies/0/keyframes/1/time",
     {"increase"}},
    {"KeyframesAndVelocity",
     "\"material\": \"ice\", ",
     "\"velocity\": [1, 0, 0], \"keyframes\": [{\"time\": 0}, {\"time\": 1}], ",
     "10: /bodies/0/velocity",
     {"keyframes"}},
    {"MetricUnknown",
     "\"worst_overlap\"",
     "\"worst_overlp\"",
     "18: /expect/0/metric",
     {"did you mean \"worst_overlap\"?"}},
    {"NoBound", ", \"max\": 0.1", "", "18: /expect/0", {"\"min\"", "\"max\""}},
    {"LeakOfNothing", "\"worst_overlap\"", "\"leak\"", "18: /expect/0", {"leak", "\"body\" must name it"}},
    {"OfWithoutNeed", "\"max\": 0.1", "\"max\": 0.1, \"of\": \"box\"", "18: /expect/0", {"\"of\" must not be given"}},
    {"EmptyKnownMiss",
     "\"max\": 0.1",
     "\"max\": 0.1, \"known_miss\": \"\"",
     "18: /expect/0/known_miss",
     {"at least 1"}},
    {"WorstAlone", "\"max\": 0.1", "\"max\": 0.1, \"known_worst\": 1", "18: /expect/0/known_worst", {"known_miss"}},
    {"WorstWithin",
     "\"max\": 0.1",
     "\"max\": 0.1, \"known_miss\": \"x\", \"known_worst\": 0.05",
     "18: /expect/0/known_worst",
     {"outside"}},
    {"BoundsCrossed", "\"max\": 0.1", "\"max\": 0.1, \"min\": 0.2", "18: /expect/0/min", {"at most \"max\""}},
    {"ExpectUnknownBody",
     "\"max\": 0.1",
     "\"max\": 0.1, \"body\": \"boxx\"",
     "18: /expect/0/body",
     {"did you mean \"box\"?"}},
    {"WindowBackwards",
     "\"max\": 0.1",
     "\"max\": 0.1, \"from\": 0.5, \"to\": 0.2",
     "18: /expect/0/to",
     {"at least 0.5"}},
    {"WindowAfterTheEnd", "\"max\": 0.1", "\"max\": 0.1, \"from\": 3", "18: /expect/0/from", {"at most 1"}},
    // Files.
    {"MeshMissing",
     "\"kind\": \"box\", \"size\": [1, 1, 1]",
     "\"kind\": \"mesh\", \"file\": \"none.obj\"",
     "11: /bodies/1/shape/file",
     {"no such file"}},
    {"MeshEmpty",
     "\"kind\": \"box\", \"size\": [1, 1, 1]",
     "\"kind\": \"mesh\", \"file\": \"empty.obj\"",
     "11: /bodies/1/shape/file",
     {"empty.obj"}},
    {"MeshGarbage",
     "\"kind\": \"box\", \"size\": [1, 1, 1]",
     "\"kind\": \"mesh\", \"file\": \"garbage.obj\"",
     "11: /bodies/1/shape/file",
     {"garbage.obj"}},
    {"MeshWithoutTriangles",
     "\"kind\": \"box\", \"size\": [1, 1, 1]",
     "\"kind\": \"mesh\", \"file\": \"points.obj\"",
     "11: /bodies/1/shape/file",
     {"points.obj"}},
    {"MeshDegenerate",
     "\"kind\": \"box\", \"size\": [1, 1, 1]",
     "\"kind\": \"mesh\", \"file\": \"flat.obj\"",
     "11: /bodies/1/shape/file",
     {"flat.obj"}},
    {"MeshNotANumber",
     "\"kind\": \"box\", \"size\": [1, 1, 1]",
     "\"kind\": \"mesh\", \"file\": \"nan.obj\"",
     "11: /bodies/1/shape/file",
     {"nan.obj"}},
    {"MeshOpen",
     "\"kind\": \"box\", \"size\": [1, 1, 1]",
     "\"kind\": \"mesh\", \"file\": \"open.obj\"",
     "11: /bodies/1/shape/file",
     {"closed", "winding_number", "thickness"}},
    {"MeshIsAFolder",
     "{\"kind\": \"box\", \"size\": [1, 1, 1]}",
     "{\"kind\": \"mesh\", \"file\": \".\"}",
     "11: /bodies/1/shape/file",
     {"not a file"}},
    {"TetsFlat",
     "\"shape\": {\"kind\": \"torus\", \"radius\": 0.5, \"tube\": 0.2},\n     \"lattice_spacing\": 0.15",
     "\"tet_mesh\": \"flat.msh\"",
     "13: /bodies/2/tet_mesh",
     {"flat.msh", "1 of 1 tetrahedra are flat"}},
    {"TetsOfNoNode",
     "\"shape\": {\"kind\": \"torus\", \"radius\": 0.5, \"tube\": 0.2},\n     \"lattice_spacing\": 0.15",
     "\"tet_mesh\": \"index.msh\"",
     "13: /bodies/2/tet_mesh",
     {"index.msh", "node 9"}},
    {"MeshUnknownFormat",
     "\"kind\": \"box\", \"size\": [1, 1, 1]",
     "\"kind\": \"mesh\", \"file\": \"scene.txt\"",
     "11: /bodies/1/shape/file",
     {"scene.txt"}},
    {"VariableUnset",
     "\"kind\": \"box\", \"size\": [1, 1, 1]",
     "\"kind\": \"mesh\", \"file\": \"${BRIM_NO_SUCH_FOLDER}/a.obj\"",
     "11: /bodies/1/shape/file",
     {"BRIM_NO_SUCH_FOLDER is not set"}},
    {"ThicknessMissing",
     "\"kind\": \"box\", \"size\": [1, 1, 1]",
     "\"kind\": \"mesh\", \"file\": \"open.obj\", \"treatment\": \"thickness\"",
     "11: /bodies/1/shape",
     {"\"thickness\" is missing"}},
    {"TreatmentUnknown",
     "\"kind\": \"box\", \"size\": [1, 1, 1]",
     "\"kind\": \"mesh\", \"file\": \"open.obj\", \"treatment\": \"close\"",
     "11: /bodies/1/shape/treatment",
     {"did you mean \"closed\"?"}},
    {"TetsInverted",
     "\"shape\": {\"kind\": \"torus\", \"radius\": 0.5, \"tube\": 0.2},\n     \"lattice_spacing\": 0.15,",
     "\"tet_mesh\": \"inverted.msh\",",
     "13: /bodies/2/tet_mesh",
     {"inverted.msh"}},
    {"TetsCutShort",
     "\"shape\": {\"kind\": \"torus\", \"radius\": 0.5, \"tube\": 0.2},\n     \"lattice_spacing\": 0.15,",
     "\"tet_mesh\": \"short.msh\",",
     "13: /bodies/2/tet_mesh",
     {"short.msh"}},
    {"TetsAndShape",
     "\"lattice_spacing\": 0.15",
     "\"tet_mesh\": \"inverted.msh\"",
     "14: /bodies/2/tet_mesh",
     {"give one"}},
};

TEST_F(BadScenes, TheGoodSceneIsAccepted) { EXPECT_EQ(message(kGood), ""); }

TEST_F(BadScenes, EveryMistakeGetsOneMessageWithFilePlaceValueAndWhatIsAllowed) {
  ASSERT_GE(kMistakes.size(), 100u);
  for (const Mistake& m : kMistakes) {
    const std::string text = message(spoilt(m));
    SCOPED_TRACE(std::string(m.what) + ": " + text);
    EXPECT_TRUE(text.starts_with((folder_ / "scene.json").string() + ":" + m.place)) << "expected place " << m.place;
    for (const char* word : m.words) EXPECT_NE(text.find(word), std::string::npos) << "expected the words: " << word;
    EXPECT_EQ(text.find('\n'), std::string::npos) << "one line";
  }
}

TEST_F(BadScenes, MissingFilesAndFoldersAreNamed) {
  const auto load = [](const std::string& path) {
    try {
      load_scene(path);
      return std::string();
    } catch (const InputError& e) {
      return std::string(e.what());
    }
  };
  EXPECT_NE(load((folder_ / "nothing.json").string()).find("no such file"), std::string::npos);
  EXPECT_NE(load(folder_.string()).find("is a folder"), std::string::npos);
}

TEST_F(BadScenes, DeepNestingIsRefusedAndDoesNotCrash) {
  EXPECT_NE(message(std::string(100000, '[')).find("nested deeper"), std::string::npos);
}

}  // namespace
}  // namespace brim
