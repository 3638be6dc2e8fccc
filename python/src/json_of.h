#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "brim/scene/document.h"

namespace brim::python {

/// A Python value as scene JSON: None, bool, numbers (NumPy's too), str, path, dict, list, tuple, array.
/// @param where  of the value, for messages ("shape/radius")
/// @throws InputError  for other types, non-finite numbers, keys that are not str
Json json_of(const pybind11::handle& value, const std::string& where);

/// Plain Python objects of a JSON value.
pybind11::object object_of(const Json& value);

}  // namespace brim::python
