// SPDX-License-Identifier: GPL-2.0-or-later
// Stiffness and relaxation from records that are known.
#include "host/fit/fit.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "codegen/in_memory.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "tests/bodies.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

/// 3 mm deep in 0.1 s, held for a minute, 2 mm for half a minute; samples closer together where it moves.
ForceRecord held_record() {
    ForceRecord record;
    for (double t = 0.0; t < 90.0; t += t < 1.0 ? 0.002 : 0.05) {
        record.time_s.push_back(t);
        record.depth_m.push_back(t < 0.1 ? 0.03 * t : t < 60.0 ? 0.003 : 0.002);
    }
    record.force_n.assign(record.time_s.size(), 0.0);
    return record;
}

ForceRecord noisy(ForceRecord record, double stiffness, const std::vector<RelaxationTerm>& terms, double noise_n) {
    std::mt19937 random(5);
    std::normal_distribution<double> error(0.0, 1.0);
    record.force_n = relaxed_force(record, stiffness, terms);
    for (double& force_n : record.force_n) force_n += noise_n * error(random);
    return record;
}

const std::vector<RelaxationTerm> kTwo = {{0.3, 0.15}, {0.25, 8.0}};

TEST(Fit, FindsWhatARecordWithoutNoiseWasMadeOf) {
    const PronyFit fit = fit_prony(noisy(held_record(), 120.0, kTwo, 0.0), 2, 8);
    ASSERT_EQ(fit.relaxation.size(), 2U);
    EXPECT_WITHIN(std::abs(fit.stiffness_n_per_m - 120.0), .epsilon = 1e-6, .size = 120.0);
    for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_WITHIN(std::abs(fit.relaxation[k].share - kTwo[k].share), .epsilon = 1e-6);
        EXPECT_WITHIN(std::abs(fit.relaxation[k].time_s - kTwo[k].time_s), .epsilon = 1e-5, .size = kTwo[k].time_s);
    }
}

// One percent of noise: what it finds lies within four of the standard deviations that it tells, and it takes the
// number of terms from the record.
TEST(Fit, FindsItThroughNoiseWithinTheErrorsThatItTells) {
    const double noise_n = 0.01 * 120.0 * 0.003;
    const PronyFit fit = fit_prony(noisy(held_record(), 120.0, kTwo, noise_n), 0, 8);
    ASSERT_EQ(fit.relaxation.size(), 2U) << "Schwarz's criterion";
    EXPECT_WITHIN(std::abs(fit.misfit_n - noise_n), .epsilon = 0.05, .size = noise_n);
    EXPECT_LT(std::abs(fit.stiffness_n_per_m / 120.0 - 1.0), 4.0 * fit.stiffness_error);
    EXPECT_LT(fit.stiffness_error, 0.02);
    for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_LT(std::abs(fit.relaxation[k].share / kTwo[k].share - 1.0), 4.0 * fit.share_error[k]);
        EXPECT_LT(std::abs(fit.relaxation[k].time_s / kTwo[k].time_s - 1.0), 4.0 * fit.time_error[k]);
        EXPECT_LT(fit.time_error[k], 0.1);
    }
}

TEST(Fit, AnElasticBodyHasNoTerms) {
    EXPECT_TRUE(fit_prony(noisy(held_record(), 50.0, {}, 1e-3), 0, 8).relaxation.empty());
}

