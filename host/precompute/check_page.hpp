// SPDX-License-Identifier: GPL-2.0-or-later
// What --check found, to be looked at: one HTML page that turns the surface by the pointer and asks no network.
#pragma once

#include <string>

#include "host/body/body.hpp"
#include "host/mesh/audit.hpp"

namespace haptable {

/// The page's text: held and touchable parts, the box with its limits in metres, axes, a bar of length, the worst
/// elements with their numbers, hinges, and the nodes that are under-constrained.
std::string check_page(const Scene& scene, const Body& body, const Audit& audit,
                       const std::vector<std::int32_t>& under_constrained);

}  // namespace haptable
