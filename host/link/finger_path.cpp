// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/finger_path.hpp"

#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

#include "host/base/error.hpp"
#include "host/base/file.hpp"

namespace haptable {

namespace {

/// The lines of a text, without their ends: \n, or \r\n as other systems write them.
class Lines {
public:
    explicit Lines(std::string_view text) : rest_(text) {}

    bool next(std::string_view& line) {
        if (rest_.empty()) return false;
        const std::size_t end = rest_.find('\n');
        line = rest_.substr(0, end);
        rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        ++number_;
        return true;
    }
    int number() const { return number_; }
    bool only_blank_left() const { return rest_.find_first_not_of(" \t\r\n") == std::string_view::npos; }

private:
    std::string_view rest_;
    int number_ = 0;
};

std::string_view trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// Reads one number, "nan" and "inf" among them. What is too large for a double is infinite, as IEEE 754 has it.
bool to_number(std::string_view text, double& value) {
    text = trimmed(text);
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (stop != end) return false;
    if (error == std::errc::result_out_of_range) {
        const bool tiny = text.find("e-") != std::string_view::npos || text.find("E-") != std::string_view::npos;
        value = tiny ? 0.0 : std::numeric_limits<double>::infinity();
        if (text[0] == '-') value = -value;
        return true;
    }
    return error == std::errc();
}

/// Takes the field before the next comma off the line; false where there is none, or it is no number.
template <typename Number, typename Read>
bool take_field(std::string_view& line, bool is_last, Number& value, Read read) {
    const std::size_t comma = line.find(',');
    if ((comma == std::string_view::npos) != is_last || !read(line.substr(0, comma), value)) return false;
    line.remove_prefix(is_last ? line.size() : comma + 1);
    return true;
}

bool to_bits(std::string_view text, std::uint32_t& bits) {
    text = trimmed(text);
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, bits);
    return stop == end && error == std::errc();
}

/// Splits at the commas; false unless there is exactly what belongs there.
bool to_tick(std::string_view line, bool has_buttons, FingerTick& tick) {
    for (std::size_t i = 0; i < 3; ++i)
        if (!take_field(line, i == 2 && !has_buttons, tick.position_m[i], to_number)) return false;
    return !has_buttons || take_field(line, true, tick.buttons, to_bits);
}

bool is_finite(const std::array<double, 3>& position_m) {
    return std::isfinite(position_m[0]) && std::isfinite(position_m[1]) && std::isfinite(position_m[2]);
}

std::string without_blanks(std::string_view line) {
    std::string text;
    for (const char c : line)
        if (c != ' ' && c != '\t') text += c;
    return text;
}

[[noreturn]] void fail(const std::filesystem::path& file, int line, const std::string& what) {
    throw Error(file.string() + ":" + std::to_string(line) + ": " + what);
}

/// What is shown of a bad row: not all of a binary file.
std::string excerpt(std::string_view line) {
    std::string shown(line.substr(0, 40));
    for (char& c : shown)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7E) c = '?';
    return "\"" + shown + (line.size() > 40 ? "...\"" : "\"");
}

}  // namespace

std::vector<FingerTick> read_finger_ticks(const std::filesystem::path& file, Positions allowed) {
    const std::string text = read_text(file);
    Lines lines(text);
    std::string_view line;
    const std::string header = lines.next(line) ? without_blanks(line) : "";
    const bool has_buttons = header == "x,y,z,buttons";
    if (!has_buttons && header != "x,y,z")
        fail(file, 1,
             "the header is " + excerpt(line) + ": a finger path begins with the line x,y,z, or x,y,z,buttons");
    const std::string wanted =
        has_buttons ? "three numbers x,y,z in metres and the buttons' bits" : "three numbers x,y,z in metres";
    std::vector<FingerTick> path;
    while (!lines.only_blank_left() && lines.next(line)) {
        FingerTick tick;
        if (!to_tick(line, has_buttons, tick))
            fail(file, lines.number(), excerpt(line) + " is not " + wanted + ": mend or remove the line");
        if (allowed == Positions::finite && !is_finite(tick.position_m))
            fail(file, lines.number(), excerpt(line) + " is not finite: a hand cannot go there");
        path.push_back(tick);
    }
    return path;
}

std::vector<std::array<double, 3>> read_finger_path(const std::filesystem::path& file, Positions allowed) {
    std::vector<std::array<double, 3>> path_m;
    for (const FingerTick& tick : read_finger_ticks(file, allowed)) path_m.push_back(tick.position_m);
    return path_m;
}

}  // namespace haptable
