// SPDX-License-Identifier: GPL-2.0-or-later
// A stand-in for a library's finger proxy: what that one tests in a tick, and nothing else that the library does.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <vector>

#include "host/bench/proxy/patch_tree.hpp"

namespace haptable {

/// What CHAI3D's cAlgorithmFingerProxy (3.3.0, where bodies do not move) does in a tick, to be timed beside the servo;
/// written from a description of its source, no code of it. A tick searches once: for the plane that the sphere meets,
/// in the next tick along that one for a second, in the next along the line of both for a third. In every patch that
/// its boxes find, it meets the sphere's centre with the patch's shell: both faces a radius off, three cylinders and
/// three spheres. Friction is a cone with a static and a dynamic angle. In double. What a general library adds (frames
/// of objects, materials, records of collisions) is left out: the stand-in takes a third to a quarter of CHAI3D's own
/// time, and no ratio to it is one to CHAI3D.
class ShellProxy {
public:
    /// A closed surface as PatchTree's; the sphere's radius, m; Coulomb's coefficients, 0: none.
    ShellProxy(const std::vector<Eigen::Vector3d>& point_m, const std::vector<PatchTree::Patch>& patch, double radius_m,
               double static_friction, double dynamic_friction)
        : tree_(point_m, patch),
          radius_m_(radius_m),
          gap_m_(0.01 * radius_m),
          static_friction_(static_friction),
          dynamic_friction_(dynamic_friction) {}

    /// A new session: the sphere is at the finger.
    void begin(const Eigen::Vector3d& finger_m);
    /// One tick; where the sphere's centre is after it, m.
    const Eigen::Vector3d& to(const Eigen::Vector3d& finger_m);

private:
    /// What a motion met first.
    struct Hit {
        double distance_m = std::numeric_limits<double>::infinity();  ///< from where it began; infinite: nothing
        Eigen::Vector3d at_m, normal;
    };

    Eigen::Vector3d goal(const Eigen::Vector3d& finger_m) const;
    Hit meet(const Eigen::Vector3d& goal_m) const;
    void meet_shell(const PatchTree::Triangle& triangle, const Eigen::Vector3d& goal_m, Hit& first) const;
    void stop_at(const Hit& hit, const Eigen::Vector3d& way);
    void glide(const Eigen::Vector3d& goal_m, const Eigen::Vector3d& finger_m);

    PatchTree tree_;
    double radius_m_;
    double gap_m_;  ///< that is left to what was met; a goal as near as that is reached
    double static_friction_, dynamic_friction_;
    bool slips_ = true;
    Eigen::Vector3d at_m_ = Eigen::Vector3d::Zero();
    std::size_t planes_ = 0;  ///< that were met since the last motion was free
    std::array<Eigen::Vector3d, 2> normal_;
};

}  // namespace haptable
