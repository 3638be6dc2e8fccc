#include "brim/record/h5.h"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <utility>

#include "brim/record/h5_check.h"
#include "brim/record/h5_driver.h"
#include "brim/record/h5_native.h"
#include "brim/record/journal.h"

namespace brim::h5 {

namespace {

/// What the library holds back of a small data set is written when it is closed.
void close_written(Handle& set, const std::string& path) { need(H5Dclose(set.release()), path, kNotWritten); }

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

void File::flush() { need(H5Fflush(handle_.id(), H5F_SCOPE_GLOBAL), path_, "cannot be flushed; is the disk full?"); }

}  // namespace brim::h5
