#include "brim/world/edits.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "brim/world/levels.h"

namespace brim {

namespace {

/// First number of edits in memory; differs from those of Levels, Links, Sleep and ReferencePoses.
constexpr double kEditsMark = -0.75;

/// Keywords of records.
enum Word : int { kNone, kRemoved, kFrozen, kGravity, kStiffness, kMaterial, kPair, kRule, kBase };

/// Writes records.
class RecordWriter {
 public:
  explicit RecordWriter(std::vector<double>& out) : out_(out) {}
  void begin(Word word) {
    out_.insert(out_.end(), {static_cast<double>(word), 0.0});
    start_ = out_.size();
  }
  void number(double x) { out_.push_back(x); }
  void text(const std::string& s) {
    number(static_cast<double>(s.size()));
    for (const char c : s) number(static_cast<unsigned char>(c));
  }
  void end() { out_[start_ - 1] = static_cast<double>(out_.size() - start_); }

 private:
  std::vector<double>& out_;
  std::size_t start_ = 0;
};

/// Reads the numbers of a record; zeros past their end.
class RecordReader {
 public:
  explicit RecordReader(std::span<const double> numbers) : numbers_(numbers) {}
  double number() { return at_ < numbers_.size() ? numbers_[at_++] : (good_ = false, 0.0); }
  int whole(int least, int most) {
    const double x = number();
    good_ = good_ && x >= least && x <= most;
    return good_ ? static_cast<int>(x) : least;
  }
  std::string text() {
    std::string s(static_cast<std::size_t>(whole(0, static_cast<int>(numbers_.size()))), ' ');
    for (char& c : s) c = static_cast<char>(static_cast<unsigned char>(whole(0, 255)));
    return s;
  }
  Response response() { return static_cast<Response>(whole(0, 2)); }
  bool good() const { return good_; }

