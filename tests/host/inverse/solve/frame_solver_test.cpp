// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/solve/frame_solver.hpp"

#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/precompute/precompute.hpp"
#include "host/tables/tables.hpp"
#include "host/view/deformation.hpp"
#include "tests/bodies.hpp"
#include "tests/error_of.hpp"
#include "tests/sealed.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable {
namespace {

namespace fs = std::filesystem;

Eigen::Map<const Eigen::VectorXf> vector_of(std::span<const float> values) {
    return {values.data(), Eigen::Index(values.size())};
}

/// The paper's cube with its columns, and with a budget that has no room for them.
class Frames : public testing::Test {
protected:
    Result run(double budget_bytes, const fs::path& folder, Element element = Element::kLinear) {
        Scene scene = test::cube_scene(5, 0.3);
        scene.mesh.element = element;
        scene.tables.column_budget_bytes = budget_bytes;
        Progress progress(true);
        return precompute(scene, folder, progress);
    }
    const test::TemporaryFolder temporary_;
    const fs::path columns_ = temporary_.path() / "columns", solves_ = temporary_.path() / "solves";
};

TEST_F(Frames, OverTheBudgetTheViewerSolvesAndSeesTheSame) {
    for (const Element element : {Element::kAverageNodalPressure, Element::kLinear}) {  // with pressures, and without
        SCOPED_TRACE(element);
        run(1e9, columns_, element);
        const Result result = run(1000.0, solves_, element);
        EXPECT_EQ(result.summary.identity.drawing, "solves");
        EXPECT_TRUE(test::says(to_table(Scene(), result.body, result.summary, {}), "column_budget"));
        EXPECT_FALSE(fs::exists(solves_ / "columns.npy"));
        const Tables with = read_tables(columns_), without = read_tables(solves_);
        EXPECT_TRUE(with.has_columns && !with.has_factor && !without.has_columns && without.has_factor);
        ASSERT_EQ(with.row_id, without.row_id);
        Deformation stored(with, columns_), solved(without, solves_);
        for (std::size_t p = 0; p < with.patch.size(); p += 7) {
            std::vector<NodalForce> loads;
            for (std::int32_t node : with.patch[p])
                loads.push_back({node, {0.3F, -0.2F, -0.9F + 0.1F * float(loads.size())}});
            const auto a = vector_of(stored.displace(loads)), b = vector_of(solved.displace(loads));
            EXPECT_WITHIN((a - b).cwiseAbs().maxCoeff(), .count = 8.0 * std::sqrt(300.0), .epsilon = test::kFloat,
                          .size = a.cwiseAbs().maxCoeff());
        }
        EXPECT_TRUE(vector_of(solved.displace({})).isZero(0.0F));
    }
}

TEST_F(Frames, DamagedFactorFilesAreErrorsThatNameThem) {
    run(1000.0, solves_);
    const Tables tables = read_tables(solves_);
    for (const char* name : kFactorFiles) {
        const std::string good = read_file(solves_ / name);
        std::string bad = good;
        for (std::size_t i = 128; i < 136; ++i) bad[i] = '\x7f';  // the first values: far too large
        if (std::string(name) != "factor_value.npy") {            // any float is a value
            write_file(solves_ / name, bad);
            EXPECT_THROW(Deformation(tables, solves_), Error) << name;
            test::seal(solves_);
            EXPECT_THROW(Deformation(tables, solves_), Error) << name;
        }
        write_file(solves_ / name, good.substr(0, good.size() - 4));
        test::seal(solves_);
        EXPECT_THROW(Deformation(tables, solves_), Error) << name;
        write_file(solves_ / name, good);
        test::seal(solves_);
    }
    EXPECT_NO_THROW(Deformation(tables, solves_));
}

}  // namespace
}  // namespace haptable
