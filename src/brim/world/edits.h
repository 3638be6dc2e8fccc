#pragma once

#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "brim/raster/shape.h"
#include "brim/world/world.h"

namespace brim {

/// Edits of a world between its steps that no coordinate records (docs/editing.md). Part of the world's state, in its
/// memory, so that a resumed run continues bit for bit:
///   memory: [−0.75, count of numbers, records ..., others ...]; nothing if nothing was edited
/// A record is its keyword, its count of numbers, and the numbers; texts are a length and their bytes.
/// Tests: tests/world/edits_test.cpp
struct Edits {
  std::set<int> removed, frozen;      ///< bodies
  std::map<int, Material> materials;  ///< of all parts of a body
  std::map<int, Pose> bases;          ///< poses of bodies relative to the start (MovableBase)
  std::map<std::pair<std::string, std::string>, PairMaterial> pairs;
  /// A rule without its regions, plus the number by which the world's PartFilter knows them.
  struct Rule {
    TouchRule rule;
    int region = -1;
  };
  std::vector<Rule> rules;  ///< after those of the options
  std::optional<Vec3> gravity;
  std::optional<double> stiffness;  ///< [Pa]

  /// Reads and removes its part of memory. Invalid entries are ignored. @param bodies  number in the world
  void take(std::vector<double>& memory, int bodies);
  /// Writes it in front of the rest of memory.
  void keep(std::vector<double>& memory) const;

 private:
  void read(std::span<const double> memory, int bodies);
};

/// Bodies of a state that were removed, ascending; for readers of recorded states.
std::vector<int> removed_in(const State& state);

}  // namespace brim
