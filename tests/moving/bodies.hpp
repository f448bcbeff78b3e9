// SPDX-License-Identifier: GPL-2.0-or-later
// The bodies on which the laws of motion are tried, each as a scene of its own.
#pragma once

#include <string>

#include "host/scene/scene.hpp"
#include "tests/cells.hpp"

namespace haptable::test {

/// A body of some 30 mm, by its shape.
struct Shaped {
    std::string name;
    Cells cells;
};

Shaped block();       ///< a cube
Shaped plate();       ///< 40 x 40 x 8 mm
Shaped slab();        ///< 40 x 40 x 15 mm
Shaped sheet();       ///< 40 x 20 x 3 mm, which stands on its edge
Shaped rod();         ///< 60 x 10 x 10 mm
Shaped ball();        ///< of radius 18 mm
Shaped ring();        ///< a torus of 27 mm
Shaped lump();        ///< bent, dented and round-edged: an organ
Shaped noisy_scan();  ///< voxels of a ball, moved at random

/// Soft rubber, 15 kPa, 1,000 kg/m^3. A held one stands on its lowest sixth; a free one has a floor at its lowest
/// point.
Scene scene_of(const Shaped& shaped, bool is_free, int modes, ForceLaw force, int fingers);

}  // namespace haptable::test
