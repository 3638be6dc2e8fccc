#include "stress_arrays.h"

#include "arrays.h"
#include "brim/body/stressed_solid.h"

namespace brim::python {

namespace {

py::array_t<double> matrices(std::span<const Mat3> list) {
  py::array_t<double> out({static_cast<py::ssize_t>(list.size()), py::ssize_t{3}, py::ssize_t{3}});
  double* to = out.mutable_data();
  for (const Mat3& m : list)
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) *to++ = m(r, c);
  return out;
}

}  // namespace

py::object stress_arrays(Session& session, int body) {
  const auto* solid = dynamic_cast<const StressedSolid*>(&session.world().body(body));
  if (solid == nullptr) return py::none();
  StressField field;
  session.unlocked([&] { field = solid->stress_field(); });
  if (field.filled.empty()) field.filled.assign(field.size(), 1.0);
  return py::make_tuple(array_of(std::span<const Vec3>(field.place)), array_of<4>(std::span(field.tets)),
                        array_of(field.volume), array_of(field.filled), matrices(field.deformation),
                        matrices(field.stress));
}

}  // namespace brim::python
