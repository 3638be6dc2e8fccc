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

}  // namespace brim::python
