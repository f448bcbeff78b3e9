// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/limits.hpp"

#include <fmt/format.h>

namespace haptable {

std::string fault_of_mean(const SafetyLimits& limits, double max_force_n) {
    const double mean2 = limits.mean_force_n * limits.mean_force_n, most2 = max_force_n * max_force_n;
    if (!limits.has_mean(max_force_n) || (2.0 * most2 / mean2 - 1.0) * kServoTick_s <= limits.mean_force_time_s)
        return {};
    return fmt::format("is {} s, too short for max_force = {} N and mean_force = {} N: give {:.2g} s or more",
                       limits.mean_force_time_s, max_force_n, limits.mean_force_n,
                       1.01 * (2.0 * most2 / mean2 - 1.0) * kServoTick_s);
}

}  // namespace haptable
