#include <algorithm>
#include <numeric>

#include "brim/core/parallel.h"
#include "brim/world/coarse_grid.h"
#include "brim/world/coarse_grid_lanes.h"

namespace brim {

using namespace coarse_grid_lanes;

struct CoarseGrid::Workspace {
  std::vector<float> sum;
  std::vector<std::int32_t> row;
  Sight sight;
};

CoarseGrid::CoarseGrid() : pool_(std::make_unique<WorkspacePool<Workspace>>()) {}
CoarseGrid::~CoarseGrid() = default;
CoarseGrid::CoarseGrid(CoarseGrid&&) noexcept = default;
CoarseGrid& CoarseGrid::operator=(CoarseGrid&&) noexcept = default;

void CoarseGrid::scatter(const float* sum, const std::array<std::int32_t, 8>& corner,
                         const std::array<std::int32_t, 8>& other, const Place& away) {
  // Blocks below the diagonal are stored transposed in the row of the other corner. Each coupling is added once.
  const bool same = away == Place{0, 0, 0};
  for (std::size_t I = 0; I < 8; ++I)
    for (std::size_t J = 0; J < 8; ++J) {
      std::int32_t code = 0;
      for (int a = 0, stride = 1; a < 3; ++a, stride *= 5)
        code += stride * (away[a] + corner_bit(J, a) - corner_bit(I, a));
      if (same && code < 0) continue;
      const std::int32_t row = code < 0 ? other[J] : corner[I];
      const std::size_t e = kAhead * static_cast<std::size_t>(row) + static_cast<std::size_t>(std::abs(code));
      used_[e] = 1;
      const float* from = sum + 9 * 8 * I + J;
      float* to = sum_[e].data();
      const auto add = [&](bool transposed) {
        for (std::size_t c = 0; c < 3; ++c)
          for (std::size_t r = 0; r < 3; ++r) to[3 * c + r] += from[8 * (transposed ? 3 * r + c : 3 * c + r)];
      };
      add(code < 0);
      if (code == 0 && !same) add(true);
    }
}

void CoarseGrid::sum_bodies(std::span<const Member> members) {
  sum_.assign(kAhead * corner_.size(), BlockCholesky::Block::Zero());
  used_.assign(sum_.size(), 0);
  // Cells of one colour, and the cells around them, share no corner.
  std::array<std::vector<std::size_t>, 64> colour;  // of runs: the first of each cell
  for (std::size_t i = 0; i < run_.size(); ++i)
    if (i == 0 || run_[i].cell != run_[i - 1].cell) {
      const Place& p = cell_[run_[i].cell].at;
      colour[static_cast<std::size_t>(p[0] % 4 + 4 * (p[1] % 4) + 16 * (p[2] % 4))].push_back(i);
    }
  for (const auto& firsts : colour)
    parallel_for(firsts.size(), [&](std::size_t k) {
      auto work = pool_->borrow();
      work->sum.resize(kAround * kPair);
      std::uint32_t used = 0;
      const std::size_t cell = run_[firsts[k]].cell;
      for (std::size_t i = firsts[k]; i < run_.size() && run_[i].cell == cell; ++i) {
        const Run& run = run_[i];
        const Member& m = members[run.member];
        const BlockMatrix& K = *m.system.stiffness;
        const Rows rows{.first = K.row_first().data(),
                        .column = K.columns().data(),
                        .value = K.values(0),
                        .diagonal = &K.diagonal(0),
                        .mass = m.system.mass.data(),
                        .stiffness_share = static_cast<float>(m.system.stiffness_share),
                        .mass_share = static_cast<float>(m.system.mass_share),
                        .node = node_of_.data() + m.first_v,
                        .code = code_.data(),
                        .width = cells_[0] + 2,
                        .height = cells_[1] + 2,
                        .weight = weight_.data()};
        work->row.clear();
        for (std::size_t n = run.begin; n < run.end; ++n)
          work->row.push_back((velocity_[n] - static_cast<std::int32_t>(m.first_v)) / 3);
        add_rows(rows, work->row.data(), work->row.size(), run.begin, work->sum.data(), used);
      }
      for (std::size_t c = 0; c < kAround; ++c) {
        if (!(used >> c & 1)) continue;
        const Place away = {static_cast<std::int32_t>(c % 3) - 1, static_cast<std::int32_t>(c / 3 % 3) - 1,
                            static_cast<std::int32_t>(c / 9) - 1};
        const Place& at = cell_[cell].at;
        const auto other = cell_of_[dense_cell({at[0] + away[0], at[1] + away[1], at[2] + away[2]})];
        scatter(work->sum.data() + c * kPair, cell_[cell].corner, cell_[other].corner, away);
      }
    });
  own_ = sum_, own_used_ = used_;
}

void CoarseGrid::sum_contacts(const ContactRows& rows) {
  // Contacts by the lowest cell that they reach; contacts that reach beyond the next cell are left out.
  constexpr std::uint32_t kNone = 0xffffffff;
  std::vector<std::uint32_t> lowest(rows.size(), kNone);
  contact_first_.assign(cell_of_.size() + 1, 0);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Place lo = cells_, hi = {-1, -1, -1};
    for (std::int32_t e = rows.first[i]; e < rows.first[i + 1]; ++e) {
      const std::int32_t node = node_of_[rows.offset[e]];
      if (node < 0) continue;
      const Place& p = cell_[cell_at_[node]].at;
      for (int a = 0; a < 3; ++a) lo[a] = std::min(lo[a], p[a]), hi[a] = std::max(hi[a], p[a]);
    }
    if (hi[0] < 0 || hi[0] > lo[0] + 1 || hi[1] > lo[1] + 1 || hi[2] > lo[2] + 1) continue;
    lowest[i] = static_cast<std::uint32_t>(dense_cell(lo));
    ++contact_first_[lowest[i] + 1];
  }
  std::partial_sum(contact_first_.begin(), contact_first_.end(), contact_first_.begin());
  contact_.resize(contact_first_.back());
  std::vector<std::size_t> next(contact_first_.begin(), contact_first_.end() - 1);
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (lowest[i] != kNone) contact_[next[lowest[i]]++] = static_cast<std::uint32_t>(i);
  // Cells of one colour, and the cells next to them, share no corner.
  std::array<std::vector<std::size_t>, 27> colour;
  for (std::size_t c = 0; c < cell_of_.size(); ++c)
    if (contact_first_[c] < contact_first_[c + 1]) {
      const std::size_t x = c % static_cast<std::size_t>(cells_[0]), yz = c / static_cast<std::size_t>(cells_[0]),
                        y = yz % static_cast<std::size_t>(cells_[1]), z = yz / static_cast<std::size_t>(cells_[1]);
      colour[x % 3 + 3 * (y % 3) + 9 * (z % 3)].push_back(c);
    }
  for (const auto& lows : colour)
    parallel_for(lows.size(), [&](std::size_t k) {
      auto work = pool_->borrow();
      work->sum.resize(64 * kPair);
      std::uint64_t used = 0;
      Place lo = cells_;
      const std::size_t begin = contact_first_[lows[k]], end = contact_first_[lows[k] + 1];
      Sight& s = work->sight;
      std::array<std::int32_t, 8> cell = {};  // of the grid's cells
      for (std::size_t c = begin; c < end; ++c) {
        const std::size_t i = contact_[c];
        s.used = 0, s.plain = true;
        if (c == begin) {
          const auto low = static_cast<std::int32_t>(lows[k]);
          lo = {low % cells_[0], low / cells_[0] % cells_[1], low / cells_[0] / cells_[1]};
        }
        for (std::int32_t e = rows.first[i]; e < rows.first[i + 1]; ++e)
          s.plain = s.plain && (rows.blocks.plain(e) || node_of_[rows.offset[e]] < 0);
        for (std::int32_t e = rows.first[i]; e < rows.first[i + 1]; ++e) {
          const std::int32_t node = node_of_[rows.offset[e]];
          if (node < 0) continue;
          const Place& p = cell_[cell_at_[node]].at;
          const int at = (p[0] - lo[0]) + 2 * (p[1] - lo[1]) + 4 * (p[2] - lo[2]);
          cell[at] = cell_at_[node];
          const float weight = rows.blocks.weight(e);
          const BlockCholesky::Block J = rows.blocks[e];
          see(s, at, s.plain ? &weight : J.data(), weight_.data() + 8 * static_cast<std::size_t>(node));
        }
        for (int a = 0; a < 8; ++a)
          for (int b = a; b < 8; ++b) {
            if (!(s.used >> a & 1) || !(s.used >> b & 1)) continue;
            float* sum = work->sum.data() + static_cast<std::size_t>(8 * a + b) * kPair;
            if (!(used >> (8 * a + b) & 1)) used |= std::uint64_t{1} << (8 * a + b), std::fill_n(sum, kPair, 0.0f);
            add_contact(s, a, b, rows.stiffness[i].data(), sum);
          }
      }
      for (std::size_t a = 0; a < 8; ++a)
        for (std::size_t b = 0; b < 8; ++b)
          if (used >> (8 * a + b) & 1)
            scatter(work->sum.data() + (8 * a + b) * kPair, cell_[cell[a]].corner, cell_[cell[b]].corner,
                    {corner_bit(b, 0) - corner_bit(a, 0), corner_bit(b, 1) - corner_bit(a, 1),
                     corner_bit(b, 2) - corner_bit(a, 2)});
    });
}

}  // namespace brim
