#pragma once

#include <Eigen/SparseCholesky>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/contact/contact_set.h"
#include "brim/response/penalty.h"
#include "brim/world/contact_maps.h"
#include "brim/world/contact_stage.h"

namespace brim {

/// Coarse level of the preconditioner: the rigid motions of all bodies, coupled by their contacts and solved
/// directly. R holds up to six motions per body,
///   P⁻¹ = (local part) + R (Rᵀ A R)⁻¹ Rᵀ
/// so that weights and impacts travel through a pile of bodies without iterations per body. A body whose only motions
/// are rigid is solved entirely here.
/// Cost of a build: six products per body and six per contact; of an application: two passes over the node positions if
/// the body provides them (BlockSystem), else over six vectors.
class CoarseSpace {
 public:
  /// Takes the modes of the bodies, which must have begun their solve.
  /// @param without  nonzero for excluded bodies, shape (bodies)
  void begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
             std::span<const WorldPart> parts, std::span<const std::uint8_t> without);
  /// Assembles and factors Rᵀ A R with the present contact stiffness.
  /// @param maps  of all contacts, the same until begin @return false when it is not definite, or empty
  bool factor(const ContactMaps& maps, const ContactSet& contacts, const Penalty& response);

  /// True when the modes span all motions of the body.
  bool complete(std::size_t body) const { return complete_[body]; }
  /// z += R (Rᵀ A R)⁻¹ Rᵀ r. Same bits for any number of threads.
  void add(std::span<const double> r, std::span<double> z);
  /// x += R (Rᵀ A R)⁻¹ Rᵀ r with the bodies' own A, for bodies without prescribed motion: gives back the momentum and
  /// angular momentum missing after a solve, whatever its tolerance. @param r  b − A x
  void give_back(std::span<const double> r, std::span<double> x) const;

 private:
  static constexpr int kModes = 6;
  using Block = Eigen::Matrix<double, kModes, kModes>;
  /// Velocities of the modes at a contact; padded by two columns to the width of a register.
  using Seen = Eigen::Matrix<double, 3, 8, Eigen::RowMajor>;
  /// A range of a pair's contacts, and its share of the blocks (a, a), (b, b) and (a, b).
  struct Patch {
    std::size_t pair = 0, begin = 0, end = 0;
    std::array<Block, 3> sum = {Block::Zero(), Block::Zero(), Block::Zero()};
  };

  struct Modes {
    int count = 0;                ///< modes that are kept
    int coupled = 0;              ///< number of these in the coarse system: all or none
    bool free = true;             ///< no velocity of the body is prescribed
    std::size_t row = 0;          ///< first unknown in the coarse system
    std::vector<double> columns;  ///< orthonormal, concatenated, shape (count, v_size)
    Block system = Block::Zero();
    // When the nodes' positions are known: column j is the sum over k of basis(k, j) times e_k, or e_k × (x − center).
    std::span<const Vec3> place;
    Vec3 center = Vec3::Zero();
    Block basis = Block::Zero();
  };
  /// Rᵀ r of one body, and z += R c.
  static Eigen::VectorXd restricted(const Modes& m, std::span<const double> r);
  static void add_prolonged(const Modes& m, const Eigen::VectorXd& c, std::span<double> z);
  /// Σ Sᵀ K S over the acting contacts of a patch.
  static void sum_contacts(std::span<const Seen> a, std::span<const Seen> b, const Penalty& response, Patch& patch);
  /// Finds the velocities of the modes at each contact.
  void see(const ContactMaps& maps, std::size_t contacts);
  void take_modes(const Body& body, std::size_t n, Modes& m) const;
  /// Finds the rigid motions that the body can make, orthonormal. @param n  size of its velocities
  /// @return number of translations, which come first; none when the body does not offer its rigid motions
  static std::optional<int> find_modes(const Body& body, std::size_t n, Modes& m);
  /// Keeps column m.count, filtered motion k, if enough of it is independent of the columns before it.
  /// @param length  of the column
  static bool add_mode(std::size_t n, int k, double length, Modes& m);
  void add_block(const Block& block, const Modes& a, const Modes& b);

  std::vector<Modes> modes_;  ///< per body
  std::vector<std::uint8_t> complete_;
  std::vector<std::size_t> first_v_;
  std::vector<std::int32_t> body_of_part_;
  bool seen_ = false;                  ///< see() was called since begin
  std::vector<Seen> seen_a_, seen_b_;  ///< per contact
  std::vector<Patch> patches_;
  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::SparseMatrix<double> matrix_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
  Eigen::VectorXd coarse_;
  std::vector<double> column_;
  std::vector<Vec3> velocity_a_, velocity_b_;
};

}  // namespace brim
