#include "brim/record/h5.h"

#include <fmt/ranges.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <utility>

#include "brim/record/h5_check.h"
#include "brim/record/h5_driver.h"
#include "brim/record/journal.h"

namespace brim::h5 {

static_assert(sizeof(hid_t) == sizeof(Id));

namespace {

hid_t native(Type t) {
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

/// Little-endian in the file, whatever the machine.
hid_t stored(Type t) {
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

/// Keeps the library from printing its error stack; we say what went wrong ourselves. Builds of HDF5 for threads keep
/// the setting for each thread apart.
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

// Deflate packs at most 1032 : 1 (zlib's documentation): what a shape says beyond that is not in the file.
constexpr std::uint64_t kMostDeflation = 1100;
constexpr std::uint64_t kSmallBytes = 1 << 20;
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 40;

std::uint64_t bytes_of(Type t) {
  return t == Type::Float64 || t == Type::Int64 ? 8 : t == Type::Float32 || t == Type::Int32 ? 4 : 1;
}

bool real(Type t) { return t == Type::Float64 || t == Type::Float32; }

template <class T>
T need(T result, const std::string& path, const char* what) {
  if (result < 0) throw InputError(fmt::format("{}: {}", path, what));
  return result;
}

constexpr const char* kNotWritten = "cannot be written; is the disk full?";

/// What the library holds back of a small data set is written when it is closed.
void close_written(Handle& set, const std::string& path) { need(H5Dclose(set.release()), path, kNotWritten); }

Handle text_type(std::size_t length) {
  Handle type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type.id(), length);
  H5Tset_strpad(type.id(), H5T_STR_NULLPAD);
  H5Tset_cset(type.id(), H5T_CSET_UTF8);
  return type;
}

/// Refuses attributes of more than one value: they are read into the room of one.
void need_single(Id attribute, const std::string& where) {
  const Handle space(need(H5Aget_space(attribute), where, "cannot be read"));
  if (H5Sget_simple_extent_npoints(space.id()) != 1) throw InputError(fmt::format("{}: must be a single value", where));
}

/// Refuses data sets that store fewer bytes than their elements need: HDF5 1.10 takes a chunk or a compact data set for
/// whole whatever its length in the file says, and would read beyond its end. Chunks whose lengths are wrong but right
/// together are not seen, nor what packed chunks unpack to.
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

}  // namespace

Handle::~Handle() {
  if (id_ < 0) return;
  switch (H5Iget_type(id_)) {
    case H5I_FILE:
      H5Fclose(id_);
      H5garbage_collect();  // else the library keeps up to some megabytes of what it has freed
      break;
    case H5I_GROUP:
      H5Gclose(id_);
      break;
    case H5I_DATASET:
      H5Dclose(id_);
      break;
    case H5I_DATASPACE:
      H5Sclose(id_);
      break;
    case H5I_DATATYPE:
      H5Tclose(id_);
      break;
    case H5I_ATTR:
      H5Aclose(id_);
      break;
    case H5I_GENPROP_LST:
      H5Pclose(id_);
      break;
    default:
      break;
  }
}

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

bool never_flushed(const std::string& path) {
  Journal waiting;
  std::error_code error;
  const auto length = std::filesystem::file_size(path, error);
  if (error) return false;
  waiting.find(path, length);
  if (!waiting.empty()) return false;
  std::array<char, 8> head{};
  std::ifstream(path, std::ios::binary).read(head.data(), head.size());
  return std::ranges::all_of(head, [](char c) { return c == 0; });
}

File::File(const std::string& path, Mode mode) : path_(path) {
  hush();
  if (mode != Mode::Create && !std::filesystem::exists(path)) throw InputError(path + ": no such file");
  if (mode == Mode::Write || mode == Mode::Read) need_sound(path);
  const Handle access(H5Pcreate(H5P_FILE_ACCESS));
  // Version 2 of the superblock carries no "open for writing" mark, which would lock out readers for ever after a
  // crash.
  H5Pset_libver_bounds(access.id(), H5F_LIBVER_V18, H5F_LIBVER_V18);
  H5Pset_file_locking(access.id(), false, true);
  need(H5Pset_driver(access.id(), journal_driver(), nullptr), path, "HDF5 refuses the driver of run files");
  if (mode == Mode::Create || mode == Mode::Write) {
    // Metadata reach the disk at flush() and at no other moment, so that the file on disk is always that of a flush.
    H5AC_cache_config_t cache;
    cache.version = H5AC__CURR_CACHE_CONFIG_VERSION;
    H5Pget_mdc_config(access.id(), &cache);
    cache.evictions_enabled = false;
    cache.incr_mode = H5C_incr__off;
    cache.flash_incr_mode = H5C_flash_incr__off;
    cache.decr_mode = H5C_decr__off;
    need(H5Pset_mdc_config(access.id(), &cache), path, "the cache of HDF5 cannot be set");
  }
  switch (mode) {
    case Mode::Create:
      handle_ = Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.id()));
      need(handle_.id(), path, "cannot be created");
      break;
    case Mode::Write:
      // Damage that HDF5 would follow without end is seen in files that are only read (h5_driver.h).
      File(path, Mode::Seen).datasets();
      handle_ = Handle(H5Fopen(path.c_str(), H5F_ACC_RDWR, access.id()));
      need(handle_.id(), path, "cannot be opened for writing; is it an HDF5 file, and not open elsewhere?");
      break;
    case Mode::Read:
    case Mode::Seen:
      handle_ = Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.id()));
      need(handle_.id(), path, "is not an HDF5 file, or is damaged");
      break;
  }
}

