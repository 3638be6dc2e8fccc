#include "brim/scene/syntax_hint.h"

#include <fmt/format.h>

#include "brim/core/printable.h"

namespace brim {

namespace {

struct JsonToken {
  std::string_view text;
  int line = 1;
};

/// Reads JSON with comments token by token, as far as the text goes.
class JsonTokens {
 public:
  explicit JsonTokens(std::string_view text) : text_(text) {}

  /// False at the end.
  bool next(JsonToken& token) {
    skip();
    if (at_ >= text_.size()) return false;
    const std::size_t begin = at_;
    token.line = line_;
    if (text_[at_] == '"')
      pass_string();
    else if (kMarks.find(text_[at_]) != std::string_view::npos)
      ++at_;
    else
      while (at_ < text_.size() && (kMarks.find(text_[at_]) == std::string_view::npos) &&
             kSpace.find(text_[at_]) == std::string_view::npos && text_[at_] != '"' && text_[at_] != '/')
        ++at_;
    if (at_ == begin) ++at_;
    token.text = text_.substr(begin, at_ - begin);
    return true;
  }

 private:
  static constexpr std::string_view kMarks = "{}[]:,", kSpace = " \t\r\n";

  void step() { line_ += text_[at_++] == '\n'; }

  void pass_string() {
    for (++at_; at_ < text_.size() && text_[at_] != '"'; step())
      if (text_[at_] == '\\' && at_ + 1 < text_.size()) ++at_;
    if (at_ < text_.size()) ++at_;
  }

  /// Spaces and comments.
  void skip() {
    while (at_ < text_.size()) {
      const std::string_view rest = text_.substr(at_);
      if (kSpace.find(rest.front()) != std::string_view::npos) {
        step();
      } else if (rest.starts_with("//")) {
        while (at_ < text_.size() && text_[at_] != '\n') step();
      } else if (rest.starts_with("/*")) {
        const auto end = rest.find("*/", 2);
        for (const std::size_t to = end == std::string_view::npos ? text_.size() : at_ + end + 2; at_ < to;) step();
      } else {
        return;
      }
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

bool begins_value(const JsonToken& t) {
  return std::string_view("}]:,").find(t.text.front()) == std::string_view::npos;
}
bool ends_value(const JsonToken& t) { return std::string_view("{[:,").find(t.text.front()) == std::string_view::npos; }

std::string token_text(const JsonToken& t) {
  constexpr std::size_t kMost = 40;
  return t.text.size() > kMost ? printable(t.text.substr(0, kMost)) + "..." : printable(t.text);
}

}  // namespace

std::optional<SyntaxHint> syntax_hint(std::string_view text, std::string_view complaint) {
  if (complaint.find("unexpected") == std::string_view::npos) return std::nullopt;
  JsonToken before, last, token;
  int count = 0;
  for (JsonTokens tokens(text); tokens.next(token); ++count) before = last, last = token;
  if (count < 2) return std::nullopt;
  const auto expected = [&](std::string_view what) { return complaint.find(what) != std::string_view::npos; };
  if (before.text == "," && (last.text == "]" || last.text == "}" || last.text == ","))
    return SyntaxHint{before.line, fmt::format("a comma too many before '{}'", last.text)};
  if (expected("expected ':'"))
    return SyntaxHint{before.line, fmt::format("a colon is missing after {}", token_text(before))};
  const bool within = expected("expected '}'") || expected("expected ']'");
  if (within && ends_value(before) && begins_value(last))
    return SyntaxHint{before.line, fmt::format("a comma is missing after {}", token_text(before))};
  return std::nullopt;
}

}  // namespace brim
