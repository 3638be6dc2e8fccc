// What RigidContacts tells of its pairs: their reports, the work done, the boxes sampled, and the references to keep.
#include <algorithm>

#include "brim/body/posed_shape.h"
#include "brim/world/pair_reports.h"
#include "brim/world/rigid_contacts.h"

namespace brim {

void RigidContacts::report(std::span<const WorldPart> parts, double time, StepReport& report) const {
  const std::size_t others = report.pairs.size();
  std::size_t next = 0;  // index in the gathered rows
  for (const Pair& p : pairs_) {
    if (p.contacts == 0) continue;
    const std::size_t end = next + p.rows.size();
    const RowPoint deepest = moved(p.deepest, references_.motion(static_cast<std::size_t>(p.touch.part_a)),
                                   references_.motion(static_cast<std::size_t>(p.touch.part_b)), p.touch.h);
    PairReport r;
    r.part_a = p.touch.part_a, r.part_b = p.touch.part_b;
    r.contacts = p.contacts;
    // The overlap between nodes may exceed that at any node.
    double gap = deepest.gap;
    for (; next < end; ++next) gap = std::min(gap, rows_[next].gap);
    r.worst_overlap = std::max(0.0, -gap / p.touch.h);
    r.worst_pressure = std::max(0.0, double{p.most_overlap});
    r.center = deepest.point;
    report.worst_overlap = std::max(report.worst_overlap, r.worst_overlap);
    warn_of_saturation(parts, r, 0.0, time, report);
    report.pairs.push_back(r);
  }
  std::inplace_merge(report.pairs.begin(), report.pairs.begin() + static_cast<std::ptrdiff_t>(others),
                     report.pairs.end(), [](const PairReport& r, const PairReport& s) {
                       return r.part_a != s.part_a ? r.part_a < s.part_a : r.part_b < s.part_b;
                     });
}

void RigidContacts::count_work(StepReport& report) const {
  for (const std::size_t i : fresh_) {
    report.voxels += pairs_[i].nodes;
    report.tiles += 2 * static_cast<std::int64_t>(pairs_[i].boxes.size());
  }
}

void RigidContacts::append_boxes(std::vector<std::pair<NodeBox, double>>& out) const {
  for (const Pair& p : pairs_)
    for (const NodeBox& box : p.boxes) out.emplace_back(box, p.touch.h);
}

void RigidContacts::keep(std::vector<double>& memory) const {
  std::vector<std::int32_t> elsewhere;
  for (std::size_t p = 0; p < solid_.size(); ++p) {
    if (references_.stamp(p) == 0 || solid_[p] == nullptr) continue;  // of a removed body
    const Pose &now = solid_[p]->pose(), &then = references_.pose(p);
    if (now.rotation != then.rotation || now.translation != then.translation)
      elsewhere.push_back(static_cast<std::int32_t>(p));
  }
  references_.keep(elsewhere, memory);
}

}  // namespace brim
