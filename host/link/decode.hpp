// SPDX-License-Identifier: GPL-2.0-or-later
// Bytes to a message, or to nothing: what lcm-gen's decoders believe is looked at first.
#pragma once

#include <cstdint>
#include <span>

#include "host/link/messages.hpp"

namespace haptable {

/// Bytes of the hash that every LCM message begins with; its type's name and fields make it.
inline constexpr std::size_t kTypeHash_bytes = 8;

/// The number of entries that a message says it has where its fixed part, `fixed` bytes, ends with it; -1 without one.
std::int64_t count_at_end(std::span<const std::uint8_t> bytes, std::size_t fixed);

/// True when as many entries as the message says can lie in its bytes: a decoder makes room for them first.
template <typename Message>
bool has_room(std::span<const std::uint8_t> bytes, std::size_t fixed) {
    return bytes.size() == fixed;
}
template <>
inline bool has_room<contact>(std::span<const std::uint8_t> bytes, std::size_t fixed) {
    constexpr std::size_t kEntry_bytes = 4 + 3 * 8;  // node, force_n
    const std::int64_t count = count_at_end(bytes, fixed);
    return count >= 0 && bytes.size() - fixed == static_cast<std::size_t>(count) * kEntry_bytes;
}
template <>
inline bool has_room<servo_status>(std::span<const std::uint8_t> bytes, std::size_t fixed) {
    constexpr std::size_t kLeastEntry_bytes = (4 + 1) + 8;  // an empty name, value
    const std::int64_t count = count_at_end(bytes, fixed);
    return count >= 0 && bytes.size() - fixed >= static_cast<std::size_t>(count) * kLeastEntry_bytes;
}

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
    if (!is_of_type<Message>(bytes) || !has_room<Message>(bytes, kFixed)) return false;
    const auto size = static_cast<int>(bytes.size());
    try {
        return message.decode(bytes.data(), 0, size) == size;
    } catch (const std::exception&) {  // of a name whose length is none
        return false;
    }
}

}  // namespace haptable
