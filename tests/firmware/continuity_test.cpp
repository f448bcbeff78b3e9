// SPDX-License-Identifier: GPL-2.0-or-later
// How the force changes from tick to tick: no step of the algorithm's own, and jumps that are brought down.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "tests/bodies.hpp"
#include "tests/finger.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// Forces of a finger that slides 18 mm over the cube's top at 100 mm/s, every `share` of a millisecond; [N].
struct Slide {
    std::vector<Vector3d> force;
    double stiffness = 0.0;  // N/m, normal, mean
    double taken_j = 0.0;    // work of the finger

    /// Largest change of the tangential force from one to the next, in units of k v dt.
    double worst_tangential() const {
        double worst = 0.0;
        for (std::size_t i = 1; i < force.size(); ++i)
            worst = std::max(worst, (force[i] - force[i - 1]).head<2>().norm());
        return worst / (stiffness * 1.044e-4);
    }
    double worst_n() const {
        double worst = 0.0;
        for (std::size_t i = 1; i < force.size(); ++i) worst = std::max(worst, (force[i] - force[i - 1]).norm());
        return worst;
    }
};

Slide slide(const haptable_model& model, double depth_m, int ticks_per_ms = 1) {
    haptable_servo servo;
    haptable_output out;
    haptable_servo_init(&servo);
    const auto to = [&](const Vector3d& x) {
        const float finger[3] = {float(x.x()), float(x.y()), float(x.z())};
        haptable_servo_step(&model, &servo, finger, 0, &out);
        return to_vector(out.force_n);
    };
    const Vector3d begin(0.006, 0.011, 0.03 - depth_m);
    for (int i = 100; i >= 0; --i) to(begin + Vector3d(0, 0, depth_m * i / 99.0));
    Slide result;
    Vector3d x = begin, last = to(begin);
    result.force.push_back(last);
    for (int i = 1; i <= 180 * ticks_per_ms; ++i) {
        const double ms = double(i) / ticks_per_ms;
        const Vector3d next = begin + ms * Vector3d(1e-4, 0.3e-4, 0), force = to(next);
        EXPECT_EQ(out.state, HAPTABLE_CONTACT);
        result.taken_j -= 0.5 * (force + last).dot(next - x);
        x = next;
        last = force;
        if (i % ticks_per_ms == 0) result.force.push_back(force);
    }
    for (const Vector3d& f : result.force) result.stiffness += f.z() / depth_m / double(result.force.size());
    return result;
}

// The god-object has settled when a tick ends: had the servo ticked twenty times as often, the force would be the same.
TEST(Continuity, NothingSettlesOverSeveralTicks) {
    for (const ForceLaw force : every<ForceLaw>())
        for (const GodObject god : every<GodObject>()) {
            const ElasticBody body(cube_scene(5, 0.3), force, 0.012);
            const Slide coarse = slide(body.model(god), 0.002), fine = slide(body.model(god), 0.002, 20);
            double worst = 0.0;
            for (std::size_t i = 0; i < coarse.force.size(); ++i)
                worst = std::max(worst, (coarse.force[i] - fine.force[i]).norm() / fine.force[i].norm());
            printf("%-14s %-12s at 1 and 20 kHz within %.1e\n", word(force), word(god), worst);
            // A walk ends within 2^-20 of the size.
            EXPECT_WITHIN(worst, .count = 4, .epsilon = 0x1p-20, .condition = body.size() / 0.002)
                << force << " " << god;
        }
}

// A finger that stays where it is feels one force to the last bit: nothing alternates from tick to tick.
TEST(Continuity, AFingerAtRestFeelsTheSameBits) {
    for (const ForceLaw force : every<ForceLaw>())
        for (const GodObject god : every<GodObject>()) {
            const ElasticBody body(cube_scene(5, 0.3), force, 0.012);
            const haptable_model model = body.model(god);
            std::mt19937 random(3);
            std::uniform_real_distribution<float> over(0.004F, 0.026F), deep(0.0002F, 0.003F);
            for (int press = 0; press < 100; ++press) {
                haptable_servo servo;
                haptable_output out, then;
                haptable_servo_init(&servo);
                float finger[3] = {over(random), over(random), 0.0301F};
                const float end = 0.03F - deep(random), step = (finger[2] - end) / 20.0F;
                haptable_servo_step(&model, &servo, finger, 0, &out);
                for (int tick = 0; tick < 20; ++tick, finger[2] -= step, finger[0] += 1e-5F)
                    haptable_servo_step(&model, &servo, finger, 0, &out);
                for (int tick = 0; tick < 4; ++tick) haptable_servo_step(&model, &servo, finger, 0, &out);
                EXPECT_EQ(out.state, HAPTABLE_CONTACT);
                for (int tick = 0; tick < 20; ++tick) {
                    haptable_servo_step(&model, &servo, finger, 0, &then);
                    ASSERT_EQ(std::memcmp(out.force_n, then.force_n, sizeof out.force_n), 0) << force << " " << god;
                    ASSERT_EQ(std::memcmp(out.alpha, then.alpha, sizeof out.alpha), 0) << force << " " << god;
                }
            }
        }
}

// 1 mm deep on a mesh of 9 nodes a side and, for the mask, a radius of two edges; deeper and coarser: docs/CONTACT.md.
TEST(Continuity, SlidingUnderTheNearestGodObjectIsSmooth) {
    for (const ForceLaw force : {ForceLaw::kInterpolated, ForceLaw::kPressureMask}) {
        const ElasticBody body(cube_scene(9, 0.3), force, 0.0075);
        const double worst = slide(body.model(GodObject::kNearest), 0.001).worst_tangential();
        printf("%-14s nearest: %.3f of k v dt a tick\n", word(force), worst);
        // The stiffness changes by less than half of itself over an edge.
        EXPECT_WITHIN(worst, .count = 0.5, .epsilon = 0.001 / 0.00375) << force;
    }
}

// On a mesh whose edges are not much longer than the finger is deep, the consistent force makes the god-object jump.
TEST(Continuity, AJumpIsBroughtDownAtItsSlewAndOnlyTakesEnergy) {
    const ElasticBody body(cube_scene(9, 0.3), ForceLaw::kConsistent);
    haptable_model model = body.model(GodObject::kLeastEnergy);
    const Slide click = slide(model, 0.002);
    EXPECT_GT(click.worst_n(), 0.05) << "the test must have a jump";
    model.release = haptable_release_slew;
    model.release_n = 0.01F;
    const Slide soft = slide(model, 0.002);
    printf("consistent, least energy, 2 mm: %.1f mN in a tick, with 0.01 N/ms %.1f mN\n", 1e3 * click.worst_n(),
           1e3 * soft.worst_n());
    EXPECT_WITHIN(soft.worst_n() - 0.01, .count = 2.0 * 1.5, .epsilon = soft.stiffness * 1.044e-4);
    EXPECT_GT(soft.taken_j, click.taken_j);
}

}  // namespace
}  // namespace haptable::test
