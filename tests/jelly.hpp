// SPDX-License-Identifier: GPL-2.0-or-later
// A jelly through the whole way, with its modes and what couples two fingers on it.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "codegen/in_memory.hpp"
#include "codegen/loaded_scene.hpp"
#include "tests/bodies.hpp"
#include "tests/finger.hpp"

namespace haptable::test {

/// Jelly: 10 kPa, 1000 kg/m^3. Its lowest mode has some 15 Hz.
inline Scene jelly(ForceLaw force, int modes, bool is_free = false) {
    Scene scene = cube_scene(5, 0.45);
    scene.contact.force = force;
    if (force == ForceLaw::kPressureMask) scene.contact.mask_radius_m = 0.012;
    if (is_free) set_free(scene);
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
        precompute(scene, folder_.path() / "out", quiet);
        loaded_.emplace(TablesFolder(folder_.path() / "out"));
    }
    haptable_model model(GodObject god_object = GodObject::kNearest, double friction = 0.0) const {
        return model_in_memory(touched(god_object, friction), loaded_->servo());
    }
    /// Of one that does not ring: none.
    haptable_modes modes() const { return loaded_->modes() != nullptr ? *loaded_->modes() : haptable_modes{}; }
    /// Of a scene with two fingers; model: of the same god-object and friction.
    haptable_pair_model pair(const haptable_model& model, GodObject god_object = GodObject::kNearest) const {
        return pair_in_memory(*loaded_->servo_pair(), touched(god_object, 0.0), model);
    }
    const ModeTables& files() const { return *loaded_->body_modes(); }
    double felt_n_per_m() const { return loaded_->servo().stiffness.felt_n_per_m; }

private:
    Tables touched(GodObject god_object, double friction) const {
        Tables tables = loaded_->tables();
        tables.god_object = god_object;
        tables.static_friction = tables.kinetic_friction = friction;
        return tables;
    }

    TemporaryFolder folder_;
    std::optional<LoadedScene> loaded_;
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
