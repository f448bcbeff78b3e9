// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/precompute.hpp"
#include "host/base/json.hpp"
#include "host/body/assembly.hpp"
#include "host/precompute/facts.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Dense>
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
#include "tests/conditioning.hpp"
#include "tests/dense.hpp"
#include "tests/error_of.hpp"
#include "tests/host/body/cubes.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Matrix = Eigen::MatrixXd;

/// The paper's cube, its bottom fixed.
Scene cube_scene(int nodes_per_side = 5, double side_m = 0.03) {
    Scene scene = test::cube_of("cube", nodes_per_side, {1e4, 0.49});
    scene.mesh.side_m = side_m;
    scene.fixed.push_back({std::array<double, 6>{-1e4, -1e4, -1e4, 1e4, 1e4, 1e-9 * side_m}, "", 9});
    return scene;
}

Result run(const Scene& scene, const fs::path& folder, double column_tolerance = PrecomputeOptions().column_tolerance) {
    Progress progress(true);
    PrecomputeOptions options;
    options.column_tolerance = column_tolerance;
    return precompute(scene, folder, progress, options);
}

/// Without the mark.
std::map<std::string, std::string> contents(const fs::path& folder) {
    std::map<std::string, std::string> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        if (entry.path().filename() != ".haptable")
            files[entry.path().filename()] = entry.is_directory() ? "" : read_file(entry.path());
    return files;
}

constexpr double kStored = 8.0;                       // one rounding to float32, in either of two columns from double
const double kSolved = 8.0 * std::sqrt(3.0 * 648.0);  // of float32 in an inversion or solves of up to 648 nodes

Eigen::Matrix3d block(const std::array<double, 9>& row) {
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(row.data());
}

/// L = K^-1 over all nodes (zero for the held ones), by the textbook's B^T D B and a dense inverse: shares no code
/// with the assembly, the factorisation or the solves.
Matrix dense_compliance(const Body& body, const Material& material) {
    const double young = material.young_pa, nu = material.poisson;
    Eigen::Matrix<double, 6, 6> elastic = Eigen::Matrix<double, 6, 6>::Zero();
    elastic.topLeftCorner<3, 3>().setConstant(nu);
    elastic.diagonal() << Eigen::Vector3d::Constant(1.0 - nu), Eigen::Vector3d::Constant(0.5 - nu);
    elastic *= young / ((1.0 + nu) * (1.0 - 2.0 * nu));
    const auto n = static_cast<Eigen::Index>(body.mesh.position_m.size());
    Matrix k = Matrix::Zero(3 * n, 3 * n);
    for (const Tet& tet : body.mesh.tet) {
        Eigen::Matrix4d a;
        for (int c = 0; c < 4; ++c)
            a.row(c) << 1.0,
                body.mesh.position_m[static_cast<std::size_t>(tet[static_cast<std::size_t>(c)])].transpose();
        const Eigen::Matrix4d shape = a.inverse();
        Eigen::Matrix<double, 6, 12> b = Eigen::Matrix<double, 6, 12>::Zero();
        std::vector<Eigen::Index> rows;
        for (int c = 0; c < 4; ++c) {
            const double x = shape(1, c), y = shape(2, c), z = shape(3, c);
            b.block<6, 3>(0, 3 * c) << x, 0, 0, 0, y, 0, 0, 0, z, y, x, 0, 0, z, y, z, 0, x;
            for (int d = 0; d < 3; ++d) rows.push_back(3 * tet[static_cast<std::size_t>(c)] + d);
        }
        const Eigen::Matrix<double, 12, 12> element = std::abs(a.determinant()) / 6.0 * b.transpose() * elastic * b;
        k(rows, rows) += element;
    }
    std::vector<Eigen::Index> free;
    for (std::int32_t node : body.free_node)
        for (int d = 0; d < 3; ++d) free.push_back(3 * node + d);
    Matrix l = Matrix::Zero(3 * n, 3 * n);
    l(free, free) = dense::inverse(k(free, free));
    return l;
}

/// What two folders hold besides the summary and columns.npy.
bool same_but_columns(const fs::path& a, const fs::path& b) {
    auto one = contents(a), other = contents(b);
    for (auto* files : {&one, &other})
        for (const char* file : {"summary.json", "tables.json", "columns.npy"}) files->erase(file);
    return one == other;
}

/// Largest difference of two columns.npy, as a share of the largest entry.
double column_distance(const fs::path& a, const fs::path& b) {
    const Array<float> one = read_npy<float>(a / "columns.npy"), other = read_npy<float>(b / "columns.npy");
    EXPECT_EQ(one.shape, other.shape);
    double largest = 0.0, difference = 0.0;
    for (std::size_t i = 0; i < std::min(one.values.size(), other.values.size()); ++i) {
        largest = std::max(largest, std::abs(static_cast<double>(one.values[i])));
        difference = std::max(difference, std::abs(static_cast<double>(one.values[i] - other.values[i])));
    }
    return difference / largest;
}

class PrecomputeRun : public testing::Test {
protected:
    const test::TemporaryFolder temporary_;
    const fs::path out_ = temporary_.path() / "out";
};

TEST_F(PrecomputeRun, StiffnessIsTheInverseOfADenseInversesBlocks) {
    for (double poisson : {0.3, 0.49}) {
        Scene scene = cube_scene();
        scene.material.poisson = poisson;
        const Result result = run(scene, out_);
        const Matrix l = dense_compliance(result.body, scene.material);
        const test::Bound bound = test::inverse_bound(assemble_free(scene, result.body));
        const Tables tables = read_tables(out_);
        ASSERT_EQ(tables.node_id.size(), 73U);
        for (std::size_t i = 0; i < tables.node_id.size(); ++i) {
            const Eigen::Matrix3d l_ii = l.block<3, 3>(3 * tables.node_id[i], 3 * tables.node_id[i]);
            const Eigen::Matrix3d s = block(tables.stiffness[i]);
            const double condition = l_ii.norm() * s.norm();
            EXPECT_WITHIN((s.inverse() - l_ii).norm() / l_ii.norm(), bound.times(condition));
            EXPECT_WITHIN((s - l_ii.inverse()).norm() / s.norm(), bound.times(condition));
        }
    }
}

