// SPDX-License-Identifier: GPL-2.0-or-later
// Work of a library that may crash, hang or take all memory, in a process of its own.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

namespace haptable {

/// Bounds of the child. Under a sanitizer the memory is not bounded: its shadow takes terabytes of addresses.
struct ChildLimits {
    std::size_t memory_bytes = 0;  ///< beyond what this process has now
    unsigned cpu_s = 0;
};

/// What the work counts while it runs, in memory that both processes see.
struct ChildCount {
    std::atomic<std::uint64_t> done{0}, expected{0};
};

/// Looks at the count ten times a second while the child works.
using WatchChild = std::function<void(const ChildCount& count)>;

/// Runs `work` in a forked process and returns the bytes that it returns. An Error thrown there is thrown here with its
/// text; any other end (a signal, no memory, out of time) throws Error(what + how it ended).
std::string run_in_child(const std::string& what, const ChildLimits& limits,
                         const std::function<std::string(ChildCount&)>& work, const WatchChild& watch);
inline std::string run_in_child(const std::string& what, const ChildLimits& limits,
                                const std::function<std::string()>& work) {
    return run_in_child(what, limits, [&](ChildCount&) { return work(); }, {});
}

}  // namespace haptable
