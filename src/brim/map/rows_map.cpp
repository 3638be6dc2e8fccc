#include "brim/map/rows_map.h"

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

void RowsMap::assign(std::size_t particles, WeightRows rows) {
  BRIM_CHECK(rows.source.size(), ==, rows.weight.size());
  BRIM_CHECK((rows.lever.empty() || rows.normal.size() == rows.rows()), ==, true);
  rows_ = std::move(rows);
  transpose_.build(particles, rows_.first, rows_.source);
}

void RowsMap::apply(std::span<const double> v, std::span<Vec3> u) const {
  BRIM_CHECK(u.size(), ==, points());
  apply_rows(rows_, v, u);
}

void RowsMap::apply_transpose(std::span<const Vec3> f, std::span<double> Q) const {
  BRIM_CHECK(f.size(), ==, points());
  add_transpose(rows_, transpose_, f, Q);
}

bool RowsMap::append_rows(MapRows& out) const {
  for (std::size_t p = 0; p < points(); ++p) {
    for (std::int32_t e = rows_.first[p]; e < rows_.first[p + 1]; ++e) {
      const double w = rows_.weight[e];
      if (rows_.lever.empty())
        out.add(rows_.source[e], static_cast<float>(w));
      else
        out.add(rows_.source[e],
                Eigen::Matrix3f((w * Mat3::Identity() + rows_.normal[p] * rows_.lever[e].transpose()).cast<float>()));
    }
    out.end_row();
  }
  return true;
}

void RowsMap::add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const {
  BRIM_CHECK(K.size(), ==, points());
  parallel_for(
      transpose_.columns.size(),
      [&](std::size_t c) {
        Mat3 sum = Mat3::Zero();
        for (const auto& e : transpose_.of(c)) {
          Mat3 J = rows_.weight[e.index] * Mat3::Identity();
          if (!rows_.lever.empty()) J += rows_.normal[e.row] * rows_.lever[e.index].transpose();
          sum += J.transpose() * K[e.row] * J;
        }
        D.block(first + static_cast<std::size_t>(transpose_.columns[c])) += sum;
      },
      256);
}

}  // namespace brim
