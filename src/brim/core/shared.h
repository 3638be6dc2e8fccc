#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace brim {

/// An immutable list shared by all its copies, e.g. the display mesh of thousands of bodies of one shape.
/// Tests: tests/core/shared_test.cpp
template <class T>
class SharedList {
 public:
  SharedList() = default;
  SharedList(std::vector<T> items) : items_(std::make_shared<const std::vector<T>>(std::move(items))) {}
  explicit SharedList(std::shared_ptr<const std::vector<T>> items) : items_(std::move(items)) {}

  const std::vector<T>& items() const {
    static const std::vector<T> none;
    return items_ ? *items_ : none;
  }
  operator const std::vector<T>&() const { return items(); }
  std::size_t size() const { return items().size(); }
  bool empty() const { return items().empty(); }
  const T* data() const { return items().data(); }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size(); }
  const T& operator[](std::size_t i) const { return items()[i]; }
  bool operator==(const SharedList& other) const { return items() == other.items(); }
  bool operator==(const std::vector<T>& other) const { return items() == other; }

 private:
  std::shared_ptr<const std::vector<T>> items_;
};

/// An immutable value shared by all its copies.
template <class T>
class Shared {
 public:
  Shared() : Shared(T{}) {}
  Shared(T value) : value_(std::make_shared<const T>(std::move(value))) {}

  const T& operator*() const { return *value_; }
  const T* operator->() const { return value_.get(); }
  operator const T&() const { return *value_; }
  /// A list that is a member of the value; it keeps the whole value alive.
  template <class Item>
  SharedList<Item> list(std::vector<Item> T::*member) const {
    return SharedList<Item>(std::shared_ptr<const std::vector<Item>>(value_, &((*value_).*member)));
  }

 private:
  std::shared_ptr<const T> value_;
};

}  // namespace brim
