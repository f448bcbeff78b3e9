// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/workers.hpp"

#include <utility>

namespace haptable {

Workers::Workers(int threads) {
    for (int worker = 1; worker < threads; ++worker) thread_.emplace_back([this, worker] { serve(worker); });
}

Workers::~Workers() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    begun_.notify_all();
    for (std::thread& thread : thread_) thread.join();
}

void Workers::for_each(std::size_t count, const Work& work) {
    if (thread_.empty() || count < 2) {
        for (std::size_t index = 0; index < count; ++index) work(index, 0);
        return;
    }
    {
        const std::lock_guard lock(mutex_);
        work_ = &work;
        next_ = 0;
        end_ = count;
        busy_ = this->count();
        ++loop_;
    }
    begun_.notify_all();
    take(0);
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [this] { return busy_ == 0; });
    if (failed_) std::rethrow_exception(std::exchange(failed_, nullptr));
}

void Workers::serve(int worker) {
    std::size_t seen = 0;
    for (;;) {
        {
            std::unique_lock lock(mutex_);
            begun_.wait(lock, [&] { return stop_ || loop_ != seen; });
            if (stop_) return;
            seen = loop_;
        }
        take(worker);
    }
}

/// Runs indices until none is left.
void Workers::take(int worker) {
    std::unique_lock lock(mutex_);
    while (next_ < end_) {
        const std::size_t index = next_++;
        lock.unlock();
        std::exception_ptr failed;
        try {
            (*work_)(index, worker);
        } catch (...) {
            failed = std::current_exception();
        }
        lock.lock();
        if (!failed) continue;
        if (!failed_) failed_ = failed;
        end_ = 0;
    }
    if (--busy_ == 0) ended_.notify_one();
}

}  // namespace haptable
