// SPDX-License-Identifier: GPL-2.0-or-later
// What other haptic libraries do on a rigid surface: a sphere that stays outside, by collision detection alone.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace haptable {

/// The finger proxy of Ruspini, Kolarov and Khatib ("The haptic display of complex graphical environments", SIGGRAPH
/// 1997), written from the paper to be timed beside the servo; no code of others. A sphere goes straight to the finger
/// as far as nothing is in its way, then along the planes that it met, of which there are at most three. A tree of
/// axis-aligned boxes finds what is in its way. In double, as such libraries are.
class FingerProxy {
public:
    using Patch = std::array<std::int32_t, 3>;

    /// A closed surface, [v] points in m and [p] patches, counter-clockwise from outside; the sphere's radius, m.
    FingerProxy(std::vector<Eigen::Vector3d> point_m, const std::vector<Patch>& patch, double radius_m);

    /// A new session: the sphere is at the finger.
    void begin(const Eigen::Vector3d& finger_m) { at_m_ = finger_m; }
    /// One tick; where the sphere's centre is after it, m.
    const Eigen::Vector3d& to(const Eigen::Vector3d& finger_m);

private:
    struct Box {
        Eigen::Vector3d low, high;  ///< of the patches, m
        std::uint32_t skip;         ///< the first box after this one's subtree
        std::int32_t patch;         ///< of a leaf, which has one; -1: inner box
    };
    /// A patch with what does not change.
    struct Triangle {
        std::array<Eigen::Vector3d, 3> corner;
        Eigen::Vector3d normal;
    };
    /// What a motion met first.
    struct Hit {
        double fraction;  ///< of the motion
        Eigen::Vector3d at_m, normal;
    };

    void build(std::vector<std::int32_t>& patch, std::size_t begin, std::size_t end);
    std::optional<Hit> meet(const Eigen::Vector3d& goal_m) const;
    void meet_triangle(const Triangle& triangle, const Eigen::Vector3d& way, std::optional<Hit>& first) const;
    void meet_edge(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& way,
                   std::optional<Hit>& first) const;
    void meet_corner(const Eigen::Vector3d& corner, const Eigen::Vector3d& way, std::optional<Hit>& first) const;

    std::vector<Triangle> triangle_;
    std::vector<Box> box_;
    double radius_m_;
    double gap_m_;  ///< that is left to what was met, so that the next motion begins outside of it
    Eigen::Vector3d at_m_ = Eigen::Vector3d::Zero();
};

}  // namespace haptable
