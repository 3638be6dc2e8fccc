// Joints and links of articulated bodies, as Python reads and drives them.
#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"
#include "brim/body/articulated/articulated_body.h"
#include "session.h"

namespace brim::python {

namespace {

const ArticulatedBody& tree_of(Session& s, int b) {
  const Body& body = s.world().body(b);
  const auto* tree = dynamic_cast<const ArticulatedBody*>(&body);
  if (tree == nullptr) throw InputError(fmt::format("'{}' ({}) has no joints", body.name(), body.kind()));
  return *tree;
}

const char* word_of(JointKind kind) {
  switch (kind) {
    case JointKind::Revolute:
      return "revolute";
    case JointKind::Prismatic:
      return "prismatic";
    case JointKind::Ball:
      return "ball";
    case JointKind::Free:
      return "free";
    default:
      return "fixed";
  }
}

/// Of every joint that moves: name, kind, first coordinate and their number, the same of velocities, lower, upper,
/// number of its drive or −1, its stiffness and damping.
py::list joint_table(Session& s, int b) {
  const ArticulatedBody& body = tree_of(s, b);
  py::list out;
  int drive = 0;
  const int drives = static_cast<int>(body.drive_names().size());
  for (int i = 0; i < static_cast<int>(body.tree().size()); ++i) {
    const Tree::Link& l = body.tree().links()[static_cast<std::size_t>(i)];
    if (l.dof == 0) continue;
    const auto [lower, upper] = body.joint_range(i);
    const bool driven = drive < drives && body.driven_link(static_cast<std::size_t>(drive)) == i;
    const int nq = l.dof == 1 ? 1 : l.dof + 1;
    const JointDrive& gains = body.drive(i);
    out.append(py::make_tuple(body.joint_names()[static_cast<std::size_t>(i)], word_of(l.kind), l.q0, nq, l.v0, l.dof,
                              l.kind == JointKind::Ball ? -upper : lower, upper, driven ? drive++ : -1, gains.stiffness,
                              gains.damping));
  }
  return out;
}

/// Numbers of an array, one a drive, where they lie.
DoubleArray one_each(const py::object& given, const char* what, std::span<const std::string> names) {
  DoubleArray a = DoubleArray::ensure(given);
  if (!a) {
    PyErr_Clear();
    throw InputError(fmt::format("{}: must be an array of numbers, shape ({},)", what, names.size()));
  }
  if (a.ndim() == 1 && static_cast<std::size_t>(a.size()) == names.size()) return a;
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "\"" : ", \"") + name + "\"";
  throw InputError(fmt::format("{}: shape {} is not allowed; must be ({},), one for each driven joint: {}", what,
                               shape_text(a), names.size(), all));
}

std::span<const double> numbers_in(const DoubleArray& a) { return {a.data(), static_cast<std::size_t>(a.size())}; }

void aim_drives(Session& s, int b, const py::object& positions, const py::object& velocities) {
  const std::span<const std::string> names = s.world().drives(b);
  const DoubleArray position = one_each(positions, "positions", names);
  if (velocities.is_none()) return s.aim_drives(b, 0, numbers_in(position), {});
  const DoubleArray velocity = one_each(velocities, "velocities", names);
  s.aim_drives(b, 0, numbers_in(position), numbers_in(velocity));
}

py::array drive_efforts(Session& s, int b) {
  const ArticulatedBody& body = tree_of(s, b);
  const World& world = s.world();
  py::array_t<double> out(static_cast<py::ssize_t>(body.drive_names().size()));
  for (std::size_t d = 0; d < body.drive_names().size(); ++d)
    out.mutable_data()[d] = body.drive_effort(d, world.state().time, world.q(b), world.v(b));
  return out;
}

/// Origin, rotation (quaternion w x y z), centre of mass, velocities of origin and centre, angular velocity.
py::tuple link_state(Session& s, int b, int link) {
  const ArticulatedBody& body = tree_of(s, b);
  const TreePose::Link& pose = body.pose().link.at(static_cast<std::size_t>(link));
  const Vec6 twist = body.link_twist(link, s.world().v(b));
  const Quat r(pose.rotation);
  const std::array<double, 4> quaternion = {r.w(), r.x(), r.y(), r.z()};
  return py::make_tuple(array_of(pose.origin), array_of(std::span<const double>(quaternion)),
                        array_of(Vec3(pose.origin + pose.center)), array_of(Vec3(twist.head<3>())),
                        array_of(Vec3(moved_twist(twist, pose.center).head<3>())), array_of(Vec3(twist.tail<3>())));
}

py::array link_jacobian(Session& s, int b, int link, const std::array<double, 3>& point) {
  const ArticulatedBody& body = tree_of(s, b);
  const Mat3& R = body.pose().link.at(static_cast<std::size_t>(link)).rotation;
  const auto J = body.tree().jacobian(body.pose(), link, R * Vec3(point[0], point[1], point[2]));
  py::array_t<double> out({py::ssize_t{6}, static_cast<py::ssize_t>(J.cols())});
  Eigen::Map<Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>>(out.mutable_data(), 6, J.cols()) = J;
  return out;
}

}  // namespace

void bind_articulated(py::module_& m) {
  auto session = py::reinterpret_borrow<py::class_<Session>>(m.attr("Session"));
  session
      .def("link_names",
           [](Session& s, int b) {
             const auto names = tree_of(s, b).link_names();
             return std::vector<std::string>(names.begin(), names.end());
           })
      .def("joint_table", &joint_table)
      .def("aim_drive",
           [](Session& s, int b, int drive, double position, double velocity) {
             s.aim_drives(b, drive, {&position, 1}, {&velocity, 1});
           })
      .def("aim_drives", &aim_drives, py::arg("body"), py::arg("positions"), py::arg("velocities") = py::none())
      .def("drive_efforts", &drive_efforts)
      .def("link_state", &link_state)
      .def("link_jacobian", &link_jacobian);
}

}  // namespace brim::python
