#include "brim/scene/pairs/pair_log.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <string_view>

#include "brim/core/error.h"
#include "brim/scene/document.h"

namespace brim {

namespace {

constexpr std::string_view kStart = R"({"by":)";

/// Figures and their names, in one place for both directions.
template <class Result, class Visit>
void each_figure(Result& r, Visit&& visit) {
  visit("linear", r.linear), visit("lever", r.lever), visit("drift", r.drift), visit("overlap", r.overlap);
  visit("energy", r.energy), visit("leak", r.leak), visit("motion", r.motion), visit("speed", r.speed);
  visit("under", r.under), visit("carried", r.carried), visit("force_lower", r.force_lower);
  visit("force_upper", r.force_upper), visit("seconds", r.seconds);
}

Json to_json(const PairResult& r) {
  Json pair = {{"lower", r.lower}, {"upper", r.upper},       {"run", r.run},
               {"steps", r.steps}, {"contacts", r.contacts}, {"failures", r.failures}};
  each_figure(r, [&](const char* name, double x) { pair[name] = x; });
  return pair;
}

PairResult from_json(const Json& pair) {
  PairResult r;
  pair.at("lower").get_to(r.lower), pair.at("upper").get_to(r.upper), pair.at("run").get_to(r.run);
  pair.at("steps").get_to(r.steps), pair.at("contacts").get_to(r.contacts), pair.at("failures").get_to(r.failures);
  // What is not finite has no number in JSON.
  each_figure(r, [&](const char* name, double& x) {
    x = pair.at(name).is_null() ? std::numeric_limits<double>::quiet_NaN() : pair.at(name).get<double>();
  });
  return r;
}

std::string what_decides(const PairTable& table, const PairKind& a, const PairKind& b) {
  const PairBounds& p = table.bounds;
  Json what = {{"scene", Json::parse(pair_scene_text(table, a, b))},
               {"bounds", {p.overlap, p.energy, p.drift, p.leak, p.speed, p.carried}}};
  for (const PairKind* kind : {&a, &b})
    what["kinds"].push_back({kind->lowest, kind->highest, kind->linear, kind->lever, kind->rolls});
  return what.dump();
}

}  // namespace

PairLog::PairLog(std::string path, std::string version) : path_(std::move(path)), version_(std::move(version)) {
  if (!std::filesystem::exists(path_)) return;
  std::ifstream file(path_, std::ios::binary);
  std::string line;
  std::uintmax_t whole = 0;  // bytes
  for (int number = 1; std::getline(file, line); ++number) {
    const Json entry = Json::parse(line, nullptr, false);
    if (file.eof() && entry.is_discarded() && line.starts_with(kStart)) {  // cut short as it was written
      file.close();
      std::filesystem::resize_file(path_, whole);
      return;
    }
    whole += line.size() + 1;
    try {
      if (entry.at("by") == version_) results_[entry.at("what").dump()] = from_json(entry.at("pair"));
    } catch (const Json::exception&) {
      throw InputError(fmt::format(
          "{}:{}: not a line of figures of pairs; give the file of an earlier run, or a new one", path_, number));
    }
  }
  if (file.bad() || !file.eof()) throw InputError(fmt::format("{}: the file cannot be read", path_));
}

const PairResult* PairLog::find(const PairTable& table, const PairKind& a, const PairKind& b) const {
  const auto found = results_.find(what_decides(table, a, b));
  return found == results_.end() ? nullptr : &found->second;
}

void PairLog::add(const PairTable& table, const PairKind& a, const PairKind& b, const PairResult& result) {
  const std::string what = what_decides(table, a, b);
  Json entry;
  entry["by"] = version_;
  entry["what"] = Json::parse(what);
  entry["pair"] = to_json(result);
  const std::filesystem::path path = path_;
  std::error_code error;  // told by the stream below
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  std::ofstream file(path, std::ios::binary | std::ios::app);
  file << entry.dump() << "\n";
  file.close();
  if (!file) throw InputError(fmt::format("{}: the file cannot be written", path_));
  results_[what] = result;
}

}  // namespace brim
