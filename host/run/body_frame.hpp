// SPDX-License-Identifier: GPL-2.0-or-later
// How deep a contact is: with where a body that nothing holds is, of HAPTABLE_BODY, and where the points of a tool are,
// of HAPTABLE_WRENCH, which come before the contacts of their tick.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
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
    void take(const tool_wrench& wrench) { wrench_ = wrench; }

    /// 0 without contact.
    struct Dent {
        double depth_m = 0.0;   ///< of a tool its deepest point's
        double stored_j = 0.0;  ///< half of each load times its depth
    };
    Dent dent_of(const contact& touched) const {
        Dent dent;
        if (touched.touches == 0) return dent;
        const auto add = [&dent](const Eigen::Vector3d& u_m, const Eigen::Vector3d& load_n) {
            dent.depth_m = std::max(dent.depth_m, u_m.norm());
            dent.stored_j += 0.5 * load_n.dot(u_m);
        };
        if (wrench_.session == touched.session && wrench_.seq == touched.seq && wrench_.servo == touched.servo) {
            for (std::size_t i = 0; i < wrench_.touches.size(); ++i)
                if (wrench_.touches[i] != 0)
                    add(Eigen::Vector3d(wrench_.point_m[i].data()) - Eigen::Vector3d(wrench_.god_object_m[i].data()),
                        -Eigen::Vector3d(wrench_.force_n[i].data()));
            return dent;
        }
        for (const auto& load_n : touched.force_n) add(offset_m(touched), Eigen::Vector3d(load_n.data()));
        return dent;
    }

private:
    /// From the god-object to the finger, in the body's axes, as its loads are.
    Eigen::Vector3d offset_m(const contact& touched) const {
        const Eigen::Vector3d finger_m(touched.finger_m), god_object_m(touched.god_object_m);
        const bool moves = from_world_ && servo_ == touched.servo;
        return (moves ? *from_world_ * finger_m : finger_m) - god_object_m;
    }

    std::optional<Eigen::Isometry3d> from_world_;  ///< none: it is held
    std::int64_t servo_ = 0;
    tool_wrench wrench_{};  ///< the newest
};

}  // namespace haptable
