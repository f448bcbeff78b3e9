// SPDX-License-Identifier: GPL-2.0-or-later
// How a body's stiffness falls with time.
#pragma once

#include <vector>

namespace haptable {

/// One term of g(t) = 1 - sum share (1 - exp(-t / time)): what the whole stiffness is multiplied by (Prony's series).
struct RelaxationTerm {
    double share = 0.0;   ///< of the stiffness at once, > 0; all of them below 1
    double time_s = 0.0;  ///< > 0
    bool operator==(const RelaxationTerm&) const = default;
};

/// What is left for good: 1 less all shares.
inline double rest_share(const std::vector<RelaxationTerm>& terms) {
    double rest = 1.0;
    for (const RelaxationTerm& term : terms) rest -= term.share;
    return rest;
}

}  // namespace haptable
