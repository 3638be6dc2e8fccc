#include <charconv>
#include <optional>

#include "brim/core/error.h"
#include "brim/record/export/export.h"

namespace brim {

namespace {

std::optional<std::int64_t> whole_number(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

FrameRange parse_frames(const std::string& text, std::int64_t frames) {
  const auto refuse = [&](const std::string& why) { throw InputError(fmt::format("frames \"{}\": {}", text, why)); };
  if (frames <= 0) throw InputError("the run holds no frame yet");
  FrameRange range{0, frames - 1, 1};
  if (text.empty()) return range;
  std::array<std::string_view, 3> field;
  std::size_t fields = 0;
  for (std::string_view rest = text;; rest.remove_prefix(rest.find(':') + 1)) {
    if (fields == field.size()) refuse("must be first:last or first:last:stride");
    field[fields++] = rest.substr(0, rest.find(':'));
    if (rest.find(':') == std::string_view::npos) break;
  }
  const auto frame = [&](std::string_view word, std::int64_t otherwise) {
    if (word.empty()) return otherwise;
    const auto n = whole_number(word);
    if (!n) refuse("must be first:last or first:last:stride, in whole numbers");
    const std::int64_t f = *n < 0 ? *n + frames : *n;
    if (f < 0 || f >= frames) refuse(fmt::format("frame {} is not there; the run has frames 0 to {}", *n, frames - 1));
    return f;
  };
  range.first = frame(field[0], 0);
  range.last = fields == 1 ? range.first : frame(field[1], frames - 1);
  if (fields == 3 && !field[2].empty()) {
    const auto n = whole_number(field[2]);
    if (!n || *n < 1) refuse("the stride must be a whole number from 1 on");
    range.stride = *n;
  }
  if (range.last < range.first) refuse("the last frame comes before the first");
  range.last = range.first + (range.count() - 1) * range.stride;
  return range;
}

}  // namespace brim
