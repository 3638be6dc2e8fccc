// Edits of a world between its steps, as Python asks for them.
#include "brim/raster/shape.h"
#include "session.h"

namespace brim::python {

namespace {

Vec3 vector_of(const std::array<double, 3>& x) { return {x[0], x[1], x[2]}; }

constexpr std::array<const char*, 3> kResponses = {"inherit", "penalty", "constraint"};

Response response_of(const py::dict& d, const std::string& of) {
  if (!d.contains("response") || d["response"].is_none()) return Response::Inherit;
  const auto word = py::str(d["response"]).cast<std::string>();
  for (std::size_t i = 0; i < kResponses.size(); ++i)
    if (word == kResponses[i]) return static_cast<Response>(i);
  throw InputError(fmt::format(
      "{}: response \"{}\" is not allowed; must be one of \"penalty\", \"constraint\" or \"inherit\"", of, word));
}

double number_of(const py::dict& d, const char* key, double otherwise, const std::string& of) {
  if (!d.contains(key) || d[key].is_none()) return otherwise;
  try {
    return py::float_(d[key]);
  } catch (const py::error_already_set&) {
    throw InputError(fmt::format("{}: {} must be a number", of, key));
  }
}

void need_known(const py::dict& d, std::initializer_list<const char*> known, const std::string& of) {
  for (const auto& [key, unused] : d) {
    const auto word = py::str(key).cast<std::string>();
    std::string all;
    bool found = false;
    for (const char* k : known) all += (all.empty() ? "" : ", ") + std::string(k), found = found || word == k;
    if (!found) throw InputError(fmt::format("{}: {} is not known; known are {}", of, word, all));
  }
}

py::dict dict_of(const Material& m) {
  py::dict d;
  d["name"] = m.name;
  d["friction"] = m.friction;
  d["restitution"] = m.restitution;
  d["rolling_resistance"] = m.rolling_resistance;
  d["response"] = kResponses.at(static_cast<std::size_t>(m.response));
  return d;
}

}  // namespace

void Session::set_gravity(const std::array<double, 3>& g) {
  edit([&] { world_->set_gravity(vector_of(g)); });
}

void Session::remove(int body) {
  edit([&] { world_->remove(body); });
}

void Session::grab(int body, const std::array<double, 3>& at, double stiffness, double damping) {
  edit([&] { world_->grab(body, vector_of(at), stiffness, damping); });
}

void Session::pull(const std::array<double, 3>& to) {
  edit([&] { world_->pull(vector_of(to)); });
}

void Session::release() {
  edit([&] { world_->release(); });
}

void Session::freeze(int body, bool frozen) {
  edit([&] { world_->freeze(body, frozen); });
}

void Session::move(int body, const std::array<double, 9>& R, const std::array<double, 3>& t) {
  Pose by;
  by.rotation << R[0], R[1], R[2], R[3], R[4], R[5], R[6], R[7], R[8];
  by.translation = vector_of(t);
  edit([&] { world_->move(body, by); });
}

void Session::set_velocity(int body, const std::array<double, 3>& v, const std::array<double, 3>& w) {
  edit([&] { world_->set_velocity(body, vector_of(v), vector_of(w)); });
}

std::array<double, 3> Session::apply_impulse(int body, const std::array<double, 3>& impulse,
                                             const std::array<double, 3>& point) {
  Vec3 at = Vec3::Zero();
  edit([&] { at = world_->apply_impulse(body, vector_of(impulse), vector_of(point)); });
  return {at.x(), at.y(), at.z()};
}

void Session::set_target(int body, const std::optional<std::array<double, 3>>& position,
                         const std::optional<std::array<double, 9>>& rotation, double duration) {
  edit([&] {
    Pose target;
    if (const auto q = world_->q(body); q.size() == 7)
      target = {Quat(q[3], q[4], q[5], q[6]).normalized().toRotationMatrix(), Vec3(q[0], q[1], q[2])};
    if (position) target.translation = vector_of(*position);
    if (rotation) target.rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation->data());
    world_->set_target(body, target, duration);
  });
}

void Session::set_material(int body, const py::dict& given) {
  const std::string of = fmt::format("material of \"{}\"", world().body(body).name());
  need_known(given, {"name", "friction", "restitution", "rolling_resistance", "response"}, of);
  Material m = world_->material(body);
  if (given.contains("name")) m.name = py::str(given["name"]).cast<std::string>();
  m.friction = number_of(given, "friction", m.friction, of);
  m.restitution = number_of(given, "restitution", m.restitution, of);
  m.rolling_resistance = number_of(given, "rolling_resistance", m.rolling_resistance, of);
  if (given.contains("response")) m.response = response_of(given, of);
  edit([&] { world_->set_material(body, m); });
}

py::dict Session::material(int body) { return dict_of(world().material(body)); }

py::dict Session::named_material(const std::string& name) {
  const std::map<std::string, Material> all = materials();
  const auto it = all.find(name);
  if (it != all.end()) return dict_of(it->second);
  std::string known;
  for (const auto& [other, unused] : all) known += (known.empty() ? "\"" : ", \"") + other + "\"";
  throw InputError(fmt::format("material \"{}\" is not one of the world's; those are {}", name, known));
}

void Session::set_pair_material(const std::string& a, const std::string& b, const py::dict& given) {
  const std::string of = fmt::format("materials \"{}\" and \"{}\"", a, b);
  need_known(given, {"friction", "stiffness", "restitution", "rolling_resistance", "response"}, of);
  PairMaterial pair;
  pair.friction = number_of(given, "friction", pair.friction, of);
  pair.stiffness = number_of(given, "stiffness", pair.stiffness, of);
  pair.restitution = number_of(given, "restitution", pair.restitution, of);
  pair.rolling_resistance = number_of(given, "rolling_resistance", pair.rolling_resistance, of);
  pair.response = response_of(given, of);
  edit([&] { world_->set_pair_material(a, b, pair); });
}

void Session::set_stiffness(double stiffness) {
  edit([&] { world_->set_stiffness(stiffness); });
}

}  // namespace brim::python
