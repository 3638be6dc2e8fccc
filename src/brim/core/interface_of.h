#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <typeinfo>

namespace brim {

/// What dynamic_cast<const T*>(&object) gives, for loops over thousands of objects of a few types: where the interface
/// lies in objects of a type is asked once a thread and type. A failed cast takes a tenth of a microsecond otherwise.
/// A type must not be unloaded while the thread lives: another at its address would be taken for it.
/// Tests: tests/core/interface_of_test.cpp
template <class T, class Object>
const T* interface_of(const Object& object) {
  struct KnownType {
    const std::type_info* type = nullptr;
    std::ptrdiff_t offset = 0;  ///< [bytes] from the object to its interface
    bool has = false;
  };
  constexpr std::size_t kKept = 8;
  thread_local std::array<KnownType, kKept> seen;
  const std::type_info* type = &typeid(object);
  KnownType& s = seen[(reinterpret_cast<std::uintptr_t>(type) >> 4) % kKept];
  const auto* at = reinterpret_cast<const std::byte*>(&object);
  if (s.type != type) {
    const T* found = dynamic_cast<const T*>(&object);
    s.offset = found != nullptr ? reinterpret_cast<const std::byte*>(found) - at : 0;
    s.has = found != nullptr;
    s.type = type;
  }
  return s.has ? reinterpret_cast<const T*>(at + s.offset) : nullptr;
}

template <class T, class Object>
T* interface_of(Object& object) {
  return const_cast<T*>(interface_of<T>(static_cast<const Object&>(object)));
}

}  // namespace brim
