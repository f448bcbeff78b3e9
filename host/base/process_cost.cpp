// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/process_cost.hpp"

#include <sys/resource.h>

#include <ctime>

namespace haptable {

ProcessCost process_cost() {
    timespec cpu{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu);
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return {static_cast<double>(cpu.tv_sec) + 1e-9 * static_cast<double>(cpu.tv_nsec),
            1024.0 * static_cast<double>(usage.ru_maxrss)};
}

}  // namespace haptable
