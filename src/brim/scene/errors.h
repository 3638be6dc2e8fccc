#pragma once

#include <string>
#include <vector>

#include "brim/core/error.h"

namespace brim {

/// Several things that are wrong with what the user gave. what() has one line for each.
class InputErrors : public InputError {
 public:
  explicit InputErrors(std::vector<std::string> messages);
  const std::vector<std::string>& messages() const { return messages_; }

 private:
  std::vector<std::string> messages_;
};

/// Collects the errors of a document, so that all are told at once.
class ErrorList {
 public:
  /// Most that are told; the rest is counted.
  static constexpr std::size_t kMost = 20;

  /// @param pointer  JSON pointer of the value that is wrong  @param message  whole, with its place
  void add(const std::string& pointer, const std::string& message);
  /// What is wrong without its messages, for a reader of a part of the document.
  ErrorList marks() const;
  /// Says nothing, but that a value is wrong for a reason that is told elsewhere.
  void mark(const std::string& pointer) { pointers_.push_back(pointer); }

  /// Runs f; an InputError that comes out of it is collected. @param pointer  of what f looks at
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
  /// @throws InputError   when one thing is wrong  @throws InputErrors  when several are
  void raise() const;

 private:
  std::vector<std::string> messages_, pointers_;
  std::size_t more_ = 0;
};

}  // namespace brim
