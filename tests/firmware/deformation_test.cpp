// SPDX-License-Identifier: GPL-2.0-or-later
// Equation 8 on the target: against the columns of the tables in double, and against the host's bits under QEMU.
#include "firmware/haptable_deformation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "codegen/display.hpp"
#include "codegen/in_memory.hpp"
#include "host/tables/npy.hpp"
#include "host/target/image.hpp"
#include "host/target/strokes.hpp"
#include "tests/finger.hpp"
#include "tests/process.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

class Deformation : public testing::Test {
protected:
    void SetUp() override {
        if (!std::filesystem::exists(folder / "display.c")) GTEST_SKIP() << "build/display is not built: make images";
        tables = read_tables(folder);
        built = build_model(tables);
        model = model_in_memory(tables, built);
        path_m = walked(stroke_path(tables, 25));
    }
    /// Calls `each` with every tick's output.
    template <typename Each>
    void run(Each each) const {
        Finger finger(model);
        check_tables(model, finger.servo());
        for (const auto& at_m : path_m) each(finger.to(to_vector(at_m.data())));
    }
    /// u_r in double, from the file that the host's viewer reads.
    std::array<double, 3> by_columns(const MappedNpy<float>& columns, std::size_t row,
                                     const haptable_output& out) const {
        std::array<double, 3> u{};
        for (std::size_t c = 0; c < 3 && haptable_touches(out.state) != 0; ++c) {
            if (out.vertex[c] >= tables.node_id.size()) continue;
            const float* block = &columns.values()[9 * (out.vertex[c] * tables.row_id.size() + row)];
            for (std::size_t a = 0; a < 9; ++a) u[a / 3] += double(block[a]) * double(out.nodal_force_n[c][a % 3]);
        }
        return u;
    }

    const std::filesystem::path folder = build_folder() / "display";
    Tables tables;
    ServoModel built;
    haptable_model model{};
    std::vector<std::array<float, 3>> path_m;
};

TEST_F(Deformation, IsTheProductOfTheHostsColumns) {
    const MappedNpy<float> columns(folder / "columns.npy");
    for (const auto& [precision, rounding] :
         {std::pair{Storage::kFloat32, kFloat}, std::pair{Storage::kInt16, 0x1p-16}}) {
        SCOPED_TRACE(precision);
        tables.display_precision = precision;
        const Display display = build_display(folder, tables);
        const haptable_deformation deformation = display_in_memory(tables, model.hash, display);
        std::vector<std::array<float, 3>> u(display.node.size());
        double largest_m = 0.0, worst_m = 0.0;
        run([&](const haptable_output& out) {
            haptable_deform(&deformation, &out, reinterpret_cast<float(*)[3]>(u.data()));
            for (std::size_t r = 0; r < u.size(); ++r) {
                const auto at = std::find(tables.row_id.begin(), tables.row_id.end(), tables.display_rows[r]);
                const auto want = by_columns(columns, static_cast<std::size_t>(at - tables.row_id.begin()), out);
                for (std::size_t a = 0; a < 3; ++a) {
                    largest_m = std::max(largest_m, std::abs(want[a]));
                    worst_m = std::max(worst_m, std::abs(double(u[r][a]) - want[a]));
                }
            }
        });
        EXPECT_GT(largest_m, 1e-3);
        // Nine products of entries that were rounded to what the display holds.
        EXPECT_WITHIN(worst_m, .count = 16, .epsilon = rounding, .size = largest_m);
    }
}

TEST_F(Deformation, GivesTheBitsOfTheHostOnEveryTarget) {
    const Display display = build_display(folder, tables);
    const haptable_deformation deformation = display_in_memory(tables, model.hash, display);
    std::vector<std::array<float, 3>> want, u(display.node.size());
    run([&](const haptable_output& out) {
        haptable_deform(&deformation, &out, reinterpret_cast<float(*)[3]>(u.data()));
        want.insert(want.end(), u.begin(), u.end());
    });
    for (const char* target : kTargets) {
        const TargetImage image(build_folder(), "display", target);
        if (!std::filesystem::exists(folder / "firmware" / target / "deform.elf"))
            GTEST_SKIP() << "no image for " << target << ": make images";
        const auto got = image.deform(path_m);
        ASSERT_EQ(got.size(), want.size());
        EXPECT_EQ(std::memcmp(got.data(), want.data(), want.size() * sizeof want[0]), 0) << target;
    }
}

}  // namespace
}  // namespace haptable::test
