// SPDX-License-Identifier: GPL-2.0-or-later
// The Falcon's end over a pseudo terminal: its grip where a test puts it, homed after some frames.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "host/device/falcon.hpp"
#include "tests/host/device/pty.hpp"

namespace haptable::test {

class FalconBoard : public PtyBoard {
public:
    using Values = std::array<std::int16_t, 3>;  // of each leg

    /// The grip from the base's middle, m.
    explicit FalconBoard(const Eigen::Vector3d& grip_m) : encoder_(encoders_of(grip_m)) { begin(); }
    ~FalconBoard() override { end(); }

    void press(std::uint8_t buttons) { buttons_ = buttons; }
    /// The motors' values of the last frame; frames of another form; frames that asked it to home.
    Values motor() const {
        const std::lock_guard lock(mutex_);
        return motor_;
    }
    int odd() const { return odd_; }
    int homing() const { return homing_; }
    Values encoder() const { return encoder_; }

    /// What the legs' encoders count there, rounded.
    static Values encoders_of(const Eigen::Vector3d& grip_m) {
        const Eigen::Vector3d angle = falcon_angles(grip_m).value();
        Values encoder{};
        for (std::size_t leg = 0; leg < 3; ++leg) {
            const double degrees = angle[static_cast<Eigen::Index>(leg)] * 180.0 / std::numbers::pi;
            encoder[leg] = static_cast<std::int16_t>(std::lround((degrees - 35.0) * 1280.0 / 360.0 * 110.0 / 14.25));
        }
        return encoder;
    }

private:
    static void add(std::int16_t value, Bytes& bytes) {
        for (int shift = 0; shift < 16; shift += 4)
            bytes.push_back(static_cast<std::uint8_t>('A' + (static_cast<std::uint16_t>(value) >> shift & 0xF)));
    }

    Bytes answer(Bytes& held) override {
        Bytes said;
        for (; held.size() >= 16; held.erase(held.begin(), held.begin() + 16)) {
            const std::lock_guard lock(mutex_);
            if (held[0] != '<' || held[15] != '>') ++odd_;
            for (std::size_t leg = 0; leg < 3; ++leg) {
                unsigned value = 0;
                for (std::size_t i = 0; i < 4; ++i)
                    value |= static_cast<unsigned>(held[1 + 4 * leg + i] - 'A') << (4 * i);
                motor_[leg] = static_cast<std::int16_t>(value);
            }
            homing_ += (held[13] - 'A') & 1;
            const bool homed = ++frames_ > 3;
            said.push_back('<');
            for (const std::int16_t value : encoder_) add(homed ? value : std::int16_t{0}, said);
            said.push_back(static_cast<std::uint8_t>('A' + ((homed ? 7 : 2) << 4) + buttons_));
            said.push_back('A');
            said.push_back('>');
        }
        return said;
    }

    Values encoder_, motor_{99, 99, 99};
    int frames_ = 0;
    std::atomic<int> odd_ = 0, homing_ = 0;
    std::atomic<std::uint8_t> buttons_ = 0;
};

}  // namespace haptable::test
