// SPDX-License-Identifier: GPL-2.0-or-later
// Folders, films and ParaView's files.
#include "host/view/output.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <pugixml.hpp>
#include <set>
#include <sstream>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/view/vtu.hpp"
#include "tests/environment.hpp"
#include "tests/error_of.hpp"
#include "tests/host/view/cube_tables.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

std::set<std::string> names(const fs::path& folder) {
    std::set<std::string> out;
    for (const auto& entry : fs::directory_iterator(folder)) out.insert(entry.path().filename().string());
    return out;
}

Image grey(int width, int height) { return {width, height, std::vector<std::uint32_t>(std::size_t(width * height))}; }

/// So many pictures of 8 x 8.
void add(Output& output, int pictures) {
    for (int k = 0; k < pictures; ++k) output.add(grey(8, 8));
}

TEST(ViewOutput, AFolderHoldsTheFramesOfThisRunOnly) {
    const TemporaryFolder folder;
    const fs::path out = folder.path() / "new" / "pictures";
    for (const int frames : {5, 3}) {
        Output output(out, 8, 8, 33.0);
        add(output, frames);
        if (frames == 5) write_file(output.folder()->file("frames.pvd"), "of ParaView");
        output.close();
        for (const char* name : {"notes.txt", "frame_12.png", "frame_000007.png"}) write_file(out / name, "the user's");
    }
    EXPECT_EQ(names(out), (std::set<std::string>{".haptable", "frame_000000.png", "frame_000001.png",
                                                 "frame_000002.png", "frame_000007.png", "notes.txt", "frame_12.png"}));
}

TEST(ViewOutput, AFolderOfOthersIsRefused) {
    const TemporaryFolder folder;
    write_file(folder.path() / "frame_000000.png", "the user's");
    EXPECT_THROW(Output(folder.path(), 8, 8, 33.0), Error);
    EXPECT_EQ(names(folder.path()), std::set<std::string>{"frame_000000.png"});
}

TEST(ViewOutput, WhatIsBrokenOffLeavesNothingAndSaysSo) {
    const TemporaryFolder folder;
    const fs::path old = folder.path() / "old";
    {
        Output earlier(old, 8, 8, 33.0);
        add(earlier, 1);
        earlier.close();
    }
    write_file(old / "notes.txt", "kept");
    for (const fs::path& place : {folder.path() / "pictures", old}) {
        testing::internal::CaptureStderr();
        {
            Output output(place, 8, 8, 33.0);
            add(output, 3);
            write_file(output.folder()->file("frame_000000.vtu"), "beside");
        }
        EXPECT_TRUE(says(testing::internal::GetCapturedStderr(), "broken off after 3 pictures"));
    }
    EXPECT_EQ(names(folder.path()), std::set<std::string>{"old"});
    EXPECT_EQ(names(old), (std::set<std::string>{".haptable", "notes.txt"}));
}

TEST(ViewOutput, APngHoldsOnePicture) {
    const TemporaryFolder folder;
    Output output(folder.path() / "a.png", 8, 8, 33.0);
    add(output, 1);
    EXPECT_THROW(add(output, 1), Error);
    output.close();
    EXPECT_EQ(names(folder.path()), (std::set<std::string>{"a.png"}));
}

TEST(ViewOutput, ANewFolderWithoutPicturesGoesAgain) {
    const TemporaryFolder folder;
    { const Output output(folder.path() / "live", 8, 8, 33.0); }
    EXPECT_TRUE(names(folder.path()).empty());
    { const Output output(folder.path(), 8, 8, 33.0); }  // one that was there stays
    EXPECT_TRUE(fs::exists(folder.path()));
}

TEST(ViewOutput, WhatCannotBeWrittenIsAnError) {
    const TemporaryFolder folder;
    Output output(folder.path() / "gone" / "a.png", 8, 8, 33.0);  // there is no such folder
    add(output, 1);
    EXPECT_TRUE(fails_with([&] { output.close(); }, "gone/a.png"));
    EXPECT_THROW(Output(folder.path() / "a.jpg", 8, 8, 33.0), Error);
    EXPECT_TRUE(names(folder.path()).empty());
}

/// A program of that name which runs a shell script; the film's temporary path is in $out.
void write_script(const fs::path& path, const std::string& script) {
    write_file(path, "#!/bin/sh\nfor out; do :; done; out=${out#file:}\n" + script);
    fs::permissions(path, fs::perms::owner_all);
}

TEST(ViewFilm, SaysWhatToInstallWithoutFfmpeg) {
    const TemporaryFolder folder;
    const Environment path("PATH", folder.path());
    EXPECT_TRUE(fails_with([&] { const Film film(folder.path() / "a.mp4", 8, 8, 33.0); }, "apt-get install ffmpeg"));
    EXPECT_TRUE(names(folder.path()).empty());
}

TEST(ViewFilm, HandsEveryPixelToFfmpegAndRenamesTheFilm) {
    const TemporaryFolder folder, programs;
    write_script(programs.path() / "ffmpeg", "exec /bin/cat >\"$out\"\n");
    const Environment path("PATH", programs.path());
    Film film(folder.path() / "a.mp4", 20, 10, 33.0);
    for (int k = 0; k < 5; ++k) film.add(grey(20, 10));
    film.close();
    EXPECT_EQ(names(folder.path()), (std::set<std::string>{"a.mp4"}));
    EXPECT_EQ(fs::file_size(folder.path() / "a.mp4"), 5U * 20U * 10U * 4U);
}

