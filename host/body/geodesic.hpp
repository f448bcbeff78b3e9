// SPDX-License-Identifier: GPL-2.0-or-later
// Distances over a triangle surface, exact: straight lines in the unfolded triangles, round the vertices that they can
// only pass by (saddles and borders). After Chen and Han 1990 with the filter of Xin and Wang 2009.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace haptable {

/// What a search asks of a surface, in flat lists that many searches share. A corner is 3 patch + 0, 1 or 2, and stands
/// for the edge opposite to it too, from the corner after it to the one before.
struct SurfaceGraph {
    /// How a shortest way may go on at a node.
    enum class Turn : char {
        kNone,    ///< past it only
        kSaddle,  ///< bending, where both sides keep half a turn: there is more than a full turn around it
        kAny,     ///< anywhere: at a border, or where patches meet in it that are no single fan
    };
    /// position_m [N], patch [p] nodes of the surface, counter-clockwise from outside.
    SurfaceGraph(std::span<const Eigen::Vector3d> position_m, std::span<const std::array<std::int32_t, 3>> patch);

    std::vector<std::int32_t> node;      ///< [3 p] of a corner
    std::vector<double> length_m;        ///< [3 p] of the edge opposite to it
    std::vector<double> angle;           ///< [3 p] between the edges at it
    std::vector<Eigen::Vector2d> far_m;  ///< [3 p] the corner before, with this one at 0 and the next along x
    /// [3 p] the corner as seen from its edge, in lengths of that: along it, from the corner before to the one after,
    /// and away from it.
    std::vector<Eigen::Vector2d> apex;
    /// [3 p] m: no node but the edge's ends is nearer to the edge by a way that begins in this patch.
    std::vector<double> clear_m;
    std::vector<std::int32_t> across;  ///< [3 p] opposite to the same edge in the patch across; -1: not two patches
    std::vector<std::int32_t> around_begin, around;  ///< [N + 1], [3 p] corners at each node, ascending
    std::vector<Turn> turn;                          ///< [N]
    std::vector<double> full_angle;                  ///< [N] of all corners at the node
    std::vector<std::array<std::int32_t, 3>> edge;   ///< [3 p] lower node, higher node, corner opposite; ascending

    /// Corners opposite to an edge, as rows of `edge`.
    std::span<const std::array<std::int32_t, 3>> sides(std::int32_t a, std::int32_t b) const;
    /// The corner after this one around its node; -1 at a border.
    std::int32_t counter_clockwise(std::int32_t corner) const;
    std::int32_t clockwise(std::int32_t corner) const;

private:
    void find_shapes(std::span<const Eigen::Vector3d> position_m);
    void find_sides();
    void find_turns();
    void find_clear(std::span<const Eigen::Vector3d> position_m);
};

struct NodeDistance {
    std::int32_t node;
    double distance_m;
};

/// Searches on one surface, one after the other.
class SurfaceDistance {
public:
    explicit SurfaceDistance(const SurfaceGraph& surface);

    using Distances = std::vector<NodeDistance>;  ///< of the nodes that are reached, ascending
    /// Nodes within reach_m of a node, over the surface.
    Distances from_node(std::int32_t node, double reach_m);
    /// Nodes within reach_m of the middle of an edge.
    Distances from_edge(std::int32_t a, std::int32_t b, double reach_m);

private:
    /// What a source sees through an edge: the source unfolded to the origin, the edge's ends a and b with b
    /// counter-clockwise of a, and the rays of length 1 that bound the view.
    struct Window {
        Eigen::Vector2d at_a, at_b;
        Eigen::Vector2d ray_a, ray_b;
        double base;          // from the true source to the origin
        std::int32_t corner;  // the corner opposite to the edge, on the side of the source
    };
    /// A node at which ways may bend, with the length of the best way when it was found.
    struct Event {
        double distance;
        std::int32_t node;
        bool operator<(const Event& other) const { return distance > other.distance; }
    };
    /// How the shortest way comes to a saddle: through the patch of `corner`; of its angle the rest lies
    /// counter-clockwise of the way.
    struct Arrival {
        std::int32_t corner;
        double rest;
    };

    void begin(double reach_m);
    bool reach(std::int32_t node, double distance);
    void spread(std::int32_t node, double distance);
    void spread_behind(std::int32_t node, double distance);
    void see(std::int32_t corner, double distance, double from, double to);
    void look_through(const Window& window, std::int32_t behind);
    void add(const Window& window);
    void look_through_all();
    Distances run();

    const SurfaceGraph& surface_;
    double reach_m_ = 0.0;
    std::vector<double> best_;           // [N] m, infinite where no way is known
    std::vector<Arrival> arrival_;       // [N] of the best way, at saddles
    std::vector<std::int32_t> reached_;  // nodes with one
    std::vector<Event> queue_;           // a heap, the nearest first
    std::vector<Window> window_;         // of one source, in the order they are looked through
};

}  // namespace haptable
