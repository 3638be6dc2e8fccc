#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"
#include "brim/body/changing_surface.h"
#include "brim/body/particle_fluid/particle_fluid_body.h"
#include "brim/body/particles/particle_body.h"
#include "brim/body/rigid_frame.h"
#include "brim/io/surface_reader.h"
#include "brim/io/tet_reader.h"
#include "brim/world/attachment.h"
#include "brim/world/body_motion.h"
#include "json_of.h"
#include "recorder.h"
#include "samples.h"
#include "session.h"
#include "stress_arrays.h"

namespace brim::python {

namespace {

/// Intensities in memory.
class ArraySlices final : public SliceSource {
 public:
  ArraySlices(std::vector<float> values, const Vec3i& size) : values_(std::move(values)), size_(size) {}
  void read(int k, std::span<double> out) override {
    const std::size_t slice = static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y());
    std::copy_n(values_.data() + static_cast<std::size_t>(k) * slice, slice, out.data());
  }

 private:
  std::vector<float> values_;  // shape (nk, nj, ni)
  Vec3i size_;
};

/// What a scene names `name` from now on.
void give_surface(Session& s, const std::string& name, const py::object& vertices, const py::object& triangles) {
  TriMesh soup{vectors_of(vertices, "vertices"), {}};
  soup.triangles = corners_of<3>(triangles, soup.vertices.size(), "triangles");
  s.arrays->surfaces[name] = clean_surface(std::move(soup), "vertices and triangles");
}

void give_tets(Session& s, const std::string& name, const py::object& vertices, const py::object& tetrahedra) {
  TetMesh mesh{vectors_of(vertices, "vertices"), {}};
  mesh.tets = corners_of<4>(tetrahedra, mesh.vertices.size(), "tetrahedra");
  s.arrays->tets[name] = clean_tets(mesh, "vertices and tetrahedra");
}

void give_volume(Session& s, const std::string& name, const py::object& intensities, const py::object& spacing) {
  const auto a = py::array_t<float, py::array::f_style | py::array::forcecast>::ensure(intensities);
  if (!a) throw InputError("intensities: must be an array of numbers, shape (nx, ny, nz)");
  if (a.ndim() != 3 || a.size() == 0)
    throw InputError(fmt::format("intensities: shape {} is not allowed; must be (nx, ny, nz)", shape_text(a)));
  for (int i = 0; i < 3; ++i)
    if (a.shape(i) > 100000) throw InputError("intensities: more than 100000 voxels along an axis");
  const std::vector<double> step = numbers_of(spacing, 3, "spacing");
  for (const double x : step)
    if (!(x > 0.0)) throw InputError("spacing: must be three numbers above 0, [m]");
  VolumeInfo info;
  info.path = info.format = "intensities";
  info.size = Vec3i(static_cast<int>(a.shape(0)), static_cast<int>(a.shape(1)), static_cast<int>(a.shape(2)));
  info.type = VoxelType::Float32;
  info.unit = 1.0;
  info.unit_given = true;
  info.axes = Vec3(step[0], step[1], step[2]).asDiagonal();
  info.encoding = VolumeInfo::Encoding::Slices;
  info.slices = std::make_shared<ArraySlices>(std::vector<float>(a.data(), a.data() + a.size()), info.size);
  s.arrays->volumes[name] = info;
}

/// Python's view of the coordinates or velocities of a body; those of a removed one are not for writing.
py::array view(const py::object& self, int b, std::span<double> x) {
  py::array a =
      py::array_t<double>({static_cast<py::ssize_t>(x.size())}, {py::ssize_t{sizeof(double)}}, x.data(), self);
  if (self.cast<Session&>().seen_removed(b)) a.attr("flags").attr("writeable") = false;
  return a;
}

std::vector<int> bodies_of_parts(const World& world) {
  std::vector<int> out;
  for (int p = 0; p < world.part_count(); ++p) out.push_back(world.part(p).body);
  return out;
}

bool is_nodal(const Body& body) {
  return dynamic_cast<const ParticleBody*>(&body) != nullptr ||
         dynamic_cast<const ParticleFluidBody*>(&body) != nullptr;
}

py::array positions(Session& s, int b) {
  std::vector<Vec3f> x;
  display_now(s.world().body(b), x);
  return array_of(std::span<const Vec3f>(x));
}

py::array triangles(Session& s, int b) {
  const Body& body = s.world().body(b);
  const ChangingSurface* changing = changing_surface(body);
  if (changing == nullptr) return array_of<3>(std::span(body.display().triangles));
  std::vector<Vec3f> x;
  std::vector<Triangle> now;
  changing->display_surface(x, now);
  return array_of<3>(std::span<const Triangle>(now));
}

/// Centre of the frame of a body that moves as one; nothing of others.
py::object frame_center(Session& s, int b) {
  const auto* frame = dynamic_cast<const RigidFrame*>(&s.world().body(b));
  return frame ? py::object(array_of(frame->rigid_frame().center)) : py::none();
}

py::array density(Session& s, int part, double h, const IndexArray& keys) {
  World& world = s.world();
  if (part < 0 || part >= world.part_count())
    throw InputError(fmt::format("part {}: there are {}", part, world.part_count()));
  if (!(h > 0.0) || !std::isfinite(h)) throw InputError("h: must be a number above 0, [m]");
  if (keys.ndim() != 2 || keys.shape(1) != 3)
    throw InputError(fmt::format("tiles: shape {} is not allowed; must be (n, 3)", shape_text(keys)));
  std::vector<TileKey> tiles(static_cast<std::size_t>(keys.shape(0)));
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const std::int64_t* k = keys.data() + 3 * t;
    for (int i = 0; i < 3; ++i)
      if (std::abs(k[i]) > (1 << 27)) throw InputError("tiles: a number is out of range");
    tiles[t] = {static_cast<int>(k[0]), static_cast<int>(k[1]), static_cast<int>(k[2])};
  }
  std::vector<DensityBlock> blocks(tiles.size());
  s.unlocked([&] { world.density(part, h, tiles, blocks); });
  const py::ssize_t n = kTileSize;
  py::array_t<double> out({static_cast<py::ssize_t>(tiles.size()), n, n, n});
  double* to = out.mutable_data();
  for (const DensityBlock& block : blocks)
    for (int i = 0; i < kTileSize; ++i)
      for (int j = 0; j < kTileSize; ++j)
        for (int k = 0; k < kTileSize; ++k) *to++ = block.rho[block_index(i + kHalo, j + kHalo, k + kHalo)];
  return out;
}

