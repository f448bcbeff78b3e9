// SPDX-License-Identifier: GPL-2.0-or-later
// What the contact modes feel like, as tables for docs/CONTACT.md.
#pragma once

#include <filesystem>

#include "host/bench/contact/curves.hpp"
#include "host/numbers/numbers.hpp"

namespace haptable {

/// Mean and ripple, (max - min) / mean, of the stiffness along the line, by mesh size and force.
NumberTable stiffness_table(const StiffnessLine& line);

/// Energy given to the user over the most that was stored, the worst of `loops` random closed loops (in, slide, out),
/// by body, god-object and force; without a release.
NumberTable loop_table(const std::filesystem::path& build, int loops);

/// Largest change of the tangential force from tick to tick while sliding at 100 mm/s over the cube's top, in units of
/// k v dt, by mesh, depth and mode; without a release.
NumberTable change_table(const std::filesystem::path& build);

/// By how much the force differs at 1 and at 100 kHz, relative, in 99.9 % of the ticks of those slides.
Number settling(const std::filesystem::path& build);

/// Largest change of the force in a tick, mN, at the jumps of the least-energy god-object, by force and depth.
NumberTable jump_table(const std::filesystem::path& build);

/// The same with the consistent force 2 mm deep, over 12 lines, by release and speed.
NumberTable release_table(const std::filesystem::path& build);

}  // namespace haptable
