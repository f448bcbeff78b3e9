// SPDX-License-Identifier: GPL-2.0-or-later
// A campaign of strokes: what is counted is kept, told and not counted twice.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <map>
#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "tests/error_of.hpp"
#include "tests/host/strokes/stroked.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kModes = 40;  // of the consistent force

CampaignOptions needle_options(const fs::path& folder) {
    CampaignOptions options;
    options.places = {"meshes/hard"};
    options.meshes = {"needle"};
    options.modes = {"consistent"};
    options.strokes = 10 * kModes;
    options.folder = folder;
    options.threads = 1;
    options.quiet = true;
    return options;
}

/// Every count, without the time that it took.
nlohmann::ordered_json counts_of(nlohmann::ordered_json tally) {
    tally.erase("cpu_s");
    return tally;
}

/// Strokes that an earlier run had counted.
std::size_t taken_over(const CampaignOptions& options) { return run_campaign(options).at("taken_over_strokes"); }

TEST(Campaign, GoesOnWhereItWasCutShort) {
    const TemporaryFolder folder;
    const CampaignOptions options = needle_options(folder.path());
    const auto whole = run_campaign(options);
    EXPECT_EQ(whole.at("taken_over_strokes"), 0U);
    EXPECT_EQ(whole.at("total").at("strokes"), options.strokes);
    EXPECT_GT(whole.at("total").at("contact_ticks"), 10 * options.strokes);
    EXPECT_GT(whole.at("bodies").at(0).at("tables_cpu_s"), 0.0);

    std::vector<fs::path> kept;
    for (const auto& entry : fs::directory_iterator(folder.path() / "counts")) kept.push_back(entry.path());
    ASSERT_EQ(kept.size(), kModes);
    fs::remove(kept.front());  // as when it was cut short in that mode
    const auto rest = run_campaign(options);
    EXPECT_EQ(rest.at("taken_over_strokes"), options.strokes / kModes * (kModes - 1));
    for (const auto& [mode, tally] : whole.at("bodies").at(0).at("modes").items())
        EXPECT_EQ(counts_of(rest.at("bodies").at(0).at("modes").at(mode)), counts_of(tally)) << mode;

    write_file(kept.front(), "{");
    const auto left_out = run_campaign(options).at("left_out");
    ASSERT_EQ(left_out.size(), 1U);
    EXPECT_NE(left_out[0].at("why").get<std::string>().find(kept.front().string()), std::string::npos) << left_out;
}

TEST(Campaign, TakesOverNothingOfAnotherOne) {
    const TemporaryFolder folder;
    CampaignOptions options = needle_options(folder.path());
    options.modes = {"consistent-nearest-friction"};
    options.strokes = 20;
    EXPECT_EQ(taken_over(options), 0U);
    EXPECT_EQ(taken_over(options), 20U);
    options.seed = 2;
    EXPECT_EQ(taken_over(options), 0U);
    options.seed = 1;
    EXPECT_EQ(taken_over(options), 20U) << "each seed has counts of its own";
    options.strokes = 21;
    EXPECT_EQ(taken_over(options), 0U);
}

