// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/decode.hpp"

#include <algorithm>

namespace haptable {

namespace {

constexpr std::size_t kLength_bytes = 4;

/// As LCM writes it, the highest byte first, signed as LCM means it; -1 where it is not there.
std::int64_t length_at(std::span<const std::uint8_t> bytes, std::size_t begin) {
    if (begin > bytes.size() || bytes.size() - begin < kLength_bytes) return -1;
    std::uint32_t length = 0;
    for (const std::uint8_t byte : bytes.subspan(begin, kLength_bytes)) length = length << 8 | byte;
    return static_cast<std::int32_t>(length);
}

/// Names of counters are printed on terminals and written into gnuplot's scripts: they hold nothing else.
bool is_of_name(std::uint8_t byte) {
    return (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z') || (byte >= '0' && byte <= '9') || byte == '_';
}

}  // namespace

// All end with their count where their arrays are empty.

bool has_room(const contact*, std::span<const std::uint8_t> bytes, std::size_t fixed) {
    constexpr std::size_t kEntry_bytes = 4 + 3 * 8;  // node, force_n
    const std::int64_t count = length_at(bytes, fixed - kLength_bytes);
    return count >= 0 && bytes.size() - fixed == static_cast<std::size_t>(count) * kEntry_bytes;
}

bool has_room(const tool_wrench*, std::span<const std::uint8_t> bytes, std::size_t fixed) {
    constexpr std::size_t kEntry_bytes = 1 + 9 * 8;  // touches, point_m, god_object_m, force_n
    const std::int64_t count = length_at(bytes, fixed - kLength_bytes);
    return count >= 0 && bytes.size() - fixed == static_cast<std::size_t>(count) * kEntry_bytes;
}

bool has_room(const servo_status*, std::span<const std::uint8_t> bytes, std::size_t fixed) {
    constexpr std::size_t kValue_bytes = 8;
    const std::int64_t count = length_at(bytes, fixed - kLength_bytes);
    if (count < 0) return false;
    std::size_t begin = fixed;
    for (std::int64_t i = 0; i < count; ++i) {
        const std::int64_t length = length_at(bytes, begin);  // with a zero byte at its end
        if (length < 1 || static_cast<std::size_t>(length) > bytes.size() - begin - kLength_bytes) return false;
        const auto name = bytes.subspan(begin + kLength_bytes, static_cast<std::size_t>(length));
        if (name.back() != 0 || !std::all_of(name.begin(), name.end() - 1, is_of_name)) return false;
        begin += kLength_bytes + name.size();
    }
    return bytes.size() - begin == static_cast<std::size_t>(count) * kValue_bytes;
}

}  // namespace haptable
