// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/record.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>

#include "host/link/finger_path.hpp"

namespace haptable {

namespace {

constexpr std::array kContactColumns{"contact", "node_i", "node_j", "node_k",  "alpha_i", "alpha_j", "alpha_k",
                                     "god_x",   "god_y",  "god_z",  "force_x", "force_y", "force_z"};

/// ",x,y,z,contact,...", each with that at its end.
std::string header_of_finger(const std::string& suffix) {
    std::string header;
    for (const char* name : {"x", "y", "z"}) header += fmt::format(",{}{}", name, suffix);
    for (const char* name : kContactColumns) header += fmt::format(",{}{}", name, suffix);
    for (const char* name : {"buttons", "state", "faults"}) header += fmt::format(",{}{}", name, suffix);
    return header;
}

std::string header_of_fingers(const ServoScene& scene) {
    std::string header = "tick";
    for (std::size_t finger = 0; finger < fingers_of(scene); ++finger)
        header += header_of_finger(column_suffix(finger));
    return header;
}

constexpr const char* kHeaderOfPose = ",body_x,body_y,body_z,turn_w,turn_x,turn_y,turn_z";

void append_floats(std::span<const float> values, std::string& text) {
    for (const float value : values) {
        // NaN has a sign bit that means nothing: one spelling for all of them.
        if (std::isnan(value))
            text += ",nan";
        else
            fmt::format_to(std::back_inserter(text), ",{:.9g}", value);
    }
}

// Of a tool: how the hand holds it, the torque on the hand, and where it is drawn.
constexpr const char* kHeaderOfTool =
    ",qw,qx,qy,qz,torque_x,torque_y,torque_z,tool_x,tool_y,tool_z,tool_qw,tool_qx,tool_qy,tool_qz";

/// The contact of each point of a tool: ",contact_p1,node_i_p1,..."
std::string header_of_points(const ServoScene& scene) {
    std::string header;
    for (int i = 1; scene.tool != nullptr && i <= int{scene.tool->points.count}; ++i)
        for (const char* name : kContactColumns) header += fmt::format(",{}_p{}", name, i);
    return header;
}

/// ",mode_1,mode_2"
std::string header_of_modes(const ServoScene& scene) {
    std::string header;
    for (int k = 1; scene.modes != nullptr && k <= scene.modes->count; ++k) header += fmt::format(",mode_{}", k);
    return header;
}

}  // namespace

ServoRecord::ServoRecord(const ServoScene& scene, const std::filesystem::path& path) : scene_(scene), file_(path) {
    file_.add(header_of_fingers(scene) + (scene.tool != nullptr ? kHeaderOfTool : "") + header_of_points(scene) +
              header_of_modes(scene) + (scene.body != nullptr ? kHeaderOfPose : "") + "\n");
}

void ServoRecord::add(std::int64_t tick, const FingerInputs& in, const FingerOutputs& out,
                      const haptable_body_state* body, const haptable_modes_state* modes, const ToolOutput* tool) {
    static constexpr haptable_modes_state kStill{};
    line_ = std::to_string(tick);
    for (std::size_t finger = 0; finger < fingers_of(scene_); ++finger) append(in[finger], out[finger]);
    if (tool != nullptr) append_tool(in[0].value_or(FingerInput{}).turn, *tool);
    if (scene_.modes != nullptr)
        append_floats(std::span(modes != nullptr ? modes->q : kStill.q).first(scene_.modes->count), line_);
    if (body != nullptr) {
        append_floats(body->position_m, line_);
        append_floats(body->turn, line_);
    }
    file_.add(line_ += '\n');
}

void ServoRecord::append(const std::optional<FingerInput>& input, const haptable_output& out) {
    constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
    const FingerInput of = input.value_or(FingerInput{{kNone, kNone, kNone}});
    append_floats(of.at_m, line_);
    append_contact(out);
    fmt::format_to(std::back_inserter(line_), ",{},{},{}", of.buttons, out.state, out.faults);
}

void ServoRecord::append_tool(const std::array<float, 4>& turn, const ToolOutput& tool) {
    append_floats(turn, line_);
    append_floats(tool.torque_n_m, line_);
    append_floats(tool.position_m, line_);
    append_floats(tool.turn, line_);
    for (const haptable_output& point : tool.point) append_contact(point);
}

void ServoRecord::append_contact(const haptable_output& out) {
    constexpr std::array<float, 3> kNowhere{};
    const bool touches = haptable_touches(out.state) != 0;  // else these may be of a dent that the finger left
    fmt::format_to(std::back_inserter(line_), ",{:d}", touches);
    for (std::size_t c = 0; c < 3; ++c)
        fmt::format_to(std::back_inserter(line_), ",{}", touches ? mesh_node(scene_, out, c) : -1);
    append_floats(touches ? std::span<const float>(out.alpha) : kNowhere, line_);
    append_floats(out.god_object_m, line_);
    append_floats(out.force_n, line_);
}

}  // namespace haptable
