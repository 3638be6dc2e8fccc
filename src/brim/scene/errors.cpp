#include "brim/scene/errors.h"

#include <algorithm>

namespace brim {

namespace {

constexpr std::size_t kMany = 1000;  // looking through more pointers would take longer than it helps

std::string joined(const std::vector<std::string>& messages) {
  std::string text;
  for (const std::string& m : messages) text += (text.empty() ? "" : "\n") + m;
  return text;
}

}  // namespace

InputErrors::InputErrors(std::vector<std::string> messages)
    : InputError(joined(messages)), messages_(std::move(messages)) {}

void ErrorList::add(const std::string& pointer, const std::string& message) {
  pointers_.push_back(pointer);
  if (std::find(messages_.begin(), messages_.end(), message) != messages_.end()) return;
  if (messages_.size() < kMost)
    messages_.push_back(message);
  else
    ++more_;
}

ErrorList ErrorList::marks() const {
  ErrorList list;
  list.pointers_ = pointers_;
  return list;
}

bool ErrorList::touches(const std::string& pointer) const {
  if (pointers_.size() > kMany) return true;
  return std::any_of(pointers_.begin(), pointers_.end(), [&](const std::string& p) {
    return p.starts_with(pointer) && (p.size() == pointer.size() || p[pointer.size()] == '/');
  });
}

bool ErrorList::holds(const std::string& pointer) const {
  return pointers_.size() <= kMany && std::find(pointers_.begin(), pointers_.end(), pointer) != pointers_.end();
}

void ErrorList::raise() const {
  if (messages_.empty()) return;
  if (messages_.size() == 1) throw InputError(messages_.front());
  std::vector<std::string> all = messages_;
  if (more_ > 0) all.push_back(fmt::format("and {} more", more_));
  throw InputErrors(std::move(all));
}

}  // namespace brim
