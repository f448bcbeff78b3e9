// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/contact/bodies.hpp"

#include <fmt/format.h>

#include "host/bench/cube_scene.hpp"
#include "host/precompute/precompute.hpp"

namespace haptable {

std::unique_ptr<Subject> touched_as(Scene scene, const ContactMode& mode, double mask_radius_m,
                                    const std::filesystem::path& build) {
    scene.contact.force = mode.force;
    scene.contact.god_object = mode.god_object;
    scene.contact.mask_radius_m = scene.contact.force == ForceLaw::kPressureMask ? mask_radius_m : 0.0;
    if (scene.contact.god_object == GodObject::kLeastEnergy)
        scene.contact.release_n_per_ms = 0.01;  // as a scene has by default
    scene.tables.columns = ColumnRows::kNone;
    const auto folder = build / fmt::format("{}-{}-{}", scene.name, word(mode.force), word(mode.god_object));
    Progress progress(true);
    precompute(scene, folder, progress);
    return std::make_unique<Subject>(folder);
}

Scene contact_cube(int nodes_per_side, double poisson) {
    Scene scene = cube_scene(nodes_per_side, poisson);
    if (nodes_per_side > 9)
        scene.touch.push_back({std::array<double, 6>{0.004, 0.004, 0.03 - 1e-9, 0.026, 0.026, 1}, "", 1});
    return scene;
}

}  // namespace haptable
