// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/tables.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "host/base/file.hpp"
#include "host/precompute/precompute.hpp"
#include "host/tables/npy.hpp"
#include "tests/error_of.hpp"
#include "tests/host/body/cubes.hpp"
#include "tests/sealed.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable {
namespace {

namespace fs = std::filesystem;

class TablesFiles : public testing::Test {
protected:
    TablesFiles() {
        Scene scene = test::cube_of("block", 3, {1e4, 0.3});
        scene.file = "a/block.toml";
        scene.fixed = {test::box(-1, -1, -1, 1, 1, 0)};
        scene.device.max_force_n = 3.5;
        Progress progress(true);
        body_ = precompute(scene, folder_, progress).body;
    }
    void expect_error(const std::string& file) {
        const std::string said = test::error_of([&] { read_tables(folder_); });
        EXPECT_EQ(said.rfind((folder_ / file).string(), 0), 0U) << said;
    }
    /// With `file` replaced, reading is an error that names it; then it is put back.
    void expect_error_with(const std::string& file, const std::function<void(const fs::path&)>& damage) {
        const std::string good = read_file(folder_ / file);
        const std::string facts = read_file(folder_ / "tables.json");
        damage(folder_ / file);
        expect_error(file);
        if (file != "tables.json") {  // with the hash mended, what the file holds is what is wrong
            test::seal(folder_);
            if (fs::exists(folder_ / file)) expect_error(file);
            write_file(folder_ / "tables.json", facts);
        }
        write_file(folder_ / file, good);
        EXPECT_NO_THROW(read_tables(folder_));
    }

    const test::TemporaryFolder temporary_;
    const fs::path folder_ = temporary_.path() / "block";
    Body body_;
};

TEST_F(TablesFiles, WhatPrecomputeWroteIsRead) {
    const Tables tables = read_tables(folder_);
    EXPECT_EQ(tables.options.text("device.handedness"), "right");  // that no member has
    EXPECT_EQ(tables.name, "block");
    EXPECT_EQ(tables.scene_file, "block.toml");
    EXPECT_EQ(tables.max_force_n, 3.5);
    EXPECT_EQ(tables.rigid_stiffness_n_per_m, 1000.0);
    EXPECT_NE(tables.model_hash, 0U);
    EXPECT_EQ(tables.surface, body_.surface.patch);
    EXPECT_EQ(tables.patch, body_.touch_patch);
    EXPECT_EQ(tables.node_id, body_.touch_node);
    EXPECT_EQ(tables.row_id, body_.free_surface_node);
    ASSERT_EQ(tables.position.size(), body_.mesh.position_m.size());
    for (std::size_t i = 0; i < tables.position.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(tables.position[i][c], body_.mesh.position_m[i][int(c)]);
}

TEST_F(TablesFiles, MissingAndDamagedFilesAreNamed) {
    for (const char* file : {"tables.json", "options.json", "position.npy", "surface.npy", "patch.npy", "node_id.npy",
                             "stiffness.npy", "row_id.npy"}) {
        expect_error_with(file, [](const fs::path& path) { fs::remove(path); });
        expect_error_with(file, [](const fs::path& path) { write_file(path, ""); });
        expect_error_with(file, [](const fs::path& path) {
            write_file(path, read_file(path).substr(0, read_file(path).size() / 2));
        });
    }
}

/// With another value of a key in a file.
std::function<void(const fs::path&)> with(const std::string& key, const std::string& value) {
    return [key, value](const fs::path& path) {
        std::string text = read_file(path);
        const std::size_t at = text.find("\"" + key + "\": ") + key.size() + 4;
        text.replace(at, text.find_first_of(",\n}", at) - at, value);
        write_file(path, text);
    };
}

TEST_F(TablesFiles, FilesThatDoNotFitEachOtherAreNamed) {
    const auto of = [](const std::vector<std::size_t>& shape, const std::vector<std::int32_t>& values) {
        return [=](const fs::path& path) { write_npy<std::int32_t>(path, shape, values); };
    };
    expect_error_with("patch.npy", of({1, 3}, {0, 1, 27}));
    expect_error_with("node_id.npy", of({1}, {-1}));
    expect_error_with("surface.npy", of({1, 2}, {0, 1}));
    expect_error_with("stiffness.npy", [](const fs::path& path) {
        write_npy<double>(path, {1, 3, 3}, std::vector<double>(9));
    });
    expect_error_with("tables.json", [](const fs::path& path) { write_file(path, "{\"name\": 3}"); });
    expect_error_with("tables.json", with("model_hash", "\"x123456789abcdef\""));
}

// An object that pulls the finger in, and limits that limit nothing.
TEST_F(TablesFiles, AnObjectThatWouldPullIsRefused) {
    const auto times = [](double factor) {
        return [factor](const fs::path& path) {
            Array<double> blocks = read_npy<double>(path);
            for (double& entry : blocks.values) entry *= factor;
            write_npy<double>(path, blocks.shape, blocks.values);
        };
    };
    for (const double factor : {-1.0, 0.0, std::numeric_limits<double>::quiet_NaN()})
        expect_error_with("stiffness.npy", times(factor));
    for (const char* key : {"max_force", "rigid_stiffness"})
        for (const char* value : {"-1.0", "0.0", "1e999"}) expect_error_with("options.json", with(key, value));
    for (const char* key : {"damping", "encoder_step"}) expect_error_with("options.json", with(key, "-1e-3"));
    expect_error_with("options.json", with("force", "\"harder\""));
}

}  // namespace
}  // namespace haptable
