// SPDX-License-Identifier: GPL-2.0-or-later
// Every mode of the servo on emulated microcontrollers: the host's bits, under its bound, and no more instructions than
// before.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <regex>

#include "codegen/codegen.hpp"
#include "codegen/in_memory.hpp"
#include "firmware/haptable_bounds.h"
#include "host/target/counts.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"
#include "tests/bodies.hpp"
#include "tests/firmware/on_target.hpp"
#include "tests/process.hpp"
#include "tests/shapes.hpp"

namespace haptable::test {
namespace {

struct Case {
    std::string target, body;
    Mode mode;
};

/// Every mode on the M7; the paper's and the dearest one on the others.
std::vector<Case> cases() {
    std::vector<Case> all;
    for (const char* name : {"cube", "needle"})
        for (const Mode& mode : every_mode()) all.push_back({"cortex-m7", name, mode});
    for (const char* target : {"cortex-m4", "cortex-m33", "rv32"})
        for (const Mode& mode : {Mode{ForceLaw::kInterpolated, GodObject::kNearest, ""},
                                 Mode{ForceLaw::kPressureMask, GodObject::kLeastEnergy, "friction"}})
            all.push_back({target, "needle", mode});
    return all;
}

std::string word(const Case& one) { return one.body + " " + one.target + " " + one.mode.name(); }

std::string name_of(const testing::TestParamInfo<Case>& info) { return test_name(word(info.param)); }

class ModeOnTarget : public testing::TestWithParam<Case> {
protected:
    const Case& one = GetParam();
    const TargetImage image{build_folder(), "cube", one.target};
};

INSTANTIATE_TEST_SUITE_P(Modes, ModeOnTarget, testing::ValuesIn(cases()), name_of);

// On a mesh with up to eight patches around a vertex, as the cube and the mouse have, at 168 MHz. Of the paper's mode
// the most steps of a tick that slides, times their cost, stay under 14,000, and what begins contact after two that
// were let go under half of a millisecond.
TEST(Bound, OfEveryModeIsUnderNineTenthsOfAMillisecond) {
    for (const Mode& mode : every_mode()) EXPECT_LT(most_cost(mode, 8), 168000U * 9 / 10) << mode.name();
    const Mode paper{ForceLaw::kInterpolated, GodObject::kNearest, ""};
    const TickCost slide = cost_of(paper, 8, 1);
    EXPECT_LT(slide.rest + slide.step * MOST_STEPS, 14000U);
    EXPECT_LT(most_cost(paper, 8), 168000U / 2);
}

// Blocks of a compliance in 16 bits, expanded on the target as on the host.
TEST(PackedCompliance, GivesTheHostsBitsOnEveryTarget) {
    for (const ForceLaw force : {ForceLaw::kConsistent, ForceLaw::kPressureMask})
        for (const Storage precision : {Storage::kFloat16, Storage::kInt16}) {
            Tables tables = body_of_modes("cube", force).tables();
            tables.precision = precision;
            tables.god_object = GodObject::kLeastEnergy;
            const ServoModel servo_model = build_model(tables);
            const haptable_model model = model_in_memory(tables, servo_model);
            std::vector<std::array<float, 3>> path_m{{0.015F, 0.015F, 0.031F}};
            for (int i = 0; i < 100; ++i)
                path_m.push_back(
                    {0.015F + 0.00005F * float(i), 0.014F + 0.00003F * float(i), 0.0299F - 0.00002F * float(i)});
            for (const char* target : kTargets) {
                const TargetImage image(build_folder(), "cube", target);
                if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
                SceneState host(model, nullptr, nullptr, nullptr);
                std::size_t touching = 0;
                expect_host_bits(image.measure({model}, path_m), host, path_m, [&](std::size_t, const auto* out) {
                    touching += std::size_t(haptable_touches(out->state));
                });
                EXPECT_GT(touching, 90U) << target;
            }
        }
}

/// The median sliding tick of a body that relaxes by so many terms.
std::uint64_t relaxing_tick(const TargetImage& image, const ElasticBody& body, GodObject god_object, double friction,
                            std::size_t terms, const std::vector<std::array<float, 3>>& path_m) {
    Tables tables = body.tables({.god_object = god_object, .friction = friction});
    for (std::size_t k = 0; k < terms; ++k) tables.relaxation.push_back({0.1, 1e-3 * std::pow(7.0, double(k))});
    const ServoModel servo_model = build_model(tables);
    const haptable_model model = model_in_memory(tables, servo_model);
    const std::vector<TargetTick> ticks = image.measure({model}, path_m);
    SceneState host(model, nullptr, nullptr, nullptr);
    std::size_t behind = 0;
    expect_host_bits(ticks, host, path_m, [&](std::size_t, const haptable_output* out) {
        behind += out->state == HAPTABLE_FREE && out->vertex[0] != HAPTABLE_NONE;
    });
    EXPECT_EQ(behind > 10U, terms > 0) << "a dent is left";
    return count_ticks(path_m, ticks).sliding.median;
}

// Both god-objects, smooth or rough: the host's bits, and at most 60 instructions a term.
class RelaxingOnTarget : public testing::TestWithParam<std::string> {};

TEST_P(RelaxingOnTarget, EveryForceHasTheHostsBitsAndCostsLittleATerm) {
    const TargetImage image(build_folder(), "cube", GetParam());
    if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
    using Touched = std::tuple<ForceLaw, GodObject, double>;
    for (const auto& [force, god_object, friction] : {Touched{ForceLaw::kInterpolated, GodObject::kNearest, 0.0},
                                                      Touched{ForceLaw::kInterpolated, GodObject::kNearest, 0.3},
                                                      Touched{ForceLaw::kConsistent, GodObject::kNearest, 0.0},
                                                      Touched{ForceLaw::kConsistent, GodObject::kLeastEnergy, 0.4},
                                                      Touched{ForceLaw::kPressureMask, GodObject::kNearest, 0.0},
                                                      Touched{ForceLaw::kPressureMask, GodObject::kLeastEnergy, 0.0}}) {
        const ElasticBody& touched = body_of_modes("cube", force);
        const auto path_m = stroke_path(touched.tables(), 8);
        const auto median = [&](std::size_t terms) {
            return relaxing_tick(image, touched, god_object, friction, terms, path_m);
        };
        const std::uint64_t one = median(1), eight = median(8);
        const std::string what = std::string(word(force)) + " " + word(god_object) + (friction > 0.0 ? " rough" : "");
        RecordProperty(what, std::to_string(one) + " " + std::to_string(eight));
        EXPECT_LE(eight, one + 7 * 60) << what;
        if (god_object == GodObject::kNearest && friction == 0.0) {
            EXPECT_LE(one, median(0) + 400) << what;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Targets, RelaxingOnTarget,
                         testing::ValuesIn(std::vector<std::string>(kTargets.begin(), kTargets.end())),
                         [](const auto& one) { return test_name(one.param); });

/// What stands in a text between its numbers.
std::string without_numbers(const std::string& text) {
    return std::regex_replace(text, std::regex("-|[0-9][0-9A-Za-z.+-]*"), "");
}

/// The cube of fibres, in a skin, on a bed and with its weight.
Scene dressed_cube() {
    Scene scene = cube_scene(5, 0.3);
    scene.material = like(fibre(6e4, 8e3, 0.35, 0.45, 5e3));
    scene.material.orthotropic->axes.direction = {{{0.48, 0.6, 0.64}, {0.8, -0.64, 0}}};
    const auto box = [](double low, double high) {
        return Selection{std::array<double, 6>{-1, -1, low, 1, 1, high}, "", 1};
    };
    scene.membranes = {{box(0.0299, 1), 1e-4, 3e6, 0.3}};
    scene.beds = {{box(-1, 1e-9), 2e6, 7e5}};
    scene.fixed.clear();
    scene.gravity = Gravity{1100.0, {0, 0, -9.81}, false};
    return scene;
}

// Only numbers differ: no byte of code or tables, and so no instruction.
TEST(MaterialsOnTarget, WhatABodyIsMadeOfCostsNoByteAndNoInstruction) {
    const ElasticBody dressed(dressed_cube(), ForceLaw::kInterpolated);
    Scene held_by_bed = cube_scene(5, 0.3);
    held_by_bed.fixed.clear();
    held_by_bed.beds = dressed_cube().beds;
    const ElasticBody isotropic(held_by_bed, ForceLaw::kInterpolated);
    Tables plain = isotropic.tables(), other = dressed.tables();
    EXPECT_NE(plain.stiffness, other.stiffness);
    plain.position = other.position;  // as it has sagged
    plain.limits = other.limits = {};
    const ServoModel plain_servo = build_model(plain), other_servo = build_model(other);
    EXPECT_EQ(flash_bytes(plain_servo), flash_bytes(other_servo));
    const ModelText text = model_text(plain, plain_servo), other_text = model_text(other, other_servo);
    EXPECT_NE(text.source, other_text.source);
    EXPECT_EQ(without_numbers(text.header), without_numbers(other_text.header));
    EXPECT_EQ(without_numbers(text.source), without_numbers(other_text.source));
}

// A tip of 31 patches: their normals, each with its angle, are most of what a tick that lets go there costs.
TEST(Bound, HoldsOnATipOfManyPatches) {
    const TestModel tip(spindle_shape(31, 0.02, 0.03));
    double height = 0.0;
    for (const auto& x : tip.servo().vertex_m) height = std::max(height, double(x[2]));
    std::vector<std::array<float, 3>> path_m{{0.0F, 0.0F, float(height + 1e-3)}};
    for (int i = 0; i < 200; ++i)
        path_m.push_back(
            {0.0003F * std::sin(float(i)), 0.0002F * std::cos(0.7F * float(i)), float(height - 1e-4 - 2e-5 * i)});
    path_m.push_back(path_m[0]);
    for (const char* target : kTargets) {
        const TargetImage image(build_folder(), "cube", target);
        if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
        for (const Mode& mode : every_mode()) {
            if (mode.force != ForceLaw::kInterpolated) continue;  // its blocks are made up
            const haptable_model model = in_mode(*tip.get(), mode);
            const TickCost each = cost_of(mode, most_patches_around_a_vertex(model));
            SCOPED_TRACE(mode.name());
            const std::vector<TargetTick> ticks = image.measure({model}, path_m);
            SceneState host(model, nullptr, nullptr, nullptr);
            const haptable_counters& counters = host.servo(0).counters;
            expect_host_bits(ticks, host, path_m,
                             [&](std::size_t i, auto*) { EXPECT_LE(ticks[i].instructions, cost(each, counters)); });
            EXPECT_GT(counters.contact_ticks, 150U);
        }
    }
}

TEST_P(ModeOnTarget, GivesTheHostsBitsUnderItsBoundAndNoDearerThanBefore) {
    if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
    const ElasticBody& touched = body_of_modes(one.body, one.mode.force);
    const haptable_model model = in_mode(touched.model(), one.mode);
    const auto path_m = hard_path(touched.tables(), 60);
    const std::uint64_t fan = most_patches_around_a_vertex(model);
    const TickCost each = cost_of(one.mode, fan);
    const std::vector<TargetTick> ticks = image.measure({model}, path_m);
    SceneState host(model, nullptr, nullptr, nullptr);
    const haptable_counters& counters = host.servo(0).counters;
    std::uint64_t worst = 0;
    expect_host_bits(ticks, host, path_m, [&](std::size_t i, auto*) {
        EXPECT_LE(ticks[i].instructions, cost(each, counters));
        worst = std::max(worst, ticks[i].instructions);
    });
    EXPECT_GT(counters.contact_ticks, path_m.size() / 3);
    EXPECT_LT(worst, most_cost(one.mode, fan));
    const std::uint64_t median = count_ticks(path_m, ticks).sliding.median;
    const std::string counts = word(one) + ": " + std::to_string(median) + " " + std::to_string(worst);
    const std::vector<std::uint64_t> then = announced("instructions_by_mode.txt", word(one) + ": ");
    ASSERT_EQ(then.size(), 2U);
    RecordProperty("instructions", counts);
    EXPECT_LE(median, then[0] + then[0] / 50) << "announce it in instructions_by_mode.txt: " << counts;
    EXPECT_LE(worst, then[1] + then[1] / 20) << "announce it in instructions_by_mode.txt: " << counts;
}

}  // namespace
}  // namespace haptable::test
