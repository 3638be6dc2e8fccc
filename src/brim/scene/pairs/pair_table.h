#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace brim {

/// One row and column of the table of pairs: a body of some kind, as an entry of a scene.
struct PairKind {
  std::string name;
  std::string picture;                 ///< of the kind, path relative to its table's page; empty: none
  std::string about;                   ///< short description
  double lowest = 0.0, highest = 0.0;  ///< [m] of the body's matter at its position in the entry
  double linear = 0.0;                 ///< [-] allowed relative error of momentum in its contact map
  double lever = 0.0;                  ///< [m] allowed lever by which a force's torque may be lost, for lack of spin
  bool rolls = false;                  ///< rolls or flows away, so does not come to rest on another
  std::string body;                    ///< an entry of a scene's "bodies" (JSON), without name and velocity
};

/// Procedure for every pair: the upper body is thrown down on the lower one, which is at rest.
struct PairDrop {
  double speed = 1.0;              ///< [m/s] of the upper body, downwards
  double gap = 0.0;                ///< [m] between the two at the start
  std::array<double, 2> offset{};  ///< [m] of the upper body along x and y
  int steps = 0;
};

/// Bounds that a pair must satisfy.
struct PairBounds {
  double overlap = 1.0;  ///< [voxels]
  double energy = 0.01;  ///< [-] growth relative to the energy at the start
  double drift = 0.01;   ///< [-] momentum not from contact, over the total impulse
  double leak = 0.01;    ///< [-] fraction of a body on the wrong side of the other
  double speed = 0.05;   ///< [m/s] at the end, for pairs that come to rest
  double carried =
      0.1;  ///< [-] deviation of the load carried in the last quarter from the upper body's weight, over that weight
};

/// Reason why pairs fail.
struct PairNote {
  std::vector<std::string> pairs;  ///< "upper on lower", or a kind: every pair with it
  std::string why;                 ///< Markdown

  bool about(const std::string& lower, const std::string& upper) const;
};

/// Another world in which the kinds of a table meet.
struct PairWorld {
  std::string name;
  std::string about;  ///< description of the world, for the page
  std::string patch;  ///< of the table's world: a JSON merge patch (RFC 7396)
  int steps = 0;
  double voxel_size = 0.0;                        ///< [m] of the world and of every body that sets one; 0: unchanged
  bool floor = false;                             ///< a plane under the lower body
  std::vector<PairNote> notes, constraint_notes;  ///< as those of the table
};

struct PairTable {
  std::string name = "blow";
  std::string about = "in free space without gravity";  ///< description of the world
  PairDrop drop;
  PairBounds bounds;
  std::string world;   ///< a scene's "world" (JSON)
  bool floor = false;  ///< a plane under the lower body, on which the pair comes to rest
  std::vector<PairKind> kinds;
  std::vector<PairWorld> worlds;
  std::vector<PairNote> notes;             ///< known reasons of failing pairs; the first one about a pair counts
  std::vector<PairNote> constraint_notes;  ///< the same under constraints

  /// @throws InputError  naming the nearest kind
  const PairKind& find(const std::string& name) const;
  /// Adds the kinds of another table, under this table's drop, world and bounds, and its notes, also those of worlds
  /// that this table has.
  /// @throws InputError  when a name is already here
  void add_kinds(const PairTable& other);
  /// Sets the response of every pair, overriding the table's world, and selects the notes of that response.
  /// @param response  "penalty" or "constraint"
  void set_response(const std::string& response);
  /// This table in one of its worlds. @throws InputError  naming the nearest
  PairTable in_world(const std::string& name) const;
  /// Sets the number of steps; with fewer than before, pairs need not come to rest.
  void cut(int steps);
};

/// The table included in brim (scenes/pairs/kinds.json).
const PairTable& standard_pairs();

/// Reads a table (schema/pairs.schema.json). @throws InputError  "file:line: pointer: value and what is allowed"
PairTable read_pair_table(std::string_view text, const std::string& file);

/// The scene in which one kind, "upper", is dropped on another, "lower", above a "floor" where the table has one.
std::string pair_scene_text(const PairTable& table, const PairKind& lower, const PairKind& upper);

}  // namespace brim