TEST(ViewFilm, LeavesNothingWhenFfmpegFailsOrTheFilmIsNotClosed) {
    const TemporaryFolder folder, programs;
    const Environment path("PATH", programs.path());
    write_script(programs.path() / "ffmpeg", "/bin/cat >\"$out\"; echo no such codec >&2; exit 3\n");
    const std::string said = error_of([&] {
        Film film(folder.path() / "a.gif", 8, 8, 33.0);
        film.add(grey(8, 8));
        film.close();
    });
    EXPECT_TRUE(says(said, "no such codec"));
    { Film(folder.path() / "a.gif", 8, 8, 33.0).add(grey(8, 8)); }
    EXPECT_TRUE(names(folder.path()).empty());
}

// ---- ParaView ----

/// The elements of a well-formed text, by name.
std::map<std::string, int> parse_xml(const std::string& text) {
    pugi::xml_document xml;
    EXPECT_TRUE(xml.load_string(text.c_str())) << text;
    std::map<std::string, int> count;
    for (const pugi::xpath_node& found : xml.select_nodes("//*")) ++count[found.node().name()];
    return count;
}

/// The numbers of the data array of that name, of which there are `count`.
std::vector<double> numbers(const std::string& text, const std::string& name, std::size_t count) {
    const std::size_t tag = text.find("Name=\"" + name + "\"");
    EXPECT_NE(tag, std::string::npos) << name;
    const std::size_t begin = text.find('>', tag) + 1;
    std::istringstream in(text.substr(begin, text.find('<', begin) - begin));
    std::vector<double> values{std::istream_iterator<double>(in), {}};
    EXPECT_EQ(values.size(), count) << name;
    values.resize(count);
    return values;
}

TEST(ViewVtu, IsWellFormedAndHoldsTheDeformedSurface) {
    const TemporaryFolder folder;
    write_cube_tables(folder.path());
    const Tables tables = read_tables(folder.path());
    DrawnSurface surface(tables);
    const std::vector<float> ones(3 * tables.row_id.size(), 1.0F);
    surface.deform(ones);
    const NodalForce load{112, {0.25F, -0.5F, 2.0F}};
    const std::string text = vtu_text(surface, {&load, 1});
    const auto count = parse_xml(text);
    EXPECT_EQ(count.at("Piece"), 1);
    EXPECT_EQ(count.at("DataArray"), 8);
    EXPECT_TRUE(says(text, "NumberOfPoints=\"98\" NumberOfCells=\"192\""));
    const auto position = numbers(text, "position_m", 3 * 98), displacement = numbers(text, "displacement_m", 3 * 98),
               force = numbers(text, "force_n", 3 * 98), node = numbers(text, "node", 98);
    for (std::size_t i = 0; i < 98; ++i) {
        const auto& rest = tables.position[std::size_t(node[i])];
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_EQ(displacement[3 * i + c], rest[2] > 0.0 ? 1.0 : 0.0);
            EXPECT_WITHIN(std::abs(position[3 * i + c] - rest[c] - displacement[3 * i + c]), .count = 8,
                          .epsilon = kFloat, .size = 1.03);
            EXPECT_EQ(force[3 * i + c], node[i] == 112 ? load.force_n[c] : 0.0F);
        }
    }
    numbers(text, "connectivity", 3 * 192);
    EXPECT_EQ(numbers(text, "offsets", 192).back(), 3 * 192.0);
    EXPECT_EQ(numbers(text, "types", 192), std::vector<double>(192, 5.0));
}

TEST(ViewVtu, ASeriesHasItsTimes) {
    const TemporaryFolder folder;
    write_cube_tables(folder.path() / "tables");
    const DrawnSurface surface(read_tables(folder.path() / "tables"));
    OwnFolder out(folder.path() / "series", kPictures);
    VtuSeries series(out);
    ContactFrame frame;
    series.add(surface, frame);
    frame.time_s = 0.033;
    series.add(surface, frame);
    series.close();
    const std::string pvd = read_file(out.path() / "frames.pvd");
    EXPECT_EQ(parse_xml(pvd).at("DataSet"), 4);
    EXPECT_TRUE(says(pvd, "timestep=\"0.033000\" part=\"0\" file=\"frame_000001.vtu\""));
    EXPECT_TRUE(says(pvd, "timestep=\"0.033000\" part=\"1\" file=\"contact_000001.vtu\""));
    EXPECT_EQ(names(out.path()), (std::set<std::string>{".haptable", "contact_000000.vtu", "contact_000001.vtu",
                                                        "frame_000000.vtu", "frame_000001.vtu", "frames.pvd"}));
}

TEST(ViewVtu, FingerAndGodObjectArePointsAndTheForceIsTheGodObjects) {
    ContactFrame frame;
    frame.finger_known = frame.contact = true;
    frame.finger_m = {0.25, 0.5, 0.125};
    frame.god_object_m = {0.25, 0.5, 0.75};
    frame.force_n = {1.0, -2.0, 4.0};
    const std::string text = contact_text(frame);
    parse_xml(text);
    EXPECT_EQ(numbers(text, "kind", 2), (std::vector<double>{0.0, 1.0}));
    EXPECT_EQ(numbers(text, "position_m", 6), (std::vector<double>{0.25, 0.5, 0.125, 0.25, 0.5, 0.75}));
    EXPECT_EQ(numbers(text, "force_n", 6), (std::vector<double>{0.0, 0.0, 0.0, 1.0, -2.0, 4.0}));
    EXPECT_EQ(numbers(text, "types", 2), (std::vector<double>{1.0, 1.0}));
    frame.contact = false;
    EXPECT_EQ(numbers(contact_text(frame), "kind", 1), std::vector<double>{0.0});
    frame.finger_known = false;
    EXPECT_TRUE(says(contact_text(frame), "NumberOfPoints=\"0\""));
}

}  // namespace
}  // namespace haptable::test
