// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/si.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace haptable {

std::string si(double value, const char* unit) {
    constexpr std::array<const char*, 6> kPrefix{"n", "u", "m", "", "k", "M"};
    constexpr int kNone = 3;  // its place there
    if (!std::isfinite(value) || value == 0.0) return fmt::format("{:g} {}", value, unit);
    // As it is printed: 999.9 m are 1 of the next prefix.
    const double printed = std::stod(fmt::format("{:.2e}", std::abs(value)));
    const int thousands = static_cast<int>(std::floor(std::log10(printed) / 3.0 + 1e-9));
    const int place = std::min(std::max(thousands + kNone, 0), static_cast<int>(kPrefix.size()) - 1);
    const double scaled = value * std::pow(1000.0, kNone - place);
    const double size = std::stod(fmt::format("{:.2e}", std::abs(scaled)));
    const int decimals = std::clamp(2 - static_cast<int>(std::floor(std::log10(size) + 1e-9)), 0, 9);
    return fmt::format("{:.{}f} {}{}", scaled, decimals, kPrefix[static_cast<std::size_t>(place)], unit);
}

}  // namespace haptable
