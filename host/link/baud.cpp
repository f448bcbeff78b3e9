// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/baud.hpp"

#include <asm/termbits.h>
#include <sys/ioctl.h>

#include <algorithm>

namespace haptable {

bool set_any_baud(int fd, unsigned baud) {
    termios2 port{};
    if (ioctl(fd, TCGETS2, &port) != 0) return false;
    port.c_cflag &= ~static_cast<tcflag_t>(CBAUD);
    port.c_cflag |= BOTHER;
    port.c_ispeed = port.c_ospeed = baud;
    if (ioctl(fd, TCSETS2, &port) != 0 || ioctl(fd, TCGETS2, &port) != 0) return false;
    return std::max(port.c_ospeed, baud) - std::min(port.c_ospeed, baud) <= baud / 50;
}

}  // namespace haptable