TEST_F(PrecomputeRun, ColumnsInDoubleAreThoseOfADenseInverse) {
    for (const ColumnRows columns : {ColumnRows::kSurface, ColumnRows::kAll}) {
        Scene scene = cube_scene(4);
        scene.tables.columns = columns;
        const Result result = run(scene, out_, 0.0);
        EXPECT_EQ(result.summary.inverse.columns.facts.precision, Precision::kDouble);
        const Matrix l = dense_compliance(result.body, scene.material);
        const Tables tables = read_tables(out_);
        const MappedNpy<float> file(out_ / "columns.npy");
        const std::size_t n = tables.node_id.size(), r = tables.row_id.size();
        ASSERT_EQ(file.shape(), (std::vector<std::size_t>{n, r, 3, 3}));
        EXPECT_EQ(tables.row_id, columns == ColumnRows::kAll ? result.body.free_node : result.body.free_surface_node);
        const double largest = l.cwiseAbs().maxCoeff();
        std::size_t at = 0;
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t k = 0; k < r; ++k)
                for (int a = 0; a < 3; ++a)
                    for (int b = 0; b < 3; ++b) {
                        const double expected = l(3 * tables.row_id[k] + a, 3 * tables.node_id[i] + b);
                        const double error = std::abs(static_cast<double>(file.values()[at++]) - expected);
                        ASSERT_WITHIN(error, .count = kStored, .epsilon = test::kFloat, .size = largest);
                    }
    }
}

TEST_F(PrecomputeRun, ColumnsInFloatAreWithinTheirToleranceOfADenseInverse) {
    struct Case {
        double poisson, tolerance;
        Precision precision;
    };
    // The factor is in double: nu near 0.5 costs the columns no digits.
    for (const Case& c : {Case{0.3, 1e-5, Precision::kFloat}, Case{0.4999, 1e-5, Precision::kFloat},
                          Case{0.49, 1e-7, Precision::kDouble}}) {
        Scene scene = cube_scene();
        scene.material.poisson = c.poisson;
        const ColumnSummary columns = run(scene, out_, c.tolerance).summary.inverse.columns;
        EXPECT_EQ(columns.facts.precision, c.precision) << c.poisson;
        EXPECT_GT(columns.float_error, 5e-8) << "this was not computed in float";
        const Matrix l = dense_compliance(make_body(scene, make_mesh(scene.mesh)), scene.material);
        const Tables tables = read_tables(out_);
        const MappedNpy<float> file(out_ / "columns.npy");
        const std::size_t rows = tables.row_id.size();
        for (std::size_t i = 0; i < tables.node_id.size(); ++i) {
            double squared = 0.0, norm = 0.0;
            for (std::size_t e = 0; e < 9 * rows; ++e) {
                const double exact = l(3 * tables.row_id[e / 9] + static_cast<int>(e % 9 / 3),
                                       3 * tables.node_id[i] + static_cast<int>(e % 3));
                squared += std::pow(static_cast<double>(file.values()[9 * rows * i + e]) - exact, 2);
                norm += exact * exact;
            }
            ASSERT_WITHIN(std::sqrt(squared / norm), .epsilon = c.tolerance);
        }
    }
}

TEST_F(PrecomputeRun, ChecksAreMeasuredAndKept) {
    const Result result = run(cube_scene(), out_, 0.0);
    const Checks& checks = result.summary.inverse.checks;
    const test::Bound bound = test::inverse_bound(assemble_free(cube_scene(), result.body));
    EXPECT_WITHIN(checks.largest_residual, bound);  // of unit loads
    EXPECT_GT(checks.largest_residual, 0.0);
    EXPECT_WITHIN(checks.largest_asymmetry, bound);
    EXPECT_WITHIN(checks.largest_block_difference, bound);
    EXPECT_WITHIN(checks.largest_column_difference, .count = kStored, .epsilon = test::kFloat);
    EXPECT_GT(checks.largest_column_difference, 1e-9) << "columns.npy is float32";
    EXPECT_GT(checks.smallest_eigenvalue_m_per_n, 0.0);
    const Matrix l = dense_compliance(result.body, {1e4, 0.49});
    const Eigen::VectorXd eigenvalue = dense::eigenvalues(l);
    const Eigen::Index held = 3 * static_cast<Eigen::Index>(result.body.fixed_count());
    const double exact = eigenvalue[eigenvalue.size() - 1] / eigenvalue[held];
    // Lanczos's method stops where neither of the two eigenvalues moves by more than 1 %.
    EXPECT_WITHIN(std::abs(checks.condition_estimate / exact - 1.0), .count = 6, .epsilon = 0.01);

    const nlohmann::json json = parse_json(read_file(out_ / "summary.json"));
    EXPECT_EQ(json.at("checks").at("largest_residual"), checks.largest_residual);
    EXPECT_EQ(json.at("blas_kernels"), blas_kernels());
    EXPECT_EQ(json.at("counts").at("free_surface_nodes"), 73);
    EXPECT_EQ(json.at("counts").at("touchable_patches"), 192);
    for (const auto& [file, bytes] : json.at("bytes").items()) EXPECT_EQ(bytes, fs::file_size(out_ / file)) << file;
    EXPECT_EQ(json.at("bytes").size() + 2, contents(out_).size()) << "every file but the two that tell of them";
    for (const char* stage : {"mesh", "assembly", "factor", "blocks", "columns", "check", "write", "codegen"})
        EXPECT_GE(json.at("time_s").at(stage).get<double>(), 0.0);
}

