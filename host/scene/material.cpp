// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/scene/material.hpp"

#include <fmt/format.h>

#include <cmath>

namespace haptable {

namespace {

constexpr std::array<std::array<std::size_t, 2>, 3> kPair{{{0, 1}, {0, 2}, {1, 2}}};  // of nu and G

}  // namespace

Orthotropic fibre(double young_along_pa, double young_across_pa, double poisson, double poisson_across,
                  double shear_pa) {
    return {{young_along_pa, young_across_pa, young_across_pa},
            {poisson, poisson, poisson_across},
            {shear_pa, shear_pa, young_across_pa / (2.0 * (1.0 + poisson_across))},
            {}};
}

std::string violated(const Orthotropic& law) {
    const auto& [e, nu, g, axes] = law;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto [i, j] = kPair[k];
        if (const double most = std::sqrt(e[i] / e[j]); !(std::abs(nu[k]) < most))
            return fmt::format("nu{0}{1} = {2:g} must lie between -{3:g} and {3:g}, the root of E{0} / E{1}", i + 1,
                               j + 1, nu[k], most);
    }
    const double n21 = nu[0] * e[1] / e[0], n31 = nu[1] * e[2] / e[0], n32 = nu[2] * e[2] / e[1];
    const double left = 1.0 - nu[0] * n21 - nu[1] * n31 - nu[2] * n32 - 2.0 * n21 * n32 * nu[1];
    if (left > 0.0) return {};
    return fmt::format("1 - nu12 nu21 - nu23 nu32 - nu31 nu13 - 2 nu21 nu32 nu13 = {:g} must be greater than 0", left);
}

Material like(const Orthotropic& law) {
    const auto& [e, nu, g, axes] = law;
    const double direct = 1.0 / e[0] + 1.0 / e[1] + 1.0 / e[2];
    const double cross = -nu[0] / e[0] - nu[1] / e[0] - nu[2] / e[1];
    const double shear = 1.0 / g[0] + 1.0 / g[1] + 1.0 / g[2];
    const double bulk_pa = 1.0 / (direct + 2.0 * cross), shear_pa = 15.0 / (4.0 * (direct - cross) + 3.0 * shear);
    Material material;
    material.young_pa = 9.0 * bulk_pa * shear_pa / (3.0 * bulk_pa + shear_pa);
    material.poisson = (3.0 * bulk_pa - 2.0 * shear_pa) / (2.0 * (3.0 * bulk_pa + shear_pa));
    material.orthotropic = law;
    return material;
}

}  // namespace haptable
