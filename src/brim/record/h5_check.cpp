#include "brim/record/h5_check.h"

#include <cstdint>
#include <span>
#include <vector>

#include "brim/core/error.h"
#include "brim/io/child_reader.h"
#include "brim/record/h5.h"

namespace brim::h5 {

namespace {

constexpr std::uint64_t kSmall = 1 << 12;  // elements

template <class Read>
void unless_refused(const Read& read) {
  try {
    read();
  } catch (const InputError&) {
  }
}

void read_set(const File& file, const std::string& name) {
  const Dataset set = file.open(name);
  const std::vector<std::uint64_t> shape = set.shape();
  const Type type = set.type();
  unless_refused([&] { set.chunk_rows(); });
  set.need_rows(0, shape[0], std::span(shape).subspan(1));
  std::uint64_t elements = 1;
  for (const std::uint64_t n : shape) elements *= n;
  if (elements > kSmall) return;
  std::vector<double> numbers(elements);  // the widest of all types
  set.read(numbers.data(), elements, 0, shape[0], type);
}

}  // namespace

void need_sound(const std::string& path) {
  ChildReader reader(path, [&](int, ChildReader::Answer&) {
    unless_refused([&] {
      const File file(path, File::Mode::Seen);
      for (const std::string& name : file.datasets()) unless_refused([&] { read_set(file, name); });
    });
  });
  reader.ask(0);
}

}  // namespace brim::h5
