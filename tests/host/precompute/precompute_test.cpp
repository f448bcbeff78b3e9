// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/precompute.hpp"
#include "host/base/json.hpp"
#include "host/body/assembly.hpp"
#include "host/precompute/facts.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/LU>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/own_folder.hpp"
#include "host/inverse/cholmod_inverse.hpp"
#include "host/inverse/solve/blas_core.hpp"
#include "host/tables/checks.hpp"
#include "host/tables/npy.hpp"
#include "host/tables/tables.hpp"
#include "tests/error_of.hpp"
#include "tests/files_apart.hpp"
#include "tests/host/body/cubes.hpp"
#include "tests/host/inverse/dense_reference.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable {
namespace {

namespace fs = std::filesystem;

/// The paper's cube, its bottom fixed.
Scene cube_scene(int nodes_per_side = 5, double poisson = 0.49) {
    Scene scene = test::cube_of("cube", nodes_per_side, {1e4, poisson});
    scene.fixed.push_back({std::array<double, 6>{-1, -1, -1, 1, 1, 1e-9}, "", 9});
    return scene;
}

Result run_into(const fs::path& folder, const Scene& scene, const PrecomputeOptions& options = {}) {
    Progress quiet(true);
    return precompute(scene, folder, quiet, options);
}

/// Without the mark.
std::map<std::string, std::string> contents(const fs::path& folder) {
    std::map<std::string, std::string> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        if (entry.path().filename() != ".haptable")
            files[entry.path().filename()] = entry.is_directory() ? "" : read_file(entry.path());
    return files;
}

/// L of a scene's cube by a dense inverse.
test::DenseReference reference_of(const Scene& scene) {
    return test::DenseReference(assemble_free(scene, make_body(scene, make_mesh(scene.mesh))));
}

Selection box(const std::array<double, 6>& of, int line = 1) { return {of, "", line}; }
const Selection kTop = box({-1, -1, 0.0299, 1, 1, 1}), kSide = box({0.0299, -1, -1, 1, 1, 1});

/// A file's array of blocks of 3 by 3.
template <typename T>
std::vector<Eigen::Matrix3d> blocks_of(const fs::path& file) {
    const Array<T> array = read_npy<T>(file);
    std::vector<Eigen::Matrix3d> blocks;
    for (std::size_t k = 0; k < array.values.size(); k += 9) {
        Eigen::Matrix<T, 3, 3, Eigen::RowMajor> block(array.values.data() + k);
        blocks.emplace_back(block.template cast<double>());
    }
    return blocks;
}

constexpr double kStored = 8.0;                       // one rounding to float32, in either of two columns from double
const double kSolved = 8.0 * std::sqrt(3.0 * 648.0);  // of float32 in an inversion or solves of up to 648 nodes

/// What a folder holds besides its reports and columns.npy, which are compared by value.
std::map<std::string, std::string> but_columns(const fs::path& folder) {
    auto files = contents(folder);
    for (const char* file : {"summary.json", "tables.json", "columns.npy"}) files.erase(file);
    return files;
}

double column_distance(const fs::path& a, const fs::path& b) {
    return test::difference<float>(a / "columns.npy", b / "columns.npy");
}

class PrecomputeRun : public testing::Test {
protected:
    Result run(const Scene& scene, const PrecomputeOptions& options = {}) const {
        return run_into(out_, scene, options);
    }
    nlohmann::json told(const char* file = "summary.json") const { return parse_json(read_file(out_ / file)); }

