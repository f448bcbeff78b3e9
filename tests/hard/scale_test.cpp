// SPDX-License-Identifier: GPL-2.0-or-later
// A body of a micrometre and of 100 m. Powers of 2 in lengths and in Young's modulus change exponents only (even ones,
// where roots are taken), so every bit of tables and forces must stay; a threshold in metres or newtons would change
// some.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/bodies.hpp"
#include "tests/finger.hpp"

namespace haptable::test {
namespace {

Scene scaled_cube(int length, int young) {
    Scene scene = cube_scene(5, 0.3);
    scene.mesh.side_m = std::ldexp(0.03, length);
    scene.material.young_pa = std::ldexp(1.0, young);
    scene.fixed = {{std::array{-1e4, -1e4, -1e4, 1e4, 1e4, 1e-9 * scene.mesh.side_m}, "", 1}};
    scene.device.max_force_n = std::ldexp(1e5, young + 2 * length);
    scene.contact.rigid_stiffness_n_per_m = std::ldexp(1.0, young + length);
    return scene;
}

/// The forces of strokes over the cube's top, over its rim and back, divided by the scale of forces.
std::vector<Eigen::Vector3d> felt(const ElasticBody& body, int length, int young, GodObject god_object) {
    Finger finger(body.model(god_object));
    std::vector<Eigen::Vector3d> forces;
    for (int tick = 0; tick < 4000; ++tick) {
        const double turn = 0.003 * tick, dip = std::sin(0.05 * tick);
        finger.to(std::ldexp(1.0, length) * Eigen::Vector3d(0.015 + 0.017 * std::cos(turn),
                                                            0.015 + 0.017 * std::sin(2.3 * turn),
                                                            0.0305 - 0.004 * std::abs(dip)));
        forces.emplace_back(std::ldexp(1.0, -young - 2 * length) * finger.force());
    }
    return forces;
}

TEST(HardScale, ChangesNoBitOfTablesAndForces) {
    for (const ForceLaw force : {ForceLaw::kInterpolated, ForceLaw::kConsistent}) {
        const ElasticBody one(scaled_cube(0, 13), force);
        for (const auto& [length, young] :
             {std::pair{-14, 13}, {-8, 13}, {12, 13}, {0, 1}, {0, 37}}) {  // 1.8 um, 0.1 mm, 123 m, 2 Pa, 137 GPa
            SCOPED_TRACE(testing::Message() << word(force) << " length " << length << " young " << young);
            const ElasticBody other(scaled_cube(length, young), force);
            auto blocks = one.tables().stiffness;
            for (auto& block : blocks)
                for (double& s : block) s = std::ldexp(s, length + young - 13);
            ASSERT_EQ(other.tables().stiffness, blocks);
            for (const GodObject god_object : every<GodObject>()) {
                // Squares of energies below 1e-20 J are no floats: a body of micrometres has them.
                if (god_object == GodObject::kLeastEnergy && length < -8) continue;
                const auto here = felt(one, 0, 13, god_object), there = felt(other, length, young, god_object);
                double largest = 0.0;
                for (std::size_t tick = 0; tick < here.size(); ++tick) {
                    // Products of heights and areas of a body of micrometres are below the normal floats.
                    const double error = length < -8 ? 16.0 * std::ldexp(1.0, -24) * here[tick].norm() : 0.0;
                    ASSERT_LE((there[tick] - here[tick]).norm(), error) << word(god_object) << " tick " << tick;
                    largest = std::max(largest, here[tick].norm());
                }
                EXPECT_GT(largest, 0.0);
            }
        }
    }
}

}  // namespace
}  // namespace haptable::test
