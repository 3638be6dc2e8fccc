#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace brim {

/// Reads a file in a process of its own, forked from this one: for libraries that damaged files bring to an abort, to
/// memory without end or to a loop (Assimp, OpenVDB, GDCM). What goes wrong there is one InputError here.
///
/// The child answers questions: each is a number, each answer a list of bytes. It lives as long as the reader does.
/// Limits: memory (what the parent has, plus 512 MiB, plus 64 times the file; of several files the largest) and
/// processor time (60 s, plus 2 s per MiB of the file, or of all); a child from which nothing comes for twice that time
/// is ended as well. Tests: tests/io/child_reader_test.cpp
class ChildReader {
 public:
  /// Bytes, one after another, as answers are made of.
  class Answer {
   public:
    template <class T>
    void put(const T& value) {
      put(&value, sizeof value);
    }
    void put(const void* data, std::size_t size) {
      if (size == 0) return;
      const auto* from = static_cast<const char*>(data);
      bytes_.insert(bytes_.end(), from, from + size);
    }
    void put_text(std::string_view text) {
      put(text.size());
      put(text.data(), text.size());
    }
    const std::vector<char>& bytes() const { return bytes_; }

   private:
    std::vector<char> bytes_;
  };
  /// The same as they are read.
  class Received {
   public:
    explicit Received(std::vector<char> bytes) : bytes_(std::move(bytes)) {}
    template <class T>
    T get() {
      T value;
      get(&value, sizeof value);
      return value;
    }
    /// @throws ProgrammingError  past the end
    void get(void* to, std::size_t size);
    std::string get_text();
    std::size_t left() const { return bytes_.size() - at_; }

   private:
    std::vector<char> bytes_;
    std::size_t at_ = 0;
  };
  using Serve = std::function<void(int question, Answer& answer)>;

  /// @param serve  called in the child; InputErrors and other exceptions out of it are those of ask
  ChildReader(const std::string& path, Serve serve);
  /// What the limits follow from. [bytes]
  struct Load {
    double largest = 0.0;  ///< file, for memory
    double all = 0.0;      ///< of the files together, for time
  };
  /// The same of several files. @param path  what they are called together, in messages
  ChildReader(const std::string& path, const Load& load, Serve serve);
  ~ChildReader();
  ChildReader(const ChildReader&) = delete;
  ChildReader& operator=(const ChildReader&) = delete;

  /// @throws InputError  what serve threw, or how the child ended
  Received ask(int question);
  /// Which of several files the next questions are about, for messages.
  void about(const std::string& path) { path_ = path; }

 private:
  [[noreturn]] void fail();
  bool receive(void* to, std::size_t size);
  void end();

  std::string path_;
  double seconds_ = 0.0, bytes_ = 0.0;
  int child_ = -1, channel_ = -1;
};

}  // namespace brim
