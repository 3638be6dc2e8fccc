#include "brim/scene/document.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

#include "brim/core/error.h"
#include "brim/core/printable.h"
#include "brim/scene/syntax_hint.h"

namespace brim {

namespace {

constexpr std::size_t kMaxDepth = 64;
constexpr std::size_t kMaxKey = 256;
constexpr std::uintmax_t kMaxBytes = std::uintmax_t{64} << 20;

/// Where the parser stands: the line of the last character it took.
struct Cursor {
  int next = 1, last = 1;
};

/// Walks over the text and keeps the cursor up to date; copies share it.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* at, Cursor* cursor) : at_(at), cursor_(cursor) {}
  reference operator*() const { return *at_; }
  CountingIterator& operator++() {
    cursor_->last = cursor_->next;
    if (*at_++ == '\n') ++cursor_->next;
    return *this;
  }
  CountingIterator operator++(int) {
    CountingIterator old = *this;
    ++*this;
    return old;
  }
  bool operator==(const CountingIterator& o) const { return at_ == o.at_; }
  bool operator!=(const CountingIterator& o) const { return at_ != o.at_; }

 private:
  const char* at_;
  Cursor* cursor_;
};

/// Builds the tree from the parser's events and notes the line of each value.
class TreeBuilder : public nlohmann::json_sax<Json> {
 public:
  TreeBuilder(Document& document, const Cursor& cursor) : doc_(document), cursor_(cursor) {}

  bool null() override { return put(nullptr); }
  bool boolean(bool b) override { return put(b); }
  bool number_integer(number_integer_t x) override { return put(x); }
  bool number_unsigned(number_unsigned_t x) override { return put(x); }
  bool number_float(number_float_t x, const string_t&) override { return put(x); }
  bool string(string_t& s) override { return put(s); }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(Json::object()); }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_array() override { return close(); }

  bool key(string_t& k) override {
    need_plain(k);
    key_ = k;
    const std::string pointer = stack_.back().pointer + "/" + pointer_token(k);
    if (stack_.back().value->contains(k))
      throw InputError(fmt::format("{}:{}: {}: the key \"{}\" is given twice (first on line {}); once is allowed",
                                   doc_.file, cursor_.last, pointer, k, doc_.line.at(pointer)));
    doc_.line[pointer] = cursor_.last;
    return true;
  }

  bool parse_error(std::size_t end, const std::string& last, const nlohmann::detail::exception& e) override {
    const std::string where = stack_.empty() ? "" : stack_.back().pointer;
    std::string what = e.what();
    // The library's prefix ("[json.exception...] parse error at line 1, column 2: ") repeats what we say ourselves.
    if (const auto cut = what.find("column "); cut != std::string::npos)
      if (const auto colon = what.find(": ", cut); colon != std::string::npos) what = what.substr(colon + 2);
    if (const auto cut = what.find("] "); what.starts_with("[") && cut != std::string::npos)
      what = what.substr(cut + 2);
    if (const auto hint = syntax_hint(std::string_view(doc_.text).substr(0, end), what))
      throw InputError(fmt::format("{}:{}: {}: not valid JSON: {}", doc_.file, hint->line, where.empty() ? "/" : where,
                                   hint->message));
    const bool not_number = last.find("NaN") != std::string::npos || last.find("nan") != std::string::npos ||
                            last.find("Inf") != std::string::npos || last.ends_with("N") || last.ends_with("I");
    if (not_number) what += "; NaN and Infinity are not allowed, numbers must be finite";
    if (what.starts_with("number overflow")) what += "; numbers must be finite, at most 1.8e308";
    throw InputError(
        fmt::format("{}:{}: {}: not valid JSON: {}", doc_.file, cursor_.last, where.empty() ? "/" : where, what));
  }

 private:
  struct Level {
    Json* value;
    std::string pointer;
  };

  /// Keys are repeated in messages, and by the places of all that is below them.
  void need_plain(const std::string& k) const {
    if (k.size() <= kMaxKey && printable(k) == k) return;
    throw InputError(
        fmt::format("{}:{}: {}: the key \"{}\" is not allowed; a key has at most {} bytes and no control characters",
                    doc_.file, cursor_.last, stack_.back().pointer.empty() ? "/" : stack_.back().pointer,
                    printable(k.substr(0, 60)) + (k.size() > 60 ? "..." : ""), kMaxKey));
  }

