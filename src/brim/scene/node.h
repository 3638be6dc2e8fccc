#pragma once

#include <optional>
#include <string>
#include <vector>

#include "brim/core/error.h"
#include "brim/math/types.h"
#include "brim/scene/document.h"

namespace brim {

/// A validated value of a document with its place, for precise error messages. Reading keys that the schema requires or
/// gives a default cannot fail.
class Node {
 public:
  Node(const Document& document, const Json& value, std::string pointer)
      : document_(&document), value_(&value), pointer_(std::move(pointer)) {}

  const Json& json() const { return *value_; }
  const std::string& pointer() const { return pointer_; }
  const Document& document() const { return *document_; }

  bool has(const char* key) const { return value_->contains(key); }
  Node at(const char* key) const { return {*document_, value_->at(key), pointer_ + "/" + pointer_token(key)}; }
  Node at(std::size_t i) const { return {*document_, value_->at(i), pointer_ + "/" + std::to_string(i)}; }
  std::size_t size() const { return value_->size(); }

  double number() const { return value_->get<double>(); }
  std::string string() const { return value_->get<std::string>(); }
  Vec3 vec3() const { return {(*value_)[0].get<double>(), (*value_)[1].get<double>(), (*value_)[2].get<double>()}; }
  std::vector<int> integers() const {
    std::vector<int> list;
    for (const Json& x : *value_) list.push_back(static_cast<int>(x.get<double>()));
    return list;
  }

  double number(const char* key) const { return value_->at(key).get<double>(); }
  std::optional<double> number_if(const char* key) const {
    return has(key) ? std::optional<double>(number(key)) : std::nullopt;
  }
  std::int64_t integer(const char* key) const { return static_cast<std::int64_t>(number(key)); }
  bool boolean(const char* key) const { return value_->at(key).get<bool>(); }
  std::string string(const char* key) const { return value_->at(key).get<std::string>(); }
  Vec3 vec3(const char* key) const { return at(key).vec3(); }

  /// The error to throw about this value: "file:line: pointer: message".
  InputError error(const std::string& message) const { return InputError(document_->place(pointer_) + ": " + message); }
  /// Calls f and adds this value's place to InputErrors from it (meshes, files, bodies).
  template <class F>
  auto placed(const F& f) const {
    try {
      return f();
    } catch (const InputError& e) {
      const std::string text = e.what();
      if (document_->has_place(text)) throw;
      throw error(text);
    }
  }

 private:
  const Document* document_;
  const Json* value_;
  std::string pointer_;
};

}  // namespace brim
