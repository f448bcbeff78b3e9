// SPDX-License-Identifier: GPL-2.0-or-later
// What a scene costs a microcontroller: its servo, linked with what its tables name and nothing else.
#pragma once

#include <filesystem>
#include <set>
#include <string>

namespace haptable {

/// A program for a Cortex-M7 that steps the scene (and deforms the display's rows, where it has some) for ever, without
/// a board's start-up code.
struct LinkedServo {
    std::size_t flash = 0;  ///< bytes: code, tables, and the model that names them
    std::size_t ram = 0;    ///< bytes without the stack: the scene's state, a tick's input and output, displacements
    std::set<std::string> symbols;  ///< that begin with haptable_
    std::string image;              ///< its bytes, as they are written into flash
};

/// Links the tables of a folder with the servo's objects, as gcc's --gc-sections leaves them.
///   tables   a folder that precompute wrote
///   objects  build/<name>/firmware/cortex-m7, as `make images` leaves it
///   offered  the objects that the linker is offered, a list for the shell
/// Throws Error where there are no objects, or they cannot be linked.
LinkedServo link_servo(const std::filesystem::path& tables, const std::filesystem::path& objects,
                       const std::string& offered = "haptable_*.o");

}  // namespace haptable
