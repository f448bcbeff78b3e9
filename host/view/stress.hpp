// SPDX-License-Identifier: GPL-2.0-or-later
// s = sqrt(3/2 dev(sigma) : dev(sigma)),   dev(sigma) = 2 mu dev(eps),   eps = sym(sum_a u_a grad N_a)
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "host/tables/tables.hpp"
#include "host/view/surface.hpp"

namespace haptable {

/// Von Mises stress of a linear tetrahedron, Pa. shear_pa: mu; columns: gradients of the corners' shape functions (1/m)
/// and the corners' displacements (m).
float von_mises(float shear_pa, const Eigen::Matrix<float, 3, 4>& gradient_per_m,
                const Eigen::Matrix<float, 3, 4>& displacement_m);

/// Columns: the gradients of the corners' shape functions, 1/m, of corners at `corner_m`.
Eigen::Matrix<float, 3, 4> shape_gradients(const std::array<Eigen::Vector3d, 4>& corner_m);

/// Von Mises stress of the elements at the surface: linear tetrahedra of one isotropic material, all of whose free
/// nodes have rows.
class SurfaceStress {
public:
    /// Reads mesh.vtu and summary.json of the tables' folder. Throws Error that says what is in the way: columns of the
    /// surface alone, other elements, several materials.
    SurfaceStress(const Tables& tables, const std::filesystem::path& folder, const DrawnSurface& surface);

    /// [m] at every drawn node the mean of its elements at the surface, Pa. displacement_m: [r,3] of equation 8.
    void find(std::span<const float> displacement_m, std::vector<float>& stress_pa) const;

private:
    struct Element {
        std::array<std::int32_t, 4> row;    ///< -1: fixed
        std::array<std::int32_t, 4> drawn;  ///< surface node, or -1
        Eigen::Matrix<float, 3, 4> gradient_per_m;
    };

    float shear_pa_ = 0.0F;
    std::vector<Element> element_;
    std::vector<float> share_;  ///< [m] 1 / elements at the node
};

}  // namespace haptable
