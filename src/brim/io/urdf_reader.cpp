#include "brim/io/urdf_reader.h"

#include <tinyxml2.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>

#include "brim/core/error.h"
#include "brim/io/regular_file.h"

namespace brim {

namespace {

namespace fs = std::filesystem;
using Element = tinyxml2::XMLElement;

/// Reads elements and says where they are when they cannot be read.
class Reader {
 public:
  explicit Reader(const fs::path& file) : file_(file) {}

  InputError error(int line, const std::string& what) const {
    return InputError(fmt::format("{}:{}: {}", file_.string(), line, what));
  }
  InputError error(const Element& e, const std::string& what) const { return error(e.GetLineNum(), what); }

  std::string text(const Element& e, const char* key) const {
    const char* value = e.Attribute(key);
    if (!value || !*value) throw error(e, fmt::format("<{}> has no \"{}\"", e.Name(), key));
    return value;
  }
  const Element& child(const Element& e, const char* name) const {
    const Element* c = e.FirstChildElement(name);
    if (!c) throw error(e, fmt::format("<{}> has no <{}>", e.Name(), name));
    return *c;
  }
  double number(const Element& e, const char* key) const { return numbers(e, key, text(e, key), 1)[0]; }
  double number(const Element& e, const char* key, double otherwise) const {
    return e.Attribute(key) ? number(e, key) : otherwise;
  }
  Vec3 vector(const Element& e, const char* key, const Vec3& otherwise) const {
    if (!e.Attribute(key)) return otherwise;
    const auto x = numbers(e, key, e.Attribute(key), 3);
    return {x[0], x[1], x[2]};
  }
  void origin(const Element& of, Vec3& position, Quat& rotation) const {
    const Element* e = of.FirstChildElement("origin");
    if (!e) return;
    position = vector(*e, "xyz", Vec3::Zero());
    const Vec3 rpy = vector(*e, "rpy", Vec3::Zero());
    rotation = Eigen::AngleAxisd(rpy.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vec3::UnitY()) *
               Eigen::AngleAxisd(rpy.x(), Vec3::UnitX());
  }

  Urdf::Link link(const Element& e) const;
  Urdf::Joint joint(const Element& e) const;

 private:
  std::vector<double> numbers(const Element& e, const char* key, const std::string& value, std::size_t count) const {
    std::istringstream in(value);
    std::vector<double> x;
    for (double d; in >> d;) x.push_back(d);
    bool good = x.size() == count && in.eof();
    for (const double d : x) good = good && std::isfinite(d);
    if (!good)
      throw error(e, fmt::format("<{}> {}=\"{}\" is not {}", e.Name(), key, value,
                                 count == 1 ? "a number" : fmt::format("{} numbers", count)));
    return x;
  }
  Urdf::Geometry geometry(const Element& collision) const;
  fs::path find_mesh(const Element& e, const std::string& uri) const;

