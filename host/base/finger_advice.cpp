// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/finger_advice.hpp"

#include <fmt/format.h>

namespace haptable {

std::string finger_advice(double radius_m) {
    return fmt::format(
        "  the finger is a point, the paper's own mode: on most meshes its force is 50 % and more off the body's, and "
        "closed loops give energy\n  (docs/CONTACT.md); for a finger with a size that gives none, write below name:\n"
        "    contact = {{ force = \"pressure-mask\", mask_radius = {:.2g}, god_object = \"least-energy\" }}\n",
        radius_m);
}

}  // namespace haptable
