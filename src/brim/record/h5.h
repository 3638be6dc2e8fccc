#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "brim/core/error.h"

/// A thin owner of HDF5 handles: the few calls that run files need, each failing with one message.
///
/// Files that grow stay readable while they grow and after the program was killed, with everything up to the last
/// flush(): metadata are written only there, all of them or none (journal_driver), compressed chunks are written once
/// (one row each) and never move, and uncompressed ones are rewritten in place. What a file says is checked before room
/// is made for it.
namespace brim::h5 {

using Id = std::int64_t;  ///< hid_t, without the library's header

/// Element types of data sets.
enum class Type { Float64, Float32, Int64, Int32, UInt8 };

/// Owns one handle of any kind.
class Handle {
 public:
  Handle() = default;
  explicit Handle(Id id) : id_(id) {}
  Handle(Handle&& o) noexcept : id_(std::exchange(o.id_, -1)) {}
  Handle& operator=(Handle&& o) noexcept {
    std::swap(id_, o.id_);
    return *this;
  }
  ~Handle();
  Id id() const { return id_; }
  /// Gives the id up; whoever takes it closes it.
  Id release() { return std::exchange(id_, -1); }

 private:
  Id id_ = -1;
};

/// A data set that grows along its first axis, or one of fixed size.
class Dataset {
 public:
  Dataset() = default;
  Dataset(Handle handle, std::string path) : handle_(std::move(handle)), path_(std::move(path)) {}

  /// Shape now.
  std::vector<std::uint64_t> shape() const;
  /// Type of the elements in the file.
  Type type() const;
  /// Writes rows at the end. @param data  rows x (product of the other extents) elements of `type`
  void append(const void* data, std::uint64_t rows, Type type);
  /// Reads rows [first, first + rows) into data, converting to `type` (integers to integers, real numbers to real
  /// ones).
  /// @param elements  that data holds; @throws InputError when the rows have another number, so that no file can make
  ///                  more be written than there is room for
  void read(void* data, std::uint64_t elements, std::uint64_t first, std::uint64_t rows, Type type) const;
  /// Refuses rows that are not there or have other extents after the first axis than `row`, before room is made for
  /// them; also data sets whose shape says far more than the file stores.
  void need_rows(std::uint64_t first, std::uint64_t rows, std::span<const std::uint64_t> row) const;
  /// Cuts the first axis to `rows`.
  void cut(std::uint64_t rows);

  /// Sets the first axis, as what is written by write_chunk needs.
  void set_rows(std::uint64_t rows);
  /// Rows stored together. @throws InputError when chunks do not span whole rows
  std::uint64_t chunk_rows() const;
  /// Writes one uncompressed chunk as it lies in memory; it may be written again. Rows must have been set to reach it.
  /// @param first  its first row, a multiple of chunk_rows()
  /// @param bytes  of the whole chunk
  void write_chunk(std::uint64_t first, const void* data, std::size_t bytes);
  /// Replaces all elements.
  void overwrite(const void* data, Type type);
  const std::string& path() const { return path_; }

 private:
  Handle handle_;
  std::string path_;
};

/// True for a file whose writer was killed before its first flush: it has no head yet.
bool never_flushed(const std::string& path);

/// An HDF5 file, open for as long as it lives.
class File {
 public:
  /// Seen: to be read, and need_sound (h5_check.h) has looked at it, as is done first for Write and Read.
  enum class Mode { Create, Write, Read, Seen };
  /// @throws InputError  when it cannot be opened, is no HDF5 file, or one that ends the library
  File(const std::string& path, Mode mode);
  const std::string& path() const { return path_; }

  /// Makes a group and those above it; one that is there already is left as it is.
  void group(const std::string& path);
  bool exists(const std::string& path) const;
  /// Takes a data set or group out of the file; its room is not used again.
  void remove(const std::string& path);

  /// @param row        extents after the first
  /// @param chunk_rows rows stored together
  /// @param deflate    0: as they are; 1 to 9: shuffled and compressed, with chunk_rows = 1 (see above)
  Dataset growing(const std::string& path, Type type, std::span<const std::uint64_t> row, std::uint64_t chunk_rows,
                  int deflate);
  /// A data set of fixed size, written at once.
  void write(const std::string& path, Type type, std::span<const std::uint64_t> shape, const void* data);
  /// Strings, stored with one fixed length.
  void write_texts(const std::string& path, std::span<const std::string> texts);
  std::vector<std::string> read_texts(const std::string& path) const;
  Dataset open(const std::string& path) const;
  /// Paths of all data sets, sorted.
  std::vector<std::string> datasets() const;

  void attribute(const std::string& object, const std::string& name, const std::string& value);
  void attribute(const std::string& object, const std::string& name, double value);
  void attribute(const std::string& object, const std::string& name, std::int64_t value);
  bool has_attribute(const std::string& object, const std::string& name) const;
  std::string text(const std::string& object, const std::string& name) const;
  double number(const std::string& object, const std::string& name) const;
  /// A whole number from least to most. @throws InputError
  std::int64_t whole(const std::string& object, const std::string& name, std::int64_t least, std::int64_t most) const;

  /// Hands everything to the operating system: what was written so far survives the end of this process.
  void flush();

 private:
  std::string path_;
  Handle handle_;
};

}  // namespace brim::h5
