// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/laws.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host/base/error.hpp"

namespace haptable {

namespace {

/// By the value of the enum.
template <typename Choice, typename Function, std::size_t count>
Function* chosen(Function* const (&functions)[count], Choice choice) {
    static_assert(count == words(Choice{}).size());
    return functions[static_cast<std::size_t>(choice)];
}

constexpr haptable_god_object_fn* kGodObject[] = {
#define HAPTABLE_GOD_OBJECT(NAME, WORD, TITLE, FUNCTION) haptable_god_object_##FUNCTION,
#include "host/base/laws.inc"
};

/// By whether the tables are packed.
struct LawFunctions {
    haptable_force_fn* force[2];
    haptable_energy_fn* energy[2];
};
constexpr LawFunctions kLaw[] = {
#define HAPTABLE_FORCE_LAW(NAME, WORD, TITLE, FUNCTION, PACKED, ...) \
    {{haptable_force_##FUNCTION, haptable_force_##PACKED}, {haptable_energy_##FUNCTION, haptable_energy_##PACKED}},
#include "host/base/laws.inc"
};

/// What the scene's keys say alone.
void set_keys(const SceneOptions& options, haptable_model& model) {
#define HAPTABLE_VALUE(FIELD, KEY) model.FIELD = static_cast<float>(options.amount(KEY));
#define HAPTABLE_STAGE(FIELD, FUNCTION, KEY) model.FIELD = options.amount(KEY) > 0.0 ? (FUNCTION) : nullptr;
    HAPTABLE_MODEL_KEYS(HAPTABLE_VALUE, HAPTABLE_STAGE)
}

/// What the scene switches off is not named, and so not linked.
void set_limits(const SafetyLimits& limits, double max_force_n, haptable_model& model) {
    const double mean2 = limits.mean_force_n * limits.mean_force_n, most2 = max_force_n * max_force_n;
    const bool has_mean = limits.has_mean(max_force_n);
    model.plausible = limits.max_speed_m_s > 0.0 ? haptable_plausible_motion : nullptr;
    model.max_motion_m = static_cast<float>(limits.max_speed_m_s * kServoTick_s);
    model.rate = limits.max_force_rate_n_per_s > 0.0 ? haptable_limit_rate : nullptr;
    model.rate_n = static_cast<float>(limits.max_force_rate_n_per_s * kServoTick_s);
    model.mean = has_mean ? haptable_limit_mean : nullptr;
    model.mean_limit_n2 = has_mean ? static_cast<float>(mean2) : 0.0F;
    model.mean_share = has_mean ? static_cast<float>(kServoTick_s / limits.mean_force_time_s) : 0.0F;
    model.mean_slope = has_mean ? static_cast<float>(2.0 * (most2 / mean2 - 1.0)) : 0.0F;
    if (const std::string fault = fault_of_mean(limits, max_force_n); !fault.empty())
        throw Error("device.mean_force_time: " + fault);
    model.resume = limits.ramp_s > 0.0 ? haptable_resume_ramp : nullptr;
    model.resume_gain = limits.ramp_s > 0.0 ? static_cast<float>(kServoTick_s / limits.ramp_s) : 0.0F;
    model.limit =
        model.rate != nullptr || model.mean != nullptr || model.resume != nullptr ? haptable_limit_force : nullptr;
    model.check = limits.check ? haptable_check_crc : nullptr;
}

/// The law is linear in time: what a tick of it does, exactly. The terms themselves are a table.
void set_relaxation(const Tables& tables, bool is_held, haptable_model& model) {
    const bool relaxes = !tables.relaxation.empty();
    model.relax = !relaxes ? nullptr : is_held ? haptable_relaxation_held : haptable_relaxation;
    model.rest_share = relaxes ? static_cast<float>(rest_share(tables.relaxation)) : 0.0F;
    double tick_share = relaxes ? rest_share(tables.relaxation) : 0.0;
    for (const RelaxationTerm& term : tables.relaxation) tick_share += term.share * relaxation_of_tick(term).rise;
    model.tick_share = static_cast<float>(tick_share);
}

/// After all others, whose twins it names; the curve itself is a table.
void set_stiffening(const StiffeningCurve& curve, int fingers, haptable_model& model) {
    const bool stiffens = curve.energy_j > 0.0;
    model.stiffen = stiffens ? haptable_stiffened_of : nullptr;
    if (!stiffens) return;
    model.relax = model.relax == nullptr                    ? haptable_stiffening
                  : fingers == 2                            ? haptable_pair_relaxation_stiffening
                  : model.relax == haptable_relaxation_held ? haptable_relaxation_held_stiffening
                                                            : haptable_relaxation_stiffening;
    if (model.release != nullptr) model.release = haptable_release_slew_stiffening;
}

}  // namespace

TickRelaxation relaxation_of_tick(const RelaxationTerm& term) {
    const double ticks = term.time_s / (1e-6 * HAPTABLE_TICK_US), fall = -std::expm1(-1.0 / ticks);
    return {fall, ticks * fall};
}

void set_laws(const Tables& tables, haptable_model& model) {
    const bool packed = tables.precision != Storage::kFloat32;
    const bool least = tables.god_object == GodObject::kLeastEnergy, friction = tables.static_friction > 0.0;
    const bool has_load = least && tables.force != ForceLaw::kInterpolated;
    model.god_object = friction ? haptable_god_object_friction : chosen(kGodObject, tables.god_object);
    model.frictionless = friction ? chosen(kGodObject, tables.god_object) : nullptr;
    model.static_friction = friction ? static_cast<float>(tables.static_friction) : 0.0F;
    model.kinetic_friction = friction ? static_cast<float>(tables.kinetic_friction) : 0.0F;
    const LawFunctions& law = kLaw[static_cast<std::size_t>(tables.force)];
    model.force = has_load ? haptable_force_of_least_energy : law.force[packed];
    model.energy = least ? law.energy[packed] : nullptr;
    set_keys(tables.options, model);
    // Two fingers change each other's load: along its own direction alone neither history would be passive.
    set_relaxation(tables, friction || tables.limits.grab || tables.fingers == 2, model);
    set_stiffening(tables.stiffening, tables.fingers, model);
    set_limits(tables.limits, tables.max_force_n, model);
    model.ungrabbed = tables.limits.grab ? model.god_object : nullptr;
    if (tables.limits.grab) model.god_object = haptable_god_object_grab;
}

haptable_unpack_fn* unpack_of(Storage precision) {
    static constexpr haptable_unpack_fn* kUnpack[] = {nullptr, haptable_unpack_float16, haptable_unpack_int16};
    return chosen(kUnpack, precision);
}

}  // namespace haptable
