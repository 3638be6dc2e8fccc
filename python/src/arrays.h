#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "brim/core/error.h"
#include "brim/math/types.h"

/// Conversion between NumPy arrays and brim's lists. All functions need the interpreter's lock.
namespace brim::python {

namespace py = pybind11;

using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
using IndexArray = py::array_t<std::int64_t, py::array::c_style>;

/// "(4, 2)" for messages.
inline std::string shape_text(const py::array& a) { return py::str(a.attr("shape")).cast<std::string>(); }

/// Rows of an array of shape (n, 3) of finite numbers. @throws InputError  naming it
inline std::vector<Vec3> vectors_of(const py::handle& given, const std::string& name) {
  const DoubleArray a = DoubleArray::ensure(given);
  if (!a) {
    PyErr_Clear();
    throw InputError(name + ": must be an array of numbers, shape (n, 3)");
  }
  if (a.ndim() != 2 || a.shape(1) != 3)
    throw InputError(fmt::format("{}: shape {} is not allowed; must be (n, 3)", name, shape_text(a)));
  std::vector<Vec3> out(static_cast<std::size_t>(a.shape(0)));
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = Vec3(a.data()[3 * i], a.data()[3 * i + 1], a.data()[3 * i + 2]);
    if (!out[i].allFinite()) throw InputError(fmt::format("{}[{}] is not finite", name, i));
  }
  return out;
}

/// Numbers of an array of a given length. @throws InputError  naming it
inline std::vector<double> numbers_of(const py::handle& given, std::size_t n, const std::string& name) {
  const DoubleArray a = DoubleArray::ensure(given);
  if (!a) {
    PyErr_Clear();
    throw InputError(fmt::format("{}: must be an array of numbers, shape ({},)", name, n));
  }
  if (a.ndim() != 1 || static_cast<std::size_t>(a.size()) != n)
    throw InputError(fmt::format("{}: shape {} is not allowed; must be ({},)", name, shape_text(a), n));
  for (std::size_t i = 0; i < n; ++i)
    if (!std::isfinite(a.data()[i])) throw InputError(fmt::format("{}[{}] is not finite", name, i));
  return {a.data(), a.data() + n};
}

/// Corner indices of an array of shape (n, K), each in [0, vertices). @throws InputError  naming it
template <std::size_t K>
std::vector<std::array<std::int32_t, K>> corners_of(const py::handle& given, std::size_t vertices,
                                                    const std::string& name) {
  const py::array any = py::array::ensure(given);
  if (!any || (any.dtype().kind() != 'i' && any.dtype().kind() != 'u')) {
    PyErr_Clear();
    throw InputError(fmt::format("{}: must be an array of whole numbers, shape (n, {})", name, K));
  }
  const auto a = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(any);
  if (a.ndim() != 2 || a.shape(1) != static_cast<py::ssize_t>(K))
    throw InputError(fmt::format("{}: shape {} is not allowed; must be (n, {})", name, shape_text(a), K));
  std::vector<std::array<std::int32_t, K>> out(static_cast<std::size_t>(a.shape(0)));
  for (std::size_t i = 0; i < out.size(); ++i)
    for (std::size_t k = 0; k < K; ++k) {
      const std::int64_t v = a.data()[K * i + k];
      if (v < 0 || v >= static_cast<std::int64_t>(vertices))
        throw InputError(fmt::format("{}[{}] names vertex {}; there are {}", name, i, v, vertices));
      out[i][k] = static_cast<std::int32_t>(v);
    }
  return out;
}

inline py::array_t<double> array_of(std::span<const double> x) {
  return py::array_t<double>(static_cast<py::ssize_t>(x.size()), x.data());
}
inline py::array_t<double> array_of(std::span<const Vec3> x) {
  return py::array_t<double>({static_cast<py::ssize_t>(x.size()), py::ssize_t{3}},
                             x.empty() ? nullptr : x.front().data());
}
inline py::array_t<float> array_of(std::span<const Vec3f> x) {
  return py::array_t<float>({static_cast<py::ssize_t>(x.size()), py::ssize_t{3}},
                            x.empty() ? nullptr : x.front().data());
}
template <std::size_t K>
py::array_t<std::int32_t> array_of(std::span<const std::array<std::int32_t, K>> x) {
  return py::array_t<std::int32_t>({static_cast<py::ssize_t>(x.size()), static_cast<py::ssize_t>(K)},
                                   x.empty() ? nullptr : x.front().data());
}
inline py::array_t<double> array_of(const Vec3& x) { return py::array_t<double>(py::ssize_t{3}, x.data()); }

}  // namespace brim::python
