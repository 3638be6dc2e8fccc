#pragma once

#include "brim/body/fem/elastic_law.h"

namespace brim {

/// Constant data of eight tetrahedra processed together, lane by lane.
struct TetLanes {
  static constexpr int kCount = 8;
  double gradient[3][3][kCount];  ///< [1/m] g_1, g_2, g_3 by coordinate; g_0 = −Σ
  double volume[kCount];          ///< [m³] at rest
};

/// Their elastic forces and the six stiffness blocks above the diagonal.
struct TetResponse {
  double force[4][3][TetLanes::kCount];  ///< [N] on each corner
  float block[6][9][TetLanes::kCount];   ///< [N/m] K_01, K_02, K_03, K_12, K_13, K_23, column by column
  double energy[TetLanes::kCount];       ///< [J] only if gives_energy(law)
};

/// True when the energy is a free by-product of the forces.
inline bool gives_energy(ElasticLaw law) { return law == ElasticLaw::CorotationalLinear; }

/// Elastic forces in double and blocks in single precision (formulas: TetElements, method: elastic_lanes.h).
/// @param edge  x_i − x_0 of corners 1 to 3 by coordinate, [m]
void respond(ElasticLaw law, const Lame& lame, bool project, const TetLanes& tets,
             const double edge[3][3][TetLanes::kCount], TetResponse& out);
/// Their elastic energy, [J].
void energy(ElasticLaw law, const Lame& lame, const TetLanes& tets, const double edge[3][3][TetLanes::kCount],
            double out[TetLanes::kCount]);

}  // namespace brim
