#include "brim/io/urdf_reader.h"

#include <gtest/gtest.h>

#include <fstream>

#include "brim/core/error.h"
#include "io/temporary_folder.h"

namespace brim::urdf_reader_test {
namespace {

const char* const kGood = R"(<?xml version="1.0"?>
<robot name="arm">
  <link name="tip">
    <inertial><origin xyz="0 0 1" rpy="0 0 1.5707963267948966"/><mass value="2"/>
      <inertia ixx="1" iyy="2" izz="3" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="1 2 3"/><geometry><box size="1 2 3"/></geometry></collision>
    <collision><geometry><cylinder radius="0.5" length="2"/></geometry></collision>
  </link>
  <link name="base"/>
  <joint name="hinge" type="revolute">
    <origin xyz="0 0 0.5" rpy="0.1 0.2 0.3"/>
    <parent link="base"/>
    <child link="tip"/>
    <axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" effort="30" velocity="1"/>
    <dynamics damping="0.5" friction="0.25"/>
  </joint>
</robot>
)";

class UrdfReader : public ::testing::Test {
 protected:
  Urdf read(const std::string& text) {
    std::ofstream(folder_.path / "robot.urdf") << text;
    return read_urdf(folder_.path / "robot.urdf");
  }
  std::string message(const std::string& text) {
    try {
      read(text);
      return "";
    } catch (const InputError& e) {
      return e.what();
    }
  }
  static std::string with(const std::string& find, const std::string& replace) {
    std::string text = kGood;
    const auto at = text.find(find);
    EXPECT_NE(at, std::string::npos) << find;
    return text.replace(at, find.size(), replace);
  }
  test::TemporaryFolder folder_;
};

TEST_F(UrdfReader, ATreeComesParentsFirstWithEverythingThatIsRead) {
  const Urdf u = read(kGood);
  ASSERT_EQ(u.pieces.size(), 2u);
  EXPECT_EQ(u.pieces[0].link.name, "base");
  const auto& [link, parent, joint] = u.pieces[1];
  EXPECT_EQ(parent, 0);
  EXPECT_EQ(link.mass, 2.0);
  EXPECT_EQ(link.center_of_mass, Vec3(0, 0, 1));
  EXPECT_LT((link.inertia - Mat3(Vec3(2, 1, 3).asDiagonal())).norm(), 1e-12) << "turned by 90 degrees about z";
  ASSERT_EQ(link.collision.size(), 2u);
  EXPECT_EQ(link.collision[0].size, Vec3(1, 2, 3));
  EXPECT_EQ(link.collision[0].position, Vec3(1, 2, 3));
  EXPECT_EQ(link.collision[1].radius, 0.5);
  EXPECT_EQ(joint.kind, Urdf::Joint::Kind::Revolute);
  EXPECT_EQ(joint.lower, -1.0);
  EXPECT_EQ(joint.upper, 2.0);
  EXPECT_EQ(joint.effort, 30.0);
  EXPECT_EQ(joint.damping, 0.5);
  EXPECT_EQ(joint.friction, 0.25);
  // Roll, then pitch, then yaw, about the fixed axes of the parent.
  const auto turn = [](double a, const Vec3& axis) { return Eigen::AngleAxisd(a, axis).toRotationMatrix(); };
  const Mat3 R = turn(0.3, Vec3::UnitZ()) * turn(0.2, Vec3::UnitY()) * turn(0.1, Vec3::UnitX());
  EXPECT_LT((joint.rotation.toRotationMatrix() - R).norm(), 1e-14);
}

TEST_F(UrdfReader, ContinuousJointsHaveNoLimits) {
  const Urdf u = read(with("type=\"revolute\"", "type=\"continuous\""));
  EXPECT_EQ(u.pieces[1].joint.kind, Urdf::Joint::Kind::Revolute);
  EXPECT_TRUE(std::isinf(u.pieces[1].joint.upper));
}

TEST_F(UrdfReader, MeshesAreFoundBesideTheFileAndByPackage) {
  std::filesystem::create_directories(folder_.path / "my_robot" / "meshes");
  std::ofstream(folder_.path / "my_robot" / "meshes" / "a.obj") << "v 0 0 0\n";
  const std::string box = "<box size=\"1 2 3\"/>";
  for (const char* name : {"my_robot/meshes/a.obj", "package://my_robot/meshes/a.obj"}) {
    const Urdf u = read(with(box, std::string("<mesh filename=\"") + name + "\" scale=\"1 1 2\"/>"));
    EXPECT_EQ(u.pieces[1].link.collision[0].mesh.filename(), "a.obj");
    EXPECT_EQ(u.pieces[1].link.collision[0].scale, Vec3(1, 1, 2));
  }
  EXPECT_NE(message(with(box, "<mesh filename=\"b.obj\"/>")).find("no such mesh"), std::string::npos);
  EXPECT_NE(message(with(box, "<mesh filename=\"package://x/b.obj\"/>")).find("ROS_PACKAGE_PATH"), std::string::npos);
}

TEST_F(UrdfReader, WhatCannotBeReadIsRefusedWithTheLine) {
  struct Case {
    const char *find, *replace, *line, *word;
  };
  for (const Case& c : {
           Case{"<robot name=\"arm\">", "<robot name=\"arm\"", ":", "not valid XML"},
           Case{"<axis", "<mimic joint=\"other\"/><axis", ":14:", "mimics"},
           Case{"type=\"revolute\"", "type=\"floating\"", ":10:", "floating"},
           Case{"type=\"revolute\"", "type=\"planar\"", ":10:", "planar"},
           Case{"xyz=\"0 1 0\"", "xyz=\"0 0 0\"", ":10:", "length zero"},
           Case{"xyz=\"0 1 0\"", "xyz=\"0 1\"", ":14:", "3 numbers"},
           Case{"value=\"2\"", "value=\"two\"", ":4:", "not a number"},
           Case{"value=\"2\"", "value=\"-2\"", ":4:", "below 0"},
           Case{"lower=\"-1\"", "lower=\"3\"", ":15:", "above upper"},
           Case{"child link=\"tip\"", "child link=\"top\"", ":13:", "no link \"top\""},
           Case{"child link=\"tip\"", "child link=\"base\"", ":2:", "ring"},
           Case{"name=\"base\"", "name=\"tip\"", ":9:", "twice"},
           Case{"radius=\"0.5\"", "radius=\"-0.5\"", ":7:", "above 0"},
           Case{"<box size=\"1 2 3\"/>", "<heightmap/>", ":6:", "heightmap"},
           Case{"<link name=\"base\"/>", "<link name=\"base\"/><link name=\"other\"/>",
                ":2:", "2 links have no parent"},
       }) {
    const std::string m = message(with(c.find, c.replace));
    EXPECT_NE(m.find(c.word), std::string::npos) << c.replace << ": " << m;
    EXPECT_NE(m.find(std::string("robot.urdf") + c.line), std::string::npos) << c.replace << ": " << m;
  }
  EXPECT_NE(message("<x/>").find("no <robot>"), std::string::npos);
  EXPECT_THROW(read_urdf(folder_.path / "none.urdf"), InputError);
}

}  // namespace
}  // namespace brim::urdf_reader_test
