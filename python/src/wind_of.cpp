#include "wind_of.h"

#include "arrays.h"
#include "interpreter_lock.h"

namespace brim::python {

WindField wind_of(py::object function, std::shared_ptr<CallerThread> caller) {
  // Whoever drops it last need not hold the interpreter's lock.
  const std::shared_ptr<py::object> held(new py::object(std::move(function)), [](py::object* f) {
    const Locked lock;
    delete f;
  });
  return [held, caller = std::move(caller)](double time, std::span<const Vec3> x, std::span<Vec3> velocity) {
    caller->call([&] {
      const std::vector<Vec3> air = vectors_of((*held)(time, array_of(x)), "field");
      if (air.size() != velocity.size())
        throw InputError(fmt::format("field: {} velocities for {} places", air.size(), velocity.size()));
      for (std::size_t i = 0; i < air.size(); ++i) velocity[i] += air[i];
    });
  };
}

}  // namespace brim::python
