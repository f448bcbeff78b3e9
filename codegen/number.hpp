// SPDX-License-Identifier: GPL-2.0-or-later
// Numbers as the servo has them, and as its C text does.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "host/base/error.hpp"

namespace haptable {

/// Throws Error of these words where it is no finite float.
inline float to_float(double value, const char* otherwise) {
    const auto narrow = static_cast<float>(value);
    if (!std::isfinite(narrow)) throw Error(otherwise);
    return narrow;
}

/// A float literal that reads back to the same bits. Throws Error rather than a NaN or an infinity.
inline std::string literal(float value) {
    if (!std::isfinite(value)) throw Error("a table holds a number that is not finite: make the tables again");
    std::string text = fmt::format("{:.9g}", value);
    if (text.find_first_of(".e") == std::string::npos) text += ".0";
    return text + "f";
}

}  // namespace haptable
