#pragma once

#include <cmath>
#include <span>

#include "brim/math/types.h"

namespace brim {

/// Loads of which the friction of a patch is made. Nodes in tension bear a part of the net load until they are let go,
/// so the pushing ones bear more than the net, about another centre. On a flat patch between rigid parts friction has
/// the sum and the centre of the net load, with the loads N that differ least from the pushing ones (in relative
/// entropy):
///   N_i = a l_i exp(b·(x_i − c))   Σ N_i = Σ l_j   Σ N_i x_i = Σ l_j x_j along the patch
/// i: pushing nodes, j: all nodes of the solve, l: loads, x: points, c: centre of the pushing loads. So friction does
/// not turn a body that slides straight.
struct FrictionShare {
  double scale = 1.0;          ///< [-] a
  Vec3 tilt = Vec3::Zero();    ///< [1/m] b, along the patch
  Vec3 center = Vec3::Zero();  ///< [m] c

  /// [N] load for friction. @param load  [N]  @param x  [m]
  double of(double load, const Vec3& x) const {
    return load > 0.0 ? scale * std::exp(tilt.dot(x - center)) * load : 0.0;
  }
};

/// The share for a net load and its centre. It is even (b = 0) where normals differ by more than the cosine 0.9 from
/// their mean, or where the points lie on a line. If the centre lies outside the pushing points, the nearest bear most.
/// @param points  [m]  @param normals  unit  @param loads  [N] those above zero push; shape (nodes)
/// @param net     [N]  @param center  [m] of the net load
/// Tests: tests/response/friction_share_test.cpp
FrictionShare share_about(std::span<const Vec3> points, std::span<const Vec3> normals, std::span<const double> loads,
                          double net, const Vec3& center);

}  // namespace brim