py::tuple tiles(Session& s) {
  const auto active = s.world().active_tiles();
  py::array_t<std::int64_t> keys({static_cast<py::ssize_t>(active.size()), py::ssize_t{3}});
  py::array_t<double> h(static_cast<py::ssize_t>(active.size()));
  for (std::size_t t = 0; t < active.size(); ++t) {
    const auto& [key, step] = active[t];
    std::int64_t* k = keys.mutable_data() + 3 * t;
    k[0] = key.x, k[1] = key.y, k[2] = key.z;
    h.mutable_data()[t] = step;
  }
  return py::make_tuple(keys, h);
}

}  // namespace

void bind_session(py::module_& m) {
  py::class_<Session> session(m, "Session", "The world behind brim.World.");
  session.def(py::init<const py::dict&, std::string>())
      .def_static("load", &Session::load)
      .def("add", &Session::add)
      .def("add_own", &Session::add_own)
      .def("check_own", &Session::check_own)
      .def("give_surface", &give_surface)
      .def("give_tets", &give_tets)
      .def("give_volume", &give_volume)
      .def("wire", &Session::wire, py::arg("list"), py::arg("entry"), py::arg("field") = py::none())
      .def("detach", &Session::detach)
      .def("remove_force", &Session::remove_force)
      .def("set_drive", &Session::set_drive)
      .def("grab", &Session::grab)
      .def("pull", &Session::pull)
      .def("release", &Session::release)
      .def("grabbed", [](Session& s) { return s.world().grabbed(); })
      .def("detached",
           [](Session& s, int i) {
             if (i < 0 || i >= s.world().attachment_count())
               throw InputError(fmt::format("attachment {}: there are {}", i, s.world().attachment_count()));
             return s.world().detached(i);
           })
      .def("attachment_names",
           [](Session& s) {
             std::vector<std::string> names;
             for (int i = 0; i < s.world().attachment_count(); ++i) names.push_back(s.world().attachment(i).name);
             return names;
           })
      .def("attachment_ids",
           [](Session& s) {
             std::vector<std::int64_t> ids;
             for (int i = 0; i < s.world().attachment_count(); ++i) ids.push_back(s.world().attachment_id(i));
             return ids;
           })
      .def("links", [](Session& s) { return links_array(s.report().links); })
      .def("set_gravity", &Session::set_gravity)
      .def("remove", &Session::remove)
      .def("removed", [](Session& s, int b) { return s.world().removed(b); })
      .def("freeze", &Session::freeze)
      .def("frozen", [](Session& s, int b) { return s.world().frozen(b); })
      .def("move", &Session::move)
      .def("middle", [](Session& s, int b) { return array_of(middle_of(s.world().body(b))); })
      .def("set_velocity", &Session::set_velocity)
      .def("set_target", &Session::set_target)
      .def("apply_impulse", &Session::apply_impulse)
      .def("material", &Session::material)
      .def("named_material", &Session::named_material)
      .def("set_material", &Session::set_material)
      .def("set_pair_material", &Session::set_pair_material)
      .def("set_stiffness", &Session::set_stiffness)
      .def("step", &Session::step)
      .def("takes_forces", &Session::takes_forces)
      .def("asleep", [](Session& s, int b) { return s.world().asleep(b); })
      .def("state", &Session::state)
      .def("set_state", &Session::set_state)
      .def("q", [](const py::object& self, int b) { return view(self, b, self.cast<Session&>().seen_q(b)); })
      .def("v", [](const py::object& self, int b) { return view(self, b, self.cast<Session&>().seen_v(b)); });
  // The world as it is.
  session.def_property_readonly("time", [](Session& s) { return s.world().state().time; })
      .def_property_readonly("steps", [](Session& s) { return s.world().state().step; })
      .def_property_readonly("time_step", [](Session& s) { return s.world().options().time_step; })
      .def_property_readonly("hash", [](Session& s) { return s.world().hash(); })
      .def_property_readonly("stiffness", [](Session& s) { return s.world().stiffness(); })
      .def_property_readonly("body_count", [](Session& s) { return s.world().body_count(); })
      .def_property_readonly("part_count", [](Session& s) { return s.world().part_count(); })
      .def_property_readonly("part_bodies", [](Session& s) { return bodies_of_parts(s.world()); })
      .def("report", [](const Session& s) { return s.report(); })
      .def("contacts",
           [](Session& s) {
             World& world = s.world();
             return contacts_array(world.contacts(), bodies_of_parts(world));
           })
      .def("pairs",
           [](Session& s) {
             World& world = s.world();
             return pairs_array(s.report().pairs, bodies_of_parts(world));
           })
      .def("tiles", &tiles)
      .def("density", &density);
  // Bodies by number.
  session.def("name", [](Session& s, int b) { return s.world().body(b).name(); })
      .def("kind", [](Session& s, int b) { return std::string(s.world().body(b).kind()); })
      .def("mass", [](Session& s, int b) { return s.world().body(b).mass(); })
      .def("immobile", [](Session& s, int b) { return s.world().body(b).immobile(); })
      .def("nodal", [](Session& s, int b) { return is_nodal(s.world().body(b)); })
      .def("frame_center", &frame_center)
      .def("positions", &positions)
      .def("triangles", &triangles)
      .def("stress", &stress_arrays)
      .def("lines", [](Session& s, int b) { return array_of<2>(std::span(s.world().body(b).display().lines)); })
      .def("kinetic_energy", [](Session& s, int b) { return s.world().body(b).kinetic_energy(s.world().v(b)); })
      .def("linear_momentum",
           [](Session& s, int b) { return array_of(s.world().body(b).linear_momentum(s.world().v(b))); })
      .def("angular_momentum",
           [](Session& s, int b) { return array_of(s.world().body(b).angular_momentum(s.world().v(b))); });
  // The scene that it stands for.
  session.def("head", [](Session& s) { return object_of(s.head()); })
      .def("entries", [](const Session& s) { return object_of(s.entries()); })
      .def_readonly("file", &Session::file)
      .def_readonly("text", &Session::text)
      .def_property_readonly("folder", [](const Session& s) { return s.folder(); })
      .def_readonly("frames", &Session::frames)
      .def_readonly("steps_per_frame", &Session::steps_per_frame)
      .def("given_names",
           [](const Session& s) {
             std::vector<std::string> names;
             for (const auto& [name, unused] : s.arrays->surfaces) names.push_back(name);
             for (const auto& [name, unused] : s.arrays->tets) names.push_back(name);
             for (const auto& [name, unused] : s.arrays->volumes) names.push_back(name);
             return names;
           })
      .def("given_surface",
           [](const Session& s, const std::string& name) {
             const TriMesh& mesh = s.arrays->surfaces.at(name);
             return py::make_tuple(array_of(std::span<const Vec3>(mesh.vertices)),
                                   array_of<3>(std::span(mesh.triangles)));
           })
      .def("given_tets",
           [](const Session& s, const std::string& name) {
             const TetMesh& mesh = s.arrays->tets.at(name);
             return py::make_tuple(array_of(std::span<const Vec3>(mesh.vertices)), array_of<4>(std::span(mesh.tets)));
           })
      .def("given_volume", [](const Session& s, const std::string& name) {
        const VolumeInfo& info = s.arrays->volumes.at(name);
        py::array_t<float> values({static_cast<py::ssize_t>(info.size.z()), static_cast<py::ssize_t>(info.size.y()),
                                   static_cast<py::ssize_t>(info.size.x())});
        std::vector<double> slice(static_cast<std::size_t>(info.size.x()) * static_cast<std::size_t>(info.size.y()));
        for (int k = 0; k < info.size.z(); ++k) {
          info.slices->read(k, slice);
          std::copy(slice.begin(), slice.end(), values.mutable_data() + static_cast<std::size_t>(k) * slice.size());
        }
        return py::make_tuple(values, array_of(Vec3(info.axes.diagonal())));
      });

  py::class_<Recorder>(m, "Recorder", "Records a session's frames into a run folder.")
      .def(py::init<Session&, const std::string&, const std::string&, std::int64_t, int, const std::string&,
                    const std::string&, bool>(),
           py::keep_alive<1, 2>())
      .def("add", &Recorder::add)
      .def("finish", &Recorder::finish);
}

}  // namespace brim::python
