// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/device/record.hpp"

#include <fmt/format.h>

#include <iterator>

namespace haptable {

DeviceRecord::DeviceRecord(const std::filesystem::path& path) : file_(path) {
    file_.add(
        "tick,x,y,z,velocity_x,velocity_y,velocity_z,target_x,target_y,target_z,force_x,force_y,force_z,answered_"
        "tick\n");
}

void DeviceRecord::add(const DeviceRow& row) {
    line_ = std::to_string(row.tick);
    for (const Eigen::Vector3d* v : {&row.encoder_m, &row.velocity_m_s, &row.goal_m, &row.force_n})
        fmt::format_to(std::back_inserter(line_), ",{},{},{}", v->x(), v->y(), v->z());
    fmt::format_to(std::back_inserter(line_), ",{}\n", row.answered_tick);
    file_.add(line_);
}

}  // namespace haptable
