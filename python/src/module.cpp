#include <pybind11/stl.h>

#include "bindings.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/scene/document.h"
#include "brim/scene/plugin.h"
#include "brim/scene/scene.h"
#include "interpreter_lock.h"

namespace py = pybind11;

namespace {

/// The limit that set_threads has set, for the process.
std::unique_ptr<brim::ThreadLimit> limit;

}  // namespace

PYBIND11_MODULE(_core, m) {
  m.doc() = "The compiled part of brim; use the package brim.";
  auto& input_error = py::register_exception<brim::InputError>(m, "InputError", PyExc_ValueError);
  input_error.attr("__doc__") = "What was given cannot be used; the message says where, and what is allowed.";
  auto& defect = py::register_exception<brim::ProgrammingError>(m, "Defect", PyExc_RuntimeError);
  defect.attr("__doc__") = "A broken promise within brim: please report it.";
  m.attr("__version__") = BRIM_VERSION;
  m.def("scene_schema", [] { return brim::scene_schema_text(); });
  m.def("thread_count", &brim::thread_count);
  m.def("set_threads", [](int threads) {
    if (threads < 0) throw brim::InputError("threads: must be a whole number from 0");
    limit.reset();
    if (threads > 0) limit = std::make_unique<brim::ThreadLimit>(threads);
  });
  m.def("nearest_word",
        [](const std::string& word, const std::vector<std::string>& known) { return brim::nearest_word(word, known); });
  m.def("load_plugin", &brim::load_plugin);
  brim::python::watch_for_end();
  brim::python::bind_reports(m);
  brim::python::bind_session(m);
  brim::python::bind_articulated(m);
  brim::python::bind_queries(m);
  brim::python::bind_runs(m);
  brim::python::bind_sensors(m);
}
