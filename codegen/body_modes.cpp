// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/body_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "codegen/bytes.hpp"
#include "codegen/laws.hpp"
#include "codegen/number.hpp"
#include "host/base/error.hpp"
#include "host/base/noise.hpp"

namespace haptable {

namespace {

float finite_in_modes(double value) {
    return to_float(value, "modes.json holds a number that is not finite: make the tables again");
}

}  // namespace

haptable_mode tick_of_mode(double omega_rad_per_s, double damping_ratio) {
    const double decay = damping_ratio * omega_rad_per_s;
    const double damped = omega_rad_per_s * std::sqrt(1.0 - damping_ratio * damping_ratio);
    const double left = std::exp(-decay * kServoTick_s), cosine = std::cos(damped * kServoTick_s),
                 sine = std::sin(damped * kServoTick_s) / damped;
    const double squared = omega_rad_per_s * omega_rad_per_s;
    const double q_by_q = left * (cosine + decay * sine) - 1.0;
    return {finite_in_modes(q_by_q),
            finite_in_modes(left * sine),
            finite_in_modes(-squared * left * sine),
            finite_in_modes(left * (cosine - decay * sine) - 1.0),
            finite_in_modes(-q_by_q / squared),
            finite_in_modes(squared)};
}

ServoModes build_modes(const ModeTables& body_modes, const Tables& tables, const ServoModel& servo) {
    const bool is_mask = tables.force == ForceLaw::kPressureMask;
    const std::size_t controls =
        is_mask ? servo.node.size() + tables.compliance.edge_id.size() : std::size_t{servo.free_count};
    if (body_modes.control_count != controls)
        throw Error(fmt::format("modes.json is of {} places and the surface has {}: make the tables again",
                                body_modes.control_count, controls));
    if (body_modes.modes() > HAPTABLE_MODES)
        throw Error(fmt::format("modes.json has {} modes and a servo at most {}", body_modes.modes(), HAPTABLE_MODES));
    ServoModes to;
    to.controls = is_mask ? HAPTABLE_MODES_CONTROLS : 3;
    for (const double omega : body_modes.omega_rad_per_s)
        to.mode.push_back(tick_of_mode(omega, body_modes.damping_ratio));
    const std::size_t modes = body_modes.modes();
    std::vector<double> size(modes, 0.0);  // largest entry of each mode
    for (std::size_t i = 0; i < body_modes.shape.size(); ++i)
        for (const double entry : body_modes.shape[i]) size[i % modes] = std::max(size[i % modes], std::abs(entry));
    for (std::size_t i = 0; i < body_modes.shape.size(); ++i) {
        const auto value = [&](std::size_t axis) {
            return finite_in_modes(without_noise(body_modes.shape[i][axis], size[i % modes]));
        };
        to.shape.push_back({value(0), value(1), value(2)});
    }
    return to;
}

haptable_modes modes_in_memory(const ServoModes& body_modes) {
    const std::size_t modes = body_modes.mode.size();
    haptable_modes to{static_cast<std::uint8_t>(modes),
                      body_modes.controls,
                      body_modes.mode.data(),
                      reinterpret_cast<const float(*)[3]>(body_modes.shape.data()),
                      static_cast<std::uint16_t>(modes == 0 ? 0 : body_modes.shape.size() / modes),
                      0};
    to.crc = haptable_crc_of(&to, haptable_span_of_modes);
    return to;
}

std::string modes_bytes(const ServoModes& body_modes) {
    const haptable_modes whole = modes_in_memory(body_modes);
    Bytes bytes;
    bytes.add(static_cast<std::uint32_t>(body_modes.mode.size()));
    bytes.add(static_cast<std::uint32_t>(body_modes.controls));
    bytes.add_table(body_modes.mode.data(), body_modes.mode.size());
    bytes.add_table(body_modes.shape.data(), body_modes.shape.size());
    bytes.add(static_cast<std::uint32_t>(whole.control_count));
    bytes.add(static_cast<std::uint32_t>(whole.crc));
    return bytes.take();
}

std::vector<TableBytes> flash_tables(const ServoModes& body_modes) {
    return {{"mode", body_modes.mode.size() * sizeof(haptable_mode)},
            {"mode_shape", body_modes.shape.size() * sizeof body_modes.shape[0]}};
}

void add_mode_values(const ServoModes& body_modes, TemplateValues& values) {
    const haptable_modes whole = modes_in_memory(body_modes);
    std::string mode, shape;
    for (const haptable_mode& m : body_modes.mode)
        mode += fmt::format("    {{{:.8e}f, {:.8e}f, {:.8e}f, {:.8e}f, {:.8e}f, {:.8e}f}},\n", m.q_by_q, m.q_by_p,
                            m.p_by_q, m.p_by_p, m.q_by_f, m.stiffness);
    for (const auto& [x, y, z] : body_modes.shape)
        shape += fmt::format("    {{{:.8e}f, {:.8e}f, {:.8e}f}},\n", x, y, z);
    values["modes_version"] = std::to_string(HAPTABLE_MODES_VERSION);
    values["mode"] = mode;
    values["mode_count"] = std::to_string(whole.count);
    values["mode_controls"] = std::to_string(whole.controls);
    values["mode_shape"] = shape;
    values["mode_shape_count"] = std::to_string(body_modes.shape.size());
    values["mode_control_count"] = std::to_string(whole.control_count);
    values["modes_crc"] = fmt::format("{:08x}", whole.crc);
}

}  // namespace haptable
