// SPDX-License-Identifier: GPL-2.0-or-later
// A tool whose servo is a target: what its answers say of the wrench and of each point.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "firmware/haptable_line_points.h"
#include "firmware/haptable_tool.h"
#include "host/session/scene.hpp"
#include "host/session/stepper.hpp"

namespace haptable {

class TargetTool {
public:
    /// scene: with a tool, which outlives this object.
    explicit TargetTool(const ServoScene& scene);

    /// A tick. before: the answer is one of this tool.
    void take(const haptable_tool_line_answer& answer);
    /// As after silence: no torque, no contact.
    void release();
    const ToolOutput& output() const { return output_; }

private:
    const haptable_tool_model* tool_;
    haptable_points_scene scene_{};
    ToolOutput output_;
    std::vector<std::array<float, 3>> point_m_;  ///< in the last tick whose pose was believed
};

}  // namespace haptable
