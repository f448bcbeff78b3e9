// SPDX-License-Identifier: GPL-2.0-or-later
// The coupling in clusters, of a matrix like a half-space's: bytes, error, files.
#include "host/compliance/pair_clusters.hpp"
#include "host/base/json.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>

#include "host/base/file.hpp"
#include "tests/error_of.hpp"
#include "tests/sealed.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

/// Places on a bent sheet, and what a load on one does at the other: as 1 / distance, along it more than across, both
/// spread over the places' size.
class Sheet {
public:
    explicit Sheet(std::size_t count) {
        std::mt19937 random(3);
        std::uniform_real_distribution<double> side(0.0, 1.0);
        for (std::size_t i = 0; i < count; ++i) {
            const double x = side(random), y = side(random);
            a_.position_m.emplace_back(x, y, 0.3 * x * x);
        }
        a_.rows = [this](const std::vector<std::size_t>& place) {
            MatrixXd rows(3 * Eigen::Index(place.size()), 3 * Eigen::Index(size()));
            for (std::size_t i = 0; i < place.size(); ++i)
                for (std::size_t j = 0; j < size(); ++j)
                    rows.block<3, 3>(3 * Eigen::Index(i), 3 * Eigen::Index(j)) = block(place[i], j);
            return rows;
        };
    }
    Sheet(const Sheet&) = delete;
    Sheet& operator=(const Sheet&) = delete;

    std::size_t size() const { return a_.position_m.size(); }
    const PlaceMatrix& matrix() const { return a_; }
    Matrix3d block(std::size_t i, std::size_t j) const {
        const Vector3d apart = a_.position_m[i] - a_.position_m[j];
        const double r = std::sqrt(apart.squaredNorm() + 0.0025);
        return Matrix3d::Identity() / r + apart * apart.transpose() / (r * r * r);
    }

    /// The largest |E_ij|_F over |A_ii|_F.
    double worst(const PairClusters& clusters, const std::vector<std::size_t>& order) const {
        double most = 0.0;
        for (std::size_t i = 0; i < order.size(); ++i)
            for (std::size_t j = 0; j < order.size(); ++j)
                most = std::max(most, (cluster_block(clusters, i, j) - block(order[i], order[j])).norm());
        return most / block(0, 0).norm();
    }

private:
    PlaceMatrix a_;
};

constexpr double kBound = 0.25;

PairTables tables_of(const Sheet& sheet, std::size_t bytes, std::vector<std::size_t>& order) {
    Progress quiet(true);
    std::size_t least = 0;
    PairTables tables;
    tables.clusters = cluster_pairs(sheet.matrix(), bytes, kBound, order, least, quiet);
    tables.clusters.place.resize(sheet.size());
    for (std::size_t i = 0; i < order.size(); ++i) tables.clusters.place[order[i]] = std::int32_t(i);
    tables.control_count = sheet.size();
    return tables;
}

// 100 places: the last cluster has four.
TEST(PairClusters, MoreBytesAreLessErrorAndNoneAreExceeded) {
    const Sheet sheet(100);
    double before = HUGE_VAL;
    for (const std::size_t bytes : {30'000U, 45'000U, 70'000U, 110'000U}) {
        std::vector<std::size_t> order;
        const PairTables tables = tables_of(sheet, bytes, order);
        EXPECT_LE(pair_bytes(tables), bytes + 2 * sheet.size());
        const double worst = sheet.worst(tables.clusters, order);
        EXPECT_LT(worst, before) << bytes;
        before = worst;
    }
    // Every pair in two bytes: what is left is below half a step of the largest, over 32767, in nine entries.
    EXPECT_LT(before, 3.0 * 0.5 / 32767.0 * 2.0);
}

