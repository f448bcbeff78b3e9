// SPDX-License-Identifier: GPL-2.0-or-later
// The bodies that ticks are timed on beside proxies.
#pragma once

#include <filesystem>
#include <memory>

#include "host/bench/subject.hpp"
#include "host/scene/scene.hpp"

namespace haptable {

/// How a scene is touched.
struct ContactMode {
    ForceLaw force;
    GodObject god_object;
};

/// The scene in that mode, precomputed below `build`, and ready to be touched. `mask_radius_m` counts for masks alone.
std::unique_ptr<Subject> touched_as(Scene scene, const ContactMode& mode, double mask_radius_m,
                                    const std::filesystem::path& build);

/// The paper's cube; of more than 9 nodes a side only the middle of its top may be touched.
Scene contact_cube(int nodes_per_side, double poisson);

}  // namespace haptable
