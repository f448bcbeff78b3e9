// SPDX-License-Identifier: GPL-2.0-or-later
// The paper's cube for two fingers, as a servo program has it.
#pragma once

#include <nlohmann/json.hpp>

#include "host/session/scene.hpp"
#include "tests/bodies.hpp"

namespace haptable::test {

class SoftPair {
public:
    explicit SoftPair(double friction = 0.0) : loaded_(files(friction)) {}

    const Tables& tables() const { return loaded_.tables(); }
    ServoScene scene() const { return {&loaded_.model(), loaded_.node().data(), "two", loaded_.pair()}; }
    /// The same body for one finger.
    ServoScene scene_of_one() const { return {&loaded_.model(), loaded_.node().data(), "one"}; }

private:
    static SceneFiles files(double friction) {
        Scene scene = cube_scene(4, 0.3);
        scene.contact.force = ForceLaw::kConsistent;
        scene.contact.fingers = 2;
        SceneFiles files = files_of(scene);
        files.tables.limits = {};
        files.tables.static_friction = files.tables.kinetic_friction = friction;
        files.tables.options.set("contact.release_slew", 0.0);
        return files;
    }

    LoadedScene loaded_;
};

}  // namespace haptable::test
