#pragma once

#include <Eigen/Core>

#include "brim/world/contact_rows.h"

namespace brim::testing {

/// A += Jᵀ K J of all contacts. @param A  of all velocities
inline void add_contact_stiffness(const ContactRows& rows, Eigen::MatrixXd& A) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, A.cols());
    for (std::int32_t e = rows.first[i]; e < rows.first[i + 1]; ++e)
      J.middleCols<3>(rows.offset[e]) += rows.blocks[e].cast<double>();
    A += J.transpose() * rows.stiffness[i].cast<double>() * J;
  }
}

}  // namespace brim::testing
