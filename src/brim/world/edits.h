#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "brim/raster/shape.h"
#include "brim/world/world.h"

namespace brim {

/// What was said about a world between its steps that no coordinate shows (docs/editing.md). Part of the world's state,
/// in its memory, so that a run that is resumed goes on bit for bit:
///   memory: [−0.75, numbers that follow, records ..., others ...]; nothing where nothing was edited
/// A record is its word, how many numbers follow, and those; texts are a length and their bytes.
/// Tests: tests/world/edits_test.cpp
struct Edits {
  std::set<int> removed, frozen;      ///< bodies
  std::map<int, Material> materials;  ///< of all parts of a body
  std::map<int, Pose> bases;          ///< where those of bodies are against the start (MovableBase)
  std::map<std::pair<std::string, std::string>, PairMaterial> pairs;
  /// A rule, without its regions: with what the world's PartFilter knows them by.
  struct Rule {
    TouchRule rule;
    int region = -1;
  };
  std::vector<Rule> rules;  ///< after those of the options
  std::optional<Vec3> gravity;
  std::optional<double> stiffness;  ///< [Pa]

  /// Takes what memory holds of it, and removes it there. What makes no sense is left out. @param bodies  of the world
  void take(std::vector<double>& memory, int bodies);
  /// Puts it before what memory holds.
  void keep(std::vector<double>& memory) const;
};

/// Which bodies of a state were removed, ascending; for readers of recorded states.
std::vector<int> removed_in(const State& state);

}  // namespace brim
