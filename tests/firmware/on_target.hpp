// SPDX-License-Identifier: GPL-2.0-or-later
// A tick of an emulated microcontroller beside the host's.
#pragma once

#include <gtest/gtest.h>
#include <array>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

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

/// The host's servo over a path, a tick after the other, its work counted alone.
class HostTicks {
public:
    HostTicks(const haptable_model& model, const std::vector<std::array<float, 3>>& path_m)
        : model_(model), path_m_(path_m) {
        haptable_servo_init(&servo);
    }
    haptable_output step(std::size_t i) {
        forget_work(servo.counters);
        haptable_output out;
        haptable_servo_step(&model_, &servo, path_m_[i].data(), static_cast<std::uint32_t>(i * 1000), &out);
        return out;
    }

private:
    const haptable_model& model_;
    const std::vector<std::array<float, 3>>& path_m_;
    haptable_room room_{};

public:
    haptable_servo& servo = room_.fingers.servo[0];
};

/// Every tick of the path has the host's bits, or the test fails and ends; each(i, tick, host, out) sees it.
template <typename Each>
void expect_host_bits(const TargetImage& image, const haptable_model& model,
                      const std::vector<std::array<float, 3>>& path_m, std::vector<TargetTick>& ticks, Each each) {
    ticks = image.measure({model}, path_m);
    HostTicks host(model, path_m);
    for (std::size_t i = 0; i < path_m.size(); ++i) {
        const haptable_output out = host.step(i);
        ASSERT_TRUE(same(ticks[i].finger[0], out)) << "tick " << i;
        each(ticks[i], host.servo, out);
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
