// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/record.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

namespace haptable {

namespace {

constexpr const char* kHeader =
    "tick,x,y,z,contact,node_i,node_j,node_k,alpha_i,alpha_j,alpha_k,god_x,god_y,god_z,force_x,force_y,force_z,"
    "buttons,state,faults";
constexpr const char* kHeaderOfSecond =
    ",x2,y2,z2,contact2,node_i2,node_j2,node_k2,alpha_i2,alpha_j2,alpha_k2,god_x2,god_y2,god_z2,force_x2,force_y2,"
    "force_z2,buttons2,state2,faults2";

void append_floats(const float values[3], std::string& text) {
    for (int i = 0; i < 3; ++i) {
        // NaN has a sign bit that means nothing: one spelling for all of them.
        if (std::isnan(values[i]))
            text += ",nan";
        else
            fmt::format_to(std::back_inserter(text), ",{:.9g}", values[i]);
    }
}

}  // namespace

ServoRecord::ServoRecord(const ServoScene& scene, const std::filesystem::path& path, int fingers)
    : scene_(scene), file_(path) {
    file_.add(std::string(kHeader) + (fingers == 2 ? kHeaderOfSecond : "") + "\n");
}

void ServoRecord::add(std::int64_t tick, const std::array<float, 3>& finger_m, std::uint32_t buttons,
                      const haptable_output& out) {
    line_ = std::to_string(tick);
    append(finger_m, buttons, out);
    file_.add(line_ += '\n');
}

void ServoRecord::add(std::int64_t tick, const std::array<std::array<float, 3>, 2>& finger_m,
                      const std::array<std::uint32_t, 2>& buttons, const haptable_output out[2]) {
    line_ = std::to_string(tick);
    for (std::size_t finger = 0; finger < 2; ++finger) append(finger_m[finger], buttons[finger], out[finger]);
    file_.add(line_ += '\n');
}

void ServoRecord::append(const std::array<float, 3>& finger_m, std::uint32_t buttons, const haptable_output& out) {
    constexpr float kNowhere[3] = {};
    const bool touches = haptable_touches(out.state) != 0;  // else these may be of a dent that the finger left
    append_floats(finger_m.data(), line_);
    fmt::format_to(std::back_inserter(line_), ",{:d}", touches);
    for (std::size_t c = 0; c < 3; ++c)
        fmt::format_to(std::back_inserter(line_), ",{}", touches ? mesh_node(scene_, out, c) : -1);
    append_floats(touches ? out.alpha : kNowhere, line_);
    append_floats(out.god_object_m, line_);
    append_floats(out.force_n, line_);
    fmt::format_to(std::back_inserter(line_), ",{},{},{}", buttons, out.state, out.faults);
}

}  // namespace haptable
