#pragma once

#include <map>
#include <string>

#include "brim/scene/pairs/pair_trial.h"

namespace brim {

/// Results of finished pairs, stored in a file, so that an interrupted table can continue.
///
/// One JSON object per line: {"by": version, "what": everything that determines the results, "pair": the results}.
/// Lines of another version, scene or bound, and a truncated last line are ignored. Files of several processes may be
/// concatenated. Changes of a plugin are not detected.
class PairLog {
 public:
  /// @param version  of the program that runs the pairs
  /// @throws InputError  for a file that cannot be read; a missing one is created by add()
  PairLog(std::string path, std::string version);

  /// Results of this pair, or nullptr. @param a, b  as for run_pair
  const PairResult* find(const PairTable& table, const PairKind& a, const PairKind& b) const;
  /// @throws InputError  when the file cannot be written
  void add(const PairTable& table, const PairKind& a, const PairKind& b, const PairResult& result);

 private:
  std::string path_, version_;
  std::map<std::string, PairResult> results_;  ///< by everything that determines them
};

}  // namespace brim
