#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace brim::viewer {

/// A bag of named arrays as the viewer's page reads them: little-endian, each array on an 8-byte boundary.
///   header   char[4] "BRMA", uint32 version (1), uint32 arrays n, uint32 size of the message in bytes
///   n times  char[32] name, uint32 type (1 float32, 2 int32, 3 float64), int32 body or -1, uint32 rows,
///            uint32 columns, uint64 offset of the first element from the start
/// The twin is viewer/src/codec.ts; both are held to viewer/test/golden/arrays.bin.
/// Tests: tests/server/array_message_test.cpp
class ArrayMessage {
 public:
  /// Adds rows × columns elements, copied. @param name  fewer than 32 bytes
  void add(std::string_view name, const float* data, std::size_t rows, std::size_t columns = 1, int body = -1);
  void add(std::string_view name, const std::int32_t* data, std::size_t rows, std::size_t columns = 1, int body = -1);
  void add(std::string_view name, const double* data, std::size_t rows, std::size_t columns = 1, int body = -1);

  /// The message. @throws InputError  when it exceeds 4 GiB
  std::string bytes() const;

 private:
  struct Array {
    std::string name;
    std::uint32_t type;
    std::int32_t body;
    std::size_t rows, columns;
    std::string data;
  };
  void add_raw(std::string_view name, std::uint32_t type, int body, const void* data, std::size_t rows,
               std::size_t columns, std::size_t element);

  std::vector<Array> arrays_;
};

}  // namespace brim::viewer
