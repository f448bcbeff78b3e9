// SPDX-License-Identifier: GPL-2.0-or-later
// What other haptic libraries do on a rigid surface: a sphere that stays outside, by collision detection alone.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "host/bench/proxy/patch_tree.hpp"

namespace haptable {

/// The finger proxy of Ruspini, Kolarov and Khatib ("The haptic display of complex graphical environments", SIGGRAPH
/// 1997), written from the paper to be timed beside the servo; no code of others. A sphere goes straight to the finger
/// as far as nothing is in its way, then along the planes that it met, of which there are at most three. A tree of
/// axis-aligned boxes finds what is in its way. In double, as such libraries are.
class FingerProxy {
public:
    /// A closed surface, [v] points in m and [p] patches, counter-clockwise from outside; the sphere's radius, m.
    FingerProxy(const std::vector<Eigen::Vector3d>& point_m, const std::vector<PatchTree::Patch>& patch,
                double radius_m)
        : tree_(point_m, patch), radius_m_(radius_m), gap_m_(0.01 * radius_m) {}

    /// A new session: the sphere is at the finger.
    void begin(const Eigen::Vector3d& finger_m) { at_m_ = finger_m; }
    /// One tick; where the sphere's centre is after it, m.
    const Eigen::Vector3d& to(const Eigen::Vector3d& finger_m);

private:
    /// What a motion met first.
    struct Hit {
        double fraction;  ///< of the motion
        Eigen::Vector3d at_m, normal;
    };

    std::optional<Hit> meet(const Eigen::Vector3d& goal_m) const;
    void meet_triangle(const PatchTree::Triangle& triangle, const Eigen::Vector3d& way,
                       std::optional<Hit>& first) const;
    void meet_edge(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& way,
                   std::optional<Hit>& first) const;
    void meet_corner(const Eigen::Vector3d& corner, const Eigen::Vector3d& way, std::optional<Hit>& first) const;

    PatchTree tree_;
    double radius_m_;
    double gap_m_;  ///< that is left to what was met, so that the next motion begins outside of it
    Eigen::Vector3d at_m_ = Eigen::Vector3d::Zero();
};

}  // namespace haptable
