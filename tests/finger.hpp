// SPDX-License-Identifier: GPL-2.0-or-later
// A finger that a test moves by hand, one position a tick, and what the servo makes of it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <cstring>

#include "firmware/haptable.h"
#include "firmware/haptable_scene.h"
#include "tests/shapes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {

inline constexpr double kTick_s = 1e-6 * HAPTABLE_TICK_US;

inline Eigen::Vector3d to_vector(const float x[3]) { return {double(x[0]), double(x[1]), double(x[2])}; }

template <std::size_t n>
bool same_bits(const std::array<float, n>& a, const float* b) {
    return std::memcmp(a.data(), b, sizeof a) == 0;
}

/// A point that the servo finds: coordinates, normals and area coordinates in float, about 16 roundings.
inline Bound rounded(const TestModel& model) { return {.count = 16, .epsilon = kFloat, .size = model.size()}; }
/// The nearest point: a walk ends where a patch around would move it by no more than the tolerance, 2^-20 of the size.
inline Bound rested(const TestModel& model) { return {.count = 4, .epsilon = 0x1p-20, .size = model.size()}; }

inline haptable_model with_friction(haptable_model model, float at_rest = 0.5F, float moving = 0.4F) {
    model.frictionless = model.god_object;
    model.god_object = haptable_god_object_friction;
    model.static_friction = at_rest;
    model.kinetic_friction = moving;
    return model;
}

/// On the hand, of a contact.
inline Eigen::Vector3d force_at(const haptable_model& model, const haptable_contact& contact,
                                const Eigen::Vector3d& finger_m) {
    float nodal_n[3][3], force_n[3];
    model.force(&model, &contact, Eigen::Vector3f(finger_m.cast<float>()).data(), nodal_n, force_n);
    return to_vector(force_n);
}

/// The check of one servo's tables, which has no scene.
inline void check_tables(const haptable_model& model, haptable_servo& servo, std::uint32_t bytes = HAPTABLE_CHECK_ALL) {
    haptable_scene alone{};
    alone.model = &model;
    haptable_check(&alone, &servo, bytes);
}

class Finger {
public:
    /// The tables that the model points to must outlive the finger.
    explicit Finger(const haptable_model& model) : model_(model) { haptable_servo_init(&servo_); }
    Finger(const Finger&) = delete;
    Finger& operator=(const Finger&) = delete;
    explicit Finger(const TestModel& model) : Finger(*model.get()) {}

    /// A new session; the counters go on.
    void begin() {
        const haptable_counters kept = servo_.counters;
        haptable_servo_init(&servo_);
        servo_.counters = kept;
    }
    /// One tick, of a millisecond: the finger is at x, m, rounded to float.
    const haptable_output& to(const Eigen::Vector3d& x, std::uint32_t after_us = HAPTABLE_TICK_US) {
        for (int c = 0; c < 3; ++c) finger_m_[c] = static_cast<float>(x[c]);
        servo_.counters.most_boxes = 0;  // of this tick alone
        haptable_servo_step(&model_, &servo_, finger_m_, time_us_ += after_us, &out_);
        return out_;
    }

    Eigen::Vector3d at() const { return to_vector(finger_m_); }  ///< as the servo saw it, m
    const float* at_m() const { return finger_m_; }
    bool touches() const { return haptable_touches(out_.state) != 0; }
    Eigen::Vector3d god() const { return to_vector(out_.god_object_m); }  ///< m
    Eigen::Vector3d force() const { return to_vector(out_.force_n); }     ///< N
    /// 1/2 u . f, J, where the force was not cut; 0 without contact.
    double energy() const { return touches() ? -0.5 * force().dot(at() - god()) : 0.0; }
    const haptable_output& out() const { return out_; }
    const haptable_servo& servo() const { return servo_; }
    haptable_servo& servo() { return servo_; }
    const haptable_relaxed& relaxed() const { return room_.relaxed[0]; }
    const haptable_counters& counters() const { return servo_.counters; }

private:
    haptable_model model_;
    haptable_room room_{};
    haptable_servo& servo_ = room_.fingers.servo[0];
    haptable_output out_{};
    float finger_m_[3] = {};
    std::uint32_t time_us_ = 0;
};

}  // namespace haptable::test
