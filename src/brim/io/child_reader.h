#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace brim {

/// Reads a file in a forked process: for libraries that abort, exhaust memory or loop on damaged files (Assimp,
/// OpenVDB, GDCM). Any such failure becomes one InputError here.
///
/// The child answers questions: each is a number, each answer a list of bytes. It lives as long as the reader. Limits:
/// memory (the parent's, plus 512 MiB, plus 64 times the file, or the largest of several) and processor time (60 s,
/// plus 2 s per MiB of all files; Load may set less for the first answer). A child that sends nothing for twice that
/// time is killed too. Tests: tests/io/child_reader_test.cpp
class ChildReader {
 public:
  /// Sequence of bytes of which answers are made.
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
    template <class T>
    void put_list(const std::vector<T>& list) {
      put(list.size());
      put(list.data(), list.size() * sizeof(T));
    }
    std::vector<char> take() { return std::move(bytes_); }

   private:
    std::vector<char> bytes_;
  };
  /// An answer as it is read.
  class Received {
   public:
    /// @param path  for messages
    Received(std::string path, std::vector<char> bytes) : path_(std::move(path)), bytes_(std::move(bytes)) {}
    template <class T>
    T get() {
      T value;
      get(&value, sizeof value);
      return value;
    }
    /// @throws InputError  past the end: a library that corrupted memory may answer anything
    void get(void* to, std::size_t size);
    std::string get_text();
    /// Reads a list written by put_list. @throws InputError  when its count exceeds the bytes left
    template <class T>
    std::vector<T> get_list() {
      std::vector<T> list(count_of(sizeof(T)));
      get(list.data(), list.size() * sizeof(T));
      return list;
    }
    std::size_t left() const { return bytes_.size() - at_; }

   private:
    std::size_t count_of(std::size_t size);
    std::string path_;
    std::vector<char> bytes_;
    std::size_t at_ = 0;
  };
  using Serve = std::function<void(int question, Answer& answer)>;

  /// @param serve  called in the child; its exceptions are rethrown by ask as InputError
  ChildReader(const std::string& path, Serve serve);
  /// Quantities that determine the limits, [bytes].
  struct Load {
    double largest = 0.0;  ///< largest file, for memory
    double all = 0.0;      ///< all files together, for time
    /// [s] of processor time until the first answer, for any size; 0: as for all answers.
    double opening = 0.0;
  };
  /// Load of one file.
  static Load load_of(const std::string& path);
  /// The same for several files. @param path  their common name in messages
  ChildReader(const std::string& path, const Load& load, Serve serve);
  ~ChildReader();
  ChildReader(const ChildReader&) = delete;
  ChildReader& operator=(const ChildReader&) = delete;

  /// @throws InputError  thrown by serve, or saying how the child ended
  Received ask(int question);
  /// Sets the file named in messages of the next questions.
  void about(const std::string& path) { path_ = path; }

  /// [s] base processor time for every file; 60 by default. For fuzzers and tests, which cannot wait for endless files.
  static void set_base_seconds(double seconds);
  /// True: readers made from now on answer in this process, without limits. For fuzzers, which have forked already and
  /// restart on failure: a fork takes milliseconds.
  static void answer_here(bool here);

 private:
  [[noreturn]] void fail();
  bool receive(void* to, std::size_t size);
  void end();

  std::string path_;
  Serve here_;  ///< for answers in this process
  double seconds_ = 0.0, bytes_ = 0.0;
  double opening_ = 0.0;  ///< [s] of processor time until the first answer
  bool answered_ = false;
  int child_ = -1, channel_ = -1;
};

}  // namespace brim
