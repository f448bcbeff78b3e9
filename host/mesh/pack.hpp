// SPDX-License-Identifier: GPL-2.0-or-later
// What a child process answers: values one after the other, as memory holds them, for both ends are this program.
#pragma once

#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/error.hpp"

namespace haptable {

class Packer {
public:
    template <typename T>
    void list(const std::vector<T>& values) {
        one(values.size());
        bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    }
    template <typename T>
    void one(const T& value) {
        bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    void text(const std::string& text) { list(std::vector<char>(text.begin(), text.end())); }
    std::string take() { return std::move(bytes_); }

private:
    std::string bytes_;
};

class Unpacker {
public:
    explicit Unpacker(std::string_view bytes) : bytes_(bytes) {}
    template <typename T>
    T one() {
        T value{};
        std::memcpy(&value, take(sizeof value), sizeof value);
        return value;
    }
    template <typename T>
    std::vector<T> list() {
        std::vector<T> values(one<std::size_t>());
        if (!values.empty()) std::memcpy(values.data(), take(values.size() * sizeof(T)), values.size() * sizeof(T));
        return values;
    }
    std::string text() {
        const auto letters = list<char>();
        return {letters.begin(), letters.end()};
    }

private:
    const char* take(std::size_t count) {
        if (count > bytes_.size()) throw Error("a mesh library's answer was cut off; try again");
        const char* at = bytes_.data();
        bytes_.remove_prefix(count);
        return at;
    }
    std::string_view bytes_;
};

}  // namespace haptable
