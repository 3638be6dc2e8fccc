#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"
#include "brim/world/report_fields.h"
#include "brim/world/wiring.h"
#include "samples.h"

namespace brim::python {

/// As ContactSample, with the bodies.
struct ContactRow {
  float position[3], force[3], friction[3], overlap;
  std::int32_t part_a, part_b, body_a, body_b;
};

struct PairRow {
  std::int32_t part_a, part_b, body_a, body_b, contacts;
  double worst_overlap, force[3], friction[3], center[3];
};

struct LinkRow {
  double force[3], error, coordinate, effort;
  bool broken;
};

py::object links_array(std::span<const LinkReport> links) {
  py::array_t<LinkRow> out(static_cast<py::ssize_t>(links.size()));
  LinkRow* row = out.mutable_data();
  for (const LinkReport& l : links) {
    std::copy_n(l.force.data(), 3, row->force);
    row->error = l.error, row->coordinate = l.coordinate, row->effort = l.effort, row->broken = l.broken;
    ++row;
  }
  return out;
}

py::object contacts_array(std::span<const ContactSample> contacts, std::span<const int> body_of_part) {
  py::array_t<ContactRow> out(static_cast<py::ssize_t>(contacts.size()));
  ContactRow* row = out.mutable_data();
  for (const ContactSample& c : contacts) {
    std::copy_n(c.position.data(), 3, row->position);
    std::copy_n(c.force.data(), 3, row->force);
    std::copy_n(c.friction.data(), 3, row->friction);
    row->overlap = c.overlap;
    row->part_a = c.part_a, row->part_b = c.part_b;
    row->body_a = body_of_part[static_cast<std::size_t>(c.part_a)];
    row->body_b = body_of_part[static_cast<std::size_t>(c.part_b)];
    ++row;
  }
  return out;
}

py::object pairs_array(std::span<const PairReport> pairs, std::span<const int> body_of_part) {
  py::array_t<PairRow> out(static_cast<py::ssize_t>(pairs.size()));
  PairRow* row = out.mutable_data();
  for (const PairReport& p : pairs) {
    row->part_a = p.part_a, row->part_b = p.part_b, row->contacts = p.contacts;
    row->body_a = body_of_part[static_cast<std::size_t>(p.part_a)];
    row->body_b = body_of_part[static_cast<std::size_t>(p.part_b)];
    row->worst_overlap = p.worst_overlap;
    std::copy_n(p.force_on_a.data(), 3, row->force);
    std::copy_n(p.friction_on_a.data(), 3, row->friction);
    std::copy_n(p.center.data(), 3, row->center);
    ++row;
  }
  return out;
}

void bind_reports(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(ContactRow, position, force, friction, overlap, part_a, part_b, body_a, body_b);
  PYBIND11_NUMPY_DTYPE(LinkRow, force, error, coordinate, effort, broken);
  PYBIND11_NUMPY_DTYPE(PairRow, part_a, part_b, body_a, body_b, contacts, worst_overlap, force, friction, center);

  py::class_<Warning>(m, "StepWarning", "Something that went wrong or nearly so.")
      .def_readonly("time", &Warning::time, "[s]")
      .def_readonly("code", &Warning::code)
      .def_readonly("message", &Warning::message)
      .def("__repr__", [](const Warning& w) { return fmt::format("<StepWarning {}: {}>", w.code, w.message); });

  py::class_<StepReport> report(m, "StepReport", "What happened in a step or a frame.");
  report.def_readonly("time", &StepReport::time, "[s] at the end")
      .def_readonly("ok", &StepReport::ok)
      .def_readonly("substeps", &StepReport::substeps)
      .def_readonly("wall", &StepReport::wall, "[s]")
      .def_readonly("contacts", &StepReport::contacts, "nodes, of the last sub-step")
      .def_readonly("cg_iterations", &StepReport::cg_iterations)
      .def_readonly("worst_overlap", &StepReport::worst_overlap, "[voxels]")
      .def_readonly("kinetic_energy", &StepReport::kinetic_energy, "[J]")
      .def_readonly("potential_energy", &StepReport::potential_energy, "[J]")
      .def_readonly("contact_energy", &StepReport::contact_energy, "[J]")
      .def_readonly("max_speed", &StepReport::max_speed, "[m/s] upper bound")
      .def_readonly("stiffness", &StepReport::stiffness, "[Pa] of contact")
      .def_readonly("warnings", &StepReport::warnings)
      .def(
          "fields",
          [](const StepReport& r) {
            py::dict d;
            for (const ReportField& f : report_fields()) d[f.name] = f.get(r);
            return d;
          },
          "All numbers by name.")
      .def("__repr__", [](const StepReport& r) {
        return fmt::format("<StepReport at {:.6g} s: {} sub-steps, {} contacts{}>", r.time, r.substeps, r.contacts,
                           r.ok ? "" : ", failed");
      });
  for (const ReportField& f : report_fields())
    if (!py::hasattr(report, f.name))
      report.def_property_readonly(
          f.name, [get = f.get](const StepReport& r) { return get(r); }, f.unit);

  py::class_<State>(m, "State", "All that changes in a world: a copy.")
      .def_readonly("time", &State::time, "[s]")
      .def_readonly("step", &State::step)
      .def_property_readonly(
          "q", [](const State& s) { return array_of(s.q); }, "Coordinates of all bodies, shape (nq,); a copy.")
      .def_property_readonly(
          "v", [](const State& s) { return array_of(s.v); }, "Velocities of all bodies, shape (nv,); a copy.")
      .def(py::pickle(
          [](const State& s) {
            const bool known = s.wiring != nullptr;
            return py::make_tuple(s.time, s.step, array_of(s.q), array_of(s.v), array_of(s.warm_start),
                                  known ? py::cast(s.wiring->link_names) : py::none(),
                                  known ? py::cast(s.wiring->force_names) : py::none());
          },
          [](const py::tuple& t) {
            if (t.size() != 5 && t.size() != 7) throw InputError("State: the pickled data are of another version");
            const auto list = [&](std::size_t i) {
              const auto a = t[i].cast<DoubleArray>();
              return std::vector<double>(a.data(), a.data() + a.size());
            };
            std::shared_ptr<Wiring> wiring;  // by names; older data have none
            if (t.size() == 7 && !t[5].is_none()) {
              wiring = std::make_shared<Wiring>();
              wiring->link_names = t[5].cast<std::vector<std::string>>();
              wiring->force_names = t[6].cast<std::vector<std::string>>();
            }
            return State{t[0].cast<double>(), t[1].cast<std::int64_t>(), list(2), list(3), list(4), std::move(wiring)};
          }))
      .def("__eq__",
           [](const State& a, const py::object& other) {
             if (!py::isinstance<State>(other)) return false;
             const auto& b = other.cast<const State&>();
             const auto names = [](const State& s) {
               return s.wiring ? std::pair(s.wiring->link_names, s.wiring->force_names)
                               : std::pair<std::vector<std::string>, std::vector<std::string>>();
             };
             return a.time == b.time && a.step == b.step && a.q == b.q && a.v == b.v && a.warm_start == b.warm_start &&
                    names(a) == names(b);
           })
      .def("__repr__", [](const State& s) {
        return fmt::format("<State at {:.6g} s: {} coordinates, {} velocities>", s.time, s.q.size(), s.v.size());
      });
}

}  // namespace brim::python