TEST_F(PrecomputeRun, TheDepthOfSmallStrainIsToldAndKept) {
    Scene scene = cube_scene();
    const auto told = [&] {
        run(scene, out_);
        return parse_json(read_file(out_ / "summary.json")).at("small_strain");
    };
    const nlohmann::json first = told();
    EXPECT_EQ(first.at("depth_m"), first.at("pressing_m"));
    EXPECT_EQ(first.at("finger_radius_m"), 0.0);
    EXPECT_GT(first.at("depth_m"), 0.0);
    EXPECT_EQ(read_small_strain_depth(out_), first.at("depth_m").get<double>());
    scene.contact.static_friction = scene.contact.kinetic_friction = 0.3;  // of the same body: nothing is solved
    const nlohmann::json rough = told();
    EXPECT_EQ(rough.at("depth_m").get<double>(),
              std::min(first.at("pressing_m").get<double>(), first.at("sideways_m").get<double>()));
    scene.contact.force = ForceLaw::kPressureMask;
    scene.contact.mask_radius_m = 0.012;
    const nlohmann::json mask = told();
    EXPECT_EQ(mask.at("finger_radius_m"), 0.012);
    EXPECT_GT(mask.at("pressing_m"), first.at("pressing_m")) << "a finger that is wide strains less than a point";
    scene.contact.force = ForceLaw::kInterpolated;
    scene.contact.mask_radius_m = 0.0;
    EXPECT_TRUE(told().is_null()) << "blocks of an earlier run, a depth of another finger";
    EXPECT_FALSE(read_small_strain_depth(out_));
}

TEST_F(PrecomputeRun, DentsThatStiffenAreFittedToldAndHashed) {
    Scene scene = cube_scene();
    const std::uint64_t linear = run(scene, out_).summary.identity.model_hash;
    EXPECT_EQ(read_tables(out_).stiffening.energy_j, 0.0);
    EXPECT_FALSE(parse_json(read_file(out_ / "summary.json")).contains("stiffening"));
    scene.material.stiffening = Stiffening{5.0, 0.0, 0.0, {}};
    const Result result = run(scene, out_);
    const auto json = parse_json(read_file(out_ / "summary.json"));
    const nlohmann::json& told = json.at("stiffening");
    EXPECT_EQ(told.at("yeoh"), (std::vector{5.0, 0.0}));
    EXPECT_LT(told.at("fitted").at("rms"), told.at("fitted").at("linear_rms"));
    EXPECT_EQ(told.at("by_place").size(), 5U);
    for (const char* way : {"pressing", "oblique", "sideways", "pulling"})
        EXPECT_GT(told.at("by_way").at(way).at("depth_m"), 0.0) << way;
    EXPECT_TRUE(told.at("by_way").at("pressing").at("is_fitted"));
    EXPECT_FALSE(told.at("by_way").at("pulling").at("is_fitted")) << "without grab";
    EXPECT_EQ(json.at("small_strain").at("pressing_m"), result.summary.stiffening->good.pressing_m);
    const Tables tables = read_tables(out_);
    EXPECT_EQ(tables.stiffening.c, result.summary.stiffening->curve.c);
    EXPECT_EQ(tables.stiffening.energy_j, told.at("energy_j").get<double>());
    EXPECT_NE(result.summary.identity.model_hash, linear);
    EXPECT_TRUE(run(scene, out_).unchanged);
    scene.material.stiffening = Stiffening{0.0, 0.0, 5.0, {}};
    const Result fung = run(scene, out_);
    EXPECT_FALSE(fung.unchanged);
    EXPECT_NE(read_tables(out_).stiffening.c, tables.stiffening.c);
    scene.material.stiffening.reset();
    EXPECT_EQ(run(scene, out_).summary.identity.model_hash, linear);
    EXPECT_EQ(read_tables(out_).stiffening.energy_j, 0.0);
    // A curve that would pull, by a flipped sign in the file.
    scene.material.stiffening = Stiffening{5.0, 0.0, 0.0, {}};
    run(scene, out_);
    auto facts = parse_json(read_file(out_ / "tables.json"));
    facts["stiffening"]["curve"] = {0.0, 0.0, -4.0};
    write_file(out_ / "tables.json", facts.dump());
    EXPECT_NE(test::error_of([&] { (void)read_tables(out_); }).find("force does not grow with the dent"),
              std::string::npos);
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
    const auto press = [&](double n_per_m) {
        std::string text = "# of a test\ndepth_m,force_n\n";
        for (int k = 1; k <= 10; ++k) {
            const double d = 5e-4 * k;
            text += fmt::format("{},{}\n", d, n_per_m * d * (1.0 + d / 5e-3));
        }
        write_file(out_.parent_path() / "press.csv", text);
    };
    press(50.0);
    const fs::path folder = out_.parent_path();
    run(pressed_scene(folder, "at = [0.015, 0.015, 0.03]"), out_);
    const StiffeningCurve curve = read_tables(out_).stiffening;
    EXPECT_NEAR(curve.c[0], 1.0, 1e-6);
    const auto told = parse_json(read_file(out_ / "summary.json"));
    const double own = told.at("stiffening").at("press").at("scene_stiffness_n_per_m");
    EXPECT_NEAR(curve.energy_j, 0.5 * own * 5e-3 * 5e-3, 1e-9 * curve.energy_j);
    EXPECT_NEAR(told.at("stiffening").at("press").at("stiffness_n_per_m"), 50.0, 1e-6);
    // Young's modulus that the warning gives makes the small dent the record's, and warns no more.
    const std::string warning = told.at("warnings").at(told.at("warnings").size() - 1);
    const auto at = warning.find("young = ");
    ASSERT_NE(at, std::string::npos) << warning;
    const double young = std::stod(warning.substr(at + 8));
    const Result alike = run(pressed_scene(folder, "at = [0.015, 0.015, 0.03]", young), out_);
    EXPECT_NEAR(alike.summary.stiffening->pressed->stiffness_n_per_m, 50.0, 0.025) << "young has four digits";
    for (const auto& one : parse_json(read_file(out_ / "summary.json")).at("warnings"))
        EXPECT_EQ(one.get<std::string>().find("young = "), std::string::npos) << one;
    // Another record, another place's mask: made again; the same record: not.
    EXPECT_TRUE(run(pressed_scene(folder, "at = [0.015, 0.015, 0.03]", young), out_).unchanged);
    press(51.0);
    const Result again = run(pressed_scene(folder, "at = [0.015, 0.015, 0.03]", young), out_);
    EXPECT_FALSE(again.unchanged);
    const Result wide = run(pressed_scene(folder, "at = [0.015, 0.015, 0.03], radius = 0.012", young), out_);
    EXPECT_FALSE(wide.unchanged);
    EXPECT_GT(wide.summary.stiffening->pressed->stiffness_n_per_m,
              1.5 * again.summary.stiffening->pressed->stiffness_n_per_m)
        << "12 mm, not a node";
    EXPECT_NE(test::error_of([&] {
                  run(pressed_scene(folder, "at = [0.015, 0.015, 0.06]"), out_);
              }).find("pressed.toml: material.stiffening.at: [0.015, 0.015, 0.06] is 0.03 m from the touchable"),
              std::string::npos);
    write_file(folder / "press.csv", "depth_m,force_n\n0.001,0.1\n0.002,x\n");
    EXPECT_NE(test::error_of([&] {
                  pressed_scene(folder, "at = [0.015, 0.015, 0.03]");
              }).find("press.csv:3: force_n holds what is no number"),
              std::string::npos);
}

