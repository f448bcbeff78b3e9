// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench-devices: what the device models are, and from which stiffness on each rings: raw numbers as JSON, of
// which lab/programs.py makes docs/DEVICES.md's tables.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "codegen/model.hpp"
#include "firmware/haptable_model.h"
#include "host/base/program.hpp"
#include "host/device/ringing.hpp"
#include "host/scene/device_models.hpp"
#include "host/scene/scene.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

namespace {

using nlohmann::ordered_json;

constexpr double kTick_s = HAPTABLE_TICK_US / 1e6;

ordered_json to_json(const Figure& figure) { return {{"value", figure.value}, {"source", figure.source}}; }

ordered_json to_json(const DeviceModel& m) {
    return {{"name", m.name},
            {"title", m.title},
            {"max_force_n", to_json(m.max_force_n)},
            {"continuous_force_n", to_json(m.continuous_force_n)},
            {"mass_kg", to_json(m.mass_kg)},
            {"friction_n", to_json(m.friction_n)},
            {"damping_n_s_per_m", to_json(m.damping_n_s_per_m)},
            {"encoder_step_m", to_json(m.encoder_step_m)},
            {"bandwidth_hz", to_json(m.bandwidth_hz)},
            {"delay_s", to_json(m.delay_s)},
            {"unbalanced", to_json(m.unbalanced)},
            {"reach_m", m.reach_m},
            {"reach_source", m.reach_source},
            {"up", m.up}};
}

/// What codegen promises of a body, for that device.
double promised(const Device& device) {
    Tables tables;
    tables.damping_n_s_per_m = device.damping_n_s_per_m;
    tables.device_friction_n = device.friction_n;
    tables.encoder_step_m = device.encoder_step_m;
    tables.device_delay_s = whole_delay_s(device);
    return stable_stiffness(tables);
}

/// Stiffnesses, N/m, from which the device rings; null: none to 1e6.
ordered_json stability_of(const Device& device) {
    RingingLoop alone, soft, stiff;
    alone.device = soft.device = stiff.device = device;
    soft.hand = hand_named("soft");
    stiff.hand = hand_named("stiff");
    RingingLoop slow = alone;
    slow.speed_m_s = std::max(device.encoder_step_m, 1e-6) / kTick_s;
    return {{"delay_s", whole_delay_s(device)},
            {"promised", promised(device)},
            {"alone", ringing_stiffness(alone)},
            {"soft", ringing_stiffness(soft)},
            {"stiff", ringing_stiffness(stiff)},
            {"slow", ringing_stiffness(slow)},
            {"held", device.encoder_step_m > 0.0 ? 2.0 * device.friction_n / device.encoder_step_m : 0.0},
            {"passive", 2.0 * device.damping_n_s_per_m / kTick_s}};
}

/// Each device, and where it has no delay the same a tick later.
ordered_json stability() {
    ordered_json all = ordered_json::array();
    for (const DeviceModel& model : device_models())
        for (const double later_s : {0.0, kTick_s}) {
            Device device = device_of(model);
            if (later_s > 0.0 && device.delay_s > 0.0) continue;
            device.delay_s += later_s;
            all.push_back({{"name", model.name}, {"later", later_s > 0.0}});
            all.back().update(stability_of(device));
        }
    return all;
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    using namespace haptable;
    CommandLine app("Lists the device models and measures from which stiffness on each rings.",
                    "haptable-bench-devices");
    return run_program(app, argc, argv, [&] {
        ordered_json models = ordered_json::array();
        for (const DeviceModel& model : device_models()) models.push_back(to_json(model));
        fmt::print("{}\n", ordered_json{{"models", models}, {"stability", stability()}}.dump());
    });
}
