#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace brim {

/// JSON with keys in their written order.
using Json = nlohmann::ordered_json;

struct GivenArrays;  // brim/scene/given_arrays.h

/// A JSON text with the position of each of its values.
struct Document {
  std::string file;  ///< as given by the user
  std::string text;  ///< the bytes as read
  Json root;
  std::map<std::string, int> line;  ///< JSON pointer -> line, from 1; for members of objects that of the key
  std::shared_ptr<const GivenArrays> arrays{};  ///< in-memory data in place of files; may be null

  /// Source of a value that came from another file (an "include").
  struct Origin {
    std::shared_ptr<const Document> document;
    std::string pointer;
  };
  std::map<std::string, Origin> origins{};  ///< JSON pointer here -> source, with everything below it
  Json parameters{};                        ///< values of the scene's parameters, by name; an object or null

  /// Line of a pointer, or of its nearest ancestor in the file (defaults have no line).
  int line_of(std::string pointer) const;
  /// True for a message that begins with a place of this document or of an included one.
  bool has_place(const std::string& message) const;
  /// "file:line: pointer: message", the form of every error message about a document.
  std::string place(const std::string& pointer) const;
};

/// Reads JSON (RFC 8259) with // and /* */ comments.
/// @throws InputError  naming file, line and cause: bad syntax, a duplicate key, NaN, infinite or overflowing numbers,
///                     invalid UTF-8, more than 64 levels
Document parse_document(std::string_view text, const std::string& file);

/// @throws InputError  likewise, and when the file cannot be read or exceeds 64 MiB
Document read_document(const std::string& path);

/// One token of a JSON pointer (RFC 6901): "/" becomes "~1" and "~" becomes "~0".
std::string pointer_token(std::string_view key);

/// A value for messages: compact JSON, truncated when long.
std::string shown(const Json& value);

/// The word of `known` that `word` may have meant: one that differs by a letter; else the shortest one that consists of
/// `word` and more, as young_modulus of young; else the nearest in edit distance, if at most a third of it differs, or
/// "".
template <class Words>
std::string nearest_word(std::string_view word, const Words& known);

/// True when `part` is a run of whole words of `name`, which are joined by underscores, but not all of it.
bool has_words(std::string_view name, std::string_view part);

/// Edit distance (Levenshtein): smallest number of inserted, removed or replaced letters; a swap of neighbours counts
/// as one.
int edit_distance(std::string_view a, std::string_view b);

template <class Words>
std::string nearest_word(std::string_view word, const Words& known) {
  std::string near, whole;
  int least = 1 + static_cast<int>(word.size() + 2) / 3;
  for (const auto& candidate : known) {
    if (has_words(candidate, word) && (whole.empty() || candidate.size() < whole.size())) whole = candidate;
    // The distance is at least the difference of the lengths.
    const auto apart = std::max(word.size(), candidate.size()) - std::min(word.size(), candidate.size());
    if (apart >= static_cast<std::size_t>(least)) continue;
    const int d = edit_distance(word, candidate);
    if (d < least) {
      least = d;
      near = candidate;
    }
  }
  return whole.empty() || (!near.empty() && least <= 1) ? near : whole;
}

}  // namespace brim
