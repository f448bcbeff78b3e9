// SPDX-License-Identifier: GPL-2.0-or-later
// Where a change of volume is averaged: the elements of one material at one corner node are a cell.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "host/fem/lists.hpp"
#include "host/fem/stiffness.hpp"

namespace haptable {

class NodalCells {
public:
    /// The mesh must outlive this.
    explicit NodalCells(const ElementMesh& mesh);

    std::size_t size() const { return node_.size(); }
    std::int32_t node(std::size_t cell) const { return node_[cell]; }
    /// The tetrahedra of a cell, all of one material.
    std::span<const std::int32_t> tets(std::size_t cell) const { return tets_at_[cell]; }
    const Lame& material(std::size_t cell) const { return mesh_.material[first_tet(cell)]; }

    /// theta = d . u / V with u the displacements of `node`, ascending: V in m^3, d in m^2, three a node.
    struct Average {
        std::vector<std::int32_t> node;
        Eigen::VectorXd d_m2;
        double volume_m3 = 0.0;
    };
    Average average(std::size_t cell) const;

private:
    std::size_t first_tet(std::size_t cell) const { return static_cast<std::size_t>(tets_at_[cell].front()); }

    ElementMesh mesh_;
    Lists tets_at_;                   // [cells]
    std::vector<std::int32_t> node_;  // [cells]
};

}  // namespace haptable
