// SPDX-License-Identifier: GPL-2.0-or-later
// A tick of an emulated microcontroller beside the host's.
#pragma once

#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "host/session/scene_state.hpp"
#include "host/target/image.hpp"
#include "tests/finger.hpp"

namespace haptable::test {

/// The work of the last tick is not that of the next one.
inline void forget_work(haptable_counters& of) {
    of.most_steps = of.most_held_steps = of.most_boxes = of.most_energies = 0;
}

/// State, patch and the bits of what is felt.
inline bool same(const TargetTick::Finger& got, const haptable_output& host) {
    return got.state == host.state && got.patch == host.patch && same_bits(got.alpha, host.alpha) &&
           same_bits(got.god_object_m, host.god_object_m) && same_bits(got.force_n, host.force_n);
}

/// Of a place and the vector of a turn, as firmware/port makes it: its root, too.
inline haptable_tool_input pose_of(const std::array<float, 6>& row) {
    haptable_tool_input in{{{row[0], row[1], row[2]}, 0, 1}, {1.0F, row[3], row[4], row[5]}};
    const float rest = 1.0F - row[3] * row[3] - row[4] * row[4] - row[5] * row[5];
    for (int i = 0; i < 8; ++i) in.turn[0] = 0.5F * (in.turn[0] + rest / in.turn[0]);
    return in;
}

/// Every tick of the path has the bits of the host's scene, or the test fails and ends; each(i, out) sees it with the
/// work of that tick alone.
template <std::size_t size, typename Each>
void expect_host_bits(const std::vector<TargetTick>& ticks, SceneState& host, const TargetPath<size>& path_m,
                      const Each& each) {
    ASSERT_EQ(host.fingers(), size / 3);
    ASSERT_EQ(ticks.size(), path_m.size());
    for (std::size_t i = 0; i < path_m.size() && !testing::Test::HasFatalFailure(); ++i) {
        SCOPED_TRACE(testing::Message() << "tick " << i);
        haptable_input in[HAPTABLE_HANDS]{};
        haptable_output out[HAPTABLE_HANDS]{};
        for (std::size_t f = 0; f < host.fingers(); ++f) {
            in[f].is_there = 1;
            std::copy_n(&path_m[i][3 * f], 3, in[f].finger_m);
            forget_work(host.servo(f).counters);
        }
        host.step(in, static_cast<std::uint32_t>(i) * HAPTABLE_TICK_US, out);
        for (std::size_t f = 0; f < host.fingers(); ++f)
            ASSERT_TRUE(same(ticks[i].finger[f], out[f])) << "finger " << f;
        if (const haptable_body_state* body = host.body()) {
            ASSERT_TRUE(same_bits(ticks[i].position_m, body->position_m));
            ASSERT_TRUE(same_bits(ticks[i].turn, body->turn));
        }
        if (const haptable_modes_state* modes = host.modes()) {
            ASSERT_EQ(std::memcmp(ticks[i].q.data(), modes->q, host.scene().modes->count * sizeof(float)), 0);
        }
        each(i, out);
    }
}

/// The same of a tool and its poses; each(i, out).
template <typename Each>
void expect_host_wrench(const std::vector<TargetTick>& ticks, SceneState& host, const TargetPath<6>& path,
                        const Each& each) {
    ASSERT_EQ(ticks.size(), path.size());
    for (std::size_t i = 0; i < path.size() && !testing::Test::HasFatalFailure(); ++i) {
        haptable_tool_output out{};
        host.step(pose_of(path[i]), static_cast<std::uint32_t>(i) * HAPTABLE_TICK_US, out);
        ASSERT_TRUE(same(ticks[i].finger[0], out.hand)) << "tick " << i;
        ASSERT_EQ(std::memcmp(ticks[i].q.data(), out.torque_n_m, sizeof out.torque_n_m), 0) << "tick " << i;
        each(i, out);
    }
}

/// The numbers behind these words in a file of counts, which whoever makes a tick dearer announces it in.
inline std::vector<std::uint64_t> announced(const char* file, const std::string& words) {
    std::ifstream lines(std::string("tests/firmware/") + file);
    std::vector<std::uint64_t> counts;
    for (std::string line; counts.empty() && std::getline(lines, line);) {
        if (!line.starts_with(words)) continue;
        std::istringstream numbers(line.substr(words.size()));
        for (std::uint64_t count = 0; numbers >> count;) counts.push_back(count);
    }
    EXPECT_FALSE(counts.empty()) << file << " does not name " << words;
    return counts;
}

}  // namespace haptable::test
