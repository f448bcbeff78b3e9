// SPDX-License-Identifier: GPL-2.0-or-later
// A jelly through the whole way, with its modes and what couples two fingers on it.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "codegen/body_modes.hpp"
#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "tests/bodies.hpp"
#include "tests/finger.hpp"

namespace haptable::test {

/// Jelly: 10 kPa, 1000 kg/m^3. Its lowest mode has some 15 Hz.
inline Scene jelly(ForceLaw force, int modes, bool is_free = false) {
    Scene scene = cube_scene(5, 0.45);
    scene.contact.force = force;
    if (force == ForceLaw::kPressureMask) scene.contact.mask_radius_m = 0.012;
    if (is_free) {
        scene.fixed.clear();
        scene.free_body = FreeBody{};
        scene.free_body->density_kg_per_m3 = 1000.0;
    }
    if (modes > 0) scene.body_modes = BodyModes{modes, 0.05, is_free ? 0.0 : 1000.0, 0.0, 1};
    scene.device.max_force_n = 20.0;
    scene.tables.columns = ColumnRows::kNone;
    return scene;
}

/// Its tables in memory.
class Jelly {
public:
    explicit Jelly(const Scene& scene) {
        Progress quiet(true);
        result_ = precompute(scene, folder_.path() / "out", quiet);
        tables_ = read_tables(folder_.path() / "out");
        servo_ = build_model(tables_);
        if (scene.contact.fingers == 2) coupling_ = build_pair(*read_pair(folder_.path() / "out"), tables_, servo_);
        if (!scene.body_modes) return;
        files_ = *read_modes(folder_.path() / "out");
        body_modes_ = build_modes(files_, tables_, servo_);
    }
    haptable_model model(GodObject god_object = GodObject::kNearest, double friction = 0.0) const {
        Tables tables = tables_;
        tables.god_object = god_object;
        tables.static_friction = tables.kinetic_friction = friction;
        return model_in_memory(tables, servo_);
    }
    haptable_modes modes() const { return modes_in_memory(body_modes_); }
    /// Of a scene with two fingers; model: of the same god-object and friction.
    haptable_pair_model pair(const haptable_model& model, GodObject god_object = GodObject::kNearest) const {
        Tables tables = tables_;
        tables.god_object = god_object;
        return pair_in_memory(coupling_, tables, model);
    }
    const ModeTables& files() const { return files_; }
    const Result& result() const { return result_; }
    double felt_n_per_m() const { return servo_.stiffness.felt_n_per_m; }

private:
    TemporaryFolder folder_;
    Result result_;
    Tables tables_;
    ServoModel servo_;
    ModeTables files_;
    ServoModes body_modes_;
    ServoPair coupling_;
};

/// A force, a number each tick, swings about its last one by omega and falls off by exp(-decay t). A midpoint step is
/// slow by (omega T)^2 / 12. By how much omega may be off, rad/s.
inline double expect_ring(const std::vector<double>& force, double omega, double decay) {
    const double last = force.back();
    std::vector<double> crossing;  // upwards
    for (std::size_t i = 1; i < 400; ++i)
        if (force[i - 1] < last && force[i] >= last)
            crossing.push_back(kTick_s * (double(i) - (force[i] - last) / (force[i] - force[i - 1])));
    const double within = (std::pow(omega * kTick_s, 2.0) / 12.0 + 2e-3) * omega;
    EXPECT_GT(crossing.size(), 3U);
    if (crossing.size() < 2) return within;
    const double period = (crossing.back() - crossing.front()) / double(crossing.size() - 1);
    EXPECT_NEAR(2.0 * std::numbers::pi / period, omega, within);
    const auto most = [&](std::size_t from) {
        double size = 0.0;
        for (std::size_t i = from; i < from + 60; ++i) size = std::max(size, std::abs(force[i] - last));
        return size;
    };
    EXPECT_NEAR(std::log(most(0) / most(200)) / 0.2, decay, 0.1 * decay);
    return within;
}

}  // namespace haptable::test
