#include "json_of.h"

#include <pybind11/numpy.h>

#include <cmath>

#include "brim/core/error.h"

namespace brim::python {

namespace py = pybind11;

namespace {

Json number_of(double x, const std::string& where) {
  if (!std::isfinite(x)) throw InputError(fmt::format("{}: {} is not allowed; numbers must be finite", where, x));
  return x;
}

Json list_of(const py::handle& value, const std::string& where) {
  Json list = Json::array();
  for (const py::handle item : value) list.push_back(json_of(item, where + "/" + std::to_string(list.size())));
  return list;
}

}  // namespace

Json json_of(const py::handle& value, const std::string& where) {
  if (value.is_none()) return nullptr;
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::int_>(value)) {
    int overflow = 0;
    const long long x = PyLong_AsLongLongAndOverflow(value.ptr(), &overflow);
    if (overflow != 0) throw InputError(where + ": the whole number is too large");
    return x;
  }
  if (py::isinstance<py::float_>(value)) return number_of(value.cast<double>(), where);
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::isinstance<py::dict>(value)) {
    Json object = Json::object();
    for (const auto& [key, item] : py::reinterpret_borrow<py::dict>(value)) {
      if (!py::isinstance<py::str>(key))
        throw InputError(
            fmt::format("{}: {} is not allowed as a key; keys are str", where, py::repr(key).cast<std::string>()));
      const auto word = key.cast<std::string>();
      object[word] = json_of(item, where.empty() ? word : where + "/" + word);
    }
    return object;
  }
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) return list_of(value, where);
  // NumPy's arrays and numbers, and what else knows how to become plain.
  if (py::hasattr(value, "tolist")) {
    const py::object plain = value.attr("tolist")();
    if (!plain.is(value)) return json_of(plain, where);
  }
  if (py::hasattr(value, "__fspath__")) return value.attr("__fspath__")().cast<std::string>();
  throw InputError(fmt::format("{}: a value of type {} is not allowed", where.empty() ? "value" : where,
                               py::str(py::type::handle_of(value).attr("__name__")).cast<std::string>()));
}

py::object object_of(const Json& value) {
  switch (value.type()) {
    case Json::value_t::boolean:
      return py::bool_(value.get<bool>());
    case Json::value_t::number_integer:
    case Json::value_t::number_unsigned:
      return py::int_(value.get<std::int64_t>());
    case Json::value_t::number_float:
      return py::float_(value.get<double>());
    case Json::value_t::string:
      return py::str(value.get<std::string>());
    case Json::value_t::array: {
      py::list list;
      for (const Json& item : value) list.append(object_of(item));
      return list;
    }
    case Json::value_t::object: {
      py::dict dict;
      for (const auto& [key, item] : value.items()) dict[py::str(key)] = object_of(item);
      return dict;
    }
    default:
      return py::none();
  }
}

}  // namespace brim::python
