// SPDX-License-Identifier: GPL-2.0-or-later
// The hard cases: bodies and materials at the ends of what is allowed, and past them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

namespace haptable {

struct HardCase {
    std::string name;
    Scene scene;
    std::string refusal;  ///< what the error must say; empty: it is computed
};

/// All of them; meshes are written below `folder`. Small: some hundred nodes at most.
std::vector<HardCase> hard_cases(const std::filesystem::path& folder);

/// The one of that name. Throws Error where there is none.
HardCase hard_case(const std::string& name, const std::filesystem::path& folder);

/// The paper's cube of 5 nodes a side, its bottom held.
Scene hard_cube(double side_m, const Material& material, Element element = Element::kLinear);

}  // namespace haptable
