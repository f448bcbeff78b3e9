// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "host/base/error.hpp"
#include "host/base/text.hpp"

namespace haptable {

namespace {

bool separates(char c) { return c == ' ' || c == '\t' || c == ',' || c == '\f' || c == '\v'; }

/// What of a field an error shows: a damaged file may hold anything.
std::string shown(std::string_view field) {
    std::string text(field.substr(0, 40));
    for (char& c : text)
        if (c < ' ' || c > '~') c = '?';
    return text;
}

}  // namespace

void Lines::fail(const std::string& what) const { throw Error(fmt::format("{}:{}: {}", name_, number_, what)); }

void Lines::cut() {
    field_.clear();
    for (std::size_t at = 0; at < line_.size();) {
        if (separates(line_[at])) {
            ++at;
            continue;
        }
        std::size_t end = at;
        while (end < line_.size() && !separates(line_[end])) ++end;
        field_.push_back(line_.substr(at, end - at));
        at = end;
    }
}

bool Lines::next(char comment) {
    if (again_) {
        again_ = false;
        return true;
    }
    while (!rest_.empty()) {
        const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
        line_ = rest_.substr(0, end);
        const bool crlf = end + 1 < rest_.size() && rest_[end] == '\r' && rest_[end + 1] == '\n';
        rest_.remove_prefix(std::min(rest_.size(), end + (crlf ? 2 : 1)));
        ++number_;
        line_ = line_.substr(0, line_.find(comment));
        cut();
        if (!field_.empty()) return true;
    }
    field_.clear();
    return false;
}

void Lines::require(const char* what, char comment) {
    if (!next(comment)) fail(fmt::format("the file ends before {}; it is cut off: save it again", what));
}

std::string_view Lines::field(std::size_t k, const char* what) const {
    if (k >= field_.size())
        fail(fmt::format("the line has {} fields, and field {} should be {}; save the mesh again", field_.size(), k + 1,
                         what));
    std::string_view text = field_[k];
    if (text.size() > 1 && text[0] == '+') text.remove_prefix(1);
    return text;
}

double Lines::real(std::size_t k) const {
    const std::string_view text = field(k, "a number");
    double value = 0.0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failed == std::errc::result_out_of_range)
        fail(fmt::format("\"{}\" is beyond the range of double; mend the coordinate", shown(text)));
    if (failed != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        fail(fmt::format("\"{}\" is not a finite number; mend it (decimals need a point, not a comma)", shown(text)));
    return value;
}

std::uint64_t Lines::whole(std::size_t k, const char* what) const {
    const std::string_view text = field(k, what);
    std::uint64_t value = 0;
    if (!read_number(text, value))
        fail(
            fmt::format("\"{}\" is not {}: a whole number from 0 to 2^64 - 1; save the mesh again", shown(text), what));
    return value;
}

std::size_t Lines::count(std::size_t k, const char* what) const {
    constexpr std::size_t kLeastBytes = 6;  // of a record: "0 0 0\n" and more
    const std::uint64_t value = whole(k, what);
    if (value > (rest_.size() + 1) / kLeastBytes)
        fail(fmt::format("{} is {}, more than the {} bytes that follow can hold; the file is damaged or cut off", what,
                         value, rest_.size()));
    return static_cast<std::size_t>(value);
}

}  // namespace haptable
