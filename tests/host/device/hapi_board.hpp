// SPDX-License-Identifier: GPL-2.0-or-later
// The board's end of the hAPI over a pseudo terminal: two motors whose angles a test gives.
#pragma once

#include <Eigen/Core>
#include <bit>
#include <mutex>

#include "tests/host/device/pty.hpp"

namespace haptable::test {

class HapiBoard : public PtyBoard {
public:
    /// Motors' angles in degrees.
    HapiBoard(double first, double second) : first_(first), second_(second) { begin(); }
    ~HapiBoard() override { end(); }

    void turn_to(double first, double second) {
        const std::lock_guard lock(mutex_);
        first_ = first;
        second_ = second;
    }
    /// The last torques, N m, of the first and the second motor; how many there were; the set-up that was sent.
    Eigen::Vector2d torque_nm() const {
        const std::lock_guard lock(mutex_);
        return torque_nm_;
    }
    int torques() const { return torques_; }
    Bytes set_up() const {
        const std::lock_guard lock(mutex_);
        return set_up_;
    }

    /// A float as the line has it.
    static void add(float value, Bytes& bytes) {
        for (int shift = 0; shift < 32; shift += 8)
            bytes.push_back(static_cast<std::uint8_t>(std::bit_cast<std::uint32_t>(value) >> shift));
    }
    static float float_at(const std::uint8_t* bytes) {
        return std::bit_cast<float>(std::uint32_t(bytes[0]) | std::uint32_t(bytes[1]) << 8 |
                                    std::uint32_t(bytes[2]) << 16 | std::uint32_t(bytes[3]) << 24);
    }

private:
    /// Length of the first message; 0 where it is not whole yet.
    static std::size_t length_of(const Bytes& held) {
        if (held.size() < 2) return 0;
        if (held[0] == 0) return 2;
        if (held[0] == 2) return held.size() >= 10 ? 10 : 0;
        std::size_t at = 2, floats = 0;
        for (int list = 0; list < 4; ++list) {
            if (held.size() <= at) return 0;
            // Motors and encoders: a mask of ports, then a byte for each; sensors and PWM pins: their number, and a
            // byte.
            const auto count = list < 2 ? static_cast<std::size_t>(std::popcount(held[at])) : held[at];
            if (list == 1) floats = 2 * count;
            at += 1 + count;
        }
        return held.size() >= at + 4 * floats ? at + 4 * floats : 0;
    }

    Bytes answer(Bytes& held) override {
        Bytes said;
        for (std::size_t size = 0; (size = length_of(held)) > 0;
             held.erase(held.begin(), held.begin() + static_cast<std::ptrdiff_t>(size))) {
            const std::lock_guard lock(mutex_);
            if (held[0] == 1) set_up_.assign(held.begin(), held.begin() + static_cast<std::ptrdiff_t>(size));
            if (held[0] != 2) continue;
            // In the order of the ports: the second motor is on the first.
            torque_nm_ = {static_cast<double>(float_at(&held[6])), static_cast<double>(float_at(&held[2]))};
            ++torques_;
            said.push_back(held[1]);
            for (const double angle : {second_, first_}) add(static_cast<float>(angle), said);
        }
        return said;
    }

    double first_, second_;
    Eigen::Vector2d torque_nm_ = Eigen::Vector2d::Constant(99.0);
    Bytes set_up_;
    std::atomic<int> torques_ = 0;
};

}  // namespace haptable::test
