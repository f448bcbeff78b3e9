// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/messages.hpp"

#include <random>

namespace haptable {

std::int64_t random_session() {
    std::random_device random;  // the kernel's, 32 bits at a time
    for (;;) {
        const std::uint64_t session = std::uint64_t{random()} << 32 | random();
        if (session != 0) return static_cast<std::int64_t>(session);
    }
}

}  // namespace haptable
