// SPDX-License-Identifier: GPL-2.0-or-later
// The paper's cube for two fingers, as a servo program has it.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "host/session/scene.hpp"
#include "tests/bodies.hpp"

namespace haptable::test {

class SoftPair {
public:
    explicit SoftPair(double friction = 0.0) {
        tables_.limits = {};
        tables_.static_friction = tables_.kinetic_friction = friction;
        tables_.options.set("contact.release_slew", 0.0);
        model_ = model_in_memory(tables_, servo_);
        pair_model_ = pair_in_memory(pair_, tables_, model_);
    }
    SoftPair(const SoftPair&) = delete;
    SoftPair& operator=(const SoftPair&) = delete;

    const Tables& tables() const { return tables_; }
    ServoScene scene() const { return {&model_, node_.data(), "two", &pair_model_}; }
    /// The same body for one finger.
    ServoScene scene_of_one() const { return {&model_, node_.data(), "one"}; }

private:
    static Scene scene_of_two() {
        Scene scene = cube_scene(4, 0.3);
        scene.contact.fingers = 2;
        return scene;
    }

    ElasticBody body_{scene_of_two(), ForceLaw::kConsistent};
    Tables tables_ = body_.tables();
    ServoModel servo_ = build_model(tables_);
    ServoPair pair_ = build_pair(body_.pair(), tables_, servo_);
    haptable_model model_{};
    haptable_pair_model pair_model_{};
    std::vector<std::uint32_t> node_{body_.servo().node.begin(), body_.servo().node.end()};
};

}  // namespace haptable::test
