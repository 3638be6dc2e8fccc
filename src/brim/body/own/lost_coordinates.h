#pragma once

#include <Eigen/Core>
#include <vector>

namespace brim {

/// Coordinates without an effect of their own: some motion by them moves no matter, and no force resists it, so that
/// nothing determines it. Found on the mass matrix scaled to a diagonal of ones, whatever the units of the coordinates:
/// motions z with zᵀ M z < 1e-12 zᵀ z, which move matter by less than a millionth of what the single coordinates do;
/// differences of a curved deform leave 1e-8 (OwnBody).
/// @param M  mass matrix, shape (n, n)  @param K  stiffness, −∂²E/∂q², negative semidefinite, shape (n, n)
/// @return numbers of the coordinates of one such motion, ascending; empty: none
/// Tests: tests/body/own_body_check_test.cpp
std::vector<Eigen::Index> lost_coordinates(const Eigen::MatrixXd& M, const Eigen::MatrixXd& K);

}  // namespace brim
