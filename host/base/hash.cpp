// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/hash.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <fstream>
#include <vector>

namespace haptable {

void Hash::Free::operator()(XXH3_state_s* state) const { XXH3_freeState(state); }

Hash::Hash() : state_(XXH3_createState()) { XXH3_64bits_reset(state_.get()); }

void Hash::add_bytes(std::span<const std::byte> bytes) { XXH3_64bits_update(state_.get(), bytes.data(), bytes.size()); }

std::uint64_t Hash::digest() const { return XXH3_64bits_digest(state_.get()); }

std::string Hash::text() const { return fmt::format("{:016x}", digest()); }

std::string hash_file(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) return {};
    Hash hash;
    std::vector<char> piece(std::size_t{1} << 20U);
    while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())) || file.gcount() > 0)
        hash.add_bytes(std::as_bytes(std::span(piece).first(static_cast<std::size_t>(file.gcount()))));
    return hash.text();
}

}  // namespace haptable
