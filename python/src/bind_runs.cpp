#include <pybind11/stl.h>

#include <filesystem>

#include "arrays.h"
#include "bindings.h"
#include "brim/record/run_reader.h"
#include "samples.h"

namespace brim::python {

namespace {

const RecordedBody& body_of(const RunReader& run, int b) {
  if (b < 0 || b >= static_cast<int>(run.bodies().size()))
    throw InputError(fmt::format("body {}: the run has {}", b, run.bodies().size()));
  return run.bodies()[static_cast<std::size_t>(b)];
}

std::vector<int> bodies_of_parts(const RunReader& run) {
  std::vector<int> out;
  for (const RecordedPart& p : run.parts()) out.push_back(p.body);
  return out;
}

/// Positions in all of the frames first ... last, shape (frames, n, 3).
py::array positions_over(const RunReader& run, int b, std::int64_t first, std::int64_t count) {
  const RecordedBody& body = body_of(run, b);
  if (body.changing)
    throw InputError(fmt::format("{}: its vertices change from frame to frame; ask for one frame", body.name));
  const auto n = static_cast<py::ssize_t>(body.display.vertices);
  py::array_t<float> out({static_cast<py::ssize_t>(count), n, py::ssize_t{3}});
  for (std::int64_t f = 0; f < count; ++f) {
    const std::vector<Vec3f> x = run.positions(b, first + f);
    if (!x.empty()) std::copy_n(x.front().data(), 3 * x.size(), out.mutable_data(f));
  }
  return out;
}

/// One vector of the samples of a body over all frames, shape (frames, 3).
py::array samples_over(const RunReader& run, int b, const std::string& what) {
  body_of(run, b);
  const Vec3 BodySample::*member = what == "center"     ? &BodySample::center
                                   : what == "velocity" ? &BodySample::velocity
                                   : what == "impulse"  ? &BodySample::impulse
                                                        : &BodySample::force;
  py::array_t<double> out({static_cast<py::ssize_t>(run.frames()), py::ssize_t{3}});
  for (std::int64_t f = 0; f < run.frames(); ++f) {
    const Vec3 x = run.samples(f).at(static_cast<std::size_t>(b)).*member;
    std::copy_n(x.data(), 3, out.mutable_data(f, 0));
  }
  return out;
}

}  // namespace

void bind_runs(py::module_& m) {
  py::class_<RunReader>(m, "RunReader", "Behind brim.Run.")
      .def(py::init<const std::string&>())
      .def_property_readonly("path", &RunReader::path)
      .def_property_readonly("scene_name", &RunReader::scene_name)
      .def_property_readonly("brim_version", &RunReader::brim_version)
      .def_property_readonly("frame_time", &RunReader::frame_time)
      .def_property_readonly("frames", &RunReader::frames)
      .def("body_names",
           [](const RunReader& r) {
             std::vector<std::pair<std::string, std::string>> names;
             for (const RecordedBody& b : r.bodies()) names.emplace_back(b.name, b.kind);
             return names;
           })
      .def("mass", [](const RunReader& r, int b) { return body_of(r, b).mass; })
      .def("times",
           [](const RunReader& r) {
             std::vector<double> t;
             for (std::int64_t f = 0; f < r.frames(); ++f) t.push_back(r.time(f));
             return array_of(t);
           })
      .def("state", &RunReader::state)
      .def("slices",
           [](const RunReader& r, int b) {
             const RecordedBody& body = body_of(r, b);
             return py::make_tuple(body.q_offset, body.q_size, body.v_offset, body.v_size);
           })
      .def("positions",
           [](const RunReader& r, int b, std::int64_t frame) {
             body_of(r, b);
             const std::vector<Vec3f> x = r.positions(b, frame);
             return array_of(std::span<const Vec3f>(x));
           })
      .def("positions_over", &positions_over)
      .def("samples_over", &samples_over)
      .def("triangles",
           [](const RunReader& r, int b, std::int64_t frame) {
             body_of(r, b);
             const std::vector<Triangle> t = r.triangles(b, frame);
             return array_of<3>(std::span(t));
           })
      .def("contacts",
           [](const RunReader& r, std::int64_t frame) {
             const std::vector<ContactSample> c = r.contacts(frame);
             return contacts_array(c, bodies_of_parts(r));
           })
      .def("pairs",
           [](const RunReader& r, std::int64_t frame) {
             const std::vector<PairReport> p = r.pairs(frame);
             return pairs_array(p, bodies_of_parts(r));
           })
      .def("links",
           [](const RunReader& r, std::int64_t frame) {
             const std::vector<LinkReport> l = r.links(frame);
             return links_array(l);
           })
      .def("link_names", &RunReader::link_names)
      .def("report", &RunReader::report)
      .def("series", [](const RunReader& r, const std::string& name) { return array_of(r.series(name)); });
}

}  // namespace brim::python
