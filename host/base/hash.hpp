// SPDX-License-Identifier: GPL-2.0-or-later
// XXH3 (64 bits): what tells two inputs, two files or two tables apart. Not against who means to deceive.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <type_traits>

struct XXH3_state_s;  // of xxhash.h

namespace haptable {

/// Hash of values in a fixed order. Every list is preceded by its length, so that no two contents write alike.
class Hash {
public:
    Hash();

    template <typename T>
    void add(std::span<const T> values) {
        static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>);
        const std::uint64_t count = values.size();
        add_bytes(std::as_bytes(std::span(&count, 1)));
        add_bytes(std::as_bytes(values));
    }
    void add(const std::string& text) { add(std::span<const char>(text)); }
    void add(double value) { add(std::span<const double>(&value, 1)); }
    /// Without their number.
    void add_bytes(std::span<const std::byte> bytes);

    std::uint64_t digest() const;
    std::string text() const;  ///< the digest, 16 hex digits

private:
    struct Free {
        void operator()(XXH3_state_s* state) const;
    };
    std::unique_ptr<XXH3_state_s, Free> state_;
};

/// Hash of a file's bytes, 16 hex digits; empty where it cannot be read.
std::string hash_file(const std::filesystem::path& path);

}  // namespace haptable
