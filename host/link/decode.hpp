// SPDX-License-Identifier: GPL-2.0-or-later
// Bytes to a message, or to nothing: what lcm-gen's decoders believe is looked at first.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>

#include "host/link/messages.hpp"

namespace haptable {

/// Bytes of the hash that every LCM message begins with; its type's name and fields make it.
inline constexpr std::size_t kTypeHash_bytes = 8;

/// True when every length that a message says lies in its bytes, and its names hold letters, digits and underscores:
/// lcm-gen's decoders make room for what the lengths say, and take a name of 2^31 bytes for one that fits. `fixed`:
/// bytes of the message with empty arrays. A type with a variable length that has no overload here is refused unless
/// its arrays are empty.
inline bool has_room(const void*, std::span<const std::uint8_t> bytes, std::size_t fixed) {
    return bytes.size() == fixed;
}
bool has_room(const contact*, std::span<const std::uint8_t> bytes, std::size_t fixed);
bool has_room(const tool_wrench*, std::span<const std::uint8_t> bytes, std::size_t fixed);
bool has_room(const servo_status*, std::span<const std::uint8_t> bytes, std::size_t fixed);

/// True when the bytes begin as those of this type do: another version's do not.
template <typename Message>
bool is_of_type(std::span<const std::uint8_t> bytes) {
    std::uint64_t hash = 0;
    for (std::size_t b = 0; b < kTypeHash_bytes && b < bytes.size(); ++b) hash = hash << 8 | bytes[b];
    return bytes.size() >= kTypeHash_bytes && hash == static_cast<std::uint64_t>(Message::getHash());
}

/// False, and `message` anything, unless the bytes are one message of its type and no more.
template <typename Message>
bool decode_whole(std::span<const std::uint8_t> bytes, Message& message) {
    static const auto kFixed = static_cast<std::size_t>(Message{}.getEncodedSize());  // its arrays are empty
    if (!is_of_type<Message>(bytes) || !has_room(&message, bytes, kFixed)) return false;
    const auto size = static_cast<int>(bytes.size());
    return message.decode(bytes.data(), 0, size) == size;
}

/// What came on a channel: on none of those that are asked for; a message of another version's type; one that is not
/// whole; one that was taken.
enum class Heard { elsewhere, other_version, damaged, taken };

/// A function of several types.
template <typename... Takes>
struct Overloaded : Takes... {
    using Takes::operator()...;
};
template <typename... Takes>
Overloaded(Takes...) -> Overloaded<Takes...>;

/// Calls take(message, finger) with the message that the bytes on this channel are. Channels whose type `take` does not
/// take are elsewhere.
template <typename Take>
Heard take_message(std::string_view channel, std::span<const std::uint8_t> bytes, Take&& take) {
    Heard heard = Heard::elsewhere;
    each_channel([&]<typename Message>(const char* its, std::size_t finger) {
        if constexpr (std::is_invocable_v<Take&, const Message&, std::size_t>) {
            if (channel != its) return;
            Message message;
            heard = !is_of_type<Message>(bytes)     ? Heard::other_version
                    : !decode_whole(bytes, message) ? Heard::damaged
                                                    : Heard::taken;
            if (heard == Heard::taken) take(static_cast<const Message&>(message), finger);
        }
    });
    return heard;
}

}  // namespace haptable
