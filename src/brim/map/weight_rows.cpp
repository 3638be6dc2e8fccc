#include "brim/map/weight_rows.h"

#include <algorithm>

#include "brim/core/parallel.h"

namespace brim {

void apply_rows(const WeightRows& rows, std::span<const double> v, std::span<Vec3> u) {
  parallel_for(
      rows.rows(),
      [&](std::size_t p) {
        Vec3 sum = Vec3::Zero();
        double along = 0.0;
        for (std::int32_t e = rows.first[p]; e < rows.first[p + 1]; ++e) {
          const Eigen::Map<const Vec3> vi(v.data() + 3 * static_cast<std::size_t>(rows.source[e]));
          sum += rows.weight[e] * vi;
          if (!rows.lever.empty()) along += rows.lever[e].dot(vi);
        }
        u[p] = rows.lever.empty() ? sum : Vec3(sum + along * rows.normal[p]);
      },
      256);
}

void add_transpose(const WeightRows& rows, const RowTranspose& transpose, std::span<const Vec3> f,
                   std::span<double> Q) {
  parallel_for(
      transpose.columns.size(),
      [&](std::size_t c) {
        Vec3 sum = Vec3::Zero();
        for (const auto& e : transpose.of(c)) {
          sum += rows.weight[e.index] * f[e.row];
          if (!rows.lever.empty()) sum += rows.lever[e.index] * rows.normal[e.row].dot(f[e.row]);
        }
        Eigen::Map<Vec3>(Q.data() + 3 * static_cast<std::size_t>(transpose.columns[c])) += sum;
      },
      256);
}

namespace {
constexpr std::size_t kRowsOfWork = 16;
}  // namespace

WeightRows compose(const WeightRows& outer, const WeightRows& inner) {
  struct Term {
    std::int32_t node;
    double weight;
    Vec3 lever;
  };
  const bool levers = !outer.lever.empty();
  const std::size_t rows = outer.rows();
  const std::int32_t nodes = inner.source.empty() ? 0 : *std::ranges::max_element(inner.source) + 1;
  std::vector<std::vector<Term>> made(rows);
  parallel_blocks(rows, kRowsOfWork, [&](std::size_t begin, std::size_t end) {
    std::vector<std::int32_t> place(static_cast<std::size_t>(nodes), -1);  // of a node's term in the row at hand
    for (std::size_t p = begin; p < end; ++p) {
      std::vector<Term>& terms = made[p];
      for (std::int32_t e = outer.first[p]; e < outer.first[p + 1]; ++e) {
        const std::int32_t s = outer.source[e];
        for (std::int32_t c = inner.first[s]; c < inner.first[s + 1]; ++c) {
          const Term t{inner.source[c], outer.weight[e] * inner.weight[c],
                       levers ? Vec3(inner.weight[c] * outer.lever[e]) : Vec3(Vec3::Zero())};
          std::int32_t& at = place[static_cast<std::size_t>(t.node)];
          if (at >= 0) {
            terms[static_cast<std::size_t>(at)].weight += t.weight;
            terms[static_cast<std::size_t>(at)].lever += t.lever;
          } else {
            at = static_cast<std::int32_t>(terms.size());
            terms.push_back(t);
          }
        }
      }
      for (const Term& t : terms) place[static_cast<std::size_t>(t.node)] = -1;
      std::ranges::sort(terms, {}, &Term::node);
    }
  });
  WeightRows out;
  out.normal = outer.normal;
  for (const auto& terms : made) {
    for (const Term& t : terms) {
      out.source.push_back(t.node);
      out.weight.push_back(t.weight);
      if (levers) out.lever.push_back(t.lever);
    }
    out.first.push_back(static_cast<std::int32_t>(out.source.size()));
  }
  return out;
}

}  // namespace brim
