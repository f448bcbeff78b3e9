// SPDX-License-Identifier: GPL-2.0-or-later
// The messages of a session: types that lcm-gen makes from codegen/lcm/*.lcm, and the list of codegen/lcm/channels.list
// over which all loop who send, keep or read them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

// lcm-gen 1.3.1 writes implicit conversions for variable-size arrays.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#include "haptable/channels.hpp"
#pragma GCC diagnostic pop

namespace haptable {

inline constexpr std::size_t kFingers = 8;  ///< the most of a scene

/// What names of a finger's counters and columns end with.
inline constexpr std::array<const char*, kFingers> kFingerSuffix{"", "_2", "_3", "_4", "_5", "_6", "_7", "_8"};

enum class Sender { device, servo };

/// Where a message is heard: kSender, and kChannels of each finger, or of all.
template <typename Message>
struct Sent;

// NOLINTBEGIN(bugprone-macro-parentheses): names of types
#define HAPTABLE_SENT(channel, type, sender, fingers)                    \
    template <>                                                          \
    struct Sent<type> {                                                  \
        static constexpr Sender kSender = Sender::sender;                \
        static constexpr std::size_t kChannelCount = (fingers);          \
        static constexpr const char* kChannels[kFingers] = {             \
            #channel,      #channel "_2", #channel "_3", #channel "_4",  \
            #channel "_5", #channel "_6", #channel "_7", #channel "_8"}; \
    };
// NOLINTEND(bugprone-macro-parentheses)
HAPTABLE_MESSAGES(HAPTABLE_SENT)
#undef HAPTABLE_SENT

/// finger: 0 to kFingers - 1, of a message that each finger has; else 0.
template <typename Message>
constexpr const char* channel_of(std::size_t finger = 0) {
    return Sent<Message>::kChannels[finger];
}

/// visit.template operator()<Message>(channel, finger) for every channel, in the order of the list.
template <typename Visit>
void each_channel(Visit&& visit) {
#define HAPTABLE_VISIT_CHANNELS(channel, type, sender, fingers) \
    for (std::size_t finger = 0; finger < (fingers); ++finger)  \
        visit.template operator()<type>(channel_of<type>(finger), finger);
    HAPTABLE_MESSAGES(HAPTABLE_VISIT_CHANNELS)
#undef HAPTABLE_VISIT_CHANNELS
}

/// In lockstep the device's clock is simulated: it waits for every answer.
inline bool is_simulated(const device_state& state) { return state.mode == device_state::SIMULATED; }

/// As the firmware takes them.
inline std::uint32_t buttons_of(const device_state& state) { return static_cast<std::uint32_t>(state.buttons); }

/// How far the modes have swung, as the message says; none where it is not of so many modes.
inline std::vector<float> swung_of(const body_modes& message, std::size_t modes) {
    if (modes > std::size(message.swung) || message.count != static_cast<std::int32_t>(modes)) return {};
    return {message.swung, message.swung + modes};
}

/// A number that tells this run of a device or a servo from every other, never 0.
std::int64_t random_session();

}  // namespace haptable
