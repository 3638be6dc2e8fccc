#include "brim/record/export/names.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <set>

namespace brim::exporting {

namespace {

constexpr std::size_t kLongest = 120;    // bytes of a name; files take 255, with number and ending
constexpr std::size_t kFrameDigits = 5;  // at least, in the names of frames
constexpr char32_t kInvalid = 0xfffd;    // what is no UTF-8

bool ascii_letter(char32_t c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool ascii_digit(char32_t c) { return c >= '0' && c <= '9'; }

std::u32string decoded(std::string_view text) {
  std::u32string out;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i++]);
    const int more = byte < 0x80 ? 0 : byte >= 0xf0 && byte < 0xf5 ? 3 : byte >= 0xe0 ? 2 : byte >= 0xc2 ? 1 : -1;
    char32_t c = more < 0 || byte >= 0xf5 ? kInvalid : more == 0 ? byte : byte & (0x3fu >> more);
    for (int k = 0; k < more && c != kInvalid; ++k) {
      if (i == text.size() || (static_cast<unsigned char>(text[i]) & 0xc0u) != 0x80u)
        c = kInvalid;
      else
        c = c << 6 | (static_cast<unsigned char>(text[i++]) & 0x3fu);
    }
    out += c;
  }
  return out;
}

void append(std::string& out, char32_t c) {
  const auto byte = [&out](char32_t value) { out += static_cast<char>(value); };
  if (c < 0x80) return byte(c);
  if (c < 0x800)
    byte(0xc0 | c >> 6);
  else {
    if (c < 0x10000)
      byte(0xe0 | c >> 12);
    else
      byte(0xf0 | c >> 18), byte(0x80 | (c >> 12 & 0x3f));
    byte(0x80 | (c >> 6 & 0x3f));
  }
  byte(0x80 | (c & 0x3f));
}

/// Marks that some systems join with the letter before them, so that two spellings are one file.
bool combining(char32_t c) { return (c >= 0x300 && c <= 0x36f) || c == 0x3099 || c == 0x309a; }

/// Spaces, punctuation, symbols, directions of writing and what is private or no character.
bool no_letter(char32_t c) {
  constexpr std::array<std::array<char32_t, 2>, 14> kRanges = {{{0x80, 0xbf},
                                                                {0xd7, 0xd7},
                                                                {0xf7, 0xf7},
                                                                {0x1680, 0x1680},
                                                                {0x180e, 0x180e},
                                                                {0x2000, 0x2bff},
                                                                {0x2e00, 0x2e7f},
                                                                {0x3000, 0x3004},
                                                                {0x3008, 0x3020},
                                                                {0xd800, 0xf8ff},
                                                                {0xfe00, 0xfe6f},
                                                                {0xfeff, 0xff0f},
                                                                {0xffe0, 0xffff},
                                                                {0x1d000, 0x1d3ff}}};
  return c >= 0x1f000 || std::ranges::any_of(kRanges, [c](const auto& r) { return c >= r[0] && c <= r[1]; });
}

/// A letter of Latin, Greek or Cyrillic in English ones; "" for any other.
std::string english(char32_t c) {
  constexpr std::string_view kLatin1[] = {"A", "A", "A", "A", "A", "A", "Ae", "C", "E",  "E", "E",
                                          "E", "I", "I", "I", "I", "D", "N",  "O", "O",  "O", "O",
                                          "O", "",  "O", "U", "U", "U", "U",  "Y", "Th", "ss"};
  constexpr std::string_view kExtendedA =  // U+0100 to U+017F, in pairs of upper and lower case but for a few
      "AaAaAaCcCcCcCcDdDdEeEeEeEeEeGgGgGgGgHhHhIiIiIiIiIiIiJjKkkLlLlLlLlLlNnNnNnnNnOoOoOoOoRrRrRrSsSsSsSsTtTtTtUuUuUuUu"
      "Uu"
      "UuWwYyYZzZzZzs";
  constexpr std::string_view kGreek[] = {"a", "v", "g", "d", "e", "z", "i", "th", "i", "k",  "l",  "m", "n",
                                         "x", "o", "p", "r", "s", "s", "t", "y",  "f", "ch", "ps", "o"};
  constexpr std::string_view kCyrillic[] = {"a",  "b",  "v",  "g",    "d", "e", "zh", "z", "i",  "y", "k",
                                            "l",  "m",  "n",  "o",    "p", "r", "s",  "t", "u",  "f", "kh",
                                            "ts", "ch", "sh", "shch", "",  "y", "",   "e", "yu", "ya"};
  static_assert(kExtendedA.size() == 0x80 && std::size(kLatin1) == 0x20 && std::size(kCyrillic) == 0x20);
  const auto raised = [](std::string_view word) {
    std::string out(word);
    if (!out.empty()) out[0] = static_cast<char>(out[0] - 'a' + 'A');
    return out;
  };
  if (c >= 0xc0 && c < 0xe0) return std::string(kLatin1[c - 0xc0]);
  if (c == 0xff) return "y";
  if (c >= 0xe0 && c < 0xff) {
    std::string word(kLatin1[c - 0xe0]);
    if (!word.empty() && word[0] < 'a') word[0] = static_cast<char>(word[0] - 'A' + 'a');
    return word;
  }
  if (c >= 0x100 && c < 0x180) return std::string(1, kExtendedA[c - 0x100]);
  if (c >= 0x391 && c <= 0x3a9 && c != 0x3a2) return raised(kGreek[c - 0x391]);
  if (c >= 0x3b1 && c <= 0x3c9) return std::string(kGreek[c - 0x3b1]);
  constexpr std::u32string_view kAccented = U"άέήίόύώϊϋΐΰΆΈΉΊΌΎΏ";
  if (const auto at = kAccented.find(c); at != kAccented.npos) return std::string(1, "aeiioyoiyiyAEIIOYO"[at]);
  if (c >= 0x410 && c <= 0x42f) return raised(kCyrillic[c - 0x410]);
  if (c >= 0x430 && c <= 0x44f) return std::string(kCyrillic[c - 0x430]);
  return c == 0x401 ? "E" : c == 0x451 ? "e" : "";
}

