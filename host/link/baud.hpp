// SPDX-License-Identifier: GPL-2.0-or-later
// A serial port's speed as a number, which termios has no name for. Apart, for the kernel's header and libc's each
// define struct termios.
#pragma once

namespace haptable {

/// False where the port does not take it, or takes another that is farther from it than 2 %.
bool set_any_baud(int fd, unsigned baud);

}  // namespace haptable
