#pragma once

#include <pybind11/pybind11.h>

#include <memory>

#include "brim/world/applied_force.h"
#include "caller_thread.h"

namespace brim::python {

/// A wind field given by a Python function: (t, x) -> velocities [m/s], both of shape (n, 3).
/// The interpreter's lock must be held.
WindField wind_of(pybind11::object function, std::shared_ptr<CallerThread> caller);

}  // namespace brim::python
