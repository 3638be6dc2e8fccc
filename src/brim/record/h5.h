#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "brim/core/error.h"

/// A thin wrapper of HDF5 handles: the few calls needed for run files, each with one error message.
///
/// A growing file is readable at any time and after its writer was killed, with everything up to the last flush():
/// metadata are written only there, all or nothing (journal_driver), compressed chunks are written once (one row each)
/// and never move, and uncompressed ones are rewritten in place. Sizes in a file are checked before memory is
/// allocated.
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
  /// Releases the id; the receiver must close it.
  Id release() { return std::exchange(id_, -1); }

 private:
  Id id_ = -1;
};

/// A data set that grows along its first axis, or one of fixed size.
class Dataset {
 public:
  Dataset() = default;
  Dataset(Handle handle, std::string path) : handle_(std::move(handle)), path_(std::move(path)) {}

  /// Present shape.
  std::vector<std::uint64_t> shape() const;
  /// Type of the elements in the file.
  Type type() const;
  /// Appends rows. @param data  rows x (product of the other extents) elements of `type`
  void append(const void* data, std::uint64_t rows, Type type);
  /// Reads rows [first, first + rows) into data, converting to `type` (integer to integer, real to real).
  /// @param elements  capacity of data; @throws InputError when the rows have another number, so that no file can
  ///                  overflow the buffer
  void read(void* data, std::uint64_t elements, std::uint64_t first, std::uint64_t rows, Type type) const;
  /// Throws for rows that do not exist or whose extents after the first axis are not `row`, before memory is allocated;
  /// also for data sets whose shape far exceeds the stored bytes.
  void need_rows(std::uint64_t first, std::uint64_t rows, std::span<const std::uint64_t> row) const;
  /// Cuts the first axis to `rows`.
  void cut(std::uint64_t rows);

  /// Sets the first extent, as required before write_chunk.
  void set_rows(std::uint64_t rows);
  /// Rows per chunk. @throws InputError when chunks do not span whole rows
  std::uint64_t chunk_rows() const;
  /// Writes one uncompressed chunk from memory; it may be rewritten. The extent must already include its rows.
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

/// True for a file whose writer was killed before its first flush: it has no header yet.
bool never_flushed(const std::string& path);

/// An HDF5 file, open for as long as it lives.
class File {
 public:
  /// Seen: for reading, after need_sound (h5_check.h) has checked it, which Write and Read do first.
  enum class Mode { Create, Write, Read, Seen };
  /// @throws InputError  when it cannot be opened, is not an HDF5 file, or crashes the library
  File(const std::string& path, Mode mode);
  const std::string& path() const { return path_; }

  /// Creates a group and its parents; an existing one is left unchanged.
  void group(const std::string& path);
  bool exists(const std::string& path) const;
  /// Removes a data set or group from the file; its space is not reused.
  void remove(const std::string& path);

  /// @param row        extents after the first
  /// @param chunk_rows rows per chunk
  /// @param deflate    0: uncompressed; 1 to 9: shuffled and compressed, with chunk_rows = 1 (see above)
  Dataset growing(const std::string& path, Type type, std::span<const std::uint64_t> row, std::uint64_t chunk_rows,
                  int deflate);
  /// Writes a data set of fixed size.
  void write(const std::string& path, Type type, std::span<const std::uint64_t> shape, const void* data);
  /// Strings, stored with a common fixed length.
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
  /// An integer attribute between least and most. @throws InputError
  std::int64_t whole(const std::string& object, const std::string& name, std::int64_t least, std::int64_t most) const;

  /// Passes all data to the operating system: everything written so far survives the end of this process.
  void flush();

 private:
  std::string path_;
  Handle handle_;
};

}  // namespace brim::h5
