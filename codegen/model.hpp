// SPDX-License-Identifier: GPL-2.0-or-later
// The tables as the servo holds them: vertices renumbered, patches in the order of the spatial index.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "codegen/size.hpp"
#include "firmware/haptable_model.h"
#include "host/tables/tables.hpp"

namespace haptable {

/// A firmware's type as a value: T[k] is std::array<T, k>, any other type itself.
template <typename T>
struct ValueOf {
    using type = T;
};
template <typename T, std::size_t k>
struct ValueOf<T[k]> {
    using type = std::array<T, k>;
};

#define HAPTABLE_VALUE_MEMBER(type_, name) ValueOf<type_>::type name{};
#define HAPTABLE_ROWS_MEMBER(type_, name, count) std::vector<ValueOf<type_>::type> name;
#define HAPTABLE_NO_MEMBER(...)

/// The spatial index over patches: boxes in depth-first order over patches in leaf order.
struct SpatialIndex {
    std::array<float, 3> origin_m{};
    float per_m = 0.0F;              ///< grid steps in a metre
    std::vector<std::size_t> order;  ///< [p] leaf order: the old number of each new patch
    std::vector<haptable_box> boxes;
};

/// The fields of struct haptable_compliance; degree 0: the force needs none.
struct ServoCompliance {
    HAPTABLE_COMPLIANCE_FIELDS(HAPTABLE_VALUE_MEMBER, HAPTABLE_ROWS_MEMBER)
    /// Where model_in_memory keeps the struct that its model points to.
    mutable std::shared_ptr<haptable_compliance> in_memory;
};

/// The tables of struct haptable_model, by their names there.
struct ServoTables {
    HAPTABLE_MODEL_FIELDS(HAPTABLE_NO_MEMBER, HAPTABLE_ROWS_MEMBER, HAPTABLE_NO_MEMBER, HAPTABLE_NO_MEMBER)
};

#undef HAPTABLE_VALUE_MEMBER
#undef HAPTABLE_ROWS_MEMBER
#undef HAPTABLE_NO_MEMBER

/// What struct haptable_model holds, beside what the scene's options choose. The blocks that `packed` holds
/// are there in float32 too, for comparison.
struct ServoModel : ServoTables {
    std::vector<std::int32_t> node;       ///< [v] mesh node of each vertex, free ones first
    std::size_t free_count = 0;           ///< [v]
    std::vector<std::size_t> leaf_order;  ///< [p] of each patch its number in the tables of the scene
    std::array<float, 3> grid_origin_m{};
    float grid_per_m = 0.0F;
    ServoIndex search;  ///< what a search of the spatial index takes; made by measure_search
    ServoCompliance compliance;
    ServoStiffness stiffness;
    float rigid_stiffness_n_per_m = 0.0F;
    float tolerance_m = 0.0F;
    float relaxation_reach_m = 0.0F;  ///< how far a dent is felt beside; 0: nothing relaxes
    float workspace_limit_m = 0.0F;

    /// Which blocks the force reads in float32: S of the vertices, those of a compliance, or none as it unpacks them.
    bool reads_stiffness() const { return compliance.degree == 0 && packed.empty(); }
    bool reads_compliance() const { return compliance.degree != 0 && packed.empty(); }
};

/// Builds the servo's tables. Throws Error when the object is too large for 16-bit indices, or a value is not finite.
ServoModel build_model(const Tables& tables);

/// The servo's table of a curve.
std::vector<float> stiffening_table(const StiffeningCurve& curve);

/// The blocks of C(alpha) in double, in the servo's order; as in ServoCompliance.
struct ExactCompliance {
    std::vector<std::array<double, 9>> vertex, edge, patch;
};
ExactCompliance exact_compliance(const Tables& tables, const ServoModel& model);

/// C(alpha) on the patches of `model`, which is complete but for it.
ServoCompliance build_compliance(const Tables& tables, const ServoModel& model);

/// The stiffest body that the tables' device renders stably to a hand that moves at up to 0.5 m/s: docs/DEVICES.md.
double stable_stiffness(const Tables& tables);

/// Finds the largest stiffness, what the device renders stably, and puts the coupling that the tables ask for in series
/// with every block.
void couple(const Tables& tables, ServoModel& model);

/// A block's six numbers xx yy zz xy yz zx: its symmetric part. Throws Error that names `what` where it is not finite.
std::array<float, 6> packed(const std::array<double, 9>& block, const char* what);

/// The most boxes that the search of any segment of up to `segment_m` can visit, wherever it lies: an upper bound,
/// which counts every box that comes within half the segment of its middle. Where the finger is slower, a search takes
/// one tick when this is at most HAPTABLE_TICK_BOXES.
std::size_t most_boxes(const ServoModel& model, double segment_m);

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
std::vector<haptable_hinge> build_hinges(std::size_t vertices, const std::vector<std::array<std::uint16_t, 3>>& patch,
                                         const std::vector<std::array<std::uint16_t, 3>>& neighbour);

}  // namespace haptable
