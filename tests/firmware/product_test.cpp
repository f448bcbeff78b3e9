// SPDX-License-Identifier: GPL-2.0-or-later
// Every combination that a scene may name, in the servo: fingers x held or free x modes x relaxation x precision x
// force x god-object. docs/MOVING.md has the table.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/session/scene_state.hpp"
#include "tests/bodies.hpp"
#include "tests/finger.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// What tables are made of; the rest is chosen where they are read.
struct Made {
    int fingers;
    bool is_free, rings;
    ForceLaw force;
};

std::string name_of(const Made& made) {
    return std::string(made.fingers == 1 ? "one" : "two") + (made.is_free ? "_free" : "_held") +
           (made.rings ? "_ringing_" : "_stiff_") + std::string(word(made.force));
}

std::vector<Made> every_table() {
    std::vector<Made> all;
    for (const int fingers : {1, 2})
        for (const bool is_free : {false, true})
            for (const bool rings : {false, true})
                for (const ForceLaw force : every<ForceLaw>()) all.push_back({fingers, is_free, rings, force});
    return all;
}

Scene scene_of(const Made& made) {
    Scene scene = cube_scene(4, 0.3);
    scene.contact.fingers = made.fingers;
    scene.contact.force = made.force;
    if (made.force == ForceLaw::kPressureMask) scene.contact.mask_radius_m = 0.011;
    if (made.is_free) {
        set_free(scene);
        scene.free_body->stiffness = {200.0, 200.0, 200.0, 0.05, 0.05, 0.05};  // or a finger would push it away
        scene.free_body->damping = {2.0, 2.0, 2.0, 5e-4, 5e-4, 5e-4};
    }
    if (made.rings) scene.body_modes = BodyModes{4, 0.05, made.is_free ? 0.0 : 1000.0, 0.0, 1};
    scene.tables.columns = ColumnRows::kNone;
    scene.tables.coupling_bytes = 2'000'000;
    return scene;
}

/// What is chosen where tables are read.
struct Chosen {
    Storage precision = Storage::kFloat32;
    GodObject god_object = GodObject::kNearest;
    bool relaxes = false;

    std::string name() const {
        return std::string(word(god_object)) + (relaxes ? ", relaxes, " : ", ") + std::string(word(precision));
    }
};

/// The exact one of each first.
std::vector<Chosen> every_choice(const Made& made) {
    std::vector<Chosen> all;
    for (const GodObject god_object : every<GodObject>())
        for (const bool relaxes : {false, true})
            for (const Storage precision : {Storage::kFloat32, Storage::kFloat16, Storage::kInt16})
                if (!relaxes || !made.rings)  // docs/MOVING.md: refused
                    all.push_back({precision, god_object, relaxes});
    return all;
}

constexpr double kShare = 0.5, kTime_s = 0.05, kPress_s = 0.3, kAbove_m = 0.5e-3, kWay_m = 1.7e-3;

/// A body that is four times as stiff where a dent stores that linear energy.
constexpr StiffeningCurve kStiffens{{0.5, 1.0, 1.5}, 5e-5};

/// What is left of a ramp's force when it was held as long as the whole press, of a standard linear solid.
double relaxed() {
    const double ramp_s = kPress_s * (1.0 - kAbove_m / kWay_m);
    const double branch = kShare * kTime_s / ramp_s * -std::expm1(-ramp_s / kTime_s);
    return (1.0 - kShare + branch * std::exp(-kPress_s / kTime_s)) / (1.0 - kShare + branch);
}

/// What a press, a hold and a release of 300 ticks each gave.
struct Felt {
    std::array<double, 2> pressed_n{}, held_n{};  ///< of each finger, at the end of the press and of the hold
    double left_n = 0.0;                          ///< the largest after the fingers have left
    double worst_n = 0.0;
    /// To both hands by the end; taken from them at the most before. By the mean of a motion's forces: what a hand that
    /// is felt at ticks gets beyond is the device's (docs/DEVICES.md).
    double given_j = 0.0, stored_j = 0.0;
    double wall_j = 0.0;  ///< what a wall as stiff as the body makes of their ways: modes make no more (docs/MOVING.md)
    bool is_finite = true;
};

class Combination : public testing::TestWithParam<Made> {
protected:
    /// Two fingers on the top beside its middle, 1.2 mm in, or one.
    Felt feel(const Chosen& chosen, const StiffeningCurve& curve = {}) const {
        SceneFiles files = files_;
        files.tables.precision = chosen.precision;
        files.tables.god_object = chosen.god_object;
        files.tables.limits = {};
        files.tables.limits.check = true;
        if (chosen.relaxes) files.tables.relaxation = {{kShare, kTime_s}};
        files.tables.stiffening = curve;
        const LoadedScene scene(std::move(files));
        SceneState state(scene.model(), scene.pair(), scene.body(), scene.modes());
        state.check(HAPTABLE_CHECK_ALL);
        return press(state);
    }

