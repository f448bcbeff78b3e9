// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/workers.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

namespace haptable {
namespace {

TEST(WorkersOf, AnyNumberDoEveryIndexOnce) {
    for (int threads : {1, 2, 7}) {
        Workers workers(threads);
        EXPECT_EQ(workers.count(), threads);
        for (std::size_t count : {0U, 1U, 3U, 1000U}) {
            std::vector<std::atomic<int>> seen(count);
            std::atomic<bool> inside{true};
            workers.for_each(count, [&](std::size_t index, int worker) {
                ++seen[index];
                if (worker < 0 || worker >= threads) inside = false;
            });
            for (const auto& times : seen) EXPECT_EQ(times, 1);
            EXPECT_TRUE(inside);
        }
    }
}

TEST(WorkersOf, AnExceptionComesOutAndTheyGoOn) {
    for (int threads : {1, 4}) {
        Workers workers(threads);
        for (int round = 0; round < 20; ++round) {
            EXPECT_THROW(workers.for_each(50,
                                          [](std::size_t index, int) {
                                              if (index == 7) throw std::runtime_error("seven");
                                          }),
                         std::runtime_error);
            std::atomic<int> done{0};
            workers.for_each(50, [&](std::size_t, int) { ++done; });
            EXPECT_EQ(done, 50);
        }
    }
}

}  // namespace
}  // namespace haptable
