// SPDX-License-Identifier: GPL-2.0-or-later
// A liver by other people, from its mesh to its picture, by the programs that a user runs; and ours, as docs/FIRST.md
// has it touched.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "codegen/in_memory.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "host/servo/replay.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

TEST(Liver, FromMeshToPicture) {
    const fs::path mesh = fs::absolute("../shared/meshes/liver_181.msh");
    if (!fs::exists(mesh)) GTEST_SKIP() << "no ../shared/meshes";
    const TemporaryFolder folder;
    const fs::path tables_in = folder.path() / "liver";
    // 1. The scene: a liver of 19 cm, held on the side of its lowest y.
    write_file(folder.path() / "liver.toml",
               fmt::format("name = \"liver\"\n[mesh]\nfile = \"{}\"\nscale = 0.03\n[material]\nyoung = 3000.0\n"
                           "poisson = 0.45\n[[fixed]]\nbox = [-9, -9, -9, 9, 0.03, 9]\n",
                           mesh.string()));
    ASSERT_EQ(run(fmt::format("{} {} -o {} --quiet", program("haptable-precompute").string(),
                              (folder.path() / "liver.toml").string(), tables_in.string()))
                  .status,
              0);
    // 2. The servo, pressed 10 mm into the patch that lies highest.
    const Tables tables = read_tables(tables_in);
    const ServoModel servo = build_model(tables);
    const haptable_model model = model_in_memory(tables, servo);
    const auto y = [&](std::size_t v) { return servo.vertex_m[v][1]; };
    std::size_t top = 0;
    for (std::size_t v = 0; v < servo.vertex_m.size(); ++v) top = y(v) > y(top) ? v : top;
    std::string path = "x,y,z\n";
    for (int tick = 0; tick <= 100; ++tick)
        path +=
            fmt::format("{},{},{}\n", servo.vertex_m[top][0], y(top) + 0.005 - 0.00015 * tick, servo.vertex_m[top][2]);
    write_file(folder.path() / "path.csv", path);
    std::vector<std::uint32_t> node(servo.node.begin(), servo.node.end());
    const ServoReport report =
        replay({&model, node.data(), "liver"}, folder.path() / "path.csv", folder.path() / "felt.csv", true);
    EXPECT_GT(report.counters.contact_ticks, 50U);
    EXPECT_GT(report.largest_force_n, 0.01);
    // 3. The picture: the body, its colours by displacement.
    const fs::path picture = folder.path() / "liver.png";
    ASSERT_EQ(run(fmt::format("{} {} --csv {} --ticks 100 -o {} --quiet", program("haptable-view").string(),
                              tables_in.string(), (folder.path() / "felt.csv").string(), picture.string()))
                  .status,
              0);
    EXPECT_GT(fs::file_size(picture), 20'000U) << "a picture of one colour takes a few hundred bytes";
}

/// The lines of the first block of shell in a page, with the build's folder for `build`.
std::vector<std::string> commands_of(const fs::path& page) {
    const std::string text = read_file(page), begin = "```sh\n";
    const std::size_t first = text.find(begin) + begin.size();
    std::vector<std::string> commands;
    std::istringstream block(text.substr(first, text.find("```", first) - first));
    const std::string build = build_folder().string();
    for (std::string line; std::getline(block, line); commands.push_back(line)) {
        for (std::size_t at = 0; (at = line.find("build/", at)) != std::string::npos; at += build.size())
            line.replace(at, 5, build);
        if (line.rfind("make ", 0) == 0) line += " BUILD=" + build;
    }
    return commands;
}

// docs/FIRST.md, as a reader copies it.
TEST(Liver, ThePagesLinesTouchIt) {
    const std::string url = own_url();
    if (const std::string why = why_no_lcm(url); !why.empty()) GTEST_SKIP() << why;
    if (!fs::exists(program("haptable-device"))) GTEST_SKIP() << "haptable-device is not built: make";
    setenv("LCM_DEFAULT_URL", url.c_str(), 1);
    const std::vector<std::string> commands = commands_of("docs/FIRST.md");
    ASSERT_EQ(commands.size(), 6U);
    const fs::path made = build_folder() / "liver-capsule";
    for (const char* old : {"sag.png", "session", "touched.gif", "touch.html"}) fs::remove_all(made / old);
    std::string said;
    for (const std::string& command : commands) {
        const Outcome outcome = run(command);
        ASSERT_EQ(outcome.status, 0) << command << "\n" << outcome.err;
        said += outcome.out;
    }
    unsetenv("LCM_DEFAULT_URL");
    EXPECT_NE(said.find("force_size_n       0.65"), std::string::npos) << said;
    for (const char* file : {"sag.png", "touched.gif", "session/report.html", "touch.html"})
        EXPECT_GT(fs::file_size(made / file), 20'000U) << file;
    const auto session = parse_json(read_file(made / "session/summary.json"));
    EXPECT_EQ(session.at("ticks"), 6000);
    EXPECT_GT(session.at("contact_ticks"), 2000);
    const Tables tables = read_tables(made);
    EXPECT_EQ(tables.relaxation.size(), 2U);
    EXPECT_TRUE(fs::exists(made / "sag.npy"));
}

}  // namespace
}  // namespace haptable::test
