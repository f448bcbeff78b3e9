// SPDX-License-Identifier: GPL-2.0-or-later
// The device's own CSV: where the finger was and was wanted, and the force that the motors gave.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>

#include "host/device/wrist.hpp"
#include "host/link/text_file.hpp"

namespace haptable {

/// One tick, as it began, and the force at its end.
struct DeviceRow {
    std::int64_t tick = 0;
    Eigen::Vector3d encoder_m;        ///< as published
    Eigen::Vector3d velocity_m_s;     ///< the true one
    Eigen::Vector3d goal_m;           ///< where the hand wanted the finger to be
    Eigen::Vector3d force_n;          ///< the motors' force
    std::int64_t answered_tick = -1;  ///< newest state with an answer, at the end of the tick; -1: none yet
    Turning tool = {};                ///< of a tool, as published
    Eigen::Vector3d torque_n_m = Eigen::Vector3d::Zero();  ///< of a tool, on the hand, before the force's scale
};

class DeviceRecord {
public:
    /// has_tool: orientation and torque are recorded too. Throws Error that names the path when it cannot be written
    /// there.
    explicit DeviceRecord(const std::filesystem::path& path, bool has_tool = false);

    /// One line, each number with as many digits as reading it back needs.
    void add(const DeviceRow& row);
    /// As TextFile::keep and TextFile::flush: for a session, whose record survives whatever happens.
    void keep() { file_.keep(); }
    void flush() { file_.flush(); }
    /// Throws Error when the disk did not take it.
    void finish() { file_.finish(); }

private:
    TextFile file_;
    bool has_tool_;
    std::string line_;
};

}  // namespace haptable