TEST(PairClusters, TheBoundOfBytesIsTight) {
    const Sheet sheet(60);
    Progress quiet(true);
    std::vector<std::size_t> order;
    std::size_t least = 0, again = 0;
    EXPECT_EQ(cluster_pairs(sheet.matrix(), 100, kBound, order, least, quiet).places(), 0U);
    EXPECT_EQ(cluster_pairs(sheet.matrix(), least - 1, kBound, order, again, quiet).places(), 0U);
    EXPECT_EQ(again, least);
    const PairClusters fits = cluster_pairs(sheet.matrix(), least, kBound, order, again, quiet);
    ASSERT_EQ(fits.places(), sheet.size());
    // The bound is of |A_ii^-1/2 E_ij A_jj^-1/2|_F, which is |E_ij|_F sqrt(3) / |A_ii|_F here.
    EXPECT_LE(sheet.worst(fits, order) * std::sqrt(3.0), kBound);
}

class PairFiles : public testing::Test {
protected:
    void SetUp() override {
        std::vector<std::size_t> order;
        tables_ = tables_of(sheet_, 30'000, order);
        tables_.meeting_m = 0.25;
        write_pair(tables_, folder_);
        tell_of(tables_);
    }
    void tell_of(const PairTables& tables) {
        tell(R"({"pair": {"meeting_m": 0.25, "controls": 100, "clustered": 100, "rank": )" +
             std::to_string(tables.clusters.rank) + R"(, "loads": )" +
             std::to_string(tables.clusters.load_place.size()) + "}}");
    }
    void tell(const std::string& facts) {
        write_file(folder_ / "options.json", R"({"contact": {"fingers": 2}})");
        seal(folder_, parse_json(facts));
    }
    void expect_refused(const std::string& file) {
        seal(folder_);
        const std::string said = error_of([&] { read_pair(folder_); });
        EXPECT_TRUE(says(said, file));
        EXPECT_TRUE(says(said, "make the tables again"));
    }

    const Sheet sheet_{100};
    const TemporaryFolder temporary_;
    const fs::path folder_ = temporary_.path();
    PairTables tables_;
};

TEST_F(PairFiles, HoldWhatWasWritten) {
    const PairTables read = *read_pair(folder_);
    EXPECT_EQ(read.meeting_m, 0.25);
    EXPECT_TRUE(read.clusters == tables_.clusters);
    EXPECT_GT(read.clusters.fine.size(), 0U);
    EXPECT_EQ(pair_bytes(tables_), pair_bytes(read));
}

TEST_F(PairFiles, HoldWhatPatchesLoad) {
    tables_.clusters.place.clear();
    tables_.clusters.load_begin = {0, 2, 3};
    tables_.clusters.load_place = {4, 9, 99};
    tables_.clusters.load_share = {{1, 2, 3, 4, 5, 6}, {-1, 0, 0, 0, 0, 32767}, {7, 7, 7, 7, 7, 7}};
    write_pair(tables_, folder_);
    tell_of(tables_);
    EXPECT_TRUE(read_pair(folder_)->clusters == tables_.clusters);
    tables_.clusters.load_place[2] = 100;
    write_pair(tables_, folder_);
    expect_refused("coupling_load_place.npy");
    tables_.clusters.load_begin = {0, 4, 3};
    write_pair(tables_, folder_);
    expect_refused("coupling_load_begin.npy");
}

TEST_F(PairFiles, ThatDoNotFitAreRefused) {
    const auto expect_refused_with = [&](const std::string& file, const std::function<void(PairClusters&)>& damage) {
        PairTables damaged = tables_;
        damage(damaged.clusters);
        write_pair(damaged, folder_);
        expect_refused(file);
    };
    expect_refused_with("coupling_place.npy", [](PairClusters& of) { of.place[7] = 100; });
    expect_refused_with("coupling_core.npy", [](PairClusters& of) { of.core.pop_back(); });
    expect_refused_with("coupling_fine.npy", [](PairClusters& of) { of.fine.pop_back(); });
    expect_refused_with("coupling_form.npy",
                        [](PairClusters& of) { *std::find(of.form.begin(), of.form.end(), 0) = 13; });
    expect_refused_with("coupling_step.npy", [](PairClusters& of) { of.step.pop_back(); });
    write_pair(tables_, folder_);
    tell(R"({"pair": {"meeting_m": 1, "controls": 100, "rank": 3}})");  // of an earlier one
    expect_refused("tables.json");
}

}  // namespace
}  // namespace haptable::test
