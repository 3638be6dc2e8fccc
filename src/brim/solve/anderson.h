#pragma once

#include <Eigen/Core>

namespace brim {

/// Anderson acceleration of a fixed-point iteration v ← g(v), of type II: from the last changes of f = g(v) − v and of
/// g it takes the combination whose f would be least, were g affine (Walker and Ni, Anderson acceleration for
/// fixed-point iterations, 2011). A step that makes f grow is taken back: the iteration goes on from the last g(v), and
/// what it remembers is forgotten, so that it gets no further from a solution than the plain iteration may.
/// Same bits for any number of threads.  Tests: tests/solve/anderson_test.cpp
class Anderson {
 public:
  /// @param size  of v @param memory  changes that are kept at most
  Anderson(Eigen::Index size, int memory);
  /// Of another map g.
  void forget() { kept_ = next_ = 0, any_ = false; }
  /// @param v  shape (size); on return where to evaluate g next @param g  g(v), shape (size)
  /// @return whether f did not grow; if it did, v is the last g(v) before
  bool step(Eigen::VectorXd& v, const Eigen::VectorXd& g);

 private:
  int memory_, kept_ = 0, next_ = 0;  // next_: column to write
  bool any_ = false;                  // whether f_, g_ are of an earlier step
  Eigen::VectorXd f_, g_, f_now_;
  Eigen::MatrixXd df_, dg_;   // changes, a column each
  Eigen::MatrixXd products_;  // dfᵀ df
};

}  // namespace brim
