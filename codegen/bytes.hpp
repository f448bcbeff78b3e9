// SPDX-License-Identifier: GPL-2.0-or-later
// What a hash is taken of, and what an image or a page reads: one row of bytes, little-endian, without padding.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <utility>

namespace haptable {

static_assert(std::endian::native == std::endian::little);

class Bytes {
public:
    template <typename T>
    void add(const T& value) {
        add(&value, 1);
    }
    template <typename Row>
    void add(const Row* rows, std::size_t count) {
        if (count > 0) text_.append(reinterpret_cast<const char*>(rows), count * sizeof(Row));
    }
    /// After their number, 32 bits. rows: null: none.
    template <typename Row>
    void add_table(const Row* rows, std::size_t count) {
        if (rows == nullptr) count = 0;
        add(static_cast<std::uint32_t>(count));
        add(rows, count);
    }
    std::string take() { return std::move(text_); }

private:
    std::string text_;
};

}  // namespace haptable

// How a list of fields is added to `bytes`, from `from`. NOLINTBEGIN(bugprone-macro-parentheses): names that are
// declared
#define HAPTABLE_ADD_VALUE(type, name) bytes.add(from.name);
#define HAPTABLE_ADD_TABLE(type, name, count) bytes.add_table(from.name, static_cast<std::size_t>(count));
// NOLINTEND(bugprone-macro-parentheses)
