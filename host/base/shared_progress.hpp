// SPDX-License-Identifier: GPL-2.0-or-later
// A progress bar for what several threads do together.
#pragma once

#include <cstddef>
#include <mutex>

#include "host/base/progress.hpp"

namespace haptable {

class SharedProgress {
public:
    SharedProgress(Progress& progress, std::size_t count) : progress_(progress), count_(count) {}

    /// Called by whoever begins one of the `count`. Throws Interrupted after Ctrl-C.
    void begin_one() {
        const std::lock_guard lock(mutex_);
        progress_.done(static_cast<double>(begun_++) / static_cast<double>(count_));
    }

private:
    std::mutex mutex_;
    Progress& progress_;
    std::size_t count_, begun_ = 0;
};

}  // namespace haptable
