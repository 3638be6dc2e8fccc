#pragma once

#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/body/filling.h"
#include "brim/contact/contact_set.h"
#include "brim/response/penalty.h"
#include "brim/world/contact_maps.h"
#include "brim/world/contact_stage.h"

namespace brim {

class PartFilter;

/// Contacts of bodies that fill the space between solids (Filling): one for each element within reach of a surface,
/// resisted by the body's pressure in the common solve. The surface comes from distances: the solid's own, or for other
/// bodies those of the density on the grid.
///
/// Their force on part a is push n, with n the contact's normal and n·Δ the rate of the distance.
/// Same bits for any number of threads.  Tests: tests/world/fill_stage_test.cpp
class FillStage {
 public:
  /// Finds the contacts, appends them to the set pair by pair, and passes them to the bodies.
  /// @param filter  removes contacts excluded by rules about parts of bodies
  void find(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts,
            const WorldOptions& options, PartFilter& filter, ContactSet& set);
  /// Reads the state at the start of the step: pressures and rates, passed to `response` for friction.
  /// @param velocity_a, velocity_b  [m/s] of each part's material at all contacts
  void begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
             std::span<const double> v, std::span<const Vec3> velocity_a, std::span<const Vec3> velocity_b, double dt,
             Penalty& response);

  bool empty() const { return normal_.empty(); }
  bool holds(std::size_t c) const { return c - first_ < normal_.size(); }
  std::size_t first() const { return first_; }  ///< the first of these contacts in the set; links follow them
  bool handles(std::size_t body) const { return body < filler_.size() && filler_[body].body != nullptr; }

  /// y += ∂Q/∂q v of a body at the start.
  void add_start_stiffness(std::size_t body, std::span<double> y) const;
  /// force_c += force on part a from the start state: pressure and its change by the motion at the start, [N].
  void add_right_hand_side(std::span<Vec3> force) const;
  /// Stores the relative velocity of contact c for the products that follow.
  void see(std::size_t c, const Vec3& delta) const { rate_[c - first_] = normal_[c - first_].dot(delta); }
  /// y += A x of a body, after see.
  void apply_system(std::size_t body, std::span<const double> x, std::span<double> y) const;
  /// Force times dt of contact c on part a, of the last product, [N s].
  Vec3 impulse(std::size_t c) const { return push_[c - first_] * normal_[c - first_]; }

  /// Stores the solution, from which forces follow. @param delta  velocity changes @param contact_delta  at all
  /// contacts
  void finish(std::span<const std::size_t> first_v, std::span<const double> delta, std::span<const Vec3> contact_delta);
  /// Normal force on part a at the end of the step, [N], after finish.
  void add_forces(std::span<Vec3> force) const;
  /// Loads of these contacts after finish, for friction.
  void give_loads(Penalty& response) const;

 private:
  struct Filler {
    Filling* body = nullptr;
    std::size_t begin = 0, end = 0;  ///< its contacts, counted from first_
  };
  struct Found {
    std::int32_t element;
    double distance, bend;
    Vec3 n;  ///< from the surface to the element
    std::int32_t source;
  };
  void find_in_solid(const PosedShape& solid, const Aabb& bounds, const Filling& filler);
  void find_on_grid(const WorldPart& part, double h, const Aabb& region, const Filling& filler);

  std::vector<Filler> filler_;  ///< per body
  std::size_t first_ = 0;
  std::vector<Vec3> normal_;  ///< of each contact, towards part a
  std::vector<Seen> seen_;
  std::vector<Found> found_;
  std::vector<std::vector<Found>> piece_;
  std::vector<std::pair<TileKey, std::int32_t>> binned_;
  std::vector<TileKey> tiles_, present_;
  std::vector<std::size_t> first_in_tile_;
  std::vector<DensityBlock> blocks_;
  std::vector<double> start_push_, start_change_, load_, scratch_;
  std::vector<double> start_stiffness_;
  std::vector<std::size_t> first_v_;
  mutable std::vector<double> rate_, push_;
  double dt_ = 0.0;
};

/// True when one of two parts fills the space around the other, so that grid contacts between them are not searched.
bool fills(const WorldPart& a, const WorldPart& b);

}  // namespace brim
