// SPDX-License-Identifier: GPL-2.0-or-later
// What this process took so far.
#pragma once

namespace haptable {

struct ProcessCost {
    double cpu_s = 0.0;       ///< of all threads
    double peak_bytes = 0.0;  ///< largest resident set
};

ProcessCost process_cost();

}  // namespace haptable
