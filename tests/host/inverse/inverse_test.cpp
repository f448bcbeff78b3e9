// SPDX-License-Identifier: GPL-2.0-or-later
// What every Inverse must do with K of linear tetrahedra and with pressures, against the dense inverse of a cube's K;
// and precompute() by each.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>
#include <set>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/tables/npy.hpp"
#include "host/tables/tables.hpp"
#include "tests/bodies.hpp"
#include "tests/error_of.hpp"
#include "tests/files_apart.hpp"
#include "tests/host/body/cubes.hpp"
#include "tests/host/inverse/dense_reference.hpp"
#include "tests/host/inverse/inverses.hpp"
#include "tests/pressures.hpp"

namespace haptable {
namespace {

namespace fs = std::filesystem;
using Nodes = std::vector<std::int32_t>;
using Places = std::set<std::pair<std::size_t, std::size_t>>;

// Each of two numbers is rounded once to what the file holds, and they may fall on either side of a tie.
constexpr test::Bound kStored{.count = 8.0, .epsilon = test::kFloat};

/// Cubes of 7 x 7 x 6 unknown nodes: more than two groups of columns of either inverse.
struct CubeCase {
    std::string name;
    const test::DenseReference& (*make)();
};
const test::DenseReference& linear() {
    static const test::DenseReference cube(test::cube_stiffness(7, 0.49));
    return cube;
}
const test::DenseReference& pressures() {
    static const test::DenseReference cube(test::pressure_cube(7, 0.49));
    return cube;
}
const test::DenseReference& two_materials() {
    static const test::DenseReference cube(test::pressure_cube(7, 0.4999, 1000.0));
    return cube;
}

class InverseOf : public testing::TestWithParam<std::tuple<test::InverseCase, CubeCase>> {
protected:
    static constexpr std::int32_t kNodes = 7 * 7 * 6;

    const Stiffness& stiffness() const { return cube_.k; }
    const Eigen::MatrixXd& dense() const { return cube_.l; }
    const test::Bound& bound() const { return cube_.bound; }
    static Nodes every(std::int32_t step, std::int32_t first = 0) { return test::nodes_to(kNodes, step, first); }
    FactorFacts factorize(const Stiffness& k) {
        inverse_->analyse(k, {});
        return inverse_->factorize(k, progress_);
    }
    /// Every block that a sink took, and the largest ||block - L_ri|| / sqrt(||L_rr|| ||L_ii||).
    Places compute(const Columns& columns, const Nodes& node, const Nodes& row, double& error,
                   Columns::Sink sink = {}) {
        Places taken;
        std::mutex mutex;
        sink.take = [&](std::size_t c, std::size_t k, const Eigen::Matrix3f& l_ri) {
            const std::lock_guard lock(mutex);
            EXPECT_TRUE(taken.emplace(c, k).second) << "block " << c << ", " << k << " came twice";
            error = std::max(error, cube_.error(l_ri.cast<double>(), row[k], node[c]));
        };
        facts_ = columns.compute(progress_, sink);
        return taken;
    }

