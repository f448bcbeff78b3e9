// SPDX-License-Identifier: GPL-2.0-or-later
// Inside, outside, line of sight: by CGAL, in double, over the whole surface. Shares nothing with the servo but the
// vertices.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace haptable {

/// The body that a closed triangle surface bounds. All members may be called by many threads at once.
class Solid {
public:
    /// point [v], m; triangle [p], counter-clockwise from outside, every edge on an even number of them.
    /// Throws Error where the surface is not closed.
    Solid(const std::vector<std::array<float, 3>>& point, const std::vector<std::array<std::uint16_t, 3>>& triangle);

    double size_m() const { return size_m_; }      ///< the diagonal of its box
    double reach_m() const { return reach_m_; }    ///< the largest coordinate
    bool holds(const Eigen::Vector3d& x) const;    ///< inside: the parity of exact crossings
    double gap_m(const Eigen::Vector3d& x) const;  ///< from the surface
    /// True where no triangle stands between two points; one that only an end touches counts too.
    bool sees(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;

    /// Where a segment goes in.
    struct Entry {
        std::size_t triangle;
        Eigen::Vector3d point_m;
    };
    /// Into every triangle that it crosses inwards; into one that it runs along within `near_m`, where it begins.
    std::vector<Entry> entries(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double near_m) const;
    /// The surface's nearest point.
    Entry nearest(const Eigen::Vector3d& x) const;

    /// The unit vector outwards at a point: the triangle's normal, at an edge the mean of two, at a vertex the mean
    /// weighted by angles (Baerentzen and Aanaes 2005). None at a hinge, where the surface has more than one side.
    std::optional<Eigen::Vector3d> outward(std::size_t triangle, const Eigen::Vector3d& alpha) const;

private:
    using Corners = std::array<std::uint16_t, 3>;
    Eigen::Vector3d normal(std::size_t triangle) const;
    double angle(std::size_t triangle, std::uint16_t vertex) const;
    std::size_t corner(std::size_t triangle, std::uint16_t vertex) const;
    bool is_one_ring(std::uint16_t vertex) const;

    struct Trees;
    std::shared_ptr<Trees> trees_;
    std::vector<Eigen::Vector3d> point_;            ///< [v]
    std::vector<Corners> corners_;                  ///< [p]
    std::vector<std::vector<std::size_t>> around_;  ///< [v] triangles
    double size_m_ = 0.0;
    double reach_m_ = 0.0;
};

/// Where a finger is that moves in small steps: a gap that was once measured answers for all places nearer than it.
class Whereabouts {
public:
    explicit Whereabouts(const Solid& solid) : solid_(&solid) {}

    bool is_inside(const Eigen::Vector3d& x);
    /// True where x is farther than `gap_m` from the surface.
    bool is_beyond(const Eigen::Vector3d& x, double gap_m);

private:
    void measure(const Eigen::Vector3d& x);

    const Solid* solid_;
    Eigen::Vector3d at_ = Eigen::Vector3d::Zero();
    double gap_m_ = -1.0;  ///< at `at_`; negative: nothing is known
    bool inside_ = false;
};

}  // namespace haptable
