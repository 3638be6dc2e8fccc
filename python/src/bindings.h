#pragma once

#include <pybind11/pybind11.h>

/// One function per topic of the module; module.cpp calls them in order.
namespace brim::python {

void bind_reports(pybind11::module_& m);
void bind_session(pybind11::module_& m);
void bind_articulated(pybind11::module_& m);  ///< after bind_session
void bind_queries(pybind11::module_& m);      ///< after bind_session
void bind_runs(pybind11::module_& m);
void bind_sensors(pybind11::module_& m);

}  // namespace brim::python
