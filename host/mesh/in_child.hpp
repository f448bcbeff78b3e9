// SPDX-License-Identifier: GPL-2.0-or-later
// Work of a library that may crash, hang or take all memory, in a process of its own.
#pragma once

#include <functional>
#include <string>

namespace haptable {

/// Bounds of the child. Under a sanitizer the memory is not bounded: its shadow takes terabytes of addresses.
struct ChildLimits {
    std::size_t memory_bytes = 0;  ///< beyond what this process has now
    unsigned cpu_s = 0;
};

/// Runs `work` in a forked process and returns the bytes that it returns. An Error thrown there is thrown here with its
/// text; any other end (a signal, no memory, out of time) throws Error(what + how it ended).
std::string run_in_child(const std::string& what, const ChildLimits& limits, const std::function<std::string()>& work);

}  // namespace haptable
