// SPDX-License-Identifier: GPL-2.0-or-later
// Stiffness and relaxation from records that are known.
#include "host/fit/fit.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "codegen/in_memory.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "tests/bodies.hpp"
#include "tests/error_of.hpp"
#include "tests/finger.hpp"
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

/// The terms that were published of tests/host/fit/glass_transition.csv, for all of its 33 decades, at 1e-2, 1e-1, ...
/// s: shares of 1739.03 MPa (verification/time_master/prony_terms_KPf_MD.csv, 8755fc5).
constexpr std::array<double, 31> kPublishedShare = {
    5.456513e-02, 1.990923e-02, 2.259133e-02, 1.145233e-02, 1.162351e-02, 1.134698e-02, 1.228268e-02, 1.641093e-02,
    1.282291e-02, 1.109404e-02, 1.295433e-02, 1.738946e-02, 1.582369e-02, 2.112619e-02, 2.115868e-02, 2.413420e-02,
    3.404660e-02, 5.111675e-02, 7.523961e-02, 1.091803e-01, 9.671928e-02, 8.814058e-02, 5.242764e-02, 4.113119e-02,
    2.662922e-02, 2.208281e-02, 1.375225e-02, 1.256890e-02, 1.153754e-02, 1.070454e-02, 1.161637e-02};

double published_mpa(double time_1e17_s) {
    double left = 1.0;
    for (int k = 0; k < 31; ++k)
        left += kPublishedShare[static_cast<std::size_t>(k)] * std::expm1(-time_1e17_s * std::pow(10.0, 19 - k));
    return 1739.03 * left;
}

// Three terms over three decades, with samples closer together at the beginning. What they say between the samples is
// what the published ones do, which are up to 2.2 % off of the samples themselves; one term a decade ripples by as
// much.
TEST(Fit, APublishedRecordAndItsPublishedTerms) {
    ForceRecord record = read_force_record("tests/host/fit/glass_transition.csv");
    ASSERT_EQ(record.time_s.size(), 41U);
    ASSERT_EQ(record.time_s[0], 1.1);
    const double begin = record.time_s[0];
    for (double& time : record.time_s) time -= begin;
    const PronyFit fit = fit_prony(record, 0, 8);
    ASSERT_EQ(fit.relaxation.size(), 3U);
    EXPECT_LT(fit.misfit_n, 0.005 * record.force_n[0]);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_LT(std::max(fit.share_error[k], fit.time_error[k]), 0.1) << k;
    ForceRecord between;
    for (double time = 0.03; time < 2000.0; time *= 1.5) between.time_s.push_back(time);
    between.depth_m.assign(between.time_s.size(), 1.0);
    between.time_s.insert(between.time_s.begin(), 0.0);
    between.depth_m.insert(between.depth_m.begin(), 1.0);
    const std::vector<double> said = relaxed_force(between, fit.stiffness_n_per_m, fit.relaxation);
    for (std::size_t i = 0; i < said.size(); ++i)
        EXPECT_NEAR(said[i] / published_mpa(between.time_s[i] + begin), 1.0, 0.05) << between.time_s[i];
}

// Another term makes what rounding leaves smaller still; nor has an elastic body one.
TEST(Fit, RoundingAndNoiseAreNoTerms) {
    for (const double time_s : {0.02, 0.3, 4.0, 50.0})
        EXPECT_EQ(fit_prony(noisy(held_record(), 120.0, {{0.3, time_s}}, 0.0), 0, 3).relaxation.size(), 1U) << time_s;
    EXPECT_TRUE(fit_prony(noisy(held_record(), 50.0, {}, 1e-3), 0, 8).relaxation.empty());
}

// A record as a servo writes it, in floats, a tick after the finger: what is left over fits a twin of a term, and is
// none. A third term is none either where it is asked for.
TEST(Fit, ATermThatTheRecordDoesNotDetermineIsDropped) {
    ForceRecord record = noisy(held_record(), 120.0, kTwo, 0.0);
    for (std::size_t i = 0; i < record.force_n.size(); ++i)
        record.force_n[i] =
            static_cast<double>(static_cast<float>(record.force_n[i])) * (1.0 + 2e-6 * record.time_s[i]);
    for (const std::size_t terms : {0U, 3U, 5U}) {
        const PronyFit fit = fit_prony(record, terms, 8);
        for (std::size_t k = 0; k < fit.relaxation.size(); ++k) {
            EXPECT_LT(fit.share_error[k], 0.5) << terms << " terms, " << k;
            EXPECT_LT(fit.time_error[k], 0.5) << terms << " terms, " << k;
        }
        EXPECT_WITHIN(std::abs(fit.stiffness_n_per_m - 120.0), .epsilon = 1e-3, .size = 120.0);
    }
    EXPECT_EQ(fit_prony(noisy(held_record(), 120.0, kTwo, 0.0), 4, 8).relaxation.size(), 2U);
}

