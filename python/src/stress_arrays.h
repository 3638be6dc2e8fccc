#pragma once

#include "session.h"

namespace brim::python {

/// Of an elastic solid: (place, tetrahedra, volume, filled, deformation, stress); None of other bodies.
py::object stress_arrays(Session& session, int body);

}  // namespace brim::python
