#include <fmt/ranges.h>
#include <hdf5.h>

#include <algorithm>

#include "brim/record/h5_native.h"

namespace brim::h5 {

namespace {

/// [bytes] of a row.
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 40;

std::uint64_t bytes_of(Type t) {
  return t == Type::Float64 || t == Type::Int64 ? 8 : t == Type::Float32 || t == Type::Int32 ? 4 : 1;
}

bool real(Type t) { return t == Type::Float64 || t == Type::Float32; }

}  // namespace

std::vector<std::uint64_t> Dataset::shape() const {
  hush();
  const Handle space(need(H5Dget_space(handle_.id()), path_, "cannot be read"));
  std::vector<hsize_t> dims(
      static_cast<std::size_t>(need(H5Sget_simple_extent_ndims(space.id()), path_, "has no shape")));
  if (dims.empty()) throw InputError(fmt::format("{}: is a single value; it must have rows", path_));
  H5Sget_simple_extent_dims(space.id(), dims.data(), nullptr);
  return {dims.begin(), dims.end()};
}

Type Dataset::type() const {
  const Handle type(need(H5Dget_type(handle_.id()), path_, "cannot be read"));
  const H5T_class_t kind = H5Tget_class(type.id());
  const std::size_t size = H5Tget_size(type.id());
  if (kind == H5T_FLOAT && size == 8) return Type::Float64;
  if (kind == H5T_FLOAT && size == 4) return Type::Float32;
  if (kind == H5T_INTEGER && size == 8) return Type::Int64;
  if (kind == H5T_INTEGER && size == 4) return Type::Int32;
  if (kind == H5T_INTEGER && size == 1) return Type::UInt8;
  throw InputError(fmt::format("{}: has elements of a type that brim does not write", path_));
}

void Dataset::append(const void* data, std::uint64_t rows, Type type) {
  if (rows == 0) return;
  std::vector<std::uint64_t> dims = shape();
  std::vector<hsize_t> size(dims.begin(), dims.end()), start(dims.size(), 0), count(dims.begin(), dims.end());
  start[0] = size[0];
  size[0] += rows;
  count[0] = rows;
  need(H5Dset_extent(handle_.id(), size.data()), path_, "cannot grow; is the disk full?");
  for (std::size_t i = 1; i < count.size(); ++i)
    if (count[i] == 0) return;
  const Handle space(need(H5Dget_space(handle_.id()), path_, "cannot be read"));
  need(H5Sselect_hyperslab(space.id(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr), path_,
       "bad rows");
  const Handle memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr));
  need(H5Dwrite(handle_.id(), native(type), memory.id(), space.id(), H5P_DEFAULT, data), path_, kNotWritten);
}

void Dataset::need_rows(std::uint64_t first, std::uint64_t rows, std::span<const std::uint64_t> row) const {
  const std::vector<std::uint64_t> dims = shape();
  if (dims.size() != row.size() + 1 || !std::equal(row.begin(), row.end(), dims.begin() + 1))
    throw InputError(fmt::format("{}: has shape ({}); it must have rows of shape ({})", path_, fmt::join(dims, ", "),
                                 fmt::join(row, ", ")));
  if (first > dims[0] || rows > dims[0] - first)
    throw InputError(fmt::format("{}: rows {} to {} asked for, but it has {}", path_, first, first + rows, dims[0]));
  std::uint64_t bytes = bytes_of(type());
  for (const std::uint64_t n : row) {
    if (n > 0 && bytes > kMostBytes / n) throw InputError(fmt::format("{}: has rows that are too long", path_));
    bytes *= n;
  }
  const std::uint64_t stored = H5Dget_storage_size(handle_.id());
  if (bytes > 0 && rows > (kMostDeflation * stored + kSmallBytes) / bytes)
    throw InputError(fmt::format("{}: says {} rows of {} bytes, but stores {} bytes; the file is damaged", path_, rows,
                                 bytes, stored));
}

void Dataset::read(void* data, std::uint64_t elements, std::uint64_t first, std::uint64_t rows, Type type) const {
  const std::vector<std::uint64_t> dims = shape();
  need_rows(first, rows, std::span(dims).subspan(std::min<std::size_t>(1, dims.size())));
  std::uint64_t held = rows;
  for (std::size_t a = 1; a < dims.size(); ++a) held *= dims[a];
  if (held != elements)
    throw InputError(fmt::format("{}: has shape ({}); {} numbers in {} rows are needed", path_, fmt::join(dims, ", "),
                                 elements, rows));
  if (real(this->type()) != real(type))
    throw InputError(fmt::format("{}: has {}; it must have {}", path_, real(type) ? "integers" : "real numbers",
                                 real(type) ? "real numbers" : "integers"));
  std::vector<hsize_t> start(dims.size(), 0), count(dims.begin(), dims.end());
  start[0] = first;
  count[0] = rows;
  for (const hsize_t c : count)
    if (c == 0) return;
  need_whole_storage(handle_.id(), path_);
  const Handle space(need(H5Dget_space(handle_.id()), path_, "cannot be read"));
  need(H5Sselect_hyperslab(space.id(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr), path_,
       "bad rows");
  const Handle memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr));
  need(H5Dread(handle_.id(), native(type), memory.id(), space.id(), H5P_DEFAULT, data), path_, "is damaged");
}

void Dataset::cut(std::uint64_t rows) {
  const std::vector<std::uint64_t> dims = shape();
  std::vector<hsize_t> size(dims.begin(), dims.end());
  if (size[0] <= rows) return;
  size[0] = rows;
  need(H5Dset_extent(handle_.id(), size.data()), path_, "cannot be cut");
}

void Dataset::set_rows(std::uint64_t rows) {
  const std::vector<std::uint64_t> dims = shape();
  std::vector<hsize_t> size(dims.begin(), dims.end());
  size[0] = rows;
  need(H5Dset_extent(handle_.id(), size.data()), path_, "cannot grow; is the disk full?");
}

std::uint64_t Dataset::chunk_rows() const {
  const Handle list(need(H5Dget_create_plist(handle_.id()), path_, "cannot be read"));
  const std::vector<std::uint64_t> dims = shape();
  std::vector<hsize_t> chunk(dims.size(), 0);
  if (H5Pget_layout(list.id()) != H5D_CHUNKED || H5Pget_nfilters(list.id()) != 0 ||
      H5Pget_chunk(list.id(), static_cast<int>(chunk.size()), chunk.data()) != static_cast<int>(chunk.size()))
    throw InputError(fmt::format("{}: is not stored in plain chunks, so it cannot be gone on with", path_));
  for (std::size_t a = 1; a < dims.size(); ++a)
    if (chunk[a] != std::max<std::uint64_t>(dims[a], 1))
      throw InputError(fmt::format("{}: is not stored in whole rows, so it cannot be gone on with", path_));
  return chunk[0];
}

void Dataset::write_chunk(std::uint64_t first, const void* data, std::size_t bytes) {
  std::vector<hsize_t> offset(shape().size(), 0);
  offset[0] = first;
  need(H5Dwrite_chunk(handle_.id(), H5P_DEFAULT, 0, offset.data(), bytes, data), path_, kNotWritten);
}

void Dataset::overwrite(const void* data, Type type) {
  need(H5Dwrite(handle_.id(), native(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data), path_, kNotWritten);
}

}  // namespace brim::h5