// Through the servo itself: the cube pressed as a finger would, and what is found is the scene.
TEST(Fit, FindsTheSceneThatTheServoFelt) {
    const ElasticBody cube(cube_scene(5, 0.3), ForceLaw::kInterpolated);
    Tables tables = cube.tables();
    tables.limits = {};
    tables.relaxation = kTwo;
    const double own = stiffness_at_once(tables, {}, "top", {.depth_m = 0.003});
    EXPECT_WITHIN(std::abs(own - stiffness_at_once(cube.tables(), {}, "top", {.depth_m = 0.003})), .size = own)
        << "at once, whatever it does later";
    const ServoModel servo_model = build_model(tables);
    const haptable_model model = model_in_memory(tables, servo_model);
    Finger finger(model);
    const Eigen::Vector3d top = place_of("top", model);
    ForceRecord record;
    for (int tick = -10; tick < 60'000; ++tick) {
        const double depth_m = std::min(0.003, 3e-5 * tick);
        finger.to(top - depth_m * Eigen::Vector3d::UnitZ());
        if (tick < 0 || (tick > 1000 && tick % 20 != 0)) continue;
        record.time_s.push_back(1e-3 * tick);
        record.depth_m.push_back(std::max(0.0, depth_m));
        record.force_n.push_back(finger.force().norm());
    }
    const PronyFit fit = fit_prony(record, 0, 8);
    EXPECT_WITHIN(std::abs(fit.stiffness_n_per_m / own - 1.0), .epsilon = 1e-3);
    ASSERT_GE(fit.relaxation.size(), 2U);
    double early = 0.0, late = 0.0;
    for (const RelaxationTerm& term : fit.relaxation) (term.time_s < 1.0 ? early : late) += term.share;
    EXPECT_WITHIN(std::abs(early - 0.3), .epsilon = 2e-3);
    EXPECT_WITHIN(std::abs(late - 0.25), .epsilon = 2e-3);
}

// A body that rings comes to rest under the same force: its tables are those of what the modes leave, and stiffer.
TEST(Fit, TheStiffnessOfABodyThatRingsIsThatOfTheWhole) {
    const auto stiffness = [](bool rings, bool alone) {
        Scene scene = cube_scene(5, 0.3);
        if (rings) scene.body_modes = BodyModes{8, 0.1, 1000.0, 0.0, 1};
        scene.tables.columns = ColumnRows::kNone;
        const SceneFiles files = files_of(scene);
        return stiffness_at_once(files.tables, alone ? std::nullopt : files.body_modes, "top", {.depth_m = 0.003});
    };
    const double whole = stiffness(false, true);
    EXPECT_GT(stiffness(true, true), 1.01 * whole) << "the test must tell them apart";
    EXPECT_NEAR(stiffness(true, false), whole, 1e-4 * whole);
}

TEST(Fit, ARecordThatIsNoneIsAnErrorAtItsLine) {
    const TemporaryFolder folder;
    const std::string timed = "time_s,depth_m,force_n\n";
    const std::pair<std::string, const char*> records[] = {
        {"t,d,f\n", "press.csv:1: the header must be time_s,depth_m,force_n or depth_m,force_n"},
        {timed + "0,0,0\n0,1,1\n", ":3: its time does not ascend"},
        {timed + "0,0,x\n", ":2: force_n holds what is no number"},
        {timed + "0,0\n", ":2: must be"},
        {timed + "0,0.1,-1\n", "no force above 0"},
        {timed + "0,-0.1,1\n", "no depth above 0"},
        {"# a slow press\ndepth_m,force_n\n1,1\n1,2,3\n", ":4: has more than two numbers"},
        {"depth_m,force_n\n1;2\n", ":2: must be depth_m,force_n"},
        {"time_s,depth_m,force_n\r\n0,0,0\r\n0.5,1e-3,2\r\n", "no error"}};
    for (const auto& [text, error] : records) {
        write_file(folder.path() / "press.csv", text);
        EXPECT_TRUE(fails_with([&] { read_force_record(folder.path() / "press.csv"); }, error));
    }
    // What comes after the body has let go says nothing of it.
    write_file(folder.path() / "press.csv", timed + "0,0,0\n1,1,2\n2,0.5,0\n3,0.1,0\n");
    EXPECT_EQ(read_force_record(folder.path() / "press.csv").time_s, (std::vector<double>{0.0, 1.0}));
}

