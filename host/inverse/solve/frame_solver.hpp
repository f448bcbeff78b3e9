// SPDX-License-Identifier: GPL-2.0-or-later
// u_r = sum over the loaded nodes i of L_ri F_i   (equation 8), by one solve instead of stored columns.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/inverse/solve/tree_solver.hpp"

namespace haptable {

/// One solve for a frame's forces: forward along the paths of the loaded nodes only, back only to wanted rows.
class FrameSolver {
public:
    /// value: the factor's values as float; row: [r] unknown nodes whose displacements are wanted. Factor and values
    /// must live on.
    FrameSolver(const Supernodes& factor, const float* value, std::span<const std::int32_t> row);

    struct Load {
        std::int32_t node = 0;  ///< unknown node
        float force_n[3] = {};
    };
    /// The displacements [3 r] in metres; valid until the next call.
    std::span<const float> displace(std::span<const Load> loads);

private:
    Supernodes factor_;
    EliminationTree tree_;
    TreeSolver<float> x_;
    std::vector<std::int32_t> row_, back_;  // back_: supernodes that lead to rows, ascending
    std::vector<float> displacement_;
};

}  // namespace haptable
