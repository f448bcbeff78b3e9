// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <filesystem>
#include <utility>

#include "host/numbers/numbers.hpp"

namespace haptable {

/// How many times as fast as a finger proxy on the same patches (host/bench/proxy) a whole tick of each mode is, median
/// and 99.9 %, on the cube and the mouse; first the proxy's own times. Beside FingerProxy, and beside ShellProxy. Over
/// strokes at up to 0.1 m/s through the surface and aside, in the ticks in which the finger is in contact, each as fast
/// as it was in any of `rounds`.
std::pair<NumberTable, NumberTable> beside_proxies(const std::filesystem::path& build, int rounds);

}  // namespace haptable
