// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/compliance/column_store.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "host/base/file.hpp"
#include "host/inverse/column_solver.hpp"
#include "host/inverse/factor.hpp"
#include "host/precompute/precompute.hpp"
#include "tests/bodies.hpp"
#include "tests/host/inverse/dense_reference.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable {
namespace {

namespace fs = std::filesystem;
using Nodes = std::vector<std::int32_t>;

/// A cube of 9 nodes a side, its bottom fixed: columns of all 648 unknown nodes, six groups.
class Store : public testing::Test {
protected:
    static Eigen::SparseMatrix<double> stiffness() { return test::cube_stiffness(9, 0.3); }

    /// Computes what is missing, at most `groups` of it, as a crash or Ctrl-C would end it. Returns the operations.
    double compute(ColumnStore& store, const ColumnSolver& solver, std::size_t groups = 1000) {
        struct Stop {};
        Columns::Sink sink = store.sink();
        const auto done = sink.done;
        double flops = 0.0;
        sink.done = [&](std::size_t group) {
            if (groups == 0) throw Stop();
            done(group);
            flops += solver.flops(group);
            --groups;
        };
        try {
            const double told = solver.compute(progress_, sink).flops_done;
            EXPECT_WITHIN(std::abs(told - flops), .count = 8, .size = flops);
        } catch (const Stop&) {
        }
        return flops;
    }
    double compute(ColumnStore& store, std::size_t groups = 1000) { return compute(store, solver_, groups); }
    static ColumnFormat format(bool half) { return {half, half ? 0x1p-12 : 1.0}; }
    std::string columns(const fs::path& work) {
        ColumnStore store(work, 1, solver_, node_.size(), row_.size(), format_);
        compute(store);
        store.publish(temporary_.path() / "columns.npy");
        EXPECT_FALSE(fs::exists(work));
        return read_file(temporary_.path() / "columns.npy");
    }

    const test::TemporaryFolder temporary_;
    const fs::path work_ = temporary_.path() / "out.columns";
    const Eigen::SparseMatrix<double> k_ = stiffness();
    const Factor factor_{k_};
    const Nodes node_ = test::nodes_to(648), row_ = node_;
    const ColumnSolver solver_{factor_.supernodes(), node_, row_};
    ColumnFormat format_;
    Progress progress_{true};
};

TEST_F(Store, KilledItGoesOnFromThereAndDoesDamagedForeignOrCutOffWorkAgain) {
    std::string whole[2];
    for (const bool half : {false, true}) {
        format_ = format(half);
        whole[half] = columns(temporary_.path() / "whole");
    }
    const auto change = [&](const char* file, const std::function<void(std::string&)>& how) {
        std::string text = read_file(work_ / file);
        how(text);
        write_file(work_ / file, text);
    };
    struct Case {
        const char* name;
        std::size_t kept;
        std::function<void()> damage;
        std::uint64_t key = 1;
        bool half = false;
    };
    const Case cases[] = {
        {"whole", 2, [] {}},
        {"whole, in half precision", 2, [] {}, 1, true},
        {"another key", 0, [] {}, 2},
        {"one entry is damaged", 1, [&] { change("columns.npy", [](auto& text) { text[text.size() / 2] ^= 1; }); }},
        {"cut off", 0, [&] { fs::resize_file(work_ / "columns.npy", 1000); }},
        {"the journal's last line is cut off", 1,
         [&] { change("journal", [](auto& text) { text.resize(text.size() - 5); }); }}};
    for (const Case& c : cases) {
        SCOPED_TRACE(c.name);
        format_ = format(c.half);
        double flops = 0.0;
        {
            ColumnStore store(work_, 1, solver_, node_.size(), row_.size(), format_);
            while (flops < 0.5 * solver_.flops()) flops += compute(store, 1);
        }
        c.damage();
        ColumnStore store(work_, c.key, solver_, node_.size(), row_.size(), format_);
        EXPECT_EQ(store.kept_groups(), c.kept);
        flops += compute(store);
        EXPECT_EQ(flops < 1.05 * solver_.flops(), c.kept == 2);
        store.publish(temporary_.path() / "columns.npy");
        EXPECT_TRUE(read_file(temporary_.path() / "columns.npy") == whole[c.half]);
    }
}

TEST_F(Store, PartOfATableKilledGoesOnFromThere) {
    // Every other node and row of the table: the rest is of an earlier run.
    const Nodes half = test::nodes_to(648, 2);
    ColumnPlaces places;
    for (std::int32_t i : half) places.node.push_back(std::size_t(i));
    places.row = places.node;
    const ColumnSolver solver(factor_.supernodes(), half, half);
    {
        ColumnStore store(work_, 1, solver, 648, 648, format_, places);
        compute(store, solver, 1);
    }
    ColumnStore store(work_, 1, solver, 648, 648, format_, places);
    EXPECT_EQ(store.kept_groups(), 1U);
    EXPECT_EQ(solver.compute(progress_, store.sink()).resumed, 128U);
    store.publish(temporary_.path() / "part.npy");
    const std::string whole = columns(temporary_.path() / "whole");
    const MappedNpy<float> all(temporary_.path() / "columns.npy"), some(temporary_.path() / "part.npy");
    const double scale = double(*std::max_element(all.values().begin(), all.values().end()));
    for (std::size_t i = 0; i < 648; ++i)
        for (std::size_t e = 0; e < std::size_t{9} * 648; ++e) {
            const bool there = i % 2 == 0 && e / 9 % 2 == 0;
            const float expected = there ? all.values()[9 * 648 * i + e] : 0.0F;
            const float value = some.values()[9 * 648 * i + e];
            // Both were rounded to float32 once.
            ASSERT_WITHIN(std::abs(value - expected), .count = 8, .epsilon = test::kFloat, .size = scale);
        }
}

TEST_F(Store, NothingDoneLeavesNothing) {
    { const ColumnStore store(work_, 1, solver_, node_.size(), row_.size(), format_); }
    EXPECT_FALSE(fs::exists(work_));
}

TEST_F(Store, HoldsRowsInTableOrderAndSeesADifference) {
    const Eigen::MatrixXd l = dense::inverse_spd(k_);
    ColumnStore store(work_, 1, solver_, node_.size(), row_.size(), format_);
    compute(store);
    for (std::size_t i : {0U, 7U, 647U}) {
        const Eigen::MatrixXd x = l.middleCols<3>(3 * Eigen::Index(i));
        EXPECT_WITHIN(store.difference(i, x), .count = 8, .epsilon = test::kFloat);
        EXPECT_GT(store.difference(i, 1.001 * x), 1e-4);
        EXPECT_GT(store.difference(i, x.colwise().reverse()), 1e-2);
    }
}

}  // namespace
}  // namespace haptable
