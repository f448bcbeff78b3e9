// SPDX-License-Identifier: GPL-2.0-or-later
// What a run would tell of a body before it has tables.
#pragma once

#include <optional>

#include "host/body/gravity.hpp"
#include "host/body/locking.hpp"

namespace haptable {

struct Foretold {
    Locking locking;
    std::optional<GravityFacts> gravity;  ///< of a body that is held under its weight
};

/// By one factorisation of K, as a run measures both; none where neither is asked for. Locking is foreseen from the
/// mesh where the factor does not fit into memory and nothing else needs it. Throws Error where K is singular.
Foretold foretell(const Scene& scene, const Body& body, Progress& progress);

}  // namespace haptable
