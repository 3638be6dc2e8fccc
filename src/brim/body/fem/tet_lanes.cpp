#include "brim/body/fem/tet_lanes.h"

#include "brim/body/fem/elastic_lanes.h"

namespace brim {

namespace {

using namespace elastic_lanes;

/// F of one half of the tetrahedra, and their gradients g.
BRIM_INLINE void deformation(const TetLanes& tets, const double edge[3][3][TetLanes::kCount], int half, Mat3L& g,
                             Mat3L& F) {
  const int at = half * kLanes;
  for (int i = 0; i < 3; ++i)
    for (int c = 0; c < 3; ++c) g[i][c] = load_lanes(tets.gradient[i][c] + at);
  for (int r = 0; r < 3; ++r) {
    const Lanes e0 = load_lanes(edge[0][r] + at), e1 = load_lanes(edge[1][r] + at), e2 = load_lanes(edge[2][r] + at);
    for (int c = 0; c < 3; ++c) F[r][c] = e0 * g[0][c] + e1 * g[1][c] + e2 * g[2][c];
  }
}

/// Forces, and R and F Rᵀ, of one half of the tetrahedra.
BRIM_INLINE void forces(ElasticLaw law, const Lame& lame, const TetLanes& tets,
                        const double edge[3][3][TetLanes::kCount], int half, double (&rotation)[3][3][TetLanes::kCount],
                        double (&left)[3][3][TetLanes::kCount], TetResponse& out) {
  const int at = half * kLanes;
  Mat3L F, P, R, g;
  deformation(tets, edge, half, g, F);
  split(law, lame, F, at, rotation, left, R, P);
  const Lanes volume = load_lanes(tets.volume + at);
  if (gives_energy(law)) store_lanes(out.energy + at, Lanes(volume * turned_density(lame, F, R)));
  for (int r = 0; r < 3; ++r) {
    Lanes sum = {};
    for (int i = 0; i < 3; ++i) {
      const Lanes f = -volume * (P[r][0] * g[i][0] + P[r][1] * g[i][1] + P[r][2] * g[i][2]);
      store_lanes(out.force[i + 1][r] + at, f);
      sum += f;
    }
    store_lanes(out.force[0][r] + at, Lanes(-sum));
  }
}

}  // namespace

BRIM_WIDE void energy(ElasticLaw law, const Lame& lame, const TetLanes& tets, const double edge[3][3][TetLanes::kCount],
                      double out[TetLanes::kCount]) {
  for (int half = 0; half < 2; ++half) {
    Mat3L g, F;
    deformation(tets, edge, half, g, F);
    const int at = half * kLanes;
    store_lanes(out + at, Lanes(load_lanes(tets.volume + at) * density(law, lame, F)));
  }
}

BRIM_WIDE void respond(ElasticLaw law, const Lame& lame, bool project, const TetLanes& tets,
                       const double edge[3][3][TetLanes::kCount], TetResponse& out) {
  double rotation[3][3][TetLanes::kCount], left[3][3][TetLanes::kCount];
  for (int half = 0; half < 2; ++half) forces(law, lame, tets, edge, half, rotation, left, out);

  PrincipalFrame frame;
  principal_frame(law, lame, project, rotation, left, tets.volume, frame);
  const Mat3W& W = frame.W;
  WideFloats a[4][3];
  for (int k = 0; k < 3; ++k) {
    a[0][k] = WideFloats{};
    for (int i = 0; i < 3; ++i) {
      a[i + 1][k] = W[k][0] * narrow(tets.gradient[i][0]) + W[k][1] * narrow(tets.gradient[i][1]) +
                    W[k][2] * narrow(tets.gradient[i][2]);
      a[0][k] -= a[i + 1][k];
    }
  }
  for (int i = 0, p = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j, ++p) store_block(frame.response, frame.Q, a[i], a[j], out.block[p]);
}

}  // namespace brim