TEST(Fit, TheMisfitIsDrawn) {
    const TemporaryFolder folder;
    const ForceRecord record = noisy(held_record(), 120.0, kTwo, 1e-3);
    plot_fit(record, fit_prony(record, 2, 2), folder.path() / "fit.svg");
    const std::string svg = read_file(folder.path() / "fit.svg");
    EXPECT_TRUE(says(svg, "fit - measured, N"));
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "fit.svg.gnuplot"));
}

TEST(Fit, TheLinesOfAScene) {
    Scene scene = cube_scene(5, 0.3);
    PronyFit fit = fit_prony(noisy(held_record(), 120.0, kTwo, 0.0), 2, 2);
    const std::string lines = scene_lines(scene, 2.0, fit);
    EXPECT_TRUE(says(lines, fmt::format("young = {:.6g}", 2.0 * scene.material.young_pa)));
    EXPECT_TRUE(says(lines, "[[relaxation]]\nshare = 0.3 "));
    scene.beds.push_back({});
    EXPECT_TRUE(says(scene_lines(scene, 2.0, fit), "all moduli of the scene"));
}

TEST(Fit, ASlowPressGivesTheCurveThatMadeIt) {
    const StiffeningCurve curve{{0.4, -0.3, 2.0}, 0.5 * 120.0 * 0.006 * 0.006};
    ForceRecord record;
    for (int k = 1; k <= 60; ++k) {
        const double depth_m = 1e-4 * k;
        record.time_s.push_back(k);
        record.depth_m.push_back(depth_m);
        record.force_n.push_back(curve.factor(60.0 * depth_m * depth_m) * 120.0 * depth_m);
    }
    const DentFit fit = fit_dent(record);
    EXPECT_NEAR(fit.stiffness_n_per_m, 120.0, 1e-6);
    EXPECT_NEAR(fit.curve.energy_j, curve.energy_j, 1e-9 * curve.energy_j);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(fit.curve.c[k], curve.c[k], 1e-8);
    EXPECT_LT(fit.misfit_n, 1e-9);
    for (double& force : record.force_n) force = -force;
    EXPECT_THROW((void)fit_dent(record), Error) << "the force on the press";
}

// A published press of an organ: no line is near it, and a curve is.
TEST(Fit, APublishedPressOfALiver) {
    const ForceRecord record = read_force_record("tests/host/fit/pig_liver.csv");
    ASSERT_EQ(record.force_n.size(), 10U);
    const DentFit fit = fit_dent(record);
    EXPECT_LT(fit.misfit_n, 0.01 * fit.largest_n);
    EXPECT_GT(fit.curve.factor(fit.curve.energy_j), 5.0) << "at 3 mm it is that much stiffer than at first";
    double depth2 = 0.0, both = 0.0, off2 = 0.0;
    for (std::size_t i = 0; i < record.force_n.size(); ++i) {
        depth2 += record.depth_m[i] * record.depth_m[i];
        both += record.depth_m[i] * record.force_n[i];
    }
    for (std::size_t i = 0; i < record.force_n.size(); ++i)
        off2 += std::pow(both / depth2 * record.depth_m[i] - record.force_n[i], 2);
    EXPECT_GT(std::sqrt(off2 / 10.0), 0.15 * fit.largest_n) << "the best line";
}

// Each two samples are worth a number: fewer depths than a cubic needs do not bend it through each of them.
TEST(Fit, AFewDepthsGiveACurveOfFewerTerms) {
    ForceRecord record;
    for (const double depth_mm : {1.0, 2.0, 3.0, 4.0, 5.0}) {
        record.depth_m.push_back(1e-3 * depth_mm);
        record.force_n.push_back(0.1 * depth_mm + 0.02 * depth_mm * depth_mm);
    }
    const DentFit fit = fit_dent(record);
    EXPECT_NEAR(fit.stiffness_n_per_m, 100.0, 1e-9);
    EXPECT_NEAR(fit.curve.c[0], 1.0, 1e-9);  // 0.02 x 5 mm over 0.1
    EXPECT_EQ(fit.curve.c[1], 0.0);
    EXPECT_TRUE(fails_with([&] { (void)fit_prony(record, 0, 8); }, "no times"));
    record.depth_m.resize(3);
    record.force_n.resize(3);
    EXPECT_TRUE(fails_with([&] { (void)fit_dent(record); }, "3 samples"));
}

}  // namespace
}  // namespace haptable::test