// Through the servo itself: the cube pressed as a finger would, and what is found is the scene.
TEST(Fit, FindsTheSceneThatTheServoFelt) {
    const ElasticBody cube(cube_scene(5, 0.3), ForceLaw::kInterpolated);
    Tables tables = cube.tables();
    tables.limits = {};
    tables.relaxation = kTwo;
    const double own = stiffness_at_once(tables, "top", {.depth_m = 0.003});
    EXPECT_WITHIN(std::abs(own - stiffness_at_once(cube.tables(), "top", {.depth_m = 0.003})), .size = own)
        << "at once, whatever it does later";
    const ServoModel servo_model = build_model(tables);
    const haptable_model model = model_in_memory(tables, servo_model);
    haptable_servo servo;
    haptable_init(&servo);
    const Eigen::Vector3d top = place_of("top", model);
    ForceRecord record;
    for (int tick = -10; tick < 60'000; ++tick) {
        const double depth_m = std::min(0.003, 3e-5 * tick);
        const float finger_m[3] = {float(top.x()), float(top.y()), float(top.z() - depth_m)};
        haptable_output out;
        haptable_step(&model, &servo, finger_m, static_cast<std::uint32_t>(tick + 10) * HAPTABLE_TICK_US, &out);
        if (tick < 0 || (tick > 1000 && tick % 20 != 0)) continue;
        record.time_s.push_back(1e-3 * tick);
        record.depth_m.push_back(std::max(0.0, depth_m));
        record.force_n.push_back(std::hypot(double(out.force_n[0]), double(out.force_n[1]), double(out.force_n[2])));
    }
    const PronyFit fit = fit_prony(record, 0, 8);
    EXPECT_WITHIN(std::abs(fit.stiffness_n_per_m / own - 1.0), .epsilon = 1e-3);
    ASSERT_GE(fit.relaxation.size(), 2U);
    double early = 0.0, late = 0.0;
    for (const RelaxationTerm& term : fit.relaxation) (term.time_s < 1.0 ? early : late) += term.share;
    EXPECT_WITHIN(std::abs(early - 0.3), .epsilon = 2e-3);
    EXPECT_WITHIN(std::abs(late - 0.25), .epsilon = 2e-3);
}

TEST(Fit, ARecordThatIsNoneIsAnErrorAtItsLine) {
    const TemporaryFolder folder;
    const auto error_of = [&](const std::string& text) -> std::string {
        write_file(folder.path() / "press.csv", text);
        try {
            read_force_record(folder.path() / "press.csv");
        } catch (const Error& error) {
            return error.what();
        }
        return "none";
    };
    EXPECT_NE(error_of("t,d,f\n").find("press.csv:1: the header must be time_s,depth_m,force_n"), std::string::npos);
    EXPECT_NE(error_of("time_s,depth_m,force_n\n0,0,0\n0,1,1\n").find(":3: its time does not ascend"),
              std::string::npos);
    EXPECT_NE(error_of("time_s,depth_m,force_n\n0,0,x\n").find(":2: holds what is no number"), std::string::npos);
    EXPECT_NE(error_of("time_s,depth_m,force_n\n0,0\n").find(":2: must be"), std::string::npos);
    EXPECT_NE(error_of("time_s,depth_m,force_n\n0,0.1,-1\n").find("no force above 0"), std::string::npos);
    EXPECT_EQ(error_of("time_s,depth_m,force_n\r\n0,0,0\r\n0.5,1e-3,2\r\n"), "none");
}

// What comes after the body has let go says nothing of it.
TEST(Fit, ARecordEndsWhereTheForceDoes) {
    const TemporaryFolder folder;
    write_file(folder.path() / "press.csv", "time_s,depth_m,force_n\n0,0,0\n1,1,2\n2,0.5,0\n3,0.1,0\n");
    EXPECT_EQ(read_force_record(folder.path() / "press.csv").time_s, (std::vector<double>{0.0, 1.0}));
}

TEST(Fit, TheMisfitIsDrawn) {
    const TemporaryFolder folder;
    const ForceRecord record = noisy(held_record(), 120.0, kTwo, 1e-3);
    plot_fit(record, fit_prony(record, 2, 2), folder.path() / "fit.svg");
    const std::string svg = read_file(folder.path() / "fit.svg");
    EXPECT_NE(svg.find("fit - measured, N"), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "fit.svg.gnuplot"));
}

TEST(Fit, TheLinesOfAScene) {
    Scene scene = cube_scene(5, 0.3);
    PronyFit fit = fit_prony(noisy(held_record(), 120.0, kTwo, 0.0), 2, 2);
    const std::string lines = scene_lines(scene, 2.0, fit);
    EXPECT_NE(lines.find(fmt::format("young = {:.6g}", 2.0 * scene.material.young_pa)), std::string::npos) << lines;
    EXPECT_NE(lines.find("[[relaxation]]\nshare = 0.3 "), std::string::npos) << lines;
    scene.beds.push_back({});
    EXPECT_NE(scene_lines(scene, 2.0, fit).find("all moduli of the scene"), std::string::npos);
}

}  // namespace
}  // namespace haptable::test
