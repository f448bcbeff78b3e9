// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench-devices: what the device models are, and from which stiffness on each rings: numbers for
// docs/DEVICES.md.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "codegen/model.hpp"
#include "firmware/haptable_model.h"
#include "host/base/program.hpp"
#include "host/device/ringing.hpp"
#include "host/numbers/numbers.hpp"
#include "host/scene/device_models.hpp"
#include "host/scene/scene.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

namespace {

constexpr double kTick_s = HAPTABLE_TICK_US / 1e6;

Cell figure(const Figure& figure, double unit, const char* name) {
    if (std::string(figure.source) == "none" && figure.value == 0.0) return std::string("none");
    const double value = figure.value / unit;
    return number(figure.value, fmt::format("{} {} ({})",
                                            value < 1000.0 ? fmt::format("{:.3g}", value)
                                                           : thousands(static_cast<std::uint64_t>(std::lround(value))),
                                            name, figure.source));
}

std::string reach_of(const DeviceModel& model) {
    if (model.reach_m[0] == 0.0) return "endless";
    return fmt::format("{:.0f} x {:.0f} x {:.0f} mm ({})", 1e3 * model.reach_m[0], 1e3 * model.reach_m[1],
                       1e3 * model.reach_m[2], model.reach_source);
}

NumberTable figures() {
    NumberTable table{{"name", "device", "peak force", "continuous", "mass", "friction", "damping", "encoder step",
                       "motors' bandwidth", "delay", "weight that nothing balances", "workspace, x y z", "up"},
                      {}};
    for (const DeviceModel& m : device_models())
        table.rows.push_back({fmt::format("`{}`", m.name), m.title, figure(m.max_force_n, 1.0, "N"),
                              figure(m.continuous_force_n, 1.0, "N"), figure(m.mass_kg, 1e-3, "g"),
                              figure(m.friction_n, 1.0, "N"), figure(m.damping_n_s_per_m, 1.0, "N s/m"),
                              figure(m.encoder_step_m, 1e-3, "mm"), figure(m.bandwidth_hz, 1.0, "Hz"),
                              figure(m.delay_s, 1e-3, "ms"), figure(m.unbalanced, 0.01, "%"), reach_of(m),
                              m.up[1] > 0.0 ? "y" : "z"});
    return table;
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

Cell stiffness(double n_per_m) {
    if (std::isinf(n_per_m)) return std::string("none to 1e6");
    return number(n_per_m, n_per_m < 1000.0 ? fmt::format("{:.3g}", n_per_m)
                                            : thousands(static_cast<std::uint64_t>(std::lround(n_per_m))));
}

std::vector<Cell> stability_of(const std::string& name, const Device& device) {
    RingingLoop loop;
    loop.device = device;
    const double alone = ringing_stiffness(loop), limit = promised(device);
    loop.hand = hand_named("soft");
    const double soft = ringing_stiffness(loop);
    loop.hand = hand_named("stiff");
    const double stiff = ringing_stiffness(loop);
    loop.hand = RingingLoop().hand;
    loop.speed_m_s = std::max(device.encoder_step_m, 1e-6) / kTick_s;
    const double slow = ringing_stiffness(loop);
    const double passive = 2.0 * device.damping_n_s_per_m / kTick_s;
    const double held = device.encoder_step_m > 0.0 ? 2.0 * device.friction_n / device.encoder_step_m : 0.0;
    return {name,
            number(whole_delay_s(device), fmt::format("{:.2f} ms", 1e3 * whole_delay_s(device))),
            stiffness(limit),
            stiffness(alone),
            limit > 0.0 ? Cell(number(alone / limit, fmt::format("{:.2f}", alone / limit))) : Cell(std::string("-")),
            stiffness(soft),
            stiffness(stiff),
            stiffness(slow),
            stiffness(held),
            stiffness(passive),
            stiffness(std::min(passive, held))};
}

NumberTable stability() {
    NumberTable table{{"device", "delay and lag", "codegen's limit, N/m", "rings from, at 0.5 m/s", "over codegen's",
                       "the same in a soft hand", "in a stiff hand", "rings from, at a step a tick", "2 f_c / D",
                       "Colgate and Schenkel, 2 b / T", "Abbott and Okamura"},
                      {}};
    for (const DeviceModel& model : device_models()) {
        Device device = device_of(model);
        table.rows.push_back(stability_of(fmt::format("`{}`", model.name), device));
        if (device.delay_s > 0.0) continue;
        device.delay_s = kTick_s;
        table.rows.push_back(stability_of(fmt::format("`{}`, a tick later", model.name), device));
    }
    return table;
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    using namespace haptable;
    CommandLine app("Lists the device models and measures from which stiffness on each rings.",
                    "haptable-bench-devices");
    std::filesystem::path out;
    app.option("-o", out, "write the numbers to this JSON file");
    return run_program(app, argc, argv, [&] {
        Numbers numbers("make bench");
        numbers.add("device-figures", figures());
        numbers.add("device-stability", stability());
        print_topics(numbers);
        if (!out.empty()) numbers.write(out);
    });
}
