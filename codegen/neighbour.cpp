// SPDX-License-Identifier: GPL-2.0-or-later
// Patches that share an edge, one going along it and one against it, are neighbours.
#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>

#include "codegen/model.hpp"
#include "firmware/haptable_model.h"

namespace haptable {

namespace {

using Patch = std::array<std::uint16_t, 3>;
using Edge = std::pair<std::uint16_t, std::uint16_t>;

/// One patch's side of an edge that runs from `edge.first` to `edge.second`, counter-clockwise from outside.
struct Side {
    std::size_t patch;
    std::size_t corner;  // opposite to the edge
};

using Sides = std::multimap<Edge, Side>;

Edge edge_opposite(const Patch& patch, std::size_t corner) {
    return {patch[(corner + 1) % 3], patch[(corner + 2) % 3]};
}

class Neighbours {
public:
    Neighbours(const std::vector<std::array<float, 3>>& vertex_m, const std::vector<Patch>& patch)
        : vertex_m_(vertex_m), patch_(patch) {
        for (std::size_t p = 0; p < patch.size(); ++p)
            for (std::size_t corner = 0; corner < 3; ++corner)
                sides_.emplace(edge_opposite(patch[p], corner), Side{p, corner});
    }

    std::uint16_t across(std::size_t p, std::size_t corner) const {
        const Edge edge = edge_opposite(patch_[p], corner);
        const auto [begin, end] = sides_.equal_range({edge.second, edge.first});
        std::uint16_t best = HAPTABLE_NONE;
        double least = 0.0;
        for (auto it = begin; it != end; ++it) {
            const double angle = std::next(begin) == end ? 0.0 : inner_angle(edge, {p, corner}, it->second);
            if (best != HAPTABLE_NONE && angle >= least) continue;
            best = static_cast<std::uint16_t>(it->second.patch);
            least = angle;
        }
        return best;
    }

private:
    Eigen::Vector3d at(std::uint16_t vertex) const {
        const auto& x = vertex_m_[vertex];
        return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
    }

    /// The angle at the edge from one patch through the body to the other, 0 to 2 pi.
    double inner_angle(const Edge& edge, const Side& from, const Side& to) const {
        const Eigen::Vector3d axis = (at(edge.second) - at(edge.first)).normalized();
        const auto arm = [&](const Side& side) {
            const Eigen::Vector3d out = at(patch_[side.patch][side.corner]) - at(edge.first);
            return Eigen::Vector3d(out - out.dot(axis) * axis);
        };
        const Eigen::Vector3d a = arm(from);
        const Eigen::Vector3d b = arm(to);
        // The patch lies left of its edge seen from outside, so the body lies on the side of axis x a turned back.
        const double turn = std::atan2(axis.dot(b.cross(a)), a.dot(b));
        return turn < 0.0 ? turn + 2.0 * std::numbers::pi : turn;
    }

    const std::vector<std::array<float, 3>>& vertex_m_;
    const std::vector<Patch>& patch_;
    Sides sides_;
};

}  // namespace

std::vector<Patch> build_neighbours(const std::vector<std::array<float, 3>>& vertex_m,
                                    const std::vector<Patch>& patch) {
    const Neighbours neighbours(vertex_m, patch);
    std::vector<Patch> across(patch.size());
    for (std::size_t p = 0; p < patch.size(); ++p)
        for (std::size_t corner = 0; corner < 3; ++corner) across[p][corner] = neighbours.across(p, corner);
    return across;
}

}  // namespace haptable
