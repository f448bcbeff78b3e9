// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/press.hpp"

#include <gtest/gtest.h>

#include "host/tables/npy.hpp"
#include "tests/error_of.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

/// A stiffness table of these diagonals, all off-diagonals 0.
void write_blocks(const std::filesystem::path& file, const std::vector<std::array<double, 3>>& diagonals) {
    std::vector<double> values;
    for (const auto& d : diagonals) values.insert(values.end(), {d[0], 0, 0, 0, d[1], 0, 0, 0, d[2]});
    write_npy<double>(file, {diagonals.size(), 3, 3}, values);
}

TEST(Press, TakesTheMedianOfTheFreeNodes) {
    const TemporaryFolder folder;
    write_blocks(folder.path() / "stiffness.npy", {{1, 2, 6}, {10, 20, 90}, {4, 4, 7}});
    Scene scene;
    const PressStiffness press = press_stiffness(scene, folder.path());
    EXPECT_WITHIN(std::abs(press.typical_n_per_m - 5.0), .count = 4, .size = 5.0);
    EXPECT_WITHIN(std::abs(press.largest_n_per_m - 90.0), .count = 16, .size = 90.0);
    // A mask's contacts: the inverse of their compliance.
    write_blocks(folder.path() / "vertex_compliance.npy", {{0.5, 0.5, 0.5}, {0.25, 0.25, 0.25}, {0, 0, 0}});
    scene.contact.force = ForceLaw::kPressureMask;
    EXPECT_WITHIN(std::abs(press_stiffness(scene, folder.path()).typical_n_per_m - 4.0), .count = 4, .size = 4.0);
}

TEST(Press, TellsWhetherAHandFeelsIt) {
    Scene scene;
    scene.material.young_pa = 1000.0;
    scene.device.friction_n = 0.04;
    scene.device.max_force_n = 8.5;
    for (const auto& [stiffness_n_per_m, said] :
         {std::pair(0.24,
                    "1.2 mN at a typical place (0.24 N/m; the stiffest free one 0.48 N/m); below your device's "
                    "40 mN friction: try young = 3.4e+05"),
          {20.0, "100 mN at a typical place (20 N/m; the stiffest free one 40 N/m); hardly more than"},
          {100.0, "your device has 40 mN friction and gives 8.5 N"},
          {4000.0, "20 N at a typical place"},
          {4000.0, "more than your device's 8.5 N: try young = 220"}})
        EXPECT_TRUE(says(describe({stiffness_n_per_m, 2.0 * stiffness_n_per_m}, scene), said));
    EXPECT_EQ(describe({0.0, 0.0}, scene), "");
}

}  // namespace
}  // namespace haptable::test
