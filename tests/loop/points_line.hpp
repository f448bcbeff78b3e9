// SPDX-License-Identifier: GPL-2.0-or-later
// The paper's cube under a tool or under hands, and the servo's end of a line as firmware/port/loop.c has it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <string>

#include "host/session/scene.hpp"
#include "tests/bodies.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/loop/line_bytes.hpp"

namespace haptable::test {

/// What touches the cube.
struct LinePoints {
    int hands = 0;  ///< 0: a tool

    std::string name() const { return hands == 0 ? "tool" : "hands_" + std::to_string(hands); }
};

/// A scene and what it points to; made once.
class PointsScene {
public:
    static const PointsScene& of(const LinePoints& points) {
        static std::map<int, std::unique_ptr<PointsScene>> made;
        auto& one = made[points.hands];
        if (!one) one = std::make_unique<PointsScene>(points);
        return *one;
    }
    explicit PointsScene(const LinePoints& points) : loaded_(files_of(scene_of(points))) {}
    PointsScene(const PointsScene&) = delete;
    PointsScene& operator=(const PointsScene&) = delete;

    ServoScene scene() const {
        return {&loaded_.model(), loaded_.node().data(), "points", loaded_.pair(), nullptr, nullptr, loaded_.tool()};
    }

private:
    static Scene scene_of(const LinePoints& points) {
        const WorkFolder folder;
        const std::string touch = points.hands == 0 ? "[tool]\nshape = \"disc\"\nradius = 0.008\npoints = 5\n"
                                                    : "fingers = " + std::to_string(points.hands) + "\n";
        write_file(folder / "points.toml", masked_cube("points", "nodes_per_side = 5\n", 0.0106, touch));
        return read_scene(folder / "points.toml");
    }

    LoadedScene loaded_;
};

/// A tick's input: of hands in[0 .. fingers - 1], of a tool the first and the turn.
struct PointsState {
    std::uint32_t time_us = 0;
    std::uint8_t begins = 0;
    std::array<haptable_input, HAPTABLE_HANDS> in{};
    std::array<float, 4> turn{1.0F, 0.0F, 0.0F, 0.0F};
};

/// Hands around the cube and a tool on its top that come down, slide, turn and lift, each in its own time.
class PointsPath {
public:
    explicit PointsPath(unsigned seed) : random_(seed) {
        for (Way& way : way_) way = {any(0.3, 1.0), any(0.7, 1.3), any(0.0, 6.0)};
    }
    PointsState at(std::uint32_t tick) {
        PointsState state;
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

inline Bytes points_state_frame(std::uint32_t sequence, const haptable_line_hello& hello, const PointsState& state) {
    Bytes bytes(HAPTABLE_HANDS_LINE_STATE_BYTES);
    if ((hello.flags & HAPTABLE_LINE_TOOL) != 0) {
        haptable_tool_line_state tool{state.time_us, state.begins, {state.in[0], {}}};
        std::copy_n(state.turn.begin(), 4, tool.in.turn);
        bytes.resize(haptable_tool_line_write_state(sequence, &tool, bytes.data()));
    } else {
        haptable_hands_line_state hands{state.time_us, state.begins, {}};
        std::copy_n(state.in.begin(), HAPTABLE_HANDS, hands.in);
        bytes.resize(haptable_hands_line_write_state(sequence, &hello, &hands, bytes.data()));
    }
    return bytes;
}

/// A tick's output, of either kind.
struct PointsAnswer {
    haptable_hands_line_answer hands{};
    haptable_tool_line_answer tool{};
};

inline Bytes points_answer_frame(std::uint32_t sequence, const haptable_line_hello& hello, PointsAnswer answer) {
    Bytes bytes(HAPTABLE_TOOL_LINE_ANSWER_BYTES);
    bytes.resize((hello.flags & HAPTABLE_LINE_TOOL) != 0
                     ? haptable_tool_line_write_answer(sequence, &answer.tool, bytes.data())
                     : haptable_hands_line_write_answer(sequence, &hello, &answer.hands, bytes.data()));
    return bytes;
}

/// The servo's end.
class PointsEnd {
public:
    explicit PointsEnd(const ServoScene& scene) : state(state_of(scene)), is_tool_(scene.tool != nullptr) {
        state.check(HAPTABLE_CHECK_ALL);
        std::uint32_t count = 0;
        const std::uint8_t* bytes = is_tool_ ? haptable_tool_line_begin(&state.scene(), &tool_, &count)
                                             : haptable_hands_line_begin(&state.scene(), &hands_, &count);
        begun.assign(bytes, bytes + count);
        hello = is_tool_ ? tool_.line.own : hands_.line.own;
    }

    Bytes put(std::uint8_t byte) {
        std::uint32_t count = 0;
        const std::uint8_t* said = is_tool_
                                       ? haptable_tool_line(&state.scene(), state.memory(), &tool_, byte, &count)
                                       : haptable_hands_line(&state.scene(), state.memory(), &hands_, byte, &count);
        return {said, said + count};
    }
    Bytes put(const Bytes& bytes) {
        Bytes all;
        for (const std::uint8_t byte : bytes) {
            const Bytes said = put(byte);
            all.insert(all.end(), said.begin(), said.end());
        }
        return all;
    }
    /// What it said, where that is an answer.
    bool hear(const Bytes& bytes, PointsAnswer& answer) const {
        const auto frames = LineEar().hear(bytes);
        if (frames.size() != 1) return false;
        return (is_tool_ ? haptable_tool_line_take_answer(&frames[0].frame, &answer.tool)
                         : haptable_hands_line_take_answer(&frames[0].frame, &hello, &answer.hands)) != 0;
    }

    SceneState state;
    haptable_line_hello hello{};  ///< what it says of itself
    Bytes begun;                  ///< what it has said by itself

private:
    bool is_tool_;
    haptable_hands_line_end hands_{};
    haptable_tool_line_end tool_{};
};

}  // namespace haptable::test
