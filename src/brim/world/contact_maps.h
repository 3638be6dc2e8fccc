#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/core/parallel.h"
#include "brim/map/directed_map.h"
#include "brim/map/map.h"
#include "brim/map/map_rows.h"
#include "brim/world/contact_rows.h"
#include "brim/world/contact_stage.h"

namespace brim {

/// The maps of all parts at their contacts: transfers velocities from bodies to contacts and forces back.
class ContactMaps {
 public:
  /// @param first_v  first velocity of each body in the world's vectors, shape (bodies + 1)
  void build(std::span<const WorldPart> parts, const ContactSet& contacts, std::span<const std::size_t> first_v) {
    build(parts, contacts, first_v, {}, nullptr);
  }
  /// The maps of a subset of the contacts; the others have no effect.
  /// @param all     the maps of all contacts
  /// @param chosen  nonzero for the subset, shape (contacts)
  void build(std::span<const WorldPart> parts, const ContactSet& contacts, std::span<const std::size_t> first_v,
             const ContactMaps& all, std::span<const std::uint8_t> chosen) {
    build(parts, contacts, first_v, chosen, &all);
  }

  /// True when the maps as last built hold all chosen contacts, and not many others.
  bool serves(std::span<const std::uint8_t> chosen) const;

  /// Calls f(c, n) for each contact of a part that accepts force along only one direction (DirectedMap): n along it,
  /// towards a.
  template <class F>
  void for_directed(const F& f) const {
    for (const Side& s : side_) {
      const auto* directed = s.begin < s.end ? dynamic_cast<const DirectedMap*>(s.map.get()) : nullptr;
      if (directed == nullptr) continue;
      for (std::size_t r = s.begin; r < s.end; ++r) {
        const Vec3& out = directed->directions()[r - s.begin];
        const std::size_t c = contact_[r];
        if (!out.isZero(0.0)) f(c, row_a_[c] == r ? Vec3(-out) : out);
      }
    }
  }
  /// Velocity of both parts' material at each contact, [m/s]; like relative, for maps of all contacts.
  void velocities(std::span<const double> v, std::span<Vec3> a, std::span<Vec3> b) const;
  /// Relative velocity a − b at each contact; parts of immobile bodies count as zero.
  void relative(std::span<const double> v, std::span<Vec3> out) const;
  /// Q += Jᵀ f for the force on a, and its opposite on b; immobile bodies receive nothing.
  void add_forces(std::span<const Vec3> force, std::span<double> Q) const;
  /// y += Jᵀ f(J x): f(c, Δ) gives the force on a at contact c for the relative velocity Δ = a − b. The same as
  /// relative and add_forces, in one pass over the contacts.
  template <class F>
  void add_response(std::span<const double> x, const F& f, std::span<double> y) const {
    take_velocities(x);
    answer(f, y);
  }
  /// add_response in two halves, with access to the contact velocities in between.
  void take_velocities(std::span<const double> x) const { row_velocities(x); }
  template <class F>
  void answer(const F& f, std::span<double> y) const {
    parallel_for(
        chosen_.size(),
        [&](std::size_t i) {
          Vec3 &a = row_vector_[row_a_[i]], &b = row_vector_[row_b_[i]];
          const Vec3 force = f(chosen_[i], Vec3(a - b));
          a = force, b = -force;
        },
        1024);
    add_row_forces(y);
  }
  /// After take_velocities: calls f(c, Δ) for the chosen contacts from `first` on, in order.
  template <class F>
  void for_taken(std::size_t first, const F& f) const {
    for (auto i = static_cast<std::size_t>(std::lower_bound(chosen_.begin(), chosen_.end(), first) - chosen_.begin());
         i < chosen_.size(); ++i)
      f(chosen_[i], Vec3(row_vector_[row_a_[i]] - row_vector_[row_b_[i]]));
  }
  /// Adds the diagonal blocks of Jᵀ K J, K given per contact.
  void add_block_diagonal(const std::function<Mat3(std::size_t)>& block, std::span<const std::size_t> first_block,
                          BlockDiagonal& D) const;
  std::size_t rows() const { return contact_.size(); }
  /// True when all maps of a body have sparse rows (SparseMap).
  bool sparse_rows(std::size_t body) const;
  /// The chosen contacts as sparse rows; sides without such rows are left out.
  void gather_rows(ContactRows& out) const;

 private:
  void build(std::span<const WorldPart> parts, const ContactSet& contacts, std::span<const std::size_t> first_v,
             std::span<const std::uint8_t> chosen, const ContactMaps* all);
  struct Side {
    bool movable = false;
    std::size_t begin = 0, end = 0;  ///< rows
    std::size_t first_v = 0, v_size = 0;
    std::int32_t body = 0;
    std::unique_ptr<Map> map;
    const Body* of = nullptr;  ///< body of the map; a newly added part may take the place of another
  };
  /// Calls f(side) for every movable side with contacts; sides of one body run in order on one thread, as they share Q.
  template <class F>
  void for_movable(const F& f) const;
  /// Velocity at every row into row_vector_; parts of immobile bodies count as zero.
  void row_velocities(std::span<const double> v) const;
  /// Q += Jᵀ of row_vector_.
  void add_row_forces(std::span<double> Q) const;

  std::vector<Side> side_;                    ///< per part
  std::vector<std::size_t> first_side_;       ///< per body, its first part; shape (bodies + 1)
  std::vector<std::uint32_t> chosen_;         ///< chosen contacts, ascending
  std::vector<std::uint32_t> contact_;        ///< per row: the contact
  std::vector<std::uint32_t> row_a_, row_b_;  ///< per chosen contact
  std::vector<Vec3> point_;
  std::vector<std::int32_t> source_;
  std::vector<std::uint32_t> whole_;  ///< per row: the row of the same contact and part in the maps of all contacts
  mutable std::vector<Vec3> row_vector_;
  mutable std::vector<Mat3> row_matrix_;
  std::vector<std::int32_t> part_a_, part_b_;  ///< per chosen contact
  mutable std::vector<MapRows> map_rows_;      ///< per part
};

}  // namespace brim
