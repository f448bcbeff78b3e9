// SPDX-License-Identifier: GPL-2.0-or-later
// Where a body that nothing holds is, of HAPTABLE_BODY, which comes before the contacts of its tick.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "host/link/messages.hpp"

namespace haptable {

class BodyFrame {
public:
    void take(const body_pose& pose) {
        const Eigen::Quaterniond turn(pose.turn[0], pose.turn[1], pose.turn[2], pose.turn[3]);
        if (!(turn.norm() > 0.5)) return;
        const Eigen::Vector3d centre_m(pose.centre_m), rest_m(pose.rest_centre_m);
        from_world_ = Eigen::Translation3d(rest_m) * turn.normalized().conjugate() * Eigen::Translation3d(-centre_m);
        servo_ = pose.servo;
    }
    /// From the god-object to the finger, in the body's axes, as its loads are.
    Eigen::Vector3d offset_m(const contact& touched) const {
        const Eigen::Vector3d finger_m(touched.finger_m), god_object_m(touched.god_object_m);
        const bool moves = from_world_ && servo_ == touched.servo;
        return (moves ? *from_world_ * finger_m : finger_m) - god_object_m;
    }

private:
    std::optional<Eigen::Isometry3d> from_world_;  ///< none: it is held
    std::int64_t servo_ = 0;
};

}  // namespace haptable
