// SPDX-License-Identifier: GPL-2.0-or-later
// One moment of a session: where finger and god-object are, what loads the body, what the user feels.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/tables/tables.hpp"
#include "host/view/deformation.hpp"

namespace haptable {

/// A servo's tick or a contact message, as it is drawn.
struct ContactFrame {
    std::int64_t number = 0;    ///< tick of a CSV, seq of a contact message
    double time_s = 0.0;        ///< since the beginning of the session
    bool finger_known = false;  ///< false where the position was not a finite one
    bool contact = false;
    Eigen::Vector3d finger_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d god_object_m = Eigen::Vector3d::Zero();  ///< of a contact
    Eigen::Vector3d force_n = Eigen::Vector3d::Zero();       ///< what the user feels (equation 12)
    /// From body to world coordinates, in which finger and force are; god-object and loads are the body's. None where
    /// it is held.
    std::optional<Eigen::Isometry3d> pose;
    /// Another finger; in contact its god-object and what it feels too, and its loads are among the frame's.
    struct Other {
        Eigen::Vector3d finger_m = Eigen::Vector3d::Zero(), god_object_m = Eigen::Vector3d::Zero(),
                        force_n = Eigen::Vector3d::Zero();
        bool contact = false;
    };
    std::vector<Other> others;
    /// A tool, whose handle is the finger: from its axes to the world's, and the god-objects of the points that touch,
    /// in the body's coordinates.
    struct Tool {
        Eigen::Isometry3d pose;
        std::vector<Eigen::Vector3d> god_object_m;
    };
    std::optional<Tool> tool;
    std::vector<NodalForce> loads;  ///< of the body (equation 10); or of a dent
    std::vector<float> modes;       ///< how far they have swung, sqrt(kg) m; none where the record does not say
};

/// Pose of a body that nothing holds: its centre of mass at first and now, and its turn w x y z. None
/// where a number is not finite.
std::optional<Eigen::Isometry3d> pose_of(const Eigen::Vector3d& rest_centre_m, const Eigen::Vector3d& centre_m,
                                         const std::array<double, 4>& turn);

/// Which moments are drawn.
struct FrameChoice {
    std::int64_t every_ms = 33;       ///< one a so many milliseconds (ticks), ...
    std::vector<std::int64_t> ticks;  ///< ... or just these, where any are named
};

}  // namespace haptable
