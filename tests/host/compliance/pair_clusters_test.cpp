// SPDX-License-Identifier: GPL-2.0-or-later
// The coupling in clusters, of a matrix like a half-space's: bytes and error.
#include "host/compliance/pair_clusters.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <random>

namespace haptable::test {
namespace {

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

}  // namespace
}  // namespace haptable::test