 private:
  std::span<const double> numbers_;
  std::size_t at_ = 0;
  bool good_ = true;
};

/// Count of numbers that belong to edits, mark included; 0 without mark.
std::size_t size_in(std::span<const double> memory) {
  if (memory.size() < 2 || memory[0] != kEditsMark || !(memory[1] >= 0.0)) return 0;
  return 2 + static_cast<std::size_t>(std::min(memory[1], static_cast<double>(memory.size() - 2)));
}

Word word_of(double x) {
  return x >= 1.0 && x <= static_cast<double>(kBase) ? static_cast<Word>(static_cast<int>(x)) : kNone;
}

/// Calls f(word, reader) for the records of a memory that begins with edits.
template <class F>
void for_records(std::span<const double> memory, const F& f) {
  std::size_t at = 2;
  const std::size_t end = size_in(memory);
  while (at + 2 <= end) {
    const Word word = word_of(memory[at]);
    const double numbers = memory[at + 1];
    at += 2;
    if (!(numbers >= 0.0) || numbers > static_cast<double>(end - at)) return;
    const auto n = static_cast<std::size_t>(numbers);
    f(word, RecordReader(memory.subspan(at, n)));
    at += n;
  }
}

}  // namespace

void Edits::take(std::vector<double>& memory, int bodies) {
  // In a run of steps nothing is new.
  std::vector<double> known;
  keep(known);
  const auto own_end = memory.begin() + static_cast<std::ptrdiff_t>(size_in(memory));
  if (!std::equal(memory.begin(), own_end, known.begin(), known.end())) read(memory, bodies);
  memory.erase(memory.begin(), own_end);
}

void Edits::read(std::span<const double> memory, int bodies) {
  *this = {};
  for_records(memory, [&](Word word, RecordReader r) {
    if (word == kRemoved) {
      if (const int b = r.whole(0, bodies - 1); r.good()) removed.insert(b);
    } else if (word == kFrozen) {
      if (const int b = r.whole(0, bodies - 1); r.good()) frozen.insert(b);
    } else if (word == kGravity) {
      const double x = r.number(), y = r.number(), z = r.number();
      if (r.good() && Vec3(x, y, z).allFinite()) gravity = Vec3(x, y, z);
    } else if (word == kStiffness) {
      if (const double k = r.number(); k > 0.0 && std::isfinite(k)) stiffness = k;
    } else if (word == kMaterial) {
      const int b = r.whole(0, bodies - 1);
      Material m;
      m.friction = r.number(), m.restitution = r.number(), m.response = r.response(), m.name = r.text();
      const bool good =
          r.good() && m.friction >= 0.0 && std::isfinite(m.friction) && m.restitution >= 0.0 && m.restitution <= 1.0;
      const double rolling = r.number();  // only of those that have some
      if (r.good() && rolling >= 0.0 && std::isfinite(rolling)) m.rolling_resistance = rolling;
      if (good) materials[b] = m;
    } else if (word == kPair) {
      PairMaterial p;
      p.friction = r.number(), p.stiffness = r.number(), p.restitution = r.number(), p.response = r.response();
      const std::string a = r.text(), b = r.text();
      const bool sane = std::isfinite(p.friction) && p.stiffness >= 0.0 && std::isfinite(p.stiffness);
      const bool good = r.good() && sane && p.restitution <= 1.0;
      const double rolling = r.number();  // only of those that have their own
      if (r.good() && std::isfinite(rolling)) p.rolling_resistance = rolling;
      if (good) pairs[{a, b}] = p;
    } else if (word == kBase) {
      const int b = r.whole(0, bodies - 1);
      Pose base;
      for (double& x : base.translation) x = r.number();
      for (double& x : base.rotation.reshaped()) x = r.number();
      if (r.good() && base.translation.allFinite() && base.rotation.isUnitary(1e-6)) bases[b] = base;
    } else if (word == kRule) {
      TouchRule rule;
      rule.touch = r.whole(0, 1) == 1, rule.a = r.text(), rule.b = r.text();
      const bool good = r.good();
      const double region = r.number();  // only of those that have one
      if (good) rules.push_back({rule, r.good() && region >= 0.0 && region < 1e6 ? static_cast<int>(region) : -1});
    }
  });
}

void Edits::keep(std::vector<double>& memory) const {
  std::vector<double> head = {kEditsMark, 0.0};
  RecordWriter w(head);
  const auto record = [&](Word word, const auto& write) {
    w.begin(word);
    write();
    w.end();
  };
  for (const int b : removed) record(kRemoved, [&] { w.number(b); });
  for (const int b : frozen) record(kFrozen, [&] { w.number(b); });
  if (gravity)
    record(kGravity, [&] {
      for (const double x : *gravity) w.number(x);
    });
  if (stiffness) record(kStiffness, [&] { w.number(*stiffness); });
  for (const auto& [b, m] : materials)
    record(kMaterial, [&] {
      w.number(b), w.number(m.friction), w.number(m.restitution), w.number(static_cast<double>(m.response));
      w.text(m.name);
      if (m.rolling_resistance > 0.0) w.number(m.rolling_resistance);
    });
  for (const auto& [b, base] : bases)
    record(kBase, [&] {
      w.number(b);
      for (const double x : base.translation) w.number(x);
      for (const double x : base.rotation.reshaped()) w.number(x);
    });
  for (const auto& [names, p] : pairs)
    record(kPair, [&] {
      w.number(p.friction), w.number(p.stiffness), w.number(p.restitution), w.number(static_cast<double>(p.response));
      w.text(names.first), w.text(names.second);
      if (!(p.rolling_resistance < 0.0)) w.number(p.rolling_resistance);
    });
  for (const auto& [rule, region] : rules)
    record(kRule, [&] {
      w.number(rule.touch), w.text(rule.a), w.text(rule.b);
      if (region >= 0) w.number(region);
    });
  if (head.size() == 2) return;
  head[1] = static_cast<double>(head.size() - 2);
  memory.insert(memory.begin(), head.begin(), head.end());
}

std::vector<int> removed_in(const State& state) {
  std::vector<double> memory = state.warm_start;
  Levels().take(memory, {});
  std::vector<int> out;
  for_records(memory, [&](Word word, RecordReader r) {
    if (word != kRemoved) return;
    if (const int b = r.whole(0, 1 << 30); r.good()) out.push_back(b);
  });
  return out;
}

}  // namespace brim
