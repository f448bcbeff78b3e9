// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/finger_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/text.hpp"
#include "host/link/messages.hpp"

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

constexpr int kSilent = 0;  // HAPTABLE_SILENT

/// In which columns what stands; none: -1.
struct Columns {
    struct Finger {
        std::size_t position = 0;
        std::ptrdiff_t buttons = -1, state = -1;
    };

    std::size_t count = 0;  ///< 0: the header is not one of a finger path
    std::vector<Finger> finger;
    std::ptrdiff_t number = -1;
    std::ptrdiff_t turn = -1;  ///< of a tool
};

/// Fingers beside one another, then the buttons of each; of a tool its turn between them.
std::string header_of(std::size_t fingers, bool has_turn, bool has_buttons) {
    std::string header;
    for (std::size_t i = 0; i < fingers; ++i)
        for (const char* axis : {"x", "y", "z"}) header += (header.empty() ? "" : ",") + (axis + column_suffix(i));
    if (has_turn) header += ",qw,qx,qy,qz";
    for (std::size_t i = 0; has_buttons && i < fingers; ++i) header += ",buttons" + column_suffix(i);
    return header;
}

/// Of a servo's CSV.
Columns columns_of_servo(const std::string& header) {
    const std::vector<std::string> names = split(header, ',');
    const auto place = [&](const std::string& name) -> std::ptrdiff_t {
        const auto found = std::find(names.begin(), names.end(), name);
        return found != names.end() ? found - names.begin() : -1;
    };
    Columns columns{names.size(), {{1, place("buttons")}}, 0, place("qw")};
    if (columns.turn + 4 > std::ssize(names)) return {};
    for (std::size_t i = 1; i < kFingers; ++i) {
        const std::ptrdiff_t x = place("x" + column_suffix(i));
        if (x < 0) break;
        if (x + 3 > std::ssize(names)) return {};
        columns.finger.push_back(
            {static_cast<std::size_t>(x), place("buttons" + column_suffix(i)), place("state" + column_suffix(i))});
    }
    // A finger of its own is never away: where it is silent the line says so by its position.
    if (columns.finger.size() > 1) columns.finger[0].state = place("state");
    return columns;
}

/// `header` without blanks.
Columns columns_of(const std::string& header) {
    if (header.starts_with("tick,x,y,z,contact,")) return columns_of_servo(header);
    for (std::size_t fingers = 1; fingers <= kFingers; ++fingers)
        for (const bool has_turn : {false, true})
            for (const bool has_buttons : {false, true}) {
                if ((has_turn && fingers > 1) || header != header_of(fingers, has_turn, has_buttons)) continue;
                const std::size_t buttons = 3 * fingers + (has_turn ? 4 : 0);
                Columns columns;
                columns.count = buttons + (has_buttons ? fingers : 0);
                columns.turn = has_turn ? 3 : -1;
                for (std::size_t i = 0; i < fingers; ++i)
                    columns.finger.push_back({3 * i, has_buttons ? static_cast<std::ptrdiff_t>(buttons + i) : -1});
                return columns;
            }
    return {};
}

/// False unless there is exactly what belongs there.
bool to_tick(std::string_view line, const Columns& columns, FingerTick& tick) {
    const std::vector<std::string> fields = split(line, ',');
    if (fields.size() != columns.count) return false;
    const auto is_there = [&](std::ptrdiff_t column, auto& value) {
        return column < 0 || read_number(trimmed(fields[static_cast<std::size_t>(column)]), value);
    };
    const auto is_finger = [&](const Columns::Finger& at, FingerPlace& finger) {
        int state = -1;
        for (std::size_t c = 0; c < 3; ++c)
            if (!to_number(fields[at.position + c], finger.position_m[c])) return false;
        if (!is_there(at.buttons, finger.buttons) || !is_there(at.state, state)) return false;
        finger.is_away = state == kSilent;
        return true;
    };
    tick.others.resize(columns.finger.size() - 1);
    for (std::size_t i = 0; i < columns.finger.size(); ++i)
        if (!is_finger(columns.finger[i], i == 0 ? static_cast<FingerPlace&>(tick) : tick.others[i - 1])) return false;
    for (std::size_t c = 0; columns.turn >= 0 && c < 4; ++c)
        if (!to_number(fields[static_cast<std::size_t>(columns.turn) + c],
                       (c == 0 ? tick.turn.emplace() : *tick.turn)[c]))
            return false;
    return is_there(columns.number, tick.number);
}

std::string wanted_in(const Columns& columns) {
    if (columns.number >= 0) return "a line of a servo's CSV";
    const std::size_t fingers = columns.finger.size();
    const bool has_buttons = columns.finger[0].buttons >= 0;
    if (columns.turn >= 0)
        return has_buttons ? "x,y,z in metres, a quaternion qw,qx,qy,qz and the buttons' bits"
                           : "x,y,z in metres and a quaternion qw,qx,qy,qz";
    if (fingers == 1)
        return has_buttons ? "three numbers x,y,z in metres and the buttons' bits" : "three numbers x,y,z in metres";
    return fmt::format("{} numbers {} in metres{}", 3 * fingers, header_of(fingers, false, false),
                       has_buttons ? " and the buttons' bits of each" : "");
}

bool is_finite(const std::array<double, 3>& position_m) {
    return std::isfinite(position_m[0]) && std::isfinite(position_m[1]) && std::isfinite(position_m[2]);
}

/// To 1e-3, as the servo takes it.
bool is_rotation(const std::array<double, 4>& turn) {
    constexpr double kLonger = 1e-3;
    const double length = std::sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2] + turn[3] * turn[3]);
    return std::abs(length - 1.0) <= kLonger;
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
    const Columns columns = columns_of(header);
    if (columns.count == 0)
        fail(file, 1,
             "the header is " + excerpt(line) +
                 ": a finger path begins with the line x,y,z, or x,y,z,buttons, or of more fingers "
                 "x,y,z,x2,y2,z2 and on, of a tool x,y,z,qw,qx,qy,qz, or as a servo's CSV does");
    std::vector<FingerTick> path;
    while (!lines.only_blank_left() && lines.next(line)) {
        FingerTick tick;
        if (!to_tick(line, columns, tick))
            fail(file, lines.number(), excerpt(line) + " is not " + wanted_in(columns) + ": mend or remove the line");
        bool is_all_finite = true;
        for (std::size_t i = 0; i < tick.fingers(); ++i)
            is_all_finite &= tick.finger(i).is_away || is_finite(tick.finger(i).position_m);
        if (allowed == Positions::finite && !is_all_finite)
            fail(file, lines.number(), excerpt(line) + " is not finite: a hand cannot go there");
        if (allowed == Positions::finite && tick.turn && !is_rotation(*tick.turn))
            fail(file, lines.number(), excerpt(line) + " has a quaternion qw,qx,qy,qz that is not of length 1");
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