    const test::TemporaryFolder temporary_;
    const fs::path out_ = temporary_.path() / "out", fresh_ = temporary_.path() / "fresh";
};

TEST_F(PrecomputeRun, ColumnsAreThoseOfADenseInverseWithinTheirTolerance) {
    struct Case {
        double poisson, tolerance;
        Precision precision;
        ColumnRows rows = ColumnRows::kSurface;
        Element element = Element::kLinear;
    };
    // The factor is in double: nu near 0.5 costs the columns no digits.
    for (const Case& c : {Case{0.49, 0.0, Precision::kDouble},
                          {0.49, 0.0, Precision::kDouble, ColumnRows::kAll},
                          {0.3, 1e-5, Precision::kFloat},
                          {0.49, 1e-5, Precision::kFloat, ColumnRows::kSurface, Element::kAverageNodalPressure},
                          {0.4999, 1e-5, Precision::kFloat},
                          {0.49, 1e-7, Precision::kDouble}}) {
        SCOPED_TRACE(testing::Message() << c.poisson << ", " << c.tolerance << ", " << c.element);
        Scene scene = cube_scene(5, c.poisson);
        scene.mesh.element = c.element;
        scene.tables.columns = c.rows;
        const Result result = run(scene, {.column_tolerance = c.tolerance});
        const ColumnSummary& summary = result.summary.inverse.columns;
        EXPECT_EQ(summary.facts.precision, c.precision);
        if (c.tolerance > 0.0) {
            EXPECT_GT(summary.float_error, 5e-8) << "this was not computed in float";
        }
        const Body& body = result.body;
        const std::vector<std::int32_t>& row = c.rows == ColumnRows::kAll ? body.free_node : body.free_surface_node;
        EXPECT_EQ(read_tables(out_).row_id, row);
        EXPECT_EQ(MappedNpy<float>(out_ / "columns.npy").shape(),
                  (std::vector<std::size_t>{body.touch_node.size(), row.size(), 3, 3}));
        const test::DenseReference dense = reference_of(scene);
        const auto columns = blocks_of<float>(out_ / "columns.npy");
        const auto unknown = [&](std::int32_t node) { return body.unknown[std::size_t(node)]; };
        for (std::size_t i = 0; i < body.touch_node.size(); ++i) {
            double squared = 0.0, norm = 0.0, largest = 0.0;
            for (std::size_t k = 0; k < row.size(); ++k) {
                const Eigen::Matrix3d exact = dense.block(unknown(row[k]), unknown(body.touch_node[i]));
                const Eigen::Matrix3d error = columns[row.size() * i + k] - exact;
                largest = std::max(largest, error.cwiseAbs().maxCoeff());
                squared += error.squaredNorm();
                norm += exact.squaredNorm();
            }
            if (c.tolerance > 0.0)
                ASSERT_WITHIN(std::sqrt(squared / norm), .epsilon = c.tolerance);
            else
                ASSERT_WITHIN(largest, .count = kStored, .epsilon = test::kFloat, .size = dense.l.maxCoeff());
        }
    }
}

TEST_F(PrecomputeRun, ChecksAreMeasuredAndKept) {
    const Result result = run(cube_scene(), {.column_tolerance = 0.0});
    const Checks& checks = result.summary.inverse.checks;
    const test::DenseReference dense = reference_of(cube_scene());
    const test::Bound& bound = dense.bound;
    EXPECT_WITHIN(checks.largest_residual, bound);  // of unit loads
    EXPECT_GT(checks.largest_residual, 0.0);
    EXPECT_WITHIN(checks.largest_asymmetry, bound);
    EXPECT_WITHIN(checks.largest_block_difference, bound);
    EXPECT_WITHIN(checks.largest_column_difference, .count = kStored, .epsilon = test::kFloat);
    EXPECT_GT(checks.largest_column_difference, 1e-9) << "columns.npy is float32";
    EXPECT_GT(checks.smallest_eigenvalue_m_per_n, 0.0);
    const Eigen::VectorXd eigenvalue = haptable::dense::eigenvalues(dense.l);
    const double exact = eigenvalue[eigenvalue.size() - 1] / eigenvalue[0];
    // Lanczos's method stops where neither of the two eigenvalues moves by more than 1 %.
    EXPECT_WITHIN(std::abs(checks.condition_estimate / exact - 1.0), .count = 6, .epsilon = 0.01);

    const nlohmann::json json = told();
    EXPECT_EQ(json.at("checks").at("largest_residual"), checks.largest_residual);
    EXPECT_EQ(json.at("blas_kernels"), blas_kernels());
    EXPECT_EQ(json.at("counts").at("free_surface_nodes"), 73);
    EXPECT_EQ(json.at("counts").at("touchable_patches"), 192);
    for (const auto& [file, bytes] : json.at("bytes").items()) EXPECT_EQ(bytes, fs::file_size(out_ / file)) << file;
    EXPECT_EQ(json.at("bytes").size() + 2, contents(out_).size()) << "every file but the two that tell of them";
    for (const char* stage : {"mesh", "assembly", "factor", "blocks", "columns", "check", "write", "codegen"})
        EXPECT_GE(json.at("time_s").at(stage).get<double>(), 0.0);
}

// Both are told, kept for the same body, and told anew of another finger.
TEST_F(PrecomputeRun, TheDepthOfSmallStrainAndHowMuchItLocksAreToldAndKept) {
    Scene scene = cube_scene();
    const auto depth_and_locking = [&] {
        run(scene);
        return std::pair(told().at("small_strain"), told().at("element"));
    };
    const auto [depth, element] = depth_and_locking();
    EXPECT_EQ(depth.at("depth_m"), depth.at("pressing_m"));
    EXPECT_EQ(depth.at("finger_radius_m"), 0.0);
    EXPECT_GT(depth.at("depth_m"), 0.0);
    EXPECT_EQ(read_small_strain_depth(out_), depth.at("depth_m").get<double>());
    EXPECT_EQ(element.at("places"), 5U);
    EXPECT_GT(element.at("expected_locking"), 0.05);
    EXPECT_TRUE(test::says(told().at("warnings").at(0), "a finger's pad of 0.005 m feels this mesh"));
    scene.contact.static_friction = scene.contact.kinetic_friction = 0.3;  // of the same body: nothing is solved
    const auto [rough_depth, rough_element] = depth_and_locking();
    EXPECT_EQ(rough_depth.at("depth_m").get<double>(),
              std::min(depth.at("pressing_m").get<double>(), depth.at("sideways_m").get<double>()));
    EXPECT_EQ(rough_element, element);
    scene.contact.force = ForceLaw::kPressureMask;
    scene.contact.mask_radius_m = 0.012;
    const auto [mask_depth, mask_element] = depth_and_locking();
    EXPECT_EQ(mask_depth.at("finger_radius_m"), 0.012);
    EXPECT_EQ(mask_element.at("finger_radius_m"), 0.012);
    EXPECT_GT(mask_depth.at("pressing_m"), depth.at("pressing_m")) << "a finger that is wide strains less than a point";
    scene.contact.force = ForceLaw::kInterpolated;
    scene.contact.mask_radius_m = 0.0;
    const auto [again_depth, again_element] = depth_and_locking();
    EXPECT_TRUE(again_depth.is_null()) << "blocks of an earlier run, a depth of another finger";
    EXPECT_FALSE(read_small_strain_depth(out_));
    EXPECT_EQ(again_element.at("places"), 0U) << "locking of another finger: foreseen";
    EXPECT_GT(again_element.at("expected_locking"), 0.05);
}

TEST_F(PrecomputeRun, DentsThatStiffenAreFittedToldAndHashed) {
    const Stiffening yeoh{5.0, 0.0, 0.0, {}}, fung{0.0, 0.0, 5.0, {}};
    Scene scene = cube_scene();
    const std::uint64_t linear = run(scene).summary.identity.model_hash;
    EXPECT_EQ(read_tables(out_).stiffening.energy_j, 0.0);
    EXPECT_FALSE(told().contains("stiffening"));
    scene.material.stiffening = fung;
    run(scene);
    const auto fungs = read_tables(out_).stiffening.c;
    scene.material.stiffening = yeoh;
    const Result result = run(scene);
    const nlohmann::json fit = told().at("stiffening");
    EXPECT_EQ(fit.at("yeoh"), (std::vector{5.0, 0.0}));
    EXPECT_LT(fit.at("fitted").at("rms"), fit.at("fitted").at("linear_rms"));
    EXPECT_EQ(fit.at("by_place").size(), 5U);
    for (const char* way : {"pressing", "oblique", "sideways", "pulling"})
        EXPECT_GT(fit.at("by_way").at(way).at("depth_m"), 0.0) << way;
    EXPECT_TRUE(fit.at("by_way").at("pressing").at("is_fitted"));
    EXPECT_FALSE(fit.at("by_way").at("pulling").at("is_fitted")) << "without grab";
    EXPECT_EQ(told().at("small_strain").at("pressing_m"), result.summary.stiffening->good.pressing_m);
    const StiffeningCurve curve = read_tables(out_).stiffening;
    EXPECT_EQ(curve.c, result.summary.stiffening->curve.c);
    EXPECT_NE(curve.c, fungs);
    EXPECT_EQ(curve.energy_j, fit.at("energy_j").get<double>());
    EXPECT_NE(result.summary.identity.model_hash, linear);
    EXPECT_TRUE(run(scene).unchanged);
    scene.material.stiffening.reset();
    EXPECT_EQ(run(scene).summary.identity.model_hash, linear);
    EXPECT_EQ(read_tables(out_).stiffening.energy_j, 0.0);
    // A curve that would pull, by a flipped sign in the file.
    scene.material.stiffening = yeoh;
    run(scene);
    auto facts = told("tables.json");
    facts["stiffening"]["curve"] = {0.0, 0.0, -4.0};
    write_file(out_ / "tables.json", facts.dump());
    EXPECT_TRUE(test::fails_with([&] { (void)read_tables(out_); }, "force does not grow with the dent"));
}

/// A scene file of a cube of 30 mm, pressed on its top; `more` of its stiffening.
Scene pressed_scene(const fs::path& folder, const std::string& more, double young_pa = 1e4) {
    const fs::path file = folder / "pressed.toml";
    write_file(file,
               fmt::format("name = \"pressed\"\n[mesh]\ngenerate = \"cube\"\nside = 0.03\nnodes_per_side = 5\n"
                           "[material]\nyoung = {}\npoisson = 0.45\nstiffening = {{ curve = \"press.csv\", {} }}\n"
                           "[[fixed]]\nbelow = 1e-9\n",
                           young_pa, more));
    return read_scene(file);
}

// A record F = 50 d (1 + d / 5 mm) to 5 mm.
TEST_F(PrecomputeRun, ARecordsDentHasItsCurveAtItsDepth) {
    const fs::path folder = temporary_.path();
    const auto press = [&](double n_per_m) {
        std::string text = "# of a test\ndepth_m,force_n\n";
        for (int k = 1; k <= 10; ++k) {
            const double d = 5e-4 * k;
            text += fmt::format("{},{}\n", d, n_per_m * d * (1.0 + d / 5e-3));
        }
        write_file(folder / "press.csv", text);
    };
    double young = 1e4;
    const auto pressed = [&](const char* at) { return run(pressed_scene(folder, at, young)); };
    const char* const kMiddle = "at = [0.015, 0.015, 0.03]";
    press(50.0);
    pressed(kMiddle);
    const StiffeningCurve curve = read_tables(out_).stiffening;
    EXPECT_NEAR(curve.c[0], 1.0, 1e-6);
    const auto record = told().at("stiffening").at("press");
    EXPECT_NEAR(curve.energy_j, 0.5 * record.at("scene_stiffness_n_per_m").get<double>() * 5e-3 * 5e-3,
                1e-9 * curve.energy_j);
    EXPECT_NEAR(record.at("stiffness_n_per_m"), 50.0, 1e-6);
    // Young's modulus that the warning gives makes the small dent the record's, and warns no more.
    const std::string warning = told().at("warnings").back();
    const auto at = warning.find("young = ");
    ASSERT_NE(at, std::string::npos) << warning;
    young = std::stod(warning.substr(at + 8));
    EXPECT_NEAR(pressed(kMiddle).summary.stiffening->pressed->stiffness_n_per_m, 50.0, 0.025)
        << "young has four digits";
    EXPECT_EQ(told().at("warnings").dump().find("young = "), std::string::npos) << told().at("warnings");
    // Another record, another place's mask: made again; the same record: not.
    EXPECT_TRUE(pressed(kMiddle).unchanged);
    press(51.0);
    const Result again = pressed(kMiddle), wide = pressed("at = [0.015, 0.015, 0.03], radius = 0.012");
    EXPECT_FALSE(again.unchanged || wide.unchanged);
    EXPECT_GT(wide.summary.stiffening->pressed->stiffness_n_per_m,
              1.5 * again.summary.stiffening->pressed->stiffness_n_per_m)
        << "12 mm, not a node";
    EXPECT_TRUE(
        test::fails_with([&] { pressed("at = [0.015, 0.015, 0.06]"); },
                         "pressed.toml: material.stiffening.at: [0.015, 0.015, 0.06] is 0.03 m from the touch"));
    write_file(folder / "press.csv", "depth_m,force_n\n0.001,0.1\n0.002,x\n");
    EXPECT_TRUE(test::fails_with([&] { pressed(kMiddle); }, "press.csv:3: force_n holds what is no number"));
}

// What the simulated device and the page read, though no table follows it.
TEST_F(PrecomputeRun, OptionsThatChangeNoTableAreWrittenAnew) {
    const auto mass = [&] { return told("options.json").at("device").at("mass").at(0); };
    Scene scene = cube_scene();
    run(scene);
    const auto hash = told().at("model_hash");
    EXPECT_EQ(mass(), scene.device.mass_kg[0]);
    scene.device.mass_kg[0] = 0.2;
    run(scene);
    EXPECT_EQ(mass(), 0.2);
    EXPECT_EQ(told().at("model_hash"), hash);
    EXPECT_EQ(told().at("reused"), true) << "nothing is solved for it";
    scene.contact.static_friction = scene.contact.kinetic_friction = 0.3;
    run(scene);
    EXPECT_NE(told().at("model_hash"), hash);
}

TEST(PrecomputeHash, IsOfTheContentOnly) {
    using Hashes = std::pair<std::uint64_t, std::uint64_t>;  // of the model; of the body
    const auto hash = [](const Scene& scene) -> Hashes {
        const Body body = make_body(scene, make_mesh(scene.mesh));
        return {hash_model(scene, body), hash_body(scene, body)};
    };
    const Hashes base = hash(cube_scene());
    Scene same = cube_scene();
    same.name = "other";
    same.file = "elsewhere/other.toml";
    same.fixed.push_back(same.fixed.front());  // the same nodes, said twice
    EXPECT_EQ(hash(same), base);

    constexpr std::size_t kBodies = 18, kAll = 22;
    std::vector<Scene> other(kAll, cube_scene());
    other[0].material.young_pa *= 2.0;
    other[1].material.poisson = 0.3;
    other[2].mesh.side_m = 0.031;
    other[3].mesh.nodes_per_side = 6;
    other[4].fixed[0].box_m = {-1, -1, -1, 1, 1, 0.008};
    other[5].membranes = {{kTop, 1e-3, 1e5, 0.3}};
    other[6].membranes = {{kTop, 2e-3, 1e5, 0.3}};
    other[7].beds = {{kTop, 1e5, 0.0}};
    other[8].gravity = Gravity{1000.0, {0, 0, -9.81}, false};
    other[9].gravity = Gravity{1000.0, {0, 0, -9.81}, true};
    for (std::size_t i : {10U, 11U, 12U}) {
        other[i].material = like({{5e4, 1e4, 4e3}, {0.4, 0.3, 0.25}, {6e3, i == 10 ? 5e3 : 5.05e3, 2e3}});
        other[i].material.orthotropic->axes.direction = {{{1, 0, 0}, {0, 1, i == 12 ? 0.1 : 0.0}}};
    }
    other[13].beds = {{kTop, 1e5, 2e5}};
    const Selection half = box({-1, -1, -1, 1, 1, 0.015});
    for (std::size_t i : {14U, 15U}) other[i].regions = {{half, {i == 14 ? 2e4 : 3e4, 0.3}}};
    for (std::size_t i : {16U, 17U}) {  // of one weight and of two
        other[i].regions = {{half, {2e4, 0.3}, i == 16 ? 1000.0 : 900.0}};
        other[i].gravity = other[9].gravity;
    }
    // Of the same body:
    other[18].touch = {box({-1, -1, 0.01, 1, 1, 1})};
    other[19].contact.rigid_stiffness_n_per_m = 500.0;
    other[20].device.max_force_n = 3.0;
    other[21].tables.columns = ColumnRows::kNone;
    std::set<std::uint64_t> models{base.first}, bodies{base.second};
    for (std::size_t i = 0; i < kAll; ++i) {
        models.insert(hash(other[i]).first);
        if (i < kBodies) bodies.insert(hash(other[i]).second);
    }
    EXPECT_EQ(models.size(), kAll + 1);
    EXPECT_EQ(bodies.size(), kBodies + 1);
}

TEST_F(PrecomputeRun, UnchangedTablesAreNotComputedAgain) {
    Scene scene = cube_scene(3);
    EXPECT_FALSE(run(scene, {.code = false}).unchanged);
    EXPECT_TRUE(run(scene, {.code = false}).unchanged);
    EXPECT_FALSE(run(scene).unchanged) << "they are not there as C";
    EXPECT_TRUE(fs::exists(out_ / "model.c"));
    const auto before = contents(out_);
    EXPECT_TRUE(run(scene).unchanged);
    EXPECT_TRUE(contents(out_) == before);
    EXPECT_FALSE(run(scene, {.force = true}).unchanged);
    EXPECT_FALSE(run(scene, {.tolerance = 1e-4}).unchanged);
    EXPECT_FALSE(run(scene).unchanged) << "another tolerance";
    scene.material.poisson = 0.3;
    EXPECT_FALSE(run(scene).unchanged);
    fs::resize_file(out_ / "columns.npy", 100);
    EXPECT_FALSE(run(scene).unchanged) << "a damaged file";
    std::string text = read_file(out_ / "stiffness.npy");
    text[200] ^= 1;
    write_file(out_ / "stiffness.npy", text);
    EXPECT_FALSE(run(scene).unchanged) << "a file that was changed without a change of its size";
    text = read_file(out_ / "tables.json");
    text[text.find("\"tables_hash\": \"") + 16] ^= 1;
    write_file(out_ / "tables.json", text);
    EXPECT_FALSE(run(scene).unchanged) << "a changed tables.json";
    fs::remove(out_ / "model.c");
    EXPECT_FALSE(run(scene).unchanged) << "a missing file";
    EXPECT_TRUE(run(scene).unchanged);
}

TEST_F(PrecomputeRun, ALargerTouchRegionComputesOnlyWhatIsNew) {
    for (double tolerance : {0.0, 1e-5}) {  // columns in double, in float
        const PrecomputeOptions options{.column_tolerance = tolerance, .force = false};
        Scene scene = cube_scene(9);
        scene.touch = {kTop};  // 81 nodes
        fs::remove_all(out_);
        run(scene, options);
        scene.touch.push_back(kSide);  // 63 more
        fs::remove_all(fresh_);
        const Summary larger = run(scene, options).summary, fresh = run_into(fresh_, scene, options).summary;
        EXPECT_EQ(larger.reused.blocks, 81U);
        EXPECT_EQ(larger.reused.columns, 81U);
        EXPECT_FALSE(larger.reused.all);
        EXPECT_LT(larger.inverse.blocks.flops, fresh.inverse.blocks.flops);
        EXPECT_LT(larger.inverse.columns.facts.flops_done, 0.5 * fresh.inverse.columns.facts.flops_done);
        EXPECT_TRUE(but_columns(out_) == but_columns(fresh_)) << "blocks to the last bit";
        const test::Bound bound{.count = tolerance > 0.0 ? kSolved : kStored, .epsilon = test::kFloat};
        EXPECT_WITHIN(column_distance(out_, fresh_), bound);
        EXPECT_WITHIN(larger.inverse.checks.largest_column_difference, bound);
        // L_ij = L_ji^T, whoever of the two was there before.
        const Tables tables = read_tables(out_);
        const auto columns = blocks_of<float>(out_ / "columns.npy");
        const auto block = [&](std::size_t row, std::size_t column) {
            const auto& id = tables.row_id;
            const auto at = std::lower_bound(id.begin(), id.end(), tables.node_id[row]) - id.begin();
            return columns[id.size() * column + std::size_t(at)];
        };
        const double scale = block(0, 0).maxCoeff();
        for (std::size_t i = 0; i < tables.node_id.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                ASSERT_WITHIN((block(i, j) - block(j, i).transpose()).cwiseAbs().maxCoeff() / scale, bound);
    }
}

TEST_F(PrecomputeRun, WhatHoldsOfBlocksAndColumnsIsJudgedApart) {
    Scene scene = cube_scene();
    PrecomputeOptions options;
    const auto expect_reused = [&](std::size_t blocks, std::size_t columns, const char* why, bool all = false) {
        const Summary summary = run(scene, options).summary;
        EXPECT_WITHIN(summary.inverse.checks.largest_block_difference, .count = kSolved, .epsilon = test::kFloat);
        EXPECT_EQ(summary.reused.blocks, blocks) << why;
        EXPECT_EQ(summary.reused.columns, columns) << why;
        EXPECT_EQ(summary.reused.all, all) << why;
    };
    const auto expect_as_fresh = [&](bool to_the_last_bit) {
        run_into(fresh_, scene);
        EXPECT_TRUE(but_columns(out_) == but_columns(fresh_));
        if (to_the_last_bit)
            EXPECT_TRUE(read_file(out_ / "columns.npy") == read_file(fresh_ / "columns.npy"));
        else
            EXPECT_WITHIN(column_distance(out_, fresh_), .count = kSolved, .epsilon = test::kFloat);
    };
    expect_reused(0, 0, "the first");
    scene.tables.column_precision = Storage::kFloat16;
    expect_reused(73, 73, "rounded", true);
    expect_as_fresh(true);
    scene.tables.column_precision = Storage::kFloat32;
    expect_reused(73, 0, "float16 has lost digits");
    expect_as_fresh(true);
    scene.touch = {kTop};
    scene.device.max_force_n = 3.0;
    expect_reused(25, 25, "a part of the surface", true);
    expect_as_fresh(false);
    scene.touch.clear();
    expect_reused(25, 25, "more nodes than there are blocks of");
    scene.tables.columns = ColumnRows::kAll;
    expect_reused(73, 0, "rows that no column has");
    scene.tables.columns = ColumnRows::kSurface;
    expect_reused(73, 73, "fewer rows", true);
    expect_as_fresh(false);
    options.tolerance = 1e-4;
    expect_reused(0, 73, "another tolerance of blocks");
    options.column_tolerance = 1e-4;
    expect_reused(73, 0, "another tolerance of columns");
    scene.contact.force = ForceLaw::kConsistent;
    expect_reused(0, 73, "edges need the inversion, and the rest comes with them");
    scene.contact.force = ForceLaw::kInterpolated;
    scene.tables.column_budget_bytes = 1000.0;
    expect_reused(73, 0, "the viewer's factor must be made");
    EXPECT_TRUE(fs::exists(out_ / "factor_value.npy"));
    scene.contact.rigid_stiffness_n_per_m = 500.0;
    expect_reused(73, 0, "the factor is kept", true);
    EXPECT_TRUE(fs::exists(out_ / "factor_value.npy"));
    scene.tables.column_budget_bytes = 1e9;
    expect_reused(73, 0, "columns again");
    EXPECT_TRUE(fs::exists(out_ / "columns.npy") && !fs::exists(out_ / "factor_value.npy"));
    scene.tables.columns = ColumnRows::kNone;
    expect_reused(73, 0, "no columns", true);
    scene.material.poisson = 0.3;
    expect_reused(0, 0, "another material");
    options.force = true;
    expect_reused(0, 0, "by force");
}

TEST_F(PrecomputeRun, TheNumberOfThreadsChangesNoBit) {
    for (const auto& [element, force] : {std::pair(Element::kLinear, ForceLaw::kInterpolated),
                                         {Element::kLinear, ForceLaw::kPressureMask},
                                         {Element::kAverageNodalPressure, ForceLaw::kConsistent}}) {
        Scene scene = cube_scene(12);
        scene.mesh.element = element;
        scene.contact.force = force;
        scene.contact.mask_radius_m = force == ForceLaw::kPressureMask ? 0.006 : 0.0;
        std::map<std::string, std::string> first;
        for (int threads : {1, 2, 5}) {
            EXPECT_EQ(run(scene, {.force = true, .threads = threads}).summary.inverse.factor.threads, threads);
            auto files = but_columns(out_);
            files["columns.npy"] = read_file(out_ / "columns.npy");
            if (first.empty()) first = files;
            EXPECT_TRUE(files == first) << threads << " with " << force << ", " << element;
        }
    }
}

TEST_F(PrecomputeRun, ColumnsInHalfPrecisionAreRoundedOnly) {
    for (double young : {1e-2, 1e4, 1e11}) {
        Scene scene = cube_scene();
        scene.material.young_pa = young;
        run(scene);
        const Array<float> single = read_npy<float>(out_ / "columns.npy");
        scene.tables.column_precision = Storage::kFloat16;
        run(scene);
        const Tables tables = read_tables(out_);
        ASSERT_TRUE(tables.half_columns);
        const MappedNpy<Half> half(out_ / "columns.npy");
        ASSERT_EQ(half.shape(), single.shape);
        float largest = 0.0F;
        for (float value : single.values) largest = std::max(largest, std::abs(value));
        // Numbers of fewer digits, not errors that add up: half a unit in the last place, of 2^-24 of the unit below
        // the least normal number.
        for (std::size_t i = 0; i < single.values.size(); ++i)
            ASSERT_LE(std::abs(to_float(half.values()[i]) * float(tables.column_unit_m_per_n) - single.values[i]),
                      0x1p-11F * std::abs(single.values[i]) + 0x1p-24F * largest);
    }
}

TEST_F(PrecomputeRun, TooManyPatchesAreRefusedBeforeTheFactorisation) {
    Scene scene = cube_scene(76);  // 67,500 patches: minutes of work, if it began
    scene.tables.columns = ColumnRows::kNone;
    const std::string said = test::error_of([&] { run(scene); });
    EXPECT_EQ(said.rfind("cube.toml: the touchable surface has 6", 0), 0U) << said;
    EXPECT_EQ(said.find("partial"), std::string::npos) << said;
}

/// In float every other block is off by this share.
class Spoiled : public CholmodInverse {
public:
    explicit Spoiled(double share) : share_(share) {}
    Blocks blocks(std::span<const NodePair> wanted, Precision precision, Progress& progress) override {
        Blocks found = CholmodInverse::blocks(wanted, precision, progress);
        if (precision == Precision::kFloat)
            for (std::size_t i = 0; i < found.l_ij.size(); i += 2) found.l_ij[i] *= 1.0 + share_;
        return found;
    }

private:
    double share_;
};

TEST_F(PrecomputeRun, FloatIsTakenWhereTheToleranceAllowsItAndItKeepsIt) {
    const test::DenseReference dense = reference_of(cube_scene());
    for (const auto& [tolerance, share, precision] :
         {std::tuple{0.0, 0.0, Precision::kDouble},
          {2e-6, 0.0, Precision::kDouble},  // the condition of its blocks is above 2
          {1e-4, 0.0, Precision::kFloat},
          {1e-4, 1e-5, Precision::kDouble},
          {1e-4, 1e-3, Precision::kDouble}}) {
        SCOPED_TRACE(testing::Message() << tolerance << ", " << share);
        Spoiled inverse(share);
        const Result result = run(cube_scene(), {.tolerance = tolerance, .force = true, .inverse = &inverse});
        EXPECT_EQ(result.summary.inverse.blocks.precision, precision);
        EXPECT_WITHIN(result.summary.inverse.checks.largest_block_difference, .count = kSolved,
                      .epsilon = test::kFloat);
        if (precision == Precision::kDouble) continue;
        const auto stiffness = blocks_of<double>(out_ / "stiffness.npy");
        double largest = 0.0;
        for (std::size_t i = 0; i < stiffness.size(); ++i) {
            const std::int32_t at = result.body.unknown[std::size_t(result.body.touch_node[i])];
            const Eigen::Matrix3d s = dense.block(at, at).inverse();
            largest = std::max(largest, (stiffness[i] - s).norm() / s.norm());
        }
        EXPECT_WITHIN(largest, .epsilon = 1e-4);
        EXPECT_GT(largest, 1e-9) << "this was not computed in float";
    }
}

TEST_F(PrecomputeRun, TooLittleMemoryIsAnErrorBeforeTheFactorisation) {
    const double need = run(cube_scene()).summary.memory.peak();
    EXPECT_NO_THROW(run(cube_scene(), {.force = true, .memory_bytes = 1.01 * need}));
    const std::string said = test::error_of([&] { run(cube_scene(), {.force = true, .memory_bytes = 0.5 * need}); });
    EXPECT_TRUE(test::says(said, "cube.toml: needs "));
    EXPECT_TRUE(test::says(said, "mesh of about"));
}

TEST(PrecomputeBody, ATouchRegionLimitsPatchesAndNodes) {
    Scene scene = cube_scene();
    scene.touch = {kTop, kSide};
    const Body body = make_body(scene, make_mesh(scene.mesh));
    EXPECT_EQ(body.touch_patch.size(), 64U + 2U) << "a patch at either end of their edge has its nodes on both sides";
    EXPECT_EQ(body.touch_node.size(), 25U + 25U - 5U - 5U) << "two sides, an edge in common, an edge held";
    EXPECT_TRUE(std::is_sorted(body.touch_node.begin(), body.touch_node.end()));
    for (std::int32_t node : body.touch_node) EXPECT_FALSE(body.is_fixed(node));
}

TEST(PrecomputeBody, MouseHasThePapersCounts) {
    const Scene scene = read_scene("meshes/mouse.toml");
    const Body body = make_body(scene, make_mesh(scene.mesh));
    EXPECT_TRUE(body.mesh.notes.empty());
    EXPECT_EQ(body.mesh.position_m.size(), 1713U);
    EXPECT_EQ(body.mesh.tet.size(), 6312U);
    EXPECT_EQ(body.surface.node.size(), 1175U);
    EXPECT_EQ(body.surface.patch.size(), 2346U);
    EXPECT_EQ(body.fixed_count(), 139U);
    EXPECT_EQ(body.free_surface_node.size(), 1036U);
    EXPECT_EQ(body.touch_patch.size(), 2346U);
}

TEST_F(PrecomputeRun, AMistakeIsOneLineAndLeavesTheOldTables) {
    const std::array<double, 6> nowhere{5, 5, 5, 6, 6, 6}, everywhere{-1, -1, -1, 1, 1, 1}, edge{0, 0, 0, 0, 0, 1},
        corner{-1, -1, -1, 1, 1e-9, 1e-9}, middle{-1, -1, 0.0145, 1, 1, 0.0155};
    const Selection pads{{}, "pads", 12};
    const Region all{box(everywhere, 12), {5e4, 0.0}}, none{box(nowhere, 12), {5e4, 0.0}}, named{pads, {5e4, 0.0}};
    const Bed inside{box(middle, 12), 1.0, 1.0}, away{box(nowhere, 12), 1.0, 1.0};
    const std::pair<std::function<void(Scene&)>, const char*> mistakes[] = {
        {[&](Scene& s) { s.fixed[0].box_m = corner; }, "24 of 27 nodes are under-constrained"},
        {[&](Scene& s) { s.fixed[0].box_m = nowhere; }, "cube.toml:9: fixed.box: no node lies in it"},
        {[&](Scene& s) { s.fixed[0] = pads; }, "cube.toml:12: fixed.group: "},
        {[&](Scene& s) { s.fixed[0].box_m = everywhere; }, "are fixed"},
        {[&](Scene& s) { s.touch = {box(nowhere, 12)}; }, "cube.toml:12: touch.box: no node lies in it"},
        {[&](Scene& s) { s.touch = {box(edge, 12)}; }, "cube.toml:12: touch: the region is empty"},
        {[&](Scene& s) { s.regions.assign(2, all); }, "is in the region of line 12 too"},
        {[&](Scene& s) { s.regions = {none}; }, "cube.toml:12: region.box: no tetrahedron has its centre in it"},
        {[&](Scene& s) { s.regions = {named}; }, "cube.toml:12: region.group: the mesh has no tetrahedra"},
        {[&](Scene& s) { s.beds = {inside}; }, "cube.toml:12: bed: no face of the surface has all its nodes in it"},
        {[&](Scene& s) { s.beds = {away}; }, "cube.toml:12: bed.box: no node lies in it"},
        {[](Scene& s) { s.mesh.side_m = 1e9; }, "give the right mesh.side"}};
    run(cube_scene(3));
    const auto before = contents(out_);
    for (const auto& [make, part] : mistakes) {
        Scene scene = cube_scene(3);
        make(scene);
        const std::string said = test::error_of([&] { run(scene); });
        EXPECT_TRUE(test::says(said, part));
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
        EXPECT_TRUE(before == contents(out_)) << "the tables of before must stay: " << part;
        EXPECT_EQ(contents(temporary_.path()).size(), 1U) << "something was left beside the folder: " << part;
    }
}

TEST_F(PrecomputeRun, ASecondRunIntoTheFolderIsToldWhoIsWritingIt) {
    Scene scene = cube_scene(3);
    run(scene);
    const auto before = contents(out_);
    {
        const OwnFolder first(out_, kTables);
        EXPECT_TRUE(run(scene).unchanged) << "only reads";
        scene.material.poisson = 0.3;
        const std::string said = test::error_of([&] { run(scene); });
        const std::string holder = "out: process " + std::to_string(getpid()) + " is writing it";
        EXPECT_TRUE(test::says(said, holder));
        EXPECT_NO_THROW(run_into(temporary_.path() / "other", scene));
    }
    EXPECT_TRUE(contents(out_) == before);
    EXPECT_FALSE(run(scene).unchanged);
}

// Those of earlier tables go, and of runs that were killed; others stay (BaseOwnFolder; test_files_of_others_stay).
TEST_F(PrecomputeRun, OnlyItsOwnFilesAreWrittenAndRemoved) {
    Scene scene = cube_scene(3);
    const fs::path beside = temporary_.path() / "out.columns", in_it = out_ / "display.c";
    write_file(beside, "the user's");
    run(scene);
    write_file(in_it, "the user's");
    fs::create_directories(out_ / "tables.haptable-999999999" / "half");
    scene.tables.columns = ColumnRows::kNone;
    run(scene);
    for (const char* gone : {"columns.npy", "row_id.npy", "tables.haptable-999999999"})
        EXPECT_FALSE(fs::exists(out_ / gone)) << gone;
    for (const fs::path& kept : {beside, in_it}) EXPECT_EQ(read_file(kept), "the user's") << kept;
}

TEST_F(PrecomputeRun, AFileOfItsNameThatIsNotOursStopsIt) {
    write_file(out_, "a file");
    EXPECT_THROW(run(cube_scene(3)), Error);
    EXPECT_EQ(read_file(out_), "a file");
}

TEST_F(PrecomputeRun, TablesWithoutAMarkAreKnownByTheirHashes) {
    Scene scene = cube_scene(3);
    run(scene);
    fs::remove(out_ / ".haptable");
    const auto before = contents(out_);
    scene.material.poisson = 0.3;
    write_file(out_ / "model.c", "the user's");
    EXPECT_THROW(run(scene), Error);
    EXPECT_EQ(read_file(out_ / "model.c"), "the user's");
    write_file(out_ / "model.c", before.at("model.c"));
    EXPECT_FALSE(run(scene).unchanged);
    EXPECT_TRUE(fs::exists(out_ / ".haptable"));
}

}  // namespace
}  // namespace haptable
