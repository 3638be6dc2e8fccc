#include "brim/record/h5_native.h"

#include <hdf5.h>

#include <vector>

namespace brim::h5 {

static_assert(sizeof(hid_t) == sizeof(Id));

Id native(Type t) {
  switch (t) {
    case Type::Float64:
      return H5T_NATIVE_DOUBLE;
    case Type::Float32:
      return H5T_NATIVE_FLOAT;
    case Type::Int64:
      return H5T_NATIVE_INT64;
    case Type::Int32:
      return H5T_NATIVE_INT32;
    case Type::UInt8:
      return H5T_NATIVE_UINT8;
  }
  return -1;
}

Id stored(Type t) {
  switch (t) {
    case Type::Float64:
      return H5T_IEEE_F64LE;
    case Type::Float32:
      return H5T_IEEE_F32LE;
    case Type::Int64:
      return H5T_STD_I64LE;
    case Type::Int32:
      return H5T_STD_I32LE;
    case Type::UInt8:
      return H5T_STD_U8LE;
  }
  return -1;
}

Handle text_type(std::size_t length) {
  Handle type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type.id(), length);
  H5Tset_strpad(type.id(), H5T_STR_NULLPAD);
  H5Tset_cset(type.id(), H5T_CSET_UTF8);
  return type;
}

void hush() {
  // Every handle is closed by its owner. After a disk was full the library's own clearing up at exit crashes.
  static const bool no_exit_handler = H5dont_atexit() >= 0;
  (void)no_exit_handler;
  thread_local const bool once = [] {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    return true;
  }();
  (void)once;
}

void need_whole_storage(Id set, const std::string& path) {
  const Handle list(need(H5Dget_create_plist(set), path, "cannot be read")),
      space(need(H5Dget_space(set), path, "cannot be read")), type(need(H5Dget_type(set), path, "cannot be read"));
  const H5D_layout_t layout = H5Pget_layout(list.id());
  std::vector<hsize_t> extents(
      static_cast<std::size_t>(need(H5Sget_simple_extent_ndims(space.id()), path, "has no shape")));
  hsize_t pieces = 1;
  if (layout == H5D_CHUNKED && H5Pget_nfilters(list.id()) == 0) {
    need(H5Pget_chunk(list.id(), static_cast<int>(extents.size()), extents.data()), path, "is damaged");
    need(H5Dget_num_chunks(set, space.id(), &pieces), path, "is damaged");
  } else if (layout == H5D_COMPACT) {
    H5Sget_simple_extent_dims(space.id(), extents.data(), nullptr);
  } else {
    return;
  }
  double wanted = static_cast<double>(H5Tget_size(type.id())) * static_cast<double>(pieces);
  for (const hsize_t n : extents) wanted *= static_cast<double>(n);
  const auto stored = static_cast<double>(H5Dget_storage_size(set));
  if (wanted != stored)
    throw InputError(
        fmt::format("{}: stores {} bytes where its shape needs {}; the file is damaged", path, stored, wanted));
}

}  // namespace brim::h5
