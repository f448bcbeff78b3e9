// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/decode.hpp"

namespace haptable {

std::int64_t count_at_end(std::span<const std::uint8_t> bytes, std::size_t fixed) {
    constexpr std::size_t kCount_bytes = 4;
    if (bytes.size() < fixed || fixed < kCount_bytes) return -1;
    std::uint32_t count = 0;  // as LCM writes it, the highest byte first
    for (std::size_t b = fixed - kCount_bytes; b < fixed; ++b) count = count << 8 | bytes[b];
    return static_cast<std::int32_t>(count);
}

}  // namespace haptable
