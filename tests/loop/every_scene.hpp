// SPDX-License-Identifier: GPL-2.0-or-later
// The paper's cube as every combination of parts: one finger or two, held or free, with or without modes.
#pragma once

#include <string>
#include <vector>

#include "codegen/body_modes.hpp"
#include "tests/loop/soft_pair.hpp"
#include "tests/moving_body.hpp"

namespace haptable::test {

struct Parts {
    int fingers = 1;
    bool is_free = false, rings = false;

    std::string name() const {
        return std::string(fingers == 1 ? "one" : "two") + (is_free ? "_free" : "_held") +
               (rings ? "_ringing" : "_stiff");
    }
};

inline std::vector<Parts> every_combination() {
    std::vector<Parts> all;
    for (const int fingers : {1, 2})
        for (const bool is_free : {false, true})
            for (const bool rings : {false, true}) all.push_back({fingers, is_free, rings});
    return all;
}

/// Where its surface is does not matter to who sends it over a line: its modes are made up.
class EveryScene {
public:
    EveryScene() {
        add_gravity(body_);
        add_floor(body_, 0.0, 0.3);
        const std::size_t rows = body_modes_.mode.size() * pair_.scene().model->free_count;
        for (std::size_t k = 0; k < rows; ++k) body_modes_.shape.push_back({0.0F, 2.0F, 4.0F});
        modes_ = modes_in_memory(body_modes_);
        body_.crc = haptable_crc_of(&body_, haptable_span_of_body);
    }
    EveryScene(const EveryScene&) = delete;
    EveryScene& operator=(const EveryScene&) = delete;

    ServoScene scene(const Parts& parts) const {
        ServoScene scene = parts.fingers == 2 ? pair_.scene() : pair_.scene_of_one();
        if (parts.is_free) scene.body = &body_;
        if (parts.rings) scene.modes = &modes_;
        return scene;
    }

private:
    SoftPair pair_{0.5};
    haptable_body body_ = cube_body();
    ServoModes body_modes_{{tick_of_mode(60.0, 0.05), tick_of_mode(140.0, 0.05)}, {}, 3};
    haptable_modes modes_{};
};

/// Made once.
inline const EveryScene& every_scene() {
    static const EveryScene scene;
    return scene;
}

}  // namespace haptable::test
