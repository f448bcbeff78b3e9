// SPDX-License-Identifier: GPL-2.0-or-later
// The channel of a body that rings.
#pragma once

#include <cstddef>
#include <vector>

#include "haptable/body_modes.hpp"

namespace haptable {

inline constexpr const char* kModesChannel = "HAPTABLE_MODES";  ///< body_modes, from the servo

/// What the message says; none where it is not of so many modes.
inline std::vector<float> swung_of(const body_modes& message, std::size_t modes) {
    if (modes > std::size(message.swung) || message.count != static_cast<std::int32_t>(modes)) return {};
    return {message.swung, message.swung + modes};
}

}  // namespace haptable
