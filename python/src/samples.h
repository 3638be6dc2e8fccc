#pragma once

#include <pybind11/numpy.h>

#include <span>

#include "brim/world/step_report.h"
#include "brim/world/world.h"

namespace brim::python {

/// Contacts as an array with named fields: position [m], force and friction [N] on a, overlap [voxels], part_a, part_b,
/// body_a, body_b. Shape (n,).
pybind11::object contacts_array(std::span<const ContactSample> contacts, std::span<const int> body_of_part);

/// Totals of pairs likewise: part_a, part_b, body_a, body_b, contacts, worst_overlap [voxels], force and friction [N]
/// on a, center [m].
pybind11::object pairs_array(std::span<const PairReport> pairs, std::span<const int> body_of_part);

/// Attachments likewise: force [N] on the first body, error [m], coordinate [rad or m], effort [N m or N], broken.
/// Shape (n,), none before the first step.
pybind11::object links_array(std::span<const LinkReport> links);

}  // namespace brim::python
