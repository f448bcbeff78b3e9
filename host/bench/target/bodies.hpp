// SPDX-License-Identifier: GPL-2.0-or-later
// What a tick takes of a body that nothing holds, under one finger and two, and of one that rings.
#pragma once

#include <filesystem>

#include "host/numbers/numbers.hpp"

namespace haptable {

/// Instructions of a session each (tip_path and its like) on every target: median of the ticks with contact before and
/// after, the worst of all, the bound.
///   build  where `make images` has left the images and their scenes
NumberTable body_costs(const std::filesystem::path& build);

}  // namespace haptable