/// Letters of scripts without upper and lower case.
bool caseless(char32_t c) {
  return (c >= 0x590 && c < 0x10a0) || (c >= 0x1200 && c < 0x13a0) || (c >= 0x1780 && c < 0x1880) ||
         (c >= 0x3040 && c < 0xa640) || (c >= 0xac00 && c < 0xd7a4) || (c >= 0x20000);
}

/// The same for all names that a file system may take for one. Letters that it may change and that are not known here
/// are all alike, which at worst numbers a name without need.
std::string key_of(std::string_view name) {
  std::string key;
  for (const char32_t c : decoded(name)) {
    const std::string word = c < 0x80 ? std::string(1, static_cast<char>(c)) : english(c);
    if (!word.empty())
      for (const char l : word) key += static_cast<char>(l >= 'A' && l <= 'Z' ? l - 'A' + 'a' : l);
    else if (caseless(c))
      append(key, c);
    else
      key += '?';
  }
  return key;
}

/// A name of a device, which Windows opens whatever the ending.
bool device(const std::string& key) {
  const std::string stem = key.substr(0, key.find('.'));
  if (stem == "con" || stem == "prn" || stem == "aux" || stem == "nul") return true;
  return stem.size() == 4 && (stem.starts_with("com") || stem.starts_with("lpt")) && ascii_digit(stem[3]);
}

std::string file_name(std::string_view name) {
  std::string out;
  for (const char32_t c : decoded(name)) {
    if (out.size() >= kLongest) break;
    if (combining(c)) continue;
    const bool kept = c < 0x80 ? ascii_letter(c) || ascii_digit(c) || c == '_' || c == '-' || c == '.' : !no_letter(c);
    append(out, kept ? c : U'_');
  }
  if (out.empty() || out.front() == '.') out.insert(out.begin(), '_');
  return device(key_of(out)) ? out + "_" : out;
}

/// "ball" of "ball_00001"; empty where a name is not that of a frame.
std::string body_of_frame(const std::string& key) {
  const std::size_t end = key.find_last_not_of("0123456789");
  return end != key.npos && end > 0 && key[end] == '_' && key.size() - end > kFrameDigits ? key.substr(0, end) : "";
}

/// Names of files that are taken, by their keys.
class TakenFiles {
 public:
  TakenFiles() { take("contacts"); }
  /// The name, or the first of "name_2", "name_3", ... that is no other's.
  std::string unique(const std::string& name) {
    std::string found = name;
    for (int n = 2; !free(key_of(found)); ++n) found = fmt::format("{}_{}", name, n);
    take(key_of(found));
    return found;
  }

 private:
  bool free(const std::string& key) const {
    return !keys_.contains(key) && !keys_.contains(body_of_frame(key)) && !bodies_of_frames_.contains(key);
  }
  void take(const std::string& key) {
    keys_.insert(key);
    if (const std::string body = body_of_frame(key); !body.empty()) bodies_of_frames_.insert(body);
  }
  std::set<std::string> keys_, bodies_of_frames_;
};

}  // namespace

std::vector<std::string> file_names(const std::vector<std::string>& bodies) {
  std::vector<std::string> wanted;
  std::vector<int> rank;  // whose wish comes first: what needs no change, and what is no frame of another
  for (const std::string& body : bodies) {
    wanted.push_back(file_name(body));
    rank.push_back((wanted.back() == body ? 0 : 1) + (body_of_frame(key_of(wanted.back())).empty() ? 0 : 2));
  }
  std::vector<std::size_t> order(bodies.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t b) { return rank[b]; });
  TakenFiles taken;
  std::vector<std::string> names(bodies.size());
  for (const std::size_t b : order) names[b] = taken.unique(wanted[b]);
  return names;
}

std::vector<std::string> identifiers(const std::vector<std::string>& names, std::vector<std::string> taken) {
  std::set<std::string> used(taken.begin(), taken.end());
  std::vector<std::string> list;
  for (const std::string& name : names) {
    std::string word;
    for (const char32_t c : decoded(name)) {
      if (combining(c)) continue;
      if (c < 0x80)
        word += ascii_letter(c) || ascii_digit(c) ? static_cast<char>(c) : '_';
      else if (no_letter(c))
        word += '_';
      else
        word += english(c).empty() ? fmt::format("u{:04x}", static_cast<std::uint32_t>(c)) : english(c);
    }
    if (word.empty() || ascii_digit(static_cast<unsigned char>(word[0]))) word.insert(word.begin(), '_');
    std::string unique = word;
    for (int n = 2; !used.insert(unique).second; ++n) unique = fmt::format("{}_{}", word, n);
    list.push_back(std::move(unique));
  }
  return list;
}

}  // namespace brim::exporting
