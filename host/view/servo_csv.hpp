// SPDX-License-Identifier: GPL-2.0-or-later
// The servo's CSV, read strictly: every line is what the servo of these tables can have written.
#pragma once

#include <filesystem>
#include <vector>

#include "codegen/loads.hpp"
#include "host/view/frame.hpp"

namespace haptable {

/// The chosen ticks of the file, in order. The loads are those that the servo computed (ContactLoads). Throws Error
/// "FILE:LINE: ..." for a wrong header, a field that is not its column's number, a contact that is not on a touchable
/// patch of the tables or whose area coordinates are none; Error "FILE: ..." for a chosen tick that is not there.
std::vector<ContactFrame> read_servo_csv(const std::filesystem::path& file, const ContactLoads& loads,
                                         const FrameChoice& choice);

}  // namespace haptable
