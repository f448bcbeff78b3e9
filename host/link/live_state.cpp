// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/live_state.hpp"

#include <fmt/format.h>

#include <cstdio>

namespace haptable {

LiveState::Tell teller(const std::string& program, bool quiet) {
    if (quiet) return {};
    return [program](const std::string& text) { fmt::print(stderr, "{}: {}\n", program, text); };
}

}  // namespace haptable