  fs::path file_;
};

fs::path Reader::find_mesh(const Element& e, const std::string& uri) const {
  const std::string package = "package://";
  std::error_code ignored;
  if (!uri.starts_with(package)) {
    fs::path path = uri.starts_with("file://") ? uri.substr(7) : uri;
    if (path.is_relative()) path = file_.parent_path() / path;
    if (fs::exists(path, ignored)) return path;
    throw error(e, fmt::format("no such mesh: {}", path.string()));
  }
  const fs::path rest = uri.substr(package.size());  // name/...
  fs::path folder = fs::absolute(file_).lexically_normal().parent_path();
  while (true) {
    if (fs::exists(folder / rest, ignored)) return folder / rest;
    if (folder == folder.parent_path()) break;
    folder = folder.parent_path();
  }
  if (const char* roots = std::getenv("ROS_PACKAGE_PATH")) {
    std::istringstream in(roots);
    for (std::string root; std::getline(in, root, ':');)
      if (fs::exists(fs::path(root) / rest, ignored)) return fs::path(root) / rest;
  }
  throw error(e, fmt::format("no such mesh: {}; looked for {} in the folders above the file and in those of "
                             "ROS_PACKAGE_PATH",
                             uri, rest.string()));
}

Urdf::Geometry Reader::geometry(const Element& collision) const {
  using Kind = Urdf::Geometry::Kind;
  Urdf::Geometry g;
  g.line = collision.GetLineNum();
  origin(collision, g.position, g.rotation);
  const Element& outer = child(collision, "geometry");
  const Element* e = outer.FirstChildElement();
  if (!e) throw error(outer, "<geometry> is empty; give <box>, <cylinder>, <sphere> or <mesh>");
  const std::string name = e->Name();
  if (name == "box") {
    text(*e, "size");
    g.size = vector(*e, "size", Vec3::Zero());
  } else if (name == "cylinder" || name == "sphere") {
    g.kind = name == "sphere" ? Kind::Sphere : Kind::Cylinder;
    g.radius = number(*e, "radius");
    if (name == "cylinder") g.length = number(*e, "length");
  } else if (name == "mesh") {
    g.kind = Kind::Mesh;
    g.mesh = find_mesh(*e, text(*e, "filename"));
    g.scale = vector(*e, "scale", Vec3::Ones());
  } else {
    throw error(*e,
                fmt::format("<{}> is no geometry that can be read; give <box>, <cylinder>, <sphere> or <mesh>", name));
  }
  const bool good = g.kind == Kind::Box        ? g.size.minCoeff() > 0.0
                    : g.kind == Kind::Cylinder ? g.radius > 0.0 && g.length > 0.0
                    : g.kind == Kind::Sphere   ? g.radius > 0.0
                                               : g.scale.minCoeff() > 0.0;
  if (!good) throw error(*e, fmt::format("<{}>: sizes and scales must be above 0", name));
  return g;
}

Urdf::Link Reader::link(const Element& e) const {
  Urdf::Link l;
  l.name = text(e, "name");
  l.line = e.GetLineNum();
  if (const Element* inertial = e.FirstChildElement("inertial")) {
    Quat rotation = Quat::Identity();
    origin(*inertial, l.center_of_mass, rotation);
    l.mass = number(child(*inertial, "mass"), "value");
    if (l.mass < 0.0) throw error(*inertial, fmt::format("mass {} is below 0", l.mass));
    if (const Element* i = inertial->FirstChildElement("inertia")) {
      const double xy = number(*i, "ixy", 0), xz = number(*i, "ixz", 0), yz = number(*i, "iyz", 0);
      Mat3 m;
      m << number(*i, "ixx"), xy, xz, xy, number(*i, "iyy"), yz, xz, yz, number(*i, "izz");
      l.inertia = rotation.toRotationMatrix() * m * rotation.toRotationMatrix().transpose();
    }
  }
  for (const Element* c = e.FirstChildElement("collision"); c; c = c->NextSiblingElement("collision"))
    l.collision.push_back(geometry(*c));
  return l;
}

Urdf::Joint Reader::joint(const Element& e) const {
  using Kind = Urdf::Joint::Kind;
  Urdf::Joint j;
  j.name = text(e, "name");
  j.line = e.GetLineNum();
  const std::string type = text(e, "type");
  if (type == "revolute" || type == "continuous")
    j.kind = Kind::Revolute;
  else if (type == "prismatic")
    j.kind = Kind::Prismatic;
  else if (type != "fixed")
    throw error(e, fmt::format("joint \"{}\": type \"{}\" is not supported; revolute, continuous, prismatic and fixed "
                               "are, and a base that floats is said in the scene",
                               j.name, type));
  if (const Element* mimic = e.FirstChildElement("mimic"))
    throw error(*mimic,
                fmt::format("joint \"{}\" mimics another, which is not supported; drive both joints instead", j.name));
  origin(e, j.position, j.rotation);
  if (const Element* axis = e.FirstChildElement("axis")) j.axis = vector(*axis, "xyz", j.axis);
  if (j.kind != Kind::Fixed && !(j.axis.norm() > 0.0)) throw error(e, "the axis has length zero");
  const Element* limit = e.FirstChildElement("limit");
  if (!limit && (type == "revolute" || type == "prismatic"))
    throw error(e, fmt::format("joint \"{}\" has no <limit>; a {} joint needs one", j.name, type));
  if (limit && type != "continuous" && type != "fixed") {
    j.lower = number(*limit, "lower", 0.0), j.upper = number(*limit, "upper", 0.0);
    if (j.lower > j.upper) throw error(*limit, fmt::format("lower {} is above upper {}", j.lower, j.upper));
  }
  if (limit) {
    const double effort = number(*limit, "effort", 0.0);
    if (effort > 0.0) j.effort = effort;
  }
  if (const Element* dynamics = e.FirstChildElement("dynamics")) {
    j.damping = number(*dynamics, "damping", 0.0), j.friction = number(*dynamics, "friction", 0.0);
    if (j.damping < 0.0 || j.friction < 0.0) throw error(*dynamics, "damping and friction must be at least 0");
  }
  return j;
}

/// Puts links and joints in order, parents first.
Urdf grow(const Reader& reader, const Element& robot, std::vector<Urdf::Link> links) {
  std::map<std::string, std::size_t> number;
  for (std::size_t i = 0; i < links.size(); ++i)
    if (!number.emplace(links[i].name, i).second)
      throw reader.error(links[i].line, fmt::format("link \"{}\" is there twice", links[i].name));
  struct Edge {
    std::size_t child;
    Urdf::Joint joint;
  };
  std::vector<std::vector<Edge>> below(links.size());
  std::vector<int> parents(links.size(), 0);
  std::map<std::string, int> names;
  for (const Element* e = robot.FirstChildElement("joint"); e; e = e->NextSiblingElement("joint")) {
    Urdf::Joint joint = reader.joint(*e);
    if (names[joint.name]++) throw reader.error(*e, fmt::format("joint \"{}\" is there twice", joint.name));
    const auto end = [&](const char* which) {
      const Element& at = reader.child(*e, which);
      const std::string name = reader.text(at, "link");
      const auto it = number.find(name);
      if (it == number.end()) throw reader.error(at, fmt::format("there is no link \"{}\"", name));
      return it->second;
    };
    const std::size_t parent = end("parent"), child = end("child");
    if (parents[child]++)
      throw reader.error(*e, fmt::format("link \"{}\" has two parents; only trees are supported", links[child].name));
    below[parent].push_back({child, std::move(joint)});
  }
  Urdf urdf;
  std::vector<std::size_t> roots;
  for (std::size_t i = 0; i < links.size(); ++i)
    if (!parents[i]) roots.push_back(i);
  if (roots.size() != 1)
    throw reader.error(robot, fmt::format("{} links have no parent; exactly one must have none", roots.size()));
  std::vector<std::size_t> order = {roots[0]};
  urdf.pieces.push_back({links[roots[0]], -1, {}});
  for (std::size_t i = 0; i < order.size(); ++i)
    for (Edge& e : below[order[i]]) {
      order.push_back(e.child);
      urdf.pieces.push_back({links[e.child], static_cast<int>(i), std::move(e.joint)});
    }
  if (order.size() != links.size()) throw reader.error(robot, "some joints form a ring; only trees are supported");
  return urdf;
}

}  // namespace

Urdf read_urdf(const fs::path& path) {
  const std::optional<std::string> text = read_regular_file(path.string(), std::uint64_t{64} << 20);
  if (!text) throw InputError(fmt::format("{}: cannot be read", path.string()));
  tinyxml2::XMLDocument document;
  const std::string& xml = *text;
  const Reader reader(path);
  if (document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS)
    throw reader.error(document.ErrorLineNum(), fmt::format("not valid XML ({})", document.ErrorName()));
  const Element* robot = document.FirstChildElement("robot");
  if (!robot) throw reader.error(1, "no <robot>: this is not a URDF file");
  std::vector<Urdf::Link> links;
  for (const Element* e = robot->FirstChildElement("link"); e; e = e->NextSiblingElement("link"))
    links.push_back(reader.link(*e));
  if (links.empty()) throw reader.error(*robot, "<robot> has no <link>");
  Urdf urdf = grow(reader, *robot, std::move(links));
  urdf.name = robot->Attribute("name") ? robot->Attribute("name") : "";
  return urdf;
}

}  // namespace brim