    const std::shared_ptr<Inverse> inverse_ = std::get<0>(GetParam()).make();
    const test::DenseReference& cube_ = std::get<1>(GetParam()).make();
    ColumnFacts facts_;
    Progress progress_{true};
};

TEST_P(InverseOf, TellsOfItsFactorAndSolves) {
    const MemoryNeed need = inverse_->analyse(stiffness(), {});
    const FactorFacts facts = inverse_->factorize(stiffness(), progress_);
    EXPECT_EQ(facts.ordering, "METIS");
    EXPECT_GE(facts.fill, 0.5 * double(stiffness().matrix().nonZeros()));
    EXPECT_GT(facts.flops, facts.fill);
    EXPECT_GE(need.factor, 8.0 * facts.fill);
    EXPECT_GT(need.available, need.peak());
    ASSERT_EQ(inverse_->size(), stiffness().size());
    for (Eigen::Index count : {1, 96, 5}) {
        const Eigen::MatrixXd b = Eigen::MatrixXd::Random(stiffness().size(), count);
        Eigen::MatrixXd x;
        inverse_->solve(b, x);
        EXPECT_WITHIN((x - dense::product(dense(), b)).norm() / x.norm(), bound());
    }
}

// A K that comes again may keep its factor; another one of the same pattern may not.
TEST_P(InverseOf, SolvesWithTheStiffnessThatItWasGivenLast) {
    const Stiffness other = stiffness().shifted(1.0);
    const Eigen::MatrixXd b = Eigen::MatrixXd::Random(stiffness().size(), 2);
    for (const Stiffness* k : {&stiffness(), &stiffness(), &other, &stiffness()}) {
        const FactorFacts facts = factorize(*k);
        EXPECT_GT(facts.flops, facts.fill);
        Eigen::MatrixXd x;
        inverse_->solve(b, x);
        EXPECT_WITHIN((*k * x - b).norm() / b.norm(), bound());
    }
}

TEST_P(InverseOf, BlocksInAndOutsideTheFactorsPatternAreThoseOfTheDenseInverse) {
    factorize(stiffness());
    std::vector<NodePair> wanted;
    for (std::int32_t i : every(3)) wanted.push_back({i, i});
    const auto expect_blocks = [&] {
        const Blocks blocks = inverse_->blocks(wanted, Precision::kDouble, progress_);
        EXPECT_EQ(blocks.facts.precision, Precision::kDouble);
        ASSERT_EQ(blocks.l_ij.size(), wanted.size());
        for (std::size_t p = 0; p < wanted.size(); ++p) {
            const auto [i, j] = wanted[p];
            EXPECT_WITHIN(cube_.error(blocks.l_ij[p], i, j), bound());
            if (i == j) {
                EXPECT_EQ(blocks.l_ij[p], blocks.l_ij[p].transpose());
            }
        }
    };
    expect_blocks();
    std::mt19937 random(3);
    std::uniform_int_distribution<std::int32_t> node(0, kNodes - 1);
    for (int p = 0; p < 300; ++p) wanted.push_back({node(random), node(random)});
    wanted.push_back(wanted.back());                              // twice,
    wanted.push_back({wanted.back().column, wanted.back().row});  // and the other way round
    expect_blocks();
}

TEST_P(InverseOf, ColumnsAreThoseOfTheDenseInverse) {
    factorize(stiffness());
    const std::pair<Nodes, Nodes> cases[] = {
        {every(1), every(1)}, {every(3), every(1)}, {every(1), every(5)}, {every(2), every(2, 1)}, {{200}, {7}}};
    for (const auto& [node, row] : cases) {
        double error = 0.0;
        const auto columns = inverse_->columns(node, row, Precision::kDouble);
        EXPECT_EQ(compute(*columns, node, row, error).size(), node.size() * row.size());
        EXPECT_WITHIN(error, kStored);
        EXPECT_EQ(facts_.precision, Precision::kDouble);
        EXPECT_EQ(facts_.resumed, 0U);
    }
}

TEST_P(InverseOf, GroupsThatTheSinkHasAreNotComputed) {
    factorize(stiffness());
    const Nodes node = every(1), row = every(2);
    const auto columns = inverse_->columns(node, row, Precision::kDouble);
    ASSERT_GT(columns->group_count(), 2U);
    Places of_first;
    columns->for_each_block(0, [&](std::size_t c, std::size_t k) { of_first.emplace(c, k); });
    Columns::Sink sink;
    std::set<std::size_t> done;
    sink.have = [](std::size_t group) { return group == 0; };
    sink.done = [&](std::size_t group) { done.insert(group); };
    double error = 0.0;
    const Places taken = compute(*columns, node, row, error, sink);
    EXPECT_EQ(done.size(), columns->group_count() - 1);
    EXPECT_EQ(taken.size() + of_first.size(), node.size() * row.size());
    for (const auto& place : of_first) EXPECT_FALSE(taken.contains(place));
    EXPECT_GT(facts_.resumed, 0U);
    EXPECT_LT(facts_.resumed, node.size());
}

TEST_P(InverseOf, AMatrixThatIsNotPositiveDefiniteIsToldOrRefused) {
    try {
        const FactorFacts facts = factorize(stiffness().shifted(-2.0));  // -K's diagonal, and more
        ASSERT_TRUE(facts.weakest.has_value());
        EXPECT_EQ(facts.weakest->ratio, 0.0);
        EXPECT_LT(facts.weakest->row, stiffness().size()) << "a row of K";
    } catch (const Error& error) {
        EXPECT_TRUE(test::says(std::string(error.what()), "not positive definite")) << error.what();
    }
    factorize(stiffness());  // and then it takes another
    Eigen::MatrixXd x;
    inverse_->solve(Eigen::MatrixXd::Ones(stiffness().size(), 1), x);
    EXPECT_WITHIN((x - dense().rowwise().sum()).norm() / x.norm(), bound());
}

INSTANTIATE_TEST_SUITE_P(Each, InverseOf,
                         testing::Combine(testing::ValuesIn(test::inverses()),
                                          testing::Values(CubeCase{"Linear", linear}, CubeCase{"Pressures", pressures},
                                                          CubeCase{"TwoMaterials", two_materials})),
                         [](const auto& one) { return std::get<0>(one.param).name + std::get<1>(one.param).name; });

class PrecomputeBy : public testing::TestWithParam<test::InverseCase> {
protected:
    const std::shared_ptr<Inverse> inverse_ = GetParam().make();
    Progress progress_{true};
};

/// A scene whose tables are the same by any Inverse: what `make` changes of the cube.
struct Task {
    const char* name;
    std::function<void(Scene&)> make = [](Scene&) {};
    ForceLaw force = ForceLaw::kInterpolated;
    double condition = 1.0;  ///< of K, against that of linear tetrahedra that are held
};

std::vector<Task> tasks() {
    std::vector<Task> all;
    for (const ForceLaw force : every<ForceLaw>()) all.push_back({.name = "a force", .force = force});
    const auto element = [](Element of, double poisson) {
        return [=](Scene& s) {
            s.mesh.element = of;
            s.material.poisson = poisson;
        };
    };
    const auto halved = [](Scene& s) {
        s.tables.columns = ColumnRows::kAll;
        s.tables.column_precision = Storage::kFloat16;
    };
    const auto layered = [](Element of, test::Law law) {
        return [=](Scene& s) {
            s = test::layered_cube(of, law);
            if (of != Element::kQuadratic) s.mesh.nodes_per_side = 5;
        };
    };
    const ForceLaw mask = ForceLaw::kPressureMask;
    all.insert(all.end(), {{"all rows, halved", halved, ForceLaw::kConsistent},
                           {"nodal pressures", element(Element::kAverageNodalPressure, 0.49)},
                           {"quadratic, positive definite as it stands", element(Element::kQuadratic, 0.3), {}, 2.5},
                           {"quadratic, of two signs", element(Element::kQuadratic, 0.49), {}, 2.5},
                           {"fibres", layered(Element::kAverageNodalPressure, test::Law::kFibre), mask, 10.0},
                           {"wood", layered(Element::kLinear, test::Law::kOrthotropic), mask, 10.0},
                           {"rings", layered(Element::kQuadratic, test::Law::kRings), mask, 10.0}});
    return all;
}

TEST_P(PrecomputeBy, WritesTheSameTablesByAny) {
    for (const Task& task : tasks()) {
        SCOPED_TRACE(testing::Message() << task.name << ", " << task.force);
        const test::TemporaryFolder folder;
        Scene scene = test::cube_scene(5, 0.49);
        task.make(scene);
        scene.contact.force = task.force;
        if (task.force == ForceLaw::kPressureMask) scene.contact.mask_radius_m = 0.01;
        for (const auto& [name, inverse] :
             {std::pair("one", static_cast<Inverse*>(nullptr)), {"other", inverse_.get()}})
            precompute(scene, folder.path() / name, progress_, {.column_tolerance = 0.0, .inverse = inverse});
        const auto expect_near = [&](auto type, const char* name, const test::Bound& most) {
            const fs::path one = folder.path() / "one" / name;
            if (!fs::exists(one)) return;
            EXPECT_WITHIN(test::difference<decltype(type)>(one, folder.path() / "other" / name), most) << name;
        };
        const test::Bound inverted = linear().bound.times(10.0 * task.condition);  // by the condition of an L_ii
        ASSERT_TRUE(fs::exists(folder.path() / "one/columns.npy"));
        for (const char* name :
             {"stiffness.npy", "edge_compliance.npy", "vertex_compliance.npy", "patch_compliance.npy", "sag.npy"})
            expect_near(0.0, name, inverted);
        if (scene.tables.column_precision == Storage::kFloat16)
            expect_near(Half{}, "columns.npy", {.count = 8.0, .epsilon = test::kHalf});
        else
            expect_near(0.0F, "columns.npy", kStored);
        if (scene.gravity) continue;  // mesh.vtu has the sag, whose last bits differ
        EXPECT_EQ(read_file(folder.path() / "one/mesh.vtu"), read_file(folder.path() / "other/mesh.vtu"));
    }
}

TEST_P(PrecomputeBy, ForeseesItsMemoryAndReusesItsTables) {
    const test::TemporaryFolder folder;
    PrecomputeOptions options;
    options.inverse = inverse_.get();
    Scene scene = test::cube_scene(5, 0.3, true);
    const Summary top = precompute(scene, folder.path() / "out", progress_, options).summary;
    EXPECT_EQ(top.processes.empty(), !inverse_->is_distributed());
    scene = test::cube_scene(5, 0.3);
    options.memory_bytes = 0.5 * top.memory.factor;
    EXPECT_TRUE(
        test::fails_with([&] { precompute(scene, folder.path() / "out", progress_, options); }, "GB of memory"));
    options.memory_bytes = 0.0;
    const Reused reused = precompute(scene, folder.path() / "out", progress_, options).summary.reused;
    EXPECT_FALSE(reused.all);
    EXPECT_GT(reused.blocks, 0U);
    EXPECT_EQ(reused.columns, reused.blocks);
}

INSTANTIATE_TEST_SUITE_P(Each, PrecomputeBy, testing::ValuesIn(test::inverses()),
                         [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace haptable
