#include "brim/record/h5_driver.h"

#include <fcntl.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>
#if __has_include(<H5FDdevelop.h>)
#include <H5FDdevelop.h>
#endif

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <memory>
#include <span>
#include <string>

#include "brim/record/journal.h"
#include "brim/record/local_heap.h"

namespace brim::h5 {

namespace {

constexpr haddr_t kMostAddress = (haddr_t{1} << 62) - 1;

/// HDF5 hands out pointers to the first member.
struct JournaledFile {
  H5FD_t head{};
  std::string path;
  int file = -1;
  bool writes = false;
  dev_t device = 0;
  ino_t node = 0;
  haddr_t eoa = 0;  ///< end of what HDF5 has given out
  haddr_t eof = 0;  ///< end of what it has written
  Journal journal;

  ~JournaledFile() {
    if (file >= 0) ::close(file);
  }
};

JournaledFile& of(H5FD_t* f) { return *reinterpret_cast<JournaledFile*>(f); }
const JournaledFile& of(const H5FD_t* f) { return *reinterpret_cast<const JournaledFile*>(f); }

/// Exceptions must not pass through C.
template <class Act>
herr_t guarded(const Act& act) {
  try {
    return act() ? 0 : -1;
  } catch (const std::exception&) {
    return -1;
  }
}

H5FD_t* open_file(const char* name, unsigned flags, hid_t, haddr_t) try {
  auto f = std::make_unique<JournaledFile>();
  f->path = name;
  const bool writes = f->writes = (flags & H5F_ACC_RDWR) != 0, anew = (flags & H5F_ACC_TRUNC) != 0;
  if (anew) {
    tell_disk_watch({});
    if (::unlink(Journal::path_of(f->path).c_str()) != 0 && errno != ENOENT) return nullptr;
  }
  tell_disk_watch({});
  f->file = ::open(name,
                   (writes ? O_RDWR : O_RDONLY) | (anew ? O_TRUNC : 0) | (flags & H5F_ACC_CREAT ? O_CREAT : 0) |
                       (flags & H5F_ACC_EXCL ? O_EXCL : 0) | O_CLOEXEC,
                   0666);
  struct stat now {};
  if (f->file < 0 || ::fstat(f->file, &now) != 0) return nullptr;
  f->device = now.st_dev;
  f->node = now.st_ino;
  f->eof = static_cast<haddr_t>(now.st_size);
  f->journal.find(f->path, f->eof);
  if (writes && !f->journal.commit(f->path, f->file)) return nullptr;
  return &f.release()->head;
} catch (const std::exception&) {
  return nullptr;
}

bool commit(JournaledFile& f) {
  if (f.journal.empty()) return true;
  // The superblock tells how long the file is: it must be that long before.
  struct stat now {};
  if (::fstat(f.file, &now) != 0) return false;
  const auto length = static_cast<off_t>(std::max<haddr_t>(f.eoa, f.journal.end()));
  tell_disk_watch({});
  if (now.st_size < length && ::ftruncate(f.file, length) != 0) return false;
  return f.journal.commit(f.path, f.file);
}

herr_t close_file(H5FD_t* file) {
  const std::unique_ptr<JournaledFile> f(&of(file));
  return guarded([&] { return (f->head.access_flags & H5F_ACC_RDWR) == 0 || commit(*f); });
}

int compare_files(const H5FD_t* a, const H5FD_t* b) {
  const JournaledFile &x = of(a), &y = of(b);
  if (x.device != y.device) return x.device < y.device ? -1 : 1;
  return x.node < y.node ? -1 : x.node > y.node ? 1 : 0;
}

/// In a file that is only read, metadata are not accumulated: each piece is read from its beginning (read).
herr_t query(const H5FD_t* file, unsigned long* flags) {
  if (flags == nullptr) return 0;
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_AGGREGATE_SMALLDATA;
  if (file == nullptr || of(file).writes) *flags |= H5FD_FEAT_ACCUMULATE_METADATA;
  return 0;
}

haddr_t get_eoa(const H5FD_t* file, H5FD_mem_t) { return of(file).eoa; }

herr_t set_eoa(H5FD_t* file, H5FD_mem_t, haddr_t address) {
  of(file).eoa = address;
  return 0;
}

haddr_t get_eof(const H5FD_t* file, H5FD_mem_t) { return of(file).eof; }

bool read_at(const JournaledFile& f, haddr_t at, std::span<std::byte> to) {
  size_t done = 0;
  while (done < to.size()) {
    const ssize_t n = ::pread(f.file, to.data() + done, to.size() - done, static_cast<off_t>(at + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    if (n == 0) break;
    done += static_cast<size_t>(n);
  }
  std::fill(to.begin() + static_cast<std::ptrdiff_t>(done), to.end(),
            std::byte{0});  // beyond the end, as HDF5's own drivers
  f.journal.lay_over(at, to.data(), to.size());
  return true;
}

herr_t read(H5FD_t* file, H5FD_mem_t type, hid_t, haddr_t at, size_t size, void* data) {
  const JournaledFile& f = of(file);
  const std::span<std::byte> to(static_cast<std::byte*>(data), size);
  return guarded([&] {
    if (!read_at(f, at, to)) return false;
    if (type != H5FD_MEM_LHEAP || size < 4 || std::memcmp(data, "HEAP", 4) != 0) return true;
    return local_heap_ends(to, f.eof,
                           [&](haddr_t place, std::span<std::byte> room) { return read_at(f, place, room); });
  });
}

herr_t write(H5FD_t* file, H5FD_mem_t type, hid_t, haddr_t at, size_t size, const void* data) {
  JournaledFile& f = of(file);
  return guarded([&] {
    if (type == H5FD_MEM_DRAW) {
      if (!write_at(f.file, at, data, size)) return false;
    } else {
      f.journal.add(at, data, size);
    }
    f.eof = std::max<haddr_t>(f.eof, at + size);
    return true;
  });
}

herr_t flush(H5FD_t* file, hid_t, hbool_t) {
  JournaledFile& f = of(file);
  if ((f.head.access_flags & H5F_ACC_RDWR) == 0) return 0;
  return guarded([&] { return commit(f); });
}

/// The file itself grows at the next flush; it is never cut.
herr_t truncate(H5FD_t* file, hid_t, hbool_t) {
  of(file).eof = std::max(of(file).eof, of(file).eoa);
  return 0;
}

herr_t get_handle(H5FD_t* file, hid_t, void** handle) {
  *handle = &of(file).file;
  return 0;
}

H5FD_class_t driver_class() {
  H5FD_class_t c{};
#ifdef H5FD_CLASS_VERSION
  c.version = H5FD_CLASS_VERSION;
  c.value = static_cast<H5FD_class_value_t>(517);  // of those left to applications
#endif
  c.name = "brim_journal";
  c.maxaddr = kMostAddress;
  c.fc_degree = H5F_CLOSE_WEAK;
  c.open = open_file;
  c.close = close_file;
  c.cmp = compare_files;
  c.query = query;
  c.get_eoa = get_eoa;
  c.set_eoa = set_eoa;
  c.get_eof = get_eof;
  c.get_handle = get_handle;
  c.read = read;
  c.write = write;
  c.flush = flush;
  c.truncate = truncate;
  // Every kind of memory shares one space, as in H5FD_FLMAP_DICHOTOMY's first half for metadata and its second for raw.
  const H5FD_mem_t map[] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(map), std::end(map), c.fl_map);
  return c;
}

}  // namespace

std::int64_t journal_driver() {
  static const H5FD_class_t description = driver_class();
  static const hid_t id = H5FDregister(&description);
  return id;
}

}  // namespace brim::h5
