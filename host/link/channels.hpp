// SPDX-License-Identifier: GPL-2.0-or-later
// The channels of each finger: a second one speaks on its own, so that messages are the same for both.
#pragma once

#include <array>
#include <cstddef>

#include "haptable/body_pose.hpp"
#include "host/link/messages.hpp"

namespace haptable {

inline constexpr std::size_t kFingers = 2;  ///< the most of a scene

inline constexpr const char* kBodyChannel = "HAPTABLE_BODY";  ///< body_pose, from the servo

/// By finger, 0 or 1.
inline constexpr std::array<const char*, kFingers> kStateChannels{kStateChannel, "HAPTABLE_STATE_2"};
inline constexpr std::array<const char*, kFingers> kForceChannels{kForceChannel, "HAPTABLE_FORCE_2"};
inline constexpr std::array<const char*, kFingers> kContactChannels{kContactChannel, "HAPTABLE_CONTACT_2"};

/// What names of a second finger's counters and columns end with.
inline constexpr std::array<const char*, kFingers> kFingerSuffix{"", "_2"};

}  // namespace haptable
