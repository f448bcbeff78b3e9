// SPDX-License-Identifier: GPL-2.0-or-later
// patch, area coordinates and load of a point -> its force and its loads on nodes, as the target has them
#include "host/session/bridge/target_tool.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace haptable {

TargetTool::TargetTool(const ServoScene& scene) : tool_(scene.tool), point_m_(scene.tool->points.count) {
    haptable_tool_scene_make(scene.model, tool_, &scene_);
    output_.point_m.resize(point_m_.size());
    output_.point.resize(point_m_.size());
    release();
}

void TargetTool::take(const haptable_tool_line_answer& answer) {
    const haptable_tool_output& out = answer.out;
    std::copy_n(out.torque_n_m, 3, output_.torque_n_m.begin());
    std::copy_n(out.position_m, 3, output_.position_m.begin());
    std::copy_n(out.turn, 4, output_.turn.begin());
    output_.stored_j = double{answer.stored_j};
    const bool is_believed = out.hand.state == HAPTABLE_FREE || haptable_touches(out.hand.state) != 0;
    const Eigen::Quaternionf turn(out.turn[0], out.turn[1], out.turn[2], out.turn[3]);
    for (std::uint32_t i = 0; i < tool_->points.count; ++i) {
        const haptable_line_point& said = answer.point[i];
        haptable_contact at{};
        at.patch = (answer.inside >> i & 1U) != 0 ? said.patch : HAPTABLE_NONE;
        std::copy_n(said.alpha, 3, at.alpha);
        std::copy_n(said.god_object_m, 3, at.god_object_m);
        if (is_believed) haptable_tool_place(tool_, out.position_m, out.turn, i, point_m_[i].data());
        haptable_tool_put_point(&scene_.scene, &at, said.load_n, point_m_[i].data(), &output_.point[i]);
        Eigen::Map<Eigen::Vector3f>(output_.point_m[i].data()) =
            Eigen::Vector3f(out.position_m) + turn * Eigen::Vector3f(tool_->point_m[i]);
    }
}

void TargetTool::release() {
    output_.torque_n_m = {};
    output_.stored_j = 0.0;
    for (std::size_t i = 0; i < point_m_.size(); ++i) {
        output_.point[i] = silent_output();
        output_.point[i].state = HAPTABLE_FREE;
        std::copy_n(point_m_[i].begin(), 3, output_.point[i].god_object_m);
    }
}

}  // namespace haptable