TEST_F(PrecomputeRun, HowMuchItLocksIsToldAndKept) {
    Scene scene = cube_scene();
    const auto told = [&] {
        run(scene, out_);
        return parse_json(read_file(out_ / "summary.json"));
    };
    const nlohmann::json first = told();
    EXPECT_EQ(first.at("element").at("places"), 5U);
    EXPECT_GT(first.at("element").at("expected_locking"), 0.05);
    EXPECT_NE(first.at("warnings").at(0).get<std::string>().find("a finger's pad of 0.005 m feels this mesh"),
              std::string::npos);
    scene.contact.static_friction = scene.contact.kinetic_friction = 0.3;  // of the same body: nothing is solved
    EXPECT_EQ(told().at("element"), first.at("element"));
    scene.contact.force = ForceLaw::kPressureMask;
    scene.contact.mask_radius_m = 0.012;
    EXPECT_EQ(told().at("element").at("finger_radius_m"), 0.012);
    scene.contact.force = ForceLaw::kInterpolated;
    scene.contact.mask_radius_m = 0.0;
    const nlohmann::json again = told();
    EXPECT_EQ(again.at("element").at("places"), 0U) << "blocks of an earlier run, locking of another finger: foreseen";
    EXPECT_GT(again.at("element").at("expected_locking"), 0.05);
}

// What the simulated device and the page read, though no table follows it.
TEST_F(PrecomputeRun, OptionsThatChangeNoTableAreWrittenAnew) {
    const auto told = [&](const char* file) { return parse_json(read_file(out_ / file)); };
    Scene scene = cube_scene();
    run(scene, out_);
    const auto hash = told("summary.json").at("model_hash");
    EXPECT_EQ(told("options.json").at("device").at("mass").at(0), scene.device.mass_kg[0]);
    scene.device.mass_kg[0] = 0.2;
    run(scene, out_);
    EXPECT_EQ(told("options.json").at("device").at("mass").at(0), 0.2);
    EXPECT_EQ(told("summary.json").at("model_hash"), hash);
    EXPECT_EQ(told("summary.json").at("reused"), true) << "nothing is solved for it";
    scene.contact.static_friction = scene.contact.kinetic_friction = 0.3;
    run(scene, out_);
    EXPECT_NE(told("summary.json").at("model_hash"), hash);
}

TEST_F(PrecomputeRun, TheHashIsOfTheContentOnly) {
    const auto hash = [&](const Scene& scene) { return hash_model(scene, make_body(scene, make_mesh(scene.mesh))); };
    const std::uint64_t base = hash(cube_scene());
    Scene same = cube_scene();
    same.name = "other";
    same.file = "elsewhere/other.toml";
    same.fixed.push_back(same.fixed.front());  // the same nodes, said twice
    EXPECT_EQ(hash(same), base);

    const std::vector<std::function<void(Scene&)>> changes{
        [](Scene& s) { s.material.young_pa *= 2.0; },
        [](Scene& s) { s.material.poisson = 0.3; },
        [](Scene& s) { s.mesh.side_m = 0.031; },
        [](Scene& s) { s.mesh.nodes_per_side = 6; },
        [](Scene& s) { s.fixed[0].box_m = {-1, -1, -1, 1, 1, 0.008}; },
        [](Scene& s) {
            s.touch.push_back({std::array<double, 6>{-1, -1, 0.01, 1, 1, 1}, "", 1});
        },
        [](Scene& s) { s.contact.rigid_stiffness_n_per_m = 500.0; },
        [](Scene& s) { s.device.max_force_n = 3.0; },
        [](Scene& s) { s.tables.columns = ColumnRows::kNone; }};
    std::set<std::uint64_t> hashes{base};
    for (const auto& change : changes) {
        Scene scene = cube_scene();
        change(scene);
        hashes.insert(hash(scene));
    }
    EXPECT_EQ(hashes.size(), changes.size() + 1);
}

