#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace brim {

/// One row and column of the table of pairs: a body of some kind, as a scene would give it.
struct PairKind {
  std::string name;
  std::string picture;                 ///< of the kind in its table's page, a path from there; empty: none
  std::string about;                   ///< what is dropped, in a few words
  double lowest = 0.0, highest = 0.0;  ///< [m] of the body's matter where it stands in its entry
  double linear = 0.0;                 ///< [-] relative error of momentum that the map of its contacts may make
  double lever = 0.0;                  ///< [m] lever on which it may lose a force's torque, for want of spin
  bool rolls = false;                  ///< rolls or flows away, so that it does not come to rest on another
  std::string body;                    ///< an entry of a scene's "bodies" (JSON), without name and velocity
};

/// What every pair goes through: the upper body flies down on the lower one, which is at rest.
struct PairDrop {
  double speed = 1.0;              ///< [m/s] of the upper body, downwards
  double gap = 0.0;                ///< [m] between the two at the start
  std::array<double, 2> offset{};  ///< [m] of the upper body along x and y
  int steps = 0;
};

/// What a pair must keep to.
struct PairBounds {
  double overlap = 1.0;  ///< [voxels]
  double energy = 0.01;  ///< [-] growth over the energy at the start
  double drift = 0.01;   ///< [-] momentum that does not come from contact, over the whole impulse
  double leak = 0.01;    ///< [-] share of a body on the wrong side of the other
  double speed = 0.05;   ///< [m/s] at the end, of pairs that come to rest
  double carried = 0.1;  ///< [-] of the upper body's weight, more or less than what the last quarter carries of it
};

/// Why pairs fail.
struct PairNote {
  std::vector<std::string> pairs;  ///< "upper on lower", or a kind: each pair that holds it
  std::string why;                 ///< Markdown

  bool about(const std::string& lower, const std::string& upper) const;
};

/// Another way in which the kinds of a table meet.
struct PairWorld {
  std::string name;
  std::string about;  ///< how they meet, for the page
  std::string patch;  ///< of the table's world: a JSON merge patch (RFC 7396)
  int steps = 0;
  double voxel_size = 0.0;                        ///< [m] of the world and of every body that tells one; 0: as it is
  bool floor = false;                             ///< a plane under the lower body
  std::vector<PairNote> notes, constraint_notes;  ///< as those of the table
};

struct PairTable {
  std::string name = "blow";
  std::string about = "in free space without gravity";  ///< where they meet
  PairDrop drop;
  PairBounds bounds;
  std::string world;   ///< a scene's "world" (JSON)
  bool floor = false;  ///< a plane under the lower body, on which the pair comes to rest
  std::vector<PairKind> kinds;
  std::vector<PairWorld> worlds;
  std::vector<PairNote> notes;             ///< what is known of pairs that fail; the first about a pair counts
  std::vector<PairNote> constraint_notes;  ///< the same under constraints

  /// @throws InputError  naming the nearest kind
  const PairKind& find(const std::string& name) const;
  /// Takes the kinds of another table in, under this table's drop, world and bounds, and its notes, also those of
  /// worlds that this table has.
  /// @throws InputError  when a name is already here
  void add_kinds(const PairTable& other);
  /// Every pair answers like this, whatever the table's world says; its notes are those of that response. @param
  /// response  "penalty" or "constraint"
  void set_response(const std::string& response);
  /// This table in one of its worlds. @throws InputError  naming the nearest
  PairTable in_world(const std::string& name) const;
  /// Takes so many steps; fewer than before need not bring anything to rest.
  void cut(int steps);
};

/// The table that brim brings along (scenes/pairs/kinds.json).
const PairTable& standard_pairs();

/// Reads a table (schema/pairs.schema.json). @throws InputError  "file:line: pointer: value and what is allowed"
PairTable read_pair_table(std::string_view text, const std::string& file);

/// The scene in which one kind, "upper", is dropped on another, "lower", above a "floor" where the table has one.
std::string pair_scene_text(const PairTable& table, const PairKind& lower, const PairKind& upper);

}  // namespace brim