void File::group(const std::string& path) {
  for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
    const std::string part = path.substr(0, end);
    if (!exists(part)) {
      const Handle g(H5Gcreate2(handle_.id(), part.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
      need(g.id(), path_ + ":" + part, "the group cannot be made");
    }
    if (end == std::string::npos) return;
  }
}

void File::remove(const std::string& path) {
  need(H5Ldelete(handle_.id(), path.c_str(), H5P_DEFAULT), path_ + ":" + path, "cannot be removed");
}

bool File::exists(const std::string& path) const {
  hush();
  for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
    if (H5Lexists(handle_.id(), path.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

Dataset File::growing(const std::string& path, Type type, std::span<const std::uint64_t> row, std::uint64_t chunk_rows,
                      int deflate) {
  std::vector<hsize_t> size = {0}, most = {H5S_UNLIMITED}, chunk = {std::max<hsize_t>(chunk_rows, 1)};
  for (const std::uint64_t n : row) {
    size.push_back(n);
    most.push_back(n);
    chunk.push_back(std::max<hsize_t>(n, 1));
  }
  for (std::size_t a = 1; a < size.size(); ++a)
    if (most[a] == 0) most[a] = H5S_UNLIMITED;
  const Handle space(H5Screate_simple(static_cast<int>(size.size()), size.data(), most.data()));
  const Handle list(H5Pcreate(H5P_DATASET_CREATE));
  H5Pset_chunk(list.id(), static_cast<int>(chunk.size()), chunk.data());
  if (deflate > 0) {
    H5Pset_shuffle(list.id());
    H5Pset_deflate(list.id(), static_cast<unsigned>(deflate));
  }
  Handle set(H5Dcreate2(handle_.id(), path.c_str(), stored(type), space.id(), H5P_DEFAULT, list.id(), H5P_DEFAULT));
  need(set.id(), path_ + ":" + path, "the data set cannot be made");
  return {std::move(set), path_ + ":" + path};
}

void File::write(const std::string& path, Type type, std::span<const std::uint64_t> shape, const void* data) {
  const std::vector<hsize_t> size(shape.begin(), shape.end());
  const Handle space(H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr));
  Handle set(H5Dcreate2(handle_.id(), path.c_str(), stored(type), space.id(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  need(set.id(), path_ + ":" + path, "the data set cannot be made");
  for (const hsize_t n : size)
    if (n == 0) return;
  need(H5Dwrite(set.id(), native(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data), path_ + ":" + path, kNotWritten);
  close_written(set, path_ + ":" + path);
}

void File::write_texts(const std::string& path, std::span<const std::string> texts) {
  std::size_t longest = 1;
  for (const std::string& s : texts) longest = std::max(longest, s.size());
  const Handle type(text_type(longest));
  const hsize_t count = texts.size();
  const Handle space(H5Screate_simple(1, &count, nullptr));
  Handle set(H5Dcreate2(handle_.id(), path.c_str(), type.id(), space.id(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  need(set.id(), path_ + ":" + path, "the data set cannot be made");
  if (texts.empty()) return;
  std::string all(longest * texts.size(), '\0');
  for (std::size_t i = 0; i < texts.size(); ++i) std::copy(texts[i].begin(), texts[i].end(), all.data() + i * longest);
  need(H5Dwrite(set.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()), path_ + ":" + path, kNotWritten);
  close_written(set, path_ + ":" + path);
}

std::vector<std::string> File::read_texts(const std::string& path) const {
  if (!exists(path)) throw InputError(fmt::format("{}: has no data set {}; it must be a brim run", path_, path));
  const std::string at = path_ + ":" + path;
  const Handle set(need(H5Dopen2(handle_.id(), path.c_str(), H5P_DEFAULT), at, "is not a data set"));
  const Handle type(need(H5Dget_type(set.id()), at, "cannot be read")),
      space(need(H5Dget_space(set.id()), at, "cannot be read"));
  if (H5Tget_class(type.id()) != H5T_STRING || H5Tis_variable_str(type.id()) > 0)
    throw InputError(fmt::format("{}: must hold strings of fixed length", at));
  if (H5Sget_simple_extent_ndims(space.id()) != 1) throw InputError(fmt::format("{}: must be a list", at));
  const std::size_t width = H5Tget_size(type.id());
  const auto count = static_cast<std::uint64_t>(need(H5Sget_simple_extent_npoints(space.id()), at, "cannot be read"));
  if (count > (kMostDeflation * H5Dget_storage_size(set.id()) + kSmallBytes) / width)
    throw InputError(fmt::format("{}: says more strings than it stores; the file is damaged", at));
  need_whole_storage(set.id(), at);
  std::string all(width * count, '\0');
  if (count > 0) need(H5Dread(set.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()), at, "is damaged");
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < count; ++i) {
    std::string s = all.substr(i * width, width);
    s.erase(s.find_last_not_of('\0') + 1);
    texts.push_back(std::move(s));
  }
  return texts;
}

Dataset File::open(const std::string& path) const {
  if (!exists(path)) throw InputError(fmt::format("{}: has no data set {}; it must be a brim run", path_, path));
  Handle set(H5Dopen2(handle_.id(), path.c_str(), H5P_DEFAULT));
  need(set.id(), path_ + ":" + path, "is not a data set");
  return {std::move(set), path_ + ":" + path};
}

std::vector<std::string> File::datasets() const {
  std::vector<std::string> list;
  const auto visit = [](hid_t group, const char* name, const H5L_info_t*, void* to) -> herr_t {
    const Handle object(H5Oopen(group, name, H5P_DEFAULT));
    if (H5Iget_type(object.id()) == H5I_DATASET)
      static_cast<std::vector<std::string>*>(to)->push_back(fmt::format("/{}", name));
    return 0;
  };
  need(H5Lvisit(handle_.id(), H5_INDEX_NAME, H5_ITER_NATIVE, visit, &list), path_, "is damaged");
  std::sort(list.begin(), list.end());
  return list;
}

namespace {

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

void File::flush() { need(H5Fflush(handle_.id(), H5F_SCOPE_GLOBAL), path_, "cannot be flushed; is the disk full?"); }

}  // namespace brim::h5
