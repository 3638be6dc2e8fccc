#pragma once

#include <map>
#include <string>

#include "brim/scene/pairs/pair_trial.h"

namespace brim {

/// Figures of pairs that have run, kept in a file, so that an interrupted table goes on where it ended.
///
/// A line of JSON each: {"by": version, "what": all that decides the figures, "pair": the figures}. Lines of another
/// version, of another scene or bound, and a last one that was cut short are left alone. Files of several processes may
/// be put together. Whether a plugin has changed is not seen.
class PairLog {
 public:
  /// @param version  of the program that runs the pairs
  /// @throws InputError  for a file that cannot be read; one that is not there is made by add()
  PairLog(std::string path, std::string version);

  /// Figures of this pair of these kinds, or nullptr. @param a, b  as for run_pair
  const PairResult* find(const PairTable& table, const PairKind& a, const PairKind& b) const;
  /// @throws InputError  when the file cannot be written
  void add(const PairTable& table, const PairKind& a, const PairKind& b, const PairResult& result);

 private:
  std::string path_, version_;
  std::map<std::string, PairResult> results_;  ///< by what decides them
};

}  // namespace brim
