#include <hdf5.h>

#include <algorithm>
#include <cmath>

#include "brim/record/h5_native.h"

namespace brim::h5 {

namespace {

/// Refuses attributes of more than one value: they are read into the room of one.
void need_single(Id attribute, const std::string& where) {
  const Handle space(need(H5Aget_space(attribute), where, "cannot be read"));
  if (H5Sget_simple_extent_npoints(space.id()) != 1) throw InputError(fmt::format("{}: must be a single value", where));
}

void put_attribute(Id file, const std::string& object, const std::string& name, hid_t stored_type, hid_t memory_type,
                   const void* data) {
  if (H5Aexists_by_name(file, object.c_str(), name.c_str(), H5P_DEFAULT) > 0)
    H5Adelete_by_name(file, object.c_str(), name.c_str(), H5P_DEFAULT);
  const Handle space(H5Screate(H5S_SCALAR));
  const Handle a(H5Acreate_by_name(file, object.c_str(), name.c_str(), stored_type, space.id(), H5P_DEFAULT,
                                   H5P_DEFAULT, H5P_DEFAULT));
  need(a.id(), object + "@" + name, "the attribute cannot be made");
  need(H5Awrite(a.id(), memory_type, data), object + "@" + name, "the attribute cannot be written");
}

}  // namespace

void File::attribute(const std::string& object, const std::string& name, const std::string& value) {
  const Handle type(text_type(std::max<std::size_t>(value.size(), 1)));
  const std::string padded = value.empty() ? std::string(1, '\0') : value;
  put_attribute(handle_.id(), object, name, type.id(), type.id(), padded.data());
}

void File::attribute(const std::string& object, const std::string& name, double value) {
  put_attribute(handle_.id(), object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

void File::attribute(const std::string& object, const std::string& name, std::int64_t value) {
  put_attribute(handle_.id(), object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
}

bool File::has_attribute(const std::string& object, const std::string& name) const {
  hush();
  return H5Aexists_by_name(handle_.id(), object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::string File::text(const std::string& object, const std::string& name) const {
  hush();
  const Handle a(H5Aopen_by_name(handle_.id(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT));
  need(a.id(), fmt::format("{}:{}", path_, object), ("has no attribute " + name).c_str());
  const Handle type(H5Aget_type(a.id()));
  if (H5Tget_class(type.id()) != H5T_STRING || H5Tis_variable_str(type.id()) > 0)
    throw InputError(fmt::format("{}:{}: the attribute {} must be a string of fixed length", path_, object, name));
  need_single(a.id(), fmt::format("{}:{}@{}", path_, object, name));
  std::string value(H5Tget_size(type.id()), '\0');
  need(H5Aread(a.id(), type.id(), value.data()), object + "@" + name, "cannot be read");
  while (!value.empty() && value.back() == '\0') value.pop_back();
  return value;
}

double File::number(const std::string& object, const std::string& name) const {
  hush();
  const Handle a(H5Aopen_by_name(handle_.id(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT));
  need(a.id(), fmt::format("{}:{}", path_, object), ("has no attribute " + name).c_str());
  need_single(a.id(), fmt::format("{}:{}@{}", path_, object, name));
  double value = 0.0;
  need(H5Aread(a.id(), H5T_NATIVE_DOUBLE, &value), object + "@" + name, "cannot be read");
  return value;
}

std::int64_t File::whole(const std::string& object, const std::string& name, std::int64_t least,
                         std::int64_t most) const {
  const double x = number(object, name);
  if (!(x >= static_cast<double>(least) && x <= static_cast<double>(most)) || x != std::floor(x))
    throw InputError(
        fmt::format("{}:{}@{}: is {}; it must be a whole number from {} to {}", path_, object, name, x, least, most));
  return static_cast<std::int64_t>(x);
}

}  // namespace brim::h5
