// SPDX-License-Identifier: GPL-2.0-or-later
// strain_1 = (s_1 - nu_12 s_2 - nu_13 s_3) / E_1, ...,   shear_12 = t_12 / G_12, ...,   nu_ij / E_i = nu_ji / E_j
//
// The laws of a scene's materials: isotropic, or with three planes of symmetry.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "host/base/stiffening.hpp"

namespace haptable {

/// Directions 1 and 2 of a material, which 3 = 1 x 2 makes a right-handed frame. 2 is made normal to 1.
struct MaterialAxes {
    std::array<std::array<double, 3>, 2> direction{};  ///< of the whole material; 2 is 0 where it does not matter
    std::array<std::string, 2> field;                  ///< or of each element: cell vectors of the mesh file
    /// Or around an axis, a point (m, in the mesh file's frame) and a direction: 1 around it, 2 along it, 3 outward.
    std::optional<std::array<std::array<double, 3>, 2>> around;
    int line = 0;  ///< in the scene file, for errors
};

/// Nine constants (Lekhnitskii, Theory of Elasticity of an Anisotropic Body). nu_ij: what a pull along i takes off j.
struct Orthotropic {
    std::array<double, 3> young_pa{};  ///< E_1 E_2 E_3
    std::array<double, 3> poisson{};   ///< nu_12 nu_13 nu_23
    std::array<double, 3> shear_pa{};  ///< G_12 G_13 G_23
    MaterialAxes axes = {};
};

/// [material], or that of a [[region]]: linear.
struct Material {
    double young_pa = 0.0;  ///< > 0; of an orthotropic one those of like()
    double poisson = 0.0;   ///< -1 < poisson < 0.5
    std::optional<Orthotropic> orthotropic = {};
    std::optional<Stiffening> stiffening = {};  ///< [material] alone, for all regions: dents stiffen
};

/// Transverse isotropy: fibres along 1, alike in all directions across them.
///   poisson        nu_12: what a pull along the fibres takes off across them
///   poisson_across nu_23
Orthotropic fibre(double young_along_pa, double young_across_pa, double poisson, double poisson_across,
                  double shear_pa);

/// What keeps the law from having a positive definite stiffness (Jones, Mechanics of Composite Materials, 2.4), in one
/// line; empty where nothing does. Moduli are positive.
std::string violated(const Orthotropic& law);

/// The isotropic material of the same bulk and shear modulus, both by Reuss's averages (Hill 1952): of an isotropic law
/// itself.
Material like(const Orthotropic& law);

}  // namespace haptable
