// SPDX-License-Identifier: GPL-2.0-or-later
// The paper's cube as every combination of parts: one finger or two, held or free, with or without modes; a tool;
// hands.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "codegen/body_modes.hpp"
#include "host/session/bridge/target.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/loop/soft_pair.hpp"
#include "tests/moving_body.hpp"

namespace haptable::test {

struct Parts {
    int fingers = 1;
    bool is_free = false, rings = false, has_tool = false;

    std::string name() const {
        if (has_tool) return "tool";
        if (fingers > HAPTABLE_FINGERS) return "hands_" + std::to_string(fingers);
        return std::string(fingers == 1 ? "one" : "two") + (is_free ? "_free" : "_held") +
               (rings ? "_ringing" : "_stiff");
    }
};

inline std::vector<Parts> every_combination() {
    std::vector<Parts> all{{.has_tool = true}, {.fingers = 3}, {.fingers = 5}, {.fingers = 8}};
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
        if (parts.has_tool || parts.fingers > HAPTABLE_FINGERS) {
            const LoadedScene& of = of_points(parts);
            return {&of.model(), of.node().data(), "points", of.pair(), nullptr, nullptr, of.tool()};
        }
        ServoScene scene = parts.fingers == 2 ? pair_.scene() : pair_.scene_of_one();
        if (parts.is_free) scene.body = &body_;
        if (parts.rings) scene.modes = &modes_;
        return scene;
    }
    /// With a tool, or hands; made when it is first asked for.
    const LoadedScene& of_points(const Parts& parts) const {
        std::unique_ptr<LoadedScene>& made = points_[parts.name()];
        if (made) return *made;
        const WorkFolder folder;
        const std::string touch = parts.has_tool ? "[tool]\nshape = \"disc\"\nradius = 0.008\npoints = 5\n"
                                                 : "fingers = " + std::to_string(parts.fingers) + "\n";
        write_file(folder / "points.toml",
                   "name = \"points\"\n[mesh]\ngenerate = \"cube\"\nnodes_per_side = 5\n[material]\nyoung = 1e4\n"
                   "poisson = 0.3\n[[fixed]]\nbelow = 0\n[contact]\nforce = \"pressure-mask\"\nmask_radius = 0.0106\n" +
                       touch);
        made = std::make_unique<LoadedScene>(files_of(read_scene(folder / "points.toml")));
        return *made;
    }

private:
    SoftPair pair_{0.5};
    haptable_body body_ = cube_body();
    ServoModes body_modes_{{tick_of_mode(60.0, 0.05), tick_of_mode(140.0, 0.05)}, {}, 3};
    haptable_modes modes_{};
    mutable std::map<std::string, std::unique_ptr<LoadedScene>> points_;
};

/// Made once.
inline const EveryScene& every_scene() {
    static const EveryScene scene;
    return scene;
}

/// Hands around the cube and a tool on its top that come down, slide, turn and lift, each in its own time.
class PathOfHands {
public:
    explicit PathOfHands(unsigned seed) : random_(seed) {
        for (Way& way : way_) way = {any(0.3, 1.0), any(0.7, 1.3), any(0.0, 6.0)};
    }
    TargetState at(std::uint32_t tick) const {
        TargetState state;
        const double t = 1e-3 * tick;
        state.time_us = tick * HAPTABLE_TICK_US;
        for (std::size_t f = 0; f < state.in.size(); ++f) {
            const Way& way = way_[f];
            const double deep_m = 0.0015 * (1.0 - std::cos(21.0 * way.speed * t));
            const double along_m = 0.003 * std::sin(17.0 * way.speed * t + way.phase) + 0.004 * way.place;
            const double out_m = 0.0005 - deep_m;
            const double at_m[4][3] = {{0.011 + along_m, 0.014, 0.03 + out_m},
                                       {0.015, -out_m, 0.013 + along_m},
                                       {0.03 + out_m, 0.016, 0.012 + along_m},
                                       {-out_m, 0.013 + along_m, 0.018}};
            for (std::size_t c = 0; c < 3; ++c) state.in[f].finger_m[c] = float(at_m[f % 4][c] + (f > 3 ? 2e-3 : 0.0));
            state.in[f].is_there = 1;
        }
        const double angle = 0.1 * std::sin(13.0 * t), about = 0.3 * t;
        const double length = std::sqrt(1.0 + angle * angle + about * about);
        state.turn = {float(1.0 / length), float(angle / length), 0.0F, float(about / length)};
        return state;
    }

private:
    struct Way {
        double place, speed, phase;
    };
    double any(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }

    std::mt19937 random_;
    std::array<Way, HAPTABLE_HANDS> way_{};
};

}  // namespace haptable::test
