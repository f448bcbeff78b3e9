// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/device/record.hpp"

#include <fmt/format.h>

#include <iterator>

namespace haptable {

DeviceRecord::DeviceRecord(const std::filesystem::path& path, bool has_tool) : file_(path), has_tool_(has_tool) {
    file_.add(std::string("tick,x,y,z,velocity_x,velocity_y,velocity_z,target_x,target_y,target_z,force_x,force_y,"
                          "force_z,answered_tick") +
              (has_tool ? ",qw,qx,qy,qz,torque_x,torque_y,torque_z\n" : "\n"));
}

void DeviceRecord::add(const DeviceRow& row) {
    line_ = std::to_string(row.tick);
    for (const Eigen::Vector3d* v : {&row.encoder_m, &row.velocity_m_s, &row.goal_m, &row.force_n})
        fmt::format_to(std::back_inserter(line_), ",{},{},{}", v->x(), v->y(), v->z());
    fmt::format_to(std::back_inserter(line_), ",{}", row.answered_tick);
    if (has_tool_) {
        const Eigen::Quaterniond& turn = row.tool.turn;
        fmt::format_to(std::back_inserter(line_), ",{},{},{},{}", turn.w(), turn.x(), turn.y(), turn.z());
        fmt::format_to(std::back_inserter(line_), ",{},{},{}", row.torque_n_m.x(), row.torque_n_m.y(),
                       row.torque_n_m.z());
    }
    line_ += '\n';
    file_.add(line_);
}

}  // namespace haptable
