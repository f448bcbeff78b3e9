// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/record.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

namespace haptable {

namespace {

constexpr const char* kHeader =
    "tick,x,y,z,contact,node_i,node_j,node_k,alpha_i,alpha_j,alpha_k,god_x,god_y,god_z,force_x,force_y,force_z,"
    "buttons,state,faults\n";

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

ServoRecord::ServoRecord(const ServoScene& scene, const std::filesystem::path& path) : scene_(scene), file_(path) {
    file_.add(kHeader);
}

void ServoRecord::add(std::int64_t tick, const std::array<float, 3>& finger_m, std::uint32_t buttons,
                      const haptable_output& out) {
    constexpr float kNowhere[3] = {};
    const bool touches = haptable_touches(out.state) != 0;  // else these may be of a dent that the finger left
    line_ = std::to_string(tick);
    append_floats(finger_m.data(), line_);
    fmt::format_to(std::back_inserter(line_), ",{:d}", touches);
    for (std::size_t c = 0; c < 3; ++c)
        fmt::format_to(std::back_inserter(line_), ",{}", touches ? mesh_node(scene_, out, c) : -1);
    append_floats(touches ? out.alpha : kNowhere, line_);
    append_floats(out.god_object_m, line_);
    append_floats(out.force_n, line_);
    fmt::format_to(std::back_inserter(line_), ",{},{},{}\n", buttons, out.state, out.faults);
    file_.add(line_);
}

}  // namespace haptable