TEST_F(PrecomputeRun, UnchangedTablesAreNotComputedAgain) {
    Scene scene = cube_scene(3);
    EXPECT_FALSE(run(scene, out_).unchanged);
    const auto before = contents(out_);
    EXPECT_TRUE(run(scene, out_).unchanged);
    EXPECT_TRUE(contents(out_) == before);
    Progress progress(true);
    PrecomputeOptions options;
    options.force = true;
    EXPECT_FALSE(precompute(scene, out_, progress, options).unchanged);
    options = {};
    options.tolerance = 1e-4;
    EXPECT_FALSE(precompute(scene, out_, progress, options).unchanged);
    EXPECT_FALSE(run(scene, out_).unchanged) << "another tolerance";
    scene.material.poisson = 0.3;
    EXPECT_FALSE(run(scene, out_).unchanged);
    fs::resize_file(out_ / "columns.npy", 100);
    EXPECT_FALSE(run(scene, out_).unchanged) << "a damaged file";
    std::string text = read_file(out_ / "stiffness.npy");
    text[200] ^= 1;
    write_file(out_ / "stiffness.npy", text);
    EXPECT_FALSE(run(scene, out_).unchanged) << "a file that was changed without a change of its size";
    fs::remove(out_ / "model.c");
    EXPECT_FALSE(run(scene, out_).unchanged) << "a missing file";
    EXPECT_TRUE(run(scene, out_).unchanged);
}

TEST_F(PrecomputeRun, AnotherTouchRegionOrPrecisionReusesBlocksAndColumns) {
    const auto tables_of = [&](const Scene& scene, const fs::path& folder, bool reused) {
        EXPECT_EQ(run(scene, folder).summary.reused.all, reused);
        auto files = contents(folder);
        for (const char* report : {"summary.json", "tables.json"}) files.erase(report);
        files.erase("columns.npy");  // solved for in other groups: compared by value
        return files;
    };
    Scene scene = cube_scene();
    EXPECT_FALSE(run(scene, out_).summary.reused.all);
    scene.touch.push_back({std::array<double, 6>{-1, -1, 0.0299, 1, 1, 1}, "", 1});  // the top
    scene.device.max_force_n = 3.0;
    const auto fresh = tables_of(scene, temporary_.path() / "fresh", false);
    EXPECT_TRUE(tables_of(scene, out_, true) == fresh);
    EXPECT_WITHIN(column_distance(out_, temporary_.path() / "fresh"), .count = kSolved, .epsilon = test::kFloat);
    scene.touch.clear();
    EXPECT_FALSE(run(scene, out_).summary.reused.all) << "more nodes than there are blocks of";
    scene.tables.columns = ColumnRows::kNone;
    EXPECT_TRUE(run(scene, out_).summary.reused.all);
    EXPECT_FALSE(fs::exists(out_ / "columns.npy"));
    scene.material.poisson = 0.3;
    EXPECT_FALSE(run(scene, out_).summary.reused.all) << "another material";
}

TEST_F(PrecomputeRun, ALargerTouchRegionComputesOnlyWhatIsNew) {
    const fs::path fresh_folder = temporary_.path() / "fresh";
    for (double tolerance : {0.0, 1e-5}) {  // columns in double, in float
        Scene scene = cube_scene(9);
        scene.touch.push_back({std::array<double, 6>{-1, -1, 0.0299, 1, 1, 1}, "", 1});  // the top: 81 nodes
        run(scene, out_, tolerance);
        scene.touch.push_back({std::array<double, 6>{0.0299, -1, -1, 1, 1, 1}, "", 1});  // and a side: 63 more
        const Summary larger = run(scene, out_, tolerance).summary, fresh = run(scene, fresh_folder, tolerance).summary;
        EXPECT_EQ(larger.reused.blocks, 81U);
        EXPECT_EQ(larger.reused.columns, 81U);
        EXPECT_FALSE(larger.reused.all);
        EXPECT_LT(larger.inverse.blocks.flops, fresh.inverse.blocks.flops);
        EXPECT_LT(larger.inverse.columns.facts.flops_done, 0.5 * fresh.inverse.columns.facts.flops_done);
        EXPECT_TRUE(same_but_columns(out_, fresh_folder)) << "blocks to the last bit";
        const test::Bound bound{.count = tolerance > 0.0 ? kSolved : kStored, .epsilon = test::kFloat};
        EXPECT_WITHIN(column_distance(out_, fresh_folder), bound);
        EXPECT_WITHIN(larger.inverse.checks.largest_column_difference, bound);
        // L_ij = L_ji^T, whoever of the two was there before.
        const Tables tables = read_tables(out_);
        const MappedNpy<float> columns(out_ / "columns.npy");
        const std::size_t n = tables.node_id.size(), rows = tables.row_id.size();
        const float scale = *std::max_element(columns.values().begin(), columns.values().end());
        const auto row_of = [&](std::size_t i) {
            return static_cast<std::size_t>(
                std::lower_bound(tables.row_id.begin(), tables.row_id.end(), tables.node_id[i]) -
                tables.row_id.begin());
        };
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < i; ++j)
                for (std::size_t e = 0; e < 9; ++e) {
                    const float ij = columns.values()[9 * (rows * i + row_of(j)) + e];
                    const float ji = columns.values()[9 * (rows * j + row_of(i)) + 3 * (e % 3) + e / 3];
                    ASSERT_WITHIN(std::abs(ij - ji) / scale, bound);
                }
        fs::remove_all(out_);
        fs::remove_all(fresh_folder);
    }
}

TEST_F(PrecomputeRun, AnotherColumnPrecisionIsConvertedOrSolvedFor) {
    const fs::path fresh = temporary_.path() / "fresh";
    Scene scene = cube_scene();
    run(scene, out_);
    scene.tables.column_precision = Storage::kFloat16;
    const Summary halved = run(scene, out_).summary;
    EXPECT_TRUE(halved.reused.all);
    EXPECT_EQ(halved.reused.columns, 73U);
    run(scene, fresh);
    EXPECT_TRUE(same_but_columns(out_, fresh));
    EXPECT_TRUE(read_file(out_ / "columns.npy") == read_file(fresh / "columns.npy"));
    scene.tables.column_precision = Storage::kFloat32;
    const Summary back = run(scene, out_).summary;
    EXPECT_EQ(back.reused.blocks, 73U);
    EXPECT_EQ(back.reused.columns, 0U) << "float16 has lost digits";
    EXPECT_GT(back.inverse.columns.facts.flops_done, 0.0);
    run(scene, fresh);
    EXPECT_TRUE(same_but_columns(out_, fresh));
    EXPECT_TRUE(read_file(out_ / "columns.npy") == read_file(fresh / "columns.npy"));
}