  /// Adds a value to the innermost container and returns it.
  Json* add(Json value) {
    if (stack_.empty()) {
      doc_.root = std::move(value);
      doc_.line[""] = cursor_.last;
      pointer_.clear();
      return &doc_.root;
    }
    Level& top = stack_.back();
    if (top.value->is_array()) {
      pointer_ = top.pointer + "/" + std::to_string(top.value->size());
      doc_.line[pointer_] = cursor_.last;
      top.value->push_back(std::move(value));
      return &top.value->back();
    }
    pointer_ = top.pointer + "/" + pointer_token(key_);
    return &((*top.value)[key_] = std::move(value));
  }
  bool put(Json value) {
    add(std::move(value));
    return true;
  }
  bool open(Json value) {
    if (stack_.size() >= kMaxDepth)
      throw InputError(fmt::format("{}:{}: nested deeper than {} levels, which is the most that is allowed", doc_.file,
                                   cursor_.last, kMaxDepth));
    Json* at = add(std::move(value));
    stack_.push_back({at, pointer_});
    return true;
  }
  bool close() {
    stack_.pop_back();
    return true;
  }

  Document& doc_;
  const Cursor& cursor_;
  std::vector<Level> stack_;
  std::string key_, pointer_;
};

}  // namespace

int Document::line_of(std::string pointer) const {
  for (;;) {
    if (const auto it = line.find(pointer); it != line.end()) return it->second;
    if (pointer.empty()) return 1;
    pointer.erase(pointer.rfind('/'));
  }
}

bool Document::has_place(const std::string& message) const {
  if (message.starts_with(file + ":")) return true;
  for (const auto& [unused, origin] : origins)
    if (origin.document->has_place(message)) return true;
  return false;
}

std::string Document::place(const std::string& pointer) const {
  for (std::string at = pointer; !origins.empty() && !at.empty(); at.erase(at.rfind('/')))
    if (const auto it = origins.find(at); it != origins.end())
      return it->second.document->place(it->second.pointer + pointer.substr(at.size()));
  return fmt::format("{}:{}: {}", file, line_of(pointer), pointer.empty() ? "/" : pointer);
}

Document parse_document(std::string_view text, const std::string& file) {
  Document doc;
  doc.file = file;
  doc.text = text;
  Cursor cursor;
  TreeBuilder builder(doc, cursor);
  const char* first = doc.text.data();
  Json::sax_parse(CountingIterator(first, &cursor), CountingIterator(first + doc.text.size(), &cursor), &builder,
                  Json::input_format_t::json, true, true);
  return doc;
}

Document read_document(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw InputError(fmt::format("{}: no such file", path));
  if (fs::is_directory(status)) throw InputError(fmt::format("{}: is a folder; a scene is a JSON file", path));
  if (fs::is_regular_file(status) && fs::file_size(path, error) > kMaxBytes)
    throw InputError(fmt::format("{}: {} bytes; at most {} are allowed", path, fs::file_size(path, error), kMaxBytes));
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(fmt::format("{}: cannot be opened for reading", path));
  // Pipes are welcome, and so may be asked for what never ends.
  std::string bytes;
  std::vector<char> part(1 << 20);
  while (in.read(part.data(), static_cast<std::streamsize>(part.size())) || in.gcount() > 0) {
    bytes.append(part.data(), static_cast<std::size_t>(in.gcount()));
    if (bytes.size() > kMaxBytes)
      throw InputError(fmt::format("{}: more than {} bytes; at most that many are allowed", path, kMaxBytes));
  }
  if (in.bad()) throw InputError(fmt::format("{}: cannot be read to the end", path));
  return parse_document(bytes, path);
}

std::string pointer_token(std::string_view key) {
  std::string token;
  for (const char c : key) {
    if (c == '~')
      token += "~0";
    else if (c == '/')
      token += "~1";
    else
      token += c;
  }
  return token;
}

std::string shown(const Json& value) {
  std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

bool has_words(std::string_view name, std::string_view part) {
  const auto at = part.empty() ? std::string_view::npos : name.find(part);
  if (at == std::string_view::npos || part.size() == name.size()) return false;
  const auto end = at + part.size();
  return (at == 0 || name[at - 1] == '_') && (end == name.size() || name[end] == '_');
}

int edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<int>> d(a.size() + 1, std::vector<int>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = static_cast<int>(i);
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

}  // namespace brim
