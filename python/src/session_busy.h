#pragma once

#include "session.h"

namespace brim::python {

/// Keeps a session's world from being used by what it calls, for as long as it lives.
struct Session::Busy {
  explicit Busy(Session& s) : session(s) {
    if (s.busy_) {
      PyErr_SetString(PyExc_RuntimeError, "the world is in the middle of a step");
      throw py::error_already_set();
    }
    s.busy_ = true;
  }
  ~Busy() { session.busy_ = false; }
  Session& session;
};

}  // namespace brim::python
