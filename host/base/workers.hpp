// SPDX-License-Identifier: GPL-2.0-or-later
// Threads that share loops. What a loop computes must not depend on who runs which index: then the number of threads
// changes no bit of the result.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace haptable {

class Workers {
public:
    /// threads: 1 (all on the calling thread) or more.
    explicit Workers(int threads);
    ~Workers();
    Workers(const Workers&) = delete;
    Workers& operator=(const Workers&) = delete;

    int count() const { return static_cast<int>(thread_.size()) + 1; }

    /// Calls work(index, worker) once for every index below `count`, in ascending order where there is one thread, with
    /// worker in 0..count() - 1; returns when all are done. After an exception no new index is begun, and the first one
    /// is thrown again. Must not be called from within `work`.
    using Work = std::function<void(std::size_t index, int worker)>;
    void for_each(std::size_t count, const Work& work);

private:
    void serve(int worker);
    void take(int worker);

    std::mutex mutex_;
    std::condition_variable begun_, ended_;
    const Work* work_ = nullptr;
    std::size_t next_ = 0, end_ = 0;
    std::size_t loop_ = 0;  ///< counts the loops, so that a thread knows a new one
    int busy_ = 0;
    bool stop_ = false;
    std::exception_ptr failed_;
    std::vector<std::thread> thread_;
};

}  // namespace haptable