TEST(Campaign, TellsWhichMeshesItLeavesOutAndWhy) {
    const TemporaryFolder folder;
    fs::create_directories(folder.path() / "in");
    for (const char* name : {"a", "b"})
        for (const char* part : {".node", ".ele"})
            fs::copy_file(std::string("meshes/hard/needle") + part, folder.path() / "in" / (name + std::string(part)));
    write_file(folder.path() / "in" / "c.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    CampaignOptions options = needle_options(folder.path());
    options.places = {folder.path() / "in", "meshes/hard"};
    options.meshes.clear();
    options.modes = {"interpolated-nearest-friction"};
    options.strokes = 4;
    options.most_nodes = 200;
    const auto result = run_campaign(options);
    std::map<std::string, std::string> why;
    for (const auto& one : result.at("left_out")) why[one.at("name")] = one.at("why");
    EXPECT_TRUE(why["b"].ends_with("/b.node: the same mesh as a")) << why["b"];
    EXPECT_TRUE(why["needle"].ends_with("/needle.node: the same mesh as a")) << why["needle"];
    EXPECT_EQ(why.count("c"), 1U);
    EXPECT_NE(why["torus"].find("more than 200 (--most-nodes)"), std::string::npos) << why["torus"];
    EXPECT_EQ(result.at("bodies").size(), 1U);
    options.most_nodes = 4;  // then nothing is left
    EXPECT_NE(error_of([&] { run_campaign(options); }).find("more than 4 (--most-nodes)"), std::string::npos);
}

TEST(Campaign, TouchesNoLargeMeshByMasks) {
    const TemporaryFolder folder;
    CampaignOptions options = needle_options(folder.path());
    options.modes = {"interpolated-nearest", "pressure-mask-nearest"};
    options.strokes = 8;
    options.most_mask_nodes = 10;
    const auto result = run_campaign(options);
    EXPECT_EQ(result.at("total").at("strokes"), 8U) << "the other modes have all of them";
    const auto modes = result.at("bodies").at(0).at("modes");
    EXPECT_EQ(modes.at("pressure-mask-nearest").at("strokes"), 0U) << modes;
    ASSERT_EQ(result.at("left_out").size(), 1U);
    EXPECT_EQ(result.at("left_out")[0].at("name"), "needle, by masks");
}

// ---- what is by design ----

FingerPositions one_at(const Eigen::Vector3f& x) { return {std::array{x.x(), x.y(), x.z()}, {}}; }

/// In the middle of the needle, one width beside it on either side.
std::array<FingerPositions, 2> sides_of(const ServoModel& servo) {
    Eigen::AlignedBox3f box;
    for (const auto& x : servo.vertex_m) box.extend(Eigen::Vector3f(x.data()));
    const Eigen::Vector3f middle = box.center(), way(box.sizes().x(), 0.0F, 0.0F);
    return {one_at(middle - way), one_at(middle + way)};
}

/// Straight past the corner that is farthest along (1, 1, 1), by so much of the size under it.
Stroke across_corner(const ServoModel& servo, float under) {
    const float size = 0x1p20F * servo.tolerance_m;
    Eigen::Vector3f corner = Eigen::Vector3f::Constant(-1e9F);
    for (const auto& x : servo.vertex_m)
        if (Eigen::Vector3f(x.data()).sum() > corner.sum()) corner = Eigen::Vector3f(x.data());
    const Eigen::Vector3f middle = corner - under * size * Eigen::Vector3f::Ones();
    const Eigen::Vector3f way = 0.01F * size * Eigen::Vector3f(1.0F, -1.0F, 0.0F);
    return {one_at(middle - way), one_at(middle - way), one_at(middle + way)};
}

TEST(Judge, CountsAMotionThroughABodyAndAGodObjectBehindIt) {
    const Stroked needle(tables_of("needle"), {});
    const auto [left, right] = sides_of(needle.body.servo());
    const Stroke through{left, left, right, right, right}, back{left, left, right, left};
    Touched touched = needle.touched;
    EXPECT_EQ(judge(touched, through).passed, 0U);
    EXPECT_EQ(judge(touched, through).most_behind_ticks, 3U) << "it is held until it is seen";
    touched.step = [](SceneState&, const haptable_input[], std::uint32_t, haptable_output out[]) { out[0] = {}; };
    EXPECT_EQ(judge(touched, through).passed, 1U);
    EXPECT_EQ(judge(touched, back).passed, 2U);
    EXPECT_EQ(judge(touched, through).most_behind_ticks, 0U);
    EXPECT_EQ(judge(touched, across_corner(needle.body.servo(), 1e-6F)).passed, 0U) << "it only touches the corner";
    EXPECT_EQ(judge(touched, across_corner(needle.body.servo(), 1e-3F)).passed, 1U);
}

}  // namespace
}  // namespace haptable::test
