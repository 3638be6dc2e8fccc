#include <pybind11/stl.h>

#include <optional>

#include "arrays.h"
#include "bindings.h"
#include "brim/world/queries.h"
#include "session.h"

/// Rays, nearest points and overlaps. Bodies written in Python may be asked for their place, so that the interpreter's
/// lock is released.
namespace brim::python {

namespace {

/// Bodies a query sees: one flag each; none: all.
using Seen = std::optional<std::vector<bool>>;

BodyFilter filter_of(const Seen& seen) {
  if (!seen) return {};
  return [&seen](int b) { return static_cast<std::size_t>(b) < seen->size() && (*seen)[static_cast<std::size_t>(b)]; };
}

/// A place or direction; the world says what of it is not finite.
Vec3 place_of(const std::array<double, 3>& x) { return {x[0], x[1], x[2]}; }

/// (body, part, point (3,), normal (3,), distance), or None.
py::object object_of(const std::optional<QueryHit>& hit) {
  if (!hit) return py::none();
  return py::make_tuple(hit->body, hit->part, array_of(hit->point), array_of(hit->normal), hit->distance);
}

}  // namespace

void bind_queries(py::module_& m) {
  const py::object type = m.attr("Session");
  auto session = py::reinterpret_borrow<py::class_<Session>>(type);
  session
      .def("raycast",
           [](Session& s, const std::array<double, 3>& origin, const std::array<double, 3>& direction, double most,
              const Seen& seen) {
             World& world = s.world();
             std::optional<QueryHit> hit;
             s.unlocked([&] { hit = world.raycast(place_of(origin), place_of(direction), most, filter_of(seen)); });
             return object_of(hit);
           })
      .def("closest_point",
           [](Session& s, const std::array<double, 3>& point, double most, const Seen& seen) {
             World& world = s.world();
             std::optional<QueryHit> hit;
             s.unlocked([&] { hit = world.closest_point(place_of(point), most, filter_of(seen)); });
             return object_of(hit);
           })
      .def("overlap_ball",
           [](Session& s, const std::array<double, 3>& center, double radius, const Seen& seen) {
             World& world = s.world();
             std::vector<int> bodies;
             s.unlocked([&] { bodies = world.overlap_ball(place_of(center), radius, filter_of(seen)); });
             return bodies;
           })
      .def("overlap_box", [](Session& s, const std::array<double, 3>& center, const std::array<double, 9>& R,
                             const std::array<double, 3>& size, const Seen& seen) {
        World& world = s.world();
        Pose box;
        box.rotation << R[0], R[1], R[2], R[3], R[4], R[5], R[6], R[7], R[8];
        box.translation = place_of(center);
        std::vector<int> bodies;
        s.unlocked([&] { bodies = world.overlap_box(box, place_of(size), filter_of(seen)); });
        return bodies;
      });
}

}  // namespace brim::python