TEST_F(PrecomputeRun, WhatHoldsOfBlocksAndColumnsIsJudgedApart) {
    const auto reused = [&](const Scene& scene, const PrecomputeOptions& options) {
        Progress progress(true);
        const Summary summary = precompute(scene, out_, progress, options).summary;
        EXPECT_WITHIN(summary.inverse.checks.largest_block_difference, .count = kSolved, .epsilon = test::kFloat);
        return std::pair(summary.reused.blocks, summary.reused.columns);
    };
    using Counts = std::pair<std::size_t, std::size_t>;
    Scene scene = cube_scene();
    PrecomputeOptions options;
    EXPECT_EQ(reused(scene, options), Counts(0, 0));
    scene.tables.columns = ColumnRows::kAll;
    EXPECT_EQ(reused(scene, options), Counts(73, 0)) << "rows that no column has";
    scene.tables.columns = ColumnRows::kSurface;
    EXPECT_EQ(reused(scene, options), Counts(73, 73)) << "fewer rows";
    run(scene, temporary_.path() / "fresh");
    EXPECT_WITHIN(column_distance(out_, temporary_.path() / "fresh"), .count = kSolved, .epsilon = test::kFloat);
    options.tolerance = 1e-4;
    EXPECT_EQ(reused(scene, options), Counts(0, 73));
    options.column_tolerance = 1e-4;
    EXPECT_EQ(reused(scene, options), Counts(73, 0));
    scene.contact.force = ForceLaw::kConsistent;
    EXPECT_EQ(reused(scene, options), Counts(0, 73)) << "edges need the inversion, and the rest comes with them";
    scene.contact.force = ForceLaw::kInterpolated;
    scene.tables.column_budget_bytes = 1000.0;
    EXPECT_EQ(reused(scene, options), Counts(73, 0)) << "the viewer's factor must be made";
    EXPECT_TRUE(fs::exists(out_ / "factor_value.npy"));
    scene.contact.rigid_stiffness_n_per_m = 500.0;
    EXPECT_EQ(reused(scene, options), Counts(73, 0));
    EXPECT_TRUE(fs::exists(out_ / "factor_value.npy")) << "and then it is kept";
    options.force = true;
    EXPECT_EQ(reused(scene, options), Counts(0, 0));
}

TEST_F(PrecomputeRun, TheNumberOfThreadsChangesNoBit) {
    Scene scene = cube_scene(12);
    for (const ForceLaw force : {ForceLaw::kInterpolated, ForceLaw::kPressureMask}) {
        scene.contact.force = force;
        scene.contact.mask_radius_m = force == ForceLaw::kPressureMask ? 0.006 : 0.0;
        std::map<std::string, std::string> first;
        for (int threads : {1, 2, 5}) {
            Progress progress(true);
            PrecomputeOptions options;
            options.threads = threads;
            options.force = true;
            EXPECT_EQ(precompute(scene, out_, progress, options).summary.inverse.factor.threads, threads);
            auto files = contents(out_);
            for (const char* report : {"summary.json", "tables.json"}) files.erase(report);
            if (first.empty()) first = files;
            EXPECT_TRUE(files == first) << threads << " with " << force;
        }
    }
}

TEST_F(PrecomputeRun, ColumnsInHalfPrecisionAreRoundedOnly) {
    for (double young : {1e-2, 1e4, 1e11}) {
        Scene scene = cube_scene();
        scene.material.young_pa = young;
        run(scene, out_);
        const Array<float> single = read_npy<float>(out_ / "columns.npy");
        scene.tables.column_precision = Storage::kFloat16;
        run(scene, out_);
        const Tables tables = read_tables(out_);
        ASSERT_TRUE(tables.half_columns);
        const MappedNpy<Half> half(out_ / "columns.npy");
        ASSERT_EQ(half.shape(), single.shape);
        float largest = 0.0F;
        for (float value : single.values) largest = std::max(largest, std::abs(value));
        // Numbers of fewer digits, not errors that add up: half a unit in the last place, of 2^-24 of the unit below
        // the least normal number.
        for (std::size_t i = 0; i < single.values.size(); ++i)
            ASSERT_LE(std::abs(to_float(half.values()[i]) * static_cast<float>(tables.column_unit_m_per_n) -
                               single.values[i]),
                      0x1p-11F * std::abs(single.values[i]) + 0x1p-24F * largest);
    }
}

TEST_F(PrecomputeRun, TooManyPatchesAreRefusedBeforeTheFactorisation) {
    Scene scene = cube_scene(76);  // 67,500 patches: minutes of work, if it began
    scene.tables.columns = ColumnRows::kNone;
    const std::string said = test::error_of([&] { run(scene, out_); });
    EXPECT_EQ(said.rfind("cube.toml: the touchable surface has 6", 0), 0U) << said;
    EXPECT_EQ(said.find("partial"), std::string::npos) << said;
}

