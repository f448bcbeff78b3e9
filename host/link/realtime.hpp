// SPDX-License-Identifier: GPL-2.0-or-later
// What a process can ask of Linux to keep a millisecond's tick.
#pragma once

#include <string>

namespace haptable {

/// Asks for exact timers (1 ns timer slack, which everybody may have) and for real-time priority (SCHED_FIFO), which
/// threads made later inherit: call it before a Connection is opened. Never fails; returns what was given, in words.
std::string ask_for_real_time(int priority);

/// Keeps the memory that the process has now from being swapped. True when it was given. Call it once all is set up.
bool lock_memory();

}  // namespace haptable
