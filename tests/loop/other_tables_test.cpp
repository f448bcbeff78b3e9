// SPDX-License-Identifier: GPL-2.0-or-later
// Two tables of the same inputs that differ in one bit, as two machines may make them: they have two hashes, and who
// reads a record of the other says so. That servo, bridge and viewer go by the hash their own tests show.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <nlohmann/json.hpp>

#include "codegen/codegen.hpp"
#include "codegen/loaded_scene.hpp"
#include "host/session/servo/servo.hpp"
#include "tests/error_of.hpp"
#include "tests/host/view/cube_tables.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

SceneFiles cube_files() {
    const TemporaryFolder folder;
    write_cube_tables(folder.path());
    return read_scene_files(folder.path());
}

std::string hash_of(const LoadedScene& scene) { return fmt::format("{:016x}", scene.model().hash); }
ServoScene servo_of(const LoadedScene& scene) { return {&scene.model(), scene.node().data(), "cube"}; }

/// A bit of the mantissa of one number of S. A float's last is a double's 30th.
SceneFiles with_flipped_bit(SceneFiles files, int bit) {
    double& s = files.tables.stiffness[5][0];
    s = std::bit_cast<double>(std::bit_cast<std::uint64_t>(s) ^ (std::uint64_t{1} << bit));
    return files;
}

class OtherTables : public testing::Test {
protected:
    int replay(const std::string& tables) const {
        const std::string in = folder / "path.csv", out = folder / "out.csv";
        write_file(in, "x,y,z\n0.01,0.01,0.031\n0.01,0.01,0.029\n");
        const char* argv[] = {"servo",     "--replay", in.c_str(),     "--out",
                              out.c_str(), "--tables", tables.c_str(), "--quiet"};
        return servo_main(std::size(argv), const_cast<char**>(argv), servo_of(ours));
    }

    const SceneFiles made = cube_files();
    const LoadedScene ours{made}, theirs{with_flipped_bit(made, 29)};
    const WorkFolder folder;
};

TEST_F(OtherTables, AreOfTheSameInputsAndHaveAnotherHash) {
    EXPECT_EQ(ours.tables().model_hash, theirs.tables().model_hash);
    EXPECT_NE(hash_of(ours), hash_of(theirs));
    EXPECT_EQ(hash_of(ours), hash_of(LoadedScene(made)));
    // Below a float's last bit: the servo's tables are the same.
    EXPECT_EQ(hash_of(ours), hash_of(LoadedScene(with_flipped_bit(made, 0))));
    EXPECT_TRUE(says(model_text(theirs.tables(), theirs.servo()).header, "_HASH 0x" + hash_of(theirs)));
}

TEST_F(OtherTables, AReplayRefusesARecordOfTheOther) {
    EXPECT_EQ(replay(hash_of(ours)), 0);
    std::filesystem::remove(folder / "out.csv");
    testing::internal::CaptureStderr();
    EXPECT_NE(replay(hash_of(theirs)), 0);
    const std::string said = testing::internal::GetCapturedStderr();
    for (const LoadedScene* one : {&ours, &theirs}) EXPECT_TRUE(says(said, hash_of(*one)));
    EXPECT_FALSE(std::filesystem::exists(folder / "out.csv"));
}

}  // namespace
}  // namespace haptable::test