TEST_F(PrecomputeRun, FloatIsTakenWhereTheToleranceAllowsIt) {
    const Scene scene = cube_scene();
    const Matrix l = dense_compliance(make_body(scene, make_mesh(scene.mesh)), scene.material);
    const auto error = [&](double tolerance) {
        Progress progress(true);
        PrecomputeOptions options;
        options.tolerance = tolerance;
        const Result result = precompute(scene, out_, progress, options);
        const Tables tables = read_tables(out_);
        double largest = 0.0;
        for (std::size_t i = 0; i < tables.node_id.size(); ++i) {
            const Eigen::Matrix3d s = l.block<3, 3>(3 * tables.node_id[i], 3 * tables.node_id[i]).inverse();
            largest = std::max(largest, (block(tables.stiffness[i]) - s).norm() / s.norm());
        }
        return std::pair{name_of(result.summary.inverse.blocks.precision), largest};
    };
    EXPECT_EQ(error(0.0).first, "double");
    EXPECT_EQ(error(2e-6).first, "double") << "the condition of its blocks is above 2";
    const auto [precision, largest] = error(1e-4);
    EXPECT_EQ(precision, "float");
    EXPECT_WITHIN(largest, .epsilon = 1e-4);
    EXPECT_GT(largest, 1e-9) << "this was not computed in float";
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

TEST_F(PrecomputeRun, FloatThatIsWorseThanTheToleranceIsNotTaken) {
    for (const auto& [share, precision] : {std::pair{0.0, "float"}, {1e-5, "double"}, {1e-3, "double"}}) {
        Progress progress(true);
        Spoiled inverse(share);
        PrecomputeOptions options;
        options.tolerance = 1e-4;
        options.force = true;
        options.inverse = &inverse;
        const Summary summary = precompute(cube_scene(), out_, progress, options).summary;
        EXPECT_EQ(name_of(summary.inverse.blocks.precision), precision) << share;
        EXPECT_WITHIN(summary.inverse.checks.largest_block_difference, .count = kSolved, .epsilon = test::kFloat);
    }
}

TEST_F(PrecomputeRun, TooLittleMemoryIsAnErrorBeforeTheFactorisation) {
    Progress progress(true);
    const double need = run(cube_scene(), out_).summary.memory.peak();
    PrecomputeOptions options;
    options.force = true;
    options.memory_bytes = 1.01 * need;
    EXPECT_NO_THROW(precompute(cube_scene(), out_, progress, options));
    options.memory_bytes = 0.5 * need;
    const std::string said = test::error_of([&] { precompute(cube_scene(), out_, progress, options); });
    EXPECT_NE(said.find("cube.toml: needs "), std::string::npos) << said;
    EXPECT_NE(said.find("mesh of about"), std::string::npos) << said;
}

TEST_F(PrecomputeRun, WithoutColumnsOldOnesGoAndForeignFilesStay) {
    Scene scene = cube_scene(3);
    run(scene, out_);
    EXPECT_TRUE(fs::exists(out_ / "columns.npy"));
    write_file(out_ / "servo", "foreign");
    scene.tables.columns = ColumnRows::kNone;
    run(scene, out_);
    EXPECT_FALSE(fs::exists(out_ / "columns.npy"));
    EXPECT_FALSE(fs::exists(out_ / "row_id.npy"));
    EXPECT_EQ(read_file(out_ / "servo"), "foreign");
    EXPECT_EQ(contents(temporary_.path()).size(), 1U) << "something was left beside the folder";
}

TEST_F(PrecomputeRun, ATouchRegionLimitsPatchesAndNodes) {
    Scene scene = cube_scene();
    scene.touch.push_back({std::array<double, 6>{-1, -1, 0.0299, 1, 1, 1}, "", 1});  // the top
    scene.touch.push_back({std::array<double, 6>{0.0299, -1, -1, 1, 1, 1}, "", 2});  // and the side x = 30 mm
    const Body body = make_body(scene, make_mesh(scene.mesh));
    EXPECT_EQ(body.touch_patch.size(), 64U + 2U) << "a patch at either end of their edge has its nodes on both sides";
    EXPECT_EQ(body.touch_node.size(), 25U + 25U - 5U - 5U) << "two sides, an edge in common, an edge held";
    EXPECT_TRUE(std::is_sorted(body.touch_node.begin(), body.touch_node.end()));
    for (std::int32_t node : body.touch_node) EXPECT_FALSE(body.is_fixed(node));
}

TEST_F(PrecomputeRun, MouseHasThePapersCounts) {
    Scene scene = read_scene("meshes/mouse.toml");
    const Body body = make_body(scene, make_mesh(scene.mesh));
    EXPECT_EQ(body.fixed_count(), 139U);
    EXPECT_EQ(body.free_surface_node.size(), 1036U);
    EXPECT_EQ(body.touch_patch.size(), 2346U);
}

/// One mistake in a scene, and what the error must say.
struct Mistake {
    const char* name;
    std::function<void(Scene&)> make;
    const char* part;
};

class PrecomputeMistake : public testing::TestWithParam<Mistake> {
protected:
    const test::TemporaryFolder temporary_;
};

TEST_P(PrecomputeMistake, IsOneLineAndLeavesTheOldTables) {
    const fs::path out = temporary_.path() / "out";
    run(cube_scene(3), out);
    const auto before = contents(out);
    Scene scene = cube_scene(3);
    GetParam().make(scene);
    const std::string said = test::error_of([&] { run(scene, out); });
    EXPECT_NE(said.find(GetParam().part), std::string::npos) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    EXPECT_TRUE(before == contents(out)) << "the tables of before must stay";
    EXPECT_EQ(contents(temporary_.path()).size(), 1U) << "something was left beside the folder";
}

const std::array<double, 6> kNowhere{5, 5, 5, 6, 6, 6};

INSTANTIATE_TEST_SUITE_P(
    Scenes, PrecomputeMistake,
    testing::Values(Mistake{"NothingFixed", [](Scene& s) { s.fixed.clear(); },
                            "cube.toml: fixed: 27 of 27 nodes are under-constrained"},
                    Mistake{"OneEdgeFixed", [](Scene& s) { s.fixed[0].box_m = {-1, -1, -1, 1, 1e-9, 1e-9}; },
                            "24 of 27 nodes are under-constrained"},
                    Mistake{"FixedBoxEmpty", [](Scene& s) { s.fixed[0].box_m = kNowhere; },
                            "cube.toml:9: fixed.box: no node lies in it"},
                    Mistake{"FixedGroupMissing",
                            [](Scene& s) {
                                s.fixed[0] = {{}, "pads", 9};
                            },
                            "cube.toml:9: fixed.group: "},
                    Mistake{"EverythingFixed", [](Scene& s) { s.fixed[0].box_m = {-1, -1, -1, 1, 1, 1}; }, "are fixed"},
                    Mistake{"TouchBoxEmpty",
                            [](Scene& s) {
                                s.touch = {{kNowhere, "", 12}};
                            },
                            "cube.toml:12: touch.box: no node lies in it"},
                    Mistake{"TouchRegionWithoutPatch",
                            [](Scene& s) {
                                s.touch = {{std::array<double, 6>{0, 0, 0, 0, 0, 1}, "", 12}};
                            },
                            "cube.toml:12: touch: the region is empty"},
                    Mistake{"TouchRegionFixed",
                            [](Scene& s) {
                                s.touch = {{std::array<double, 6>{-1, -1, -1, 1, 1, 0}, "", 12}};
                            },
                            "cube.toml:12: touch: all nodes of its patches are fixed"},
                    Mistake{"MeshFileMissing",
                            [](Scene& s) {
                                s.mesh.generate.clear();
                                s.mesh.file = "no/such.msh";
                            },
                            "no/such.msh: mesh file cannot be read"},
                    Mistake{"WrongUnit", [](Scene& s) { s.mesh.side_m = 1e9; }, "give the right mesh.side"}),
    [](const auto& mistake) { return mistake.param.name; });

TEST_F(PrecomputeRun, ASecondRunIntoTheFolderIsToldWhoIsWritingIt) {
    Scene scene = cube_scene(3);
    run(scene, out_);
    const auto before = contents(out_);
    {
        const OwnFolder first(out_, kTables);
        EXPECT_TRUE(run(scene, out_).unchanged) << "only reads";
        scene.material.poisson = 0.3;
        const std::string said = test::error_of([&] { run(scene, out_); });
        const std::string holder = "out: process " + std::to_string(getpid()) + " is writing it";
        EXPECT_NE(said.find(holder), std::string::npos) << said;
        EXPECT_NO_THROW(run(scene, temporary_.path() / "other"));
    }
    EXPECT_TRUE(contents(out_) == before);
    EXPECT_FALSE(run(scene, out_).unchanged);
}

// Nothing beside the folder is written or removed, and nothing in it that is not haptable's.
TEST_F(PrecomputeRun, OnlyItsOwnFolderIsWritten) {
    const auto beside = [&](const char* what) { return temporary_.path() / (std::string("out") + what); };
    write_file(temporary_.path() / "victim", "kept");
    fs::create_symlink(temporary_.path() / "victim", beside(".lock"));
    write_file(beside(".columns"), "the user's");
    fs::create_directories(beside(".partial-999999999"));
    Scene scene = cube_scene(3);
    run(scene, out_);
    fs::create_directories(out_ / "tables.haptable-999999999" / "half");
    write_file(out_ / "notes", "the user's");
    write_file(out_ / "display.c", "the user's");
    scene.tables.columns = ColumnRows::kNone;
    run(scene, out_);
    EXPECT_FALSE(fs::exists(out_ / "columns.npy")) << "of the earlier tables";
    EXPECT_FALSE(fs::exists(out_ / "tables.haptable-999999999")) << "of a run that was killed";
    for (const fs::path& kept : {out_ / "notes", out_ / "display.c", beside(".columns")})
        EXPECT_EQ(read_file(kept), "the user's") << kept;
    EXPECT_TRUE(fs::is_symlink(beside(".lock")) && fs::exists(beside(".partial-999999999")));
    EXPECT_EQ(read_file(temporary_.path() / "victim"), "kept");
}

TEST_F(PrecomputeRun, AFileOfItsNameThatIsNotOursStopsIt) {
    fs::create_directories(out_);
    write_file(out_ / "model.c", "the user's");
    EXPECT_THROW(run(cube_scene(3), out_), Error);
    EXPECT_EQ(contents(out_).size(), 1U);
    EXPECT_EQ(read_file(out_ / "model.c"), "the user's");
}

// Tables that were written without a mark are known by the hashes that their tables.json has.
TEST_F(PrecomputeRun, TablesWithoutAMarkAreKnownByTheirHashes) {
    Scene scene = cube_scene(3);
    run(scene, out_);
    fs::remove(out_ / ".haptable");
    const auto before = contents(out_);
    scene.material.poisson = 0.3;
    write_file(out_ / "model.c", "the user's");
    EXPECT_THROW(run(scene, out_), Error);
    EXPECT_EQ(read_file(out_ / "model.c"), "the user's");
    write_file(out_ / "model.c", before.at("model.c"));
    EXPECT_FALSE(run(scene, out_).unchanged);
    EXPECT_TRUE(fs::exists(out_ / ".haptable"));
}

TEST_F(PrecomputeRun, AnOutputThatIsAFileIsAnError) {
    write_file(out_, "a file");
    EXPECT_THROW(run(cube_scene(3), out_), Error);
    EXPECT_EQ(read_file(out_), "a file");
}

TEST_F(PrecomputeRun, PartsNotJoinedAreNamed) {
    const fs::path file = "../shared/meshes/two_parts_285.msh";
    if (!fs::exists(file)) GTEST_SKIP() << "no " << file;
    Scene scene = cube_scene();
    scene.mesh = MeshSource();
    scene.mesh.file = file;
    const TetMesh mesh = make_mesh(scene.mesh);
    const Eigen::Vector3d corner = mesh.position_m[0];
    scene.fixed[0].box_m = {corner.x() - 3e-3, corner.y() - 3e-3, corner.z() - 3e-3,
                            corner.x() + 3e-3, corner.y() + 3e-3, corner.z() + 3e-3};
    const std::string said = test::error_of([&] { run(scene, out_); });
    EXPECT_NE(said.find("of 285 nodes are under-constrained"), std::string::npos) << said;
}

}  // namespace

}  // namespace haptable
