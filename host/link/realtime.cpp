// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/realtime.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>

namespace haptable {

std::string ask_for_real_time(int priority) {
    // The default slack of 50 us is most of the lateness of a wake-up on an idle machine.
    prctl(PR_SET_TIMERSLACK, 1UL);
    sched_param wanted{};
    wanted.sched_priority = priority;
    if (sched_setscheduler(0, SCHED_FIFO, &wanted) == 0) return "SCHED_FIFO " + std::to_string(priority);
    return "normal priority (SCHED_FIFO is for root)";
}

// Not MCL_FUTURE: for a user with a memlock limit every later allocation, a thread's stack among them, could fail.
bool lock_memory() { return mlockall(MCL_CURRENT) == 0; }

}  // namespace haptable
