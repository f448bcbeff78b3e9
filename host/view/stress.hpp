// SPDX-License-Identifier: GPL-2.0-or-later
// s = sqrt(3/2 dev(sigma) : dev(sigma)),   dev(sigma) = P D eps,   eps = sum_a B_a u_a
//
// P takes the mean of the normal stresses away. What average nodal pressure averages is such a mean, so that the
// deviator is the element's own, whatever the element.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "host/fem/hooke.hpp"
#include "host/tables/tables.hpp"
#include "host/view/surface.hpp"

namespace haptable {

/// P D B of an element around one of its points: dev(sigma), Pa, in Voigt's notation (xx, yy, zz, xy, xz, yz), of its
/// nodes' displacements, m. gradient_per_m: a column for each node, of its shape function.
using DeviatorMap = Eigen::Matrix<float, 6, Eigen::Dynamic>;
DeviatorMap deviator_map(const Hooke& law, const Eigen::Ref<const Eigen::Matrix3Xd>& gradient_per_m);

/// Von Mises stress of a deviator in Voigt's notation, Pa.
float von_mises(const Eigen::Matrix<float, 6, 1>& deviator_pa);

/// An element at the surface.
struct StressedElement {
    /// Linear tetrahedra have one for all of its nodes.
    struct Place {
        DeviatorMap deviator_pa_per_m;
        std::vector<std::int32_t> drawn;  ///< surface nodes
    };
    std::vector<std::int32_t> row;  ///< of each of its nodes, 4 or 10; -1: fixed
    std::vector<Place> place;
};

/// Von Mises stress of the elements at the surface: of any element and material, where all free nodes have rows. It is
/// the press's alone, without the body's weight and without membranes.
class SurfaceStress {
public:
    /// Reads mesh.vtu and options.json of the tables' folder. Throws Error that says what is in the way: columns of the
    /// surface alone, tables of an earlier version.
    SurfaceStress(const Tables& tables, const TablesFolder& folder, const DrawnSurface& surface);

    /// [m] at every drawn node the mean over its elements at the surface, each taken at the node, Pa. displacement_m:
    /// [r,3] of equation 8.
    void find(std::span<const float> displacement_m, std::vector<float>& stress_pa) const;

private:
    std::vector<StressedElement> element_;
    std::vector<float> share_;  ///< [m] 1 / elements at the node
};

}  // namespace haptable
