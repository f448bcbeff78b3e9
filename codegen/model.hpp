// SPDX-License-Identifier: GPL-2.0-or-later
// The tables as the servo holds them: vertices renumbered, patches in the order of the spatial index.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "firmware/haptable.h"
#include "host/tables/tables.hpp"

namespace haptable {

/// One box of the spatial index; the same fields as firmware/haptable.h's struct haptable_box.
struct IndexBox {
    std::array<std::uint16_t, 3> low;
    std::array<std::uint16_t, 3> high;
    std::uint16_t skip;
    std::uint16_t patch;
};

/// A patch at a hinge; the same fields as firmware/haptable.h's struct haptable_hinge.
struct Hinge {
    std::uint16_t vertex;
    std::uint16_t patch;
    std::uint16_t ring;
};

/// The spatial index over patches: boxes in depth-first order over patches in leaf order.
struct SpatialIndex {
    std::array<float, 3> origin_m{};
    float per_m = 0.0F;              ///< grid steps in a metre
    std::vector<std::size_t> order;  ///< [p] leaf order: the old number of each new patch
    std::vector<IndexBox> boxes;
};

/// The fields of struct haptable_compliance; degree 0: the force needs none.
struct ServoCompliance {
    int degree = 0;
    std::size_t edge_count = 0;
    std::vector<std::array<float, 6>> vertex_m_per_n;      ///< [v]
    std::vector<std::array<float, 6>> edge_m_per_n;        ///< [edge_count (degree - 1)] from the lower vertex
    std::vector<std::array<float, 6>> patch_m_per_n;       ///< [3 p] with degree 4, or empty
    std::vector<std::array<std::uint16_t, 3>> patch_edge;  ///< [p]
    /// Where model_in_memory keeps the struct that its model points to.
    mutable std::shared_ptr<haptable_compliance> in_memory;
};

/// How stiff the servo's object is to a finger.
struct ServoStiffness {
    double largest_n_per_m = 0.0;   ///< largest eigenvalue of any point's S, without a coupling
    double stable_n_per_m = 0.0;    ///< what the device renders stably
    double coupling_n_per_m = 0.0;  ///< spring in series; 0: none
    double felt_n_per_m = 0.0;      ///< the largest with it
};

/// How large the spatial index is, and what a search of it takes.
struct ServoIndex {
    std::size_t boxes = 0;
    std::size_t fast_way_boxes = 0;  ///< most that a segment of HAPTABLE_FAST_SEGMENT_M visits
};

/// Bytes of flash of one table.
struct TableBytes {
    std::string name;
    std::size_t bytes;
};

/// The fields of struct haptable_model, ready to be written as text.
struct ServoModel {
    std::vector<std::int32_t> node;  ///< [v] mesh node of each vertex, free ones first
    std::size_t free_count = 0;
    std::vector<std::array<float, 3>> vertex_m;           ///< [v]
    std::vector<std::array<float, 6>> stiffness_n_per_m;  ///< [free_count] xx yy zz xy yz zx
    std::vector<std::array<std::uint16_t, 6>> packed;     ///< [free_count] the same in 16 bits; empty for float32
    std::vector<float> packed_scale_n_per_m;              ///< [1] for float16, [free_count] for int16
    std::vector<std::array<std::uint16_t, 3>> patch;      ///< [p] vertices
    std::vector<std::array<std::uint16_t, 3>> neighbour;  ///< [p] across the edge opposite to each corner
    std::vector<Hinge> hinge;                             ///< by vertex; empty on most bodies
    SpatialIndex index;
    ServoIndex search;  ///< what a search of it takes; made by measure_search
    ServoCompliance compliance;
    ServoStiffness stiffness;
    float rigid_stiffness_n_per_m = 0.0F;
    float tolerance_m = 0.0F;
    float workspace_limit_m = 0.0F;
};

/// Builds the servo's tables. Throws Error when the object is too large for 16-bit indices, or a value is not finite.
ServoModel build_model(const Tables& tables);

/// C(alpha) on the patches of `model`, which is complete but for it.
ServoCompliance build_compliance(const Tables& tables, const ServoModel& model);

/// Finds the largest stiffness, what the device renders stably, and puts the coupling that the tables ask for in series
/// with every block.
void couple(const Tables& tables, ServoModel& model);

/// A block's six numbers xx yy zz xy yz zx: its symmetric part. Throws Error that names `what` where it is not finite.
std::array<float, 6> packed(const std::array<double, 9>& block, const char* what);

/// The most boxes that the search of any segment of up to `segment_m` can visit, wherever it lies: an upper bound,
/// which counts every box that comes within half the segment of its middle. Where the finger is slower, a search takes
/// one tick when this is at most HAPTABLE_TICK_BOXES.
std::size_t most_boxes(const SpatialIndex& index, double segment_m);

/// Fills in `search`.
void measure_search(ServoModel& model);

/// The bounding-box tree. positions [v], patches [p].
SpatialIndex build_index(const std::vector<std::array<float, 3>>& vertex_m,
                         const std::vector<std::array<std::uint16_t, 3>>& patch);

/// Which patch lies across each edge (opposite to corner 0, 1, 2); 0xFFFF at the border. Where more than two patches
/// meet at an edge, those are neighbours that bound the same wedge of the body.
std::vector<std::array<std::uint16_t, 3>> build_neighbours(const std::vector<std::array<float, 3>>& vertex_m,
                                                           const std::vector<std::array<std::uint16_t, 3>>& patch);

/// The patches around every vertex that has more than one ring of them or an edge of more than two; vertices and
/// rings ascend. A ring is named by its lowest patch. patches and neighbours [p].
std::vector<Hinge> build_hinges(std::size_t vertices, const std::vector<std::array<std::uint16_t, 3>>& patch,
                                const std::vector<std::array<std::uint16_t, 3>>& neighbour);

}  // namespace haptable