    static void expect_passive(const Chosen& chosen, const Felt& felt) {
        EXPECT_TRUE(felt.is_finite);
        EXPECT_EQ(felt.left_n, 0.0);
        if (chosen.god_object == GodObject::kLeastEnergy || chosen.relaxes) {
            EXPECT_LE(felt.given_j, 2e-3 * felt.stored_j + (GetParam().rings ? felt.wall_j : 0.0))
                << "a cycle gives no energy";
        }
        if (chosen.relaxes && !GetParam().is_free) {
            EXPECT_LT(felt.given_j, -0.1 * felt.stored_j) << "and one that relaxes takes some";
        }
    }

private:
    static Felt press(SceneState& state) {
        Felt felt;
        std::array<Vector3d, 2> last_m{}, last_n{Vector3d::Zero(), Vector3d::Zero()};
        for (int tick = 0; tick < 900; ++tick) {
            const double way = std::min(1.0, tick / 300.0) - std::max(0.0, (tick - 600) / 300.0);
            haptable_input in[2]{};
            haptable_output out[2]{};
            for (std::size_t f = 0; f < state.fingers(); ++f) {
                const Vector3d x(f == 0 ? 0.0113 : 0.0191, f == 0 ? 0.0147 : 0.0139, 0.03 + kAbove_m - kWay_m * way);
                for (int c = 0; c < 3; ++c) in[f].finger_m[c] = static_cast<float>(x[c]);
                in[f].is_there = 1;
            }
            state.step(in, static_cast<std::uint32_t>(tick) * HAPTABLE_TICK_US, out);
            for (std::size_t f = 0; f < state.fingers(); ++f) {
                const Vector3d x = to_vector(in[f].finger_m), force = to_vector(out[f].force_n);
                felt.is_finite &= force.allFinite() && out[f].state != HAPTABLE_FAULTED;
                felt.worst_n = std::max(felt.worst_n, force.norm());
                if (tick > 0) felt.given_j += 0.5 * (last_n[f] + force).dot(x - last_m[f]);
                if (tick > 0)
                    felt.wall_j +=
                        0.5 * double(state.scene().model->stiffness_limit_n_per_m) * (x - last_m[f]).squaredNorm();
                last_m[f] = x;
                last_n[f] = force;
                if (tick == 300) felt.pressed_n[f] = force.z();
                if (tick == 600) felt.held_n[f] = force.z();
                if (tick == 899) felt.left_n = std::max(felt.left_n, force.norm());
            }
            felt.stored_j = std::max(felt.stored_j, -felt.given_j);
        }
        return felt;
    }

    const SceneFiles files_ = files_of(scene_of(GetParam()));
};

INSTANTIATE_TEST_SUITE_P(Tables, Combination, testing::ValuesIn(every_table()),
                         [](const auto& of) { return test_name(name_of(of.param)); });

TEST_P(Combination, PressesHoldsAndLetsGo) {
    const std::vector<Chosen> all = every_choice(GetParam());
    Felt exact;
    for (const Chosen& chosen : all) {
        SCOPED_TRACE(chosen.name());
        const Felt felt = feel(chosen);
        const bool is_exact = chosen.precision == Storage::kFloat32;
        if (is_exact) exact = felt;
        expect_passive(chosen, felt);
        for (std::size_t f = 0; f < std::size_t(GetParam().fingers); ++f) {
            EXPECT_GT(felt.pressed_n[f], 0.01) << f;
            if (!GetParam().is_free) {
                EXPECT_NEAR(felt.held_n[f] / felt.pressed_n[f], chosen.relaxes ? relaxed() : 1.0,
                            chosen.relaxes ? 0.01 : 0.02)
                    << f;
            }
            // 11 bits a number of a block, 16 with a scale for each; the inverse of C takes its condition.
            EXPECT_NEAR(felt.held_n[f], exact.held_n[f], is_exact ? 0.0 : 0.02 * exact.worst_n) << f;
        }
        if (GetParam().rings) continue;  // docs/MATERIALS.md: no dents that stiffen
        const Felt stiff = feel(chosen, kStiffens);
        expect_passive(chosen, stiff);
        if (!GetParam().is_free || GetParam().fingers == 1) {  // two turn a free body aside
            EXPECT_GT(stiff.pressed_n[0], 1.2 * felt.pressed_n[0]);
        }
    }
    EXPECT_EQ(all.size(), GetParam().rings ? 6U : 12U);
}

}  // namespace
}  // namespace haptable::test
