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
/// processor time (60 s, plus 2 s per MiB of the file, or of all; for the first answer less where Load says so); a
/// child from which nothing comes for twice that time is ended as well. Tests: tests/io/child_reader_test.cpp
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
    template <class T>
    void put_list(const std::vector<T>& list) {
      put(list.size());
      put(list.data(), list.size() * sizeof(T));
    }
    std::vector<char> take() { return std::move(bytes_); }

   private:
    std::vector<char> bytes_;
  };
  /// The same as they are read.
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
    /// @throws InputError  past the end: a library that wrote beyond its memory may answer anything
    void get(void* to, std::size_t size);
    std::string get_text();
    /// What put_list put. @throws InputError  when more are promised than are there
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

  /// @param serve  called in the child; InputErrors and other exceptions out of it are those of ask
  ChildReader(const std::string& path, Serve serve);
  /// What the limits follow from. [bytes]
  struct Load {
    double largest = 0.0;  ///< file, for memory
    double all = 0.0;      ///< of the files together, for time
    /// [s] of processor time until the first answer, whatever the size; 0: as for all answers.
    double opening = 0.0;
  };
  /// Of one file.
  static Load load_of(const std::string& path);
  /// The same of several files. @param path  what they are called together, in messages
  ChildReader(const std::string& path, const Load& load, Serve serve);
  ~ChildReader();
  ChildReader(const ChildReader&) = delete;
  ChildReader& operator=(const ChildReader&) = delete;

  /// @throws InputError  what serve threw, or how the child ended
  Received ask(int question);
  /// Which of several files the next questions are about, for messages.
  void about(const std::string& path) { path_ = path; }

  /// [s] of processor time that every file may take, whatever its size; 60 where nothing else was set. For fuzzers and
  /// tests, which have no time for files without end.
  static void set_base_seconds(double seconds);
  /// Whether readers made from now on answer in this process, with no limits of their own. For fuzzers, which have
  /// forked already and begin anew when it ends: a fork takes milliseconds.
  static void answer_here(bool here);

 private:
  [[noreturn]] void fail();
  bool receive(void* to, std::size_t size);
  void end();

  std::string path_;
  Serve here_;  ///< where it answers in this process
  double seconds_ = 0.0, bytes_ = 0.0;
  double opening_ = 0.0;  ///< [s] of processor time until the first answer
  bool answered_ = false;
  int child_ = -1, channel_ = -1;
};

}  // namespace brim
