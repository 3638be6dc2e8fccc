#pragma once

#include <string>
#include <vector>

#include "brim/core/error.h"

namespace brim {

/// Several errors in the user's input. what() has one line for each.
class InputErrors : public InputError {
 public:
  explicit InputErrors(std::vector<std::string> messages);
  const std::vector<std::string>& messages() const { return messages_; }

 private:
  std::vector<std::string> messages_;
};

/// Collects the errors of a document, so that all are reported at once.
class ErrorList {
 public:
  /// Maximum number reported; further ones are only counted.
  static constexpr std::size_t kMost = 20;

  /// @param pointer  JSON pointer of the wrong value  @param message  complete, with its place
  void add(const std::string& pointer, const std::string& message);
  /// A copy of the wrong pointers without messages, for a reader of a part of the document.
  ErrorList marks() const;
  /// Marks a value as wrong without a message, when the reason is reported elsewhere.
  void mark(const std::string& pointer) { pointers_.push_back(pointer); }

  /// Runs f and collects an InputError from it. @param pointer  of the value that f reads
  template <class F>
  bool attempt(const std::string& pointer, const F& f) {
    try {
      f();
      return true;
    } catch (const InputErrors& e) {
      for (const std::string& m : e.messages()) add(pointer, m);
    } catch (const InputError& e) {
      add(pointer, e.what());
    }
    return false;
  }

  bool empty() const { return messages_.empty(); }
  /// True when something at or below the pointer is wrong.
  bool touches(const std::string& pointer) const;
  /// True when the value itself is wrong.
  bool holds(const std::string& pointer) const;
  /// @throws InputError   for one error  @throws InputErrors  for several
  void raise() const;

 private:
  std::vector<std::string> messages_, pointers_;
  std::size_t more_ = 0;
};

}  // namespace brim
