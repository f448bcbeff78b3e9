// SPDX-License-Identifier: GPL-2.0-or-later
// Every file of a folder, changed, under every program that reads it: refused, by the file's name. With a hash that was
// mended, what a servo must not be given is refused all the same.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "codegen/codegen.hpp"
#include "codegen/export.hpp"
#include "codegen/loaded_scene.hpp"
#include "codegen/rigid_body.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "host/library/haptable_library.h"
#include "host/page/page.hpp"
#include "host/precompute/precompute.hpp"
#include "host/tables/npy.hpp"
#include "host/view/painter.hpp"
#include "tests/bodies.hpp"
#include "tests/error_of.hpp"
#include "tests/process.hpp"
#include "tests/sealed.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Of all that a folder may hold: two fingers on a jelly that nothing holds, drawn.
Scene every_part() {
    Scene scene = cube_scene(4, 0.3);
    set_free(scene);
    scene.gravity = Gravity{};
    scene.gravity->acceleration_m_per_s2 = {0.0, 0.0, -9.81};
    scene.gravity->density_kg_per_m3 = 1000.0;
    scene.free_body->floor = FreeBody::Floor{-0.001, {0.0, 0.0, 1.0}, 0.3};
    scene.body_modes = BodyModes{3, 0.05, 0.0, 0.0, 1};
    scene.contact.fingers = 2;
    return scene;
}

/// A name, what it does with a folder, and whether it needs a picture's files.
struct Reader {
    const char* name;
    std::function<void(const fs::path&)> read;
    bool draws;
};

std::vector<Reader> readers() {
    std::vector<Reader> all{{"codegen", [](const fs::path& folder) { generate_model(folder); }, false},
                            {"bridge, target, strokes",
                             [](const fs::path& folder) { const LoadedScene scene{TablesFolder(folder)}; }, false},
                            {"library, Python",
                             [](const fs::path& folder) {
                                 haptable_object* const object = haptable_object_load(folder.c_str(), 0);
                                 if (object == nullptr) throw Error(haptable_library_error());
                                 haptable_object_free(object);
                             },
                             true},
                            {"viewer",
                             [](const fs::path& folder) {
                                 const Tables tables = read_tables(folder);
                                 const Painter painter(tables, folder, {}, true);
                             },
                             true}};
    if (fs::exists(build_folder() / "lib/page/servo.wasm"))
        all.push_back({"page", [](const fs::path& folder) { make_page(folder, build_folder() / "lib/page"); }, true});
    return all;
}

class TamperedTables : public testing::Test {
protected:
    static const fs::path& made() {
        static const TemporaryFolder folder;
        static const fs::path tables = folder.path() / "tables";
        if (!fs::exists(tables)) {
            Progress quiet(true);
            precompute(every_part(), tables, quiet);
        }
        return tables;
    }
    void SetUp() override { fs::copy(made(), folder_); }

    json facts() const { return parse_json(read_file(folder_ / "tables.json")); }
    std::string refusal(const Reader& reader) const {
        return error_of([&] { reader.read(folder_); });
    }
    void expect_accepted() const {
        for (const Reader& reader : readers()) EXPECT_EQ(refusal(reader), "no error") << reader.name;
    }
    void expect_refused(const std::string& file, const std::string& why) const {
        for (const Reader& reader : readers()) {
            if (std::string(reader.name) == "viewer") continue;  // it draws whatever pushes
            const std::string said = refusal(reader);
            EXPECT_EQ(said.rfind((folder_ / file).string() + ": ", 0), 0U) << reader.name << ": " << said;
            EXPECT_TRUE(says(said, why)) << reader.name << ": " << said;
        }
    }
    template <typename T>
    void change(const char* file, const std::function<void(std::vector<T>&)>& to) const {
        Array<T> array = read_npy<T>(folder_ / file);
        to(array.values);
        write_npy<T>(folder_ / file, array.shape, array.values);
        seal(folder_);
    }
    /// With each of these values at its place in a file of JSON it is refused.
    void expect_refused(const char* file,
                        const std::vector<std::tuple<const char*, double, const char*>>& values) const {
        const std::string good = read_file(folder_ / file);
        for (const auto& [pointer, value, why] : values) {
            json content = parse_json(good);
            content[json::json_pointer(pointer)] = value;
            write_file(folder_ / file, json_text(content));
            seal(folder_);
            expect_refused(file, why);
        }
        write_file(folder_ / file, good);
    }

    const TemporaryFolder temporary_;
    const fs::path folder_ = temporary_.path() / "copy";
};

TEST_F(TamperedTables, AreWholeToBeginWith) {
    expect_accepted();
    seal(folder_);
    EXPECT_EQ(facts().at("tables_hash"), parse_json(read_file(made() / "tables.json")).at("tables_hash"));
}

// It is for people and scripts.
TEST_F(TamperedTables, NoProgramReadsTheSummary) {
    const fs::path summary = folder_ / "summary.json";
    const std::string good = read_file(summary);
    for (const char* text : {"", "{\"hash\": 3, \"drawing\": \"none\"", "\xff"}) {
        fs::remove(summary);
        if (*text != '\0') write_file(summary, text);
        expect_accepted();
        const std::string folder = folder_.string();
        for (const std::string& command :
             {program("haptable-codegen").string() + " " + folder,
              program("haptable-view").string() + " " + folder + " --mesh -o pictures --quiet"}) {
            const Outcome ended = run(command, temporary_.path(), std::chrono::seconds(60));
            EXPECT_EQ(ended.status, 0) << command << ended.err;
        }
        Progress quiet(true);
        const Result again = precompute(every_part(), folder_, quiet);
        EXPECT_FALSE(again.unchanged) << "the summary is part of what is asked for";
        const json told = parse_json(read_file(summary));
        for (const char* key : {"tables_hash", "model_hash", "checks", "counts", "hash"})
            EXPECT_EQ(told.at(key), parse_json(good).at(key)) << key;
    }
}

TEST_F(TamperedTables, OneBitOfAnyFileIsSeenByEveryProgramThatReadsIt) {
    // What each kind of program does without.
    const std::set<std::string> written{"model.h", "model.c", "mesh.vtu"}, drawn{"columns.npy"},
        of_servo{"coupling.npy", "body.json"};
    std::size_t seen = 0;
    const json hashes = facts().at("hash");
    for (const auto& [file, hash] : hashes.items()) {
        if (written.contains(file)) continue;
        const std::string good = read_file(folder_ / file);
        std::string bad = good;
        bad[bad.size() - 24] = static_cast<char>(bad[bad.size() - 24] ^ 1);
        write_file(folder_ / file, bad);
        for (const Reader& reader : readers()) {
            const bool views = std::string(reader.name) == "viewer";
            if ((drawn.contains(file) && !reader.draws) || (views && of_servo.contains(file))) continue;
            EXPECT_EQ(refusal(reader), (folder_ / file).string() +
                                           ": is not the file that was written with tables.json: make the tables again")
                << reader.name;
            ++seen;
        }
        fs::remove(folder_ / file);
        EXPECT_EQ(refusal(readers()[2]), (folder_ / file).string() + ": is missing: make the tables again");
        write_file(folder_ / file, good);
    }
    EXPECT_GE(seen, 4U * 10U);
}

TEST_F(TamperedTables, ProgramsSaySo) {
    Array<double> coupling = read_npy<double>(folder_ / "coupling.npy");
    for (double& entry : coupling.values) entry = -entry;
    write_npy<double>(folder_ / "coupling.npy", coupling.shape, coupling.values);
    const std::string folder = folder_.string();
    for (const std::string& command : {program("haptable-codegen").string() + " " + folder,
                                       program("haptable-bridge").string() + " " + folder + " --run true --quiet",
                                       program("haptable-view").string() + " " + folder + " --page a.html --quiet"}) {
        const Outcome ended = run(command, temporary_.path(), std::chrono::seconds(60));
        EXPECT_EQ(ended.status, 1) << command;
        EXPECT_TRUE(says(ended.err, folder + "/coupling.npy: is not the file that was written"))
            << command << ended.err;
    }
}

TEST_F(TamperedTables, ACouplingThatPullsOrGivesMoreThanTheBodyIsRefused) {
    const std::string good = read_file(folder_ / "coupling.npy");
    const auto of_places_1_and_0 = [](double entry) {  // 9 numbers behind those of 0 and 0
        return [entry](std::vector<double>& values) { std::fill_n(values.begin() + 9, 9, entry); };
    };
    const std::pair<std::function<void(std::vector<double>&)>, const char*> changes[] = {
        {[](auto& values) {
             for (double& entry : values) entry = -entry;
         },
         "not positive definite"},
        {of_places_1_and_0(100.0), "couple by more than they give"},
        {of_places_1_and_0(std::nan("")), "couple by more than they give"}};
    for (const auto& [to, why] : changes) {
        write_file(folder_ / "coupling.npy", good);
        change<double>("coupling.npy", to);
        expect_refused("coupling.npy", why);
    }
}

TEST_F(TamperedTables, ABodyThatFeedsAMotionIsRefused) {
    expect_refused("body.json", {{"/mass_kg", -1.0, "mass_kg holds -1"},
                                 {"/mass_kg", 0.0, "mass_kg holds 0"},
                                 {"/inertia_kg_m2/1", -1e-6, "inertia_kg_m2 is not positive definite"},
                                 {"/inertia_kg_m2/3", 1.0, "inertia_kg_m2 is not positive definite"},
                                 {"/damping_n_s_per_m/0", -1.0, "damping_n_s_per_m holds -1"},
                                 {"/floor_friction", -0.5, "floor_friction holds -0.5"},
                                 {"/floor_normal/2", 2.0, "floor_normal has length 2"},
                                 {"/point_m/0/0", 1e300, "point_m"}});
}

TEST_F(TamperedTables, ModesThatGrowAreRefused) {
    expect_refused("modes.json", {{"/omega_rad_per_s/0", -300.0, "positive and ascend"},
                                  {"/omega_rad_per_s/1", 0.0, "positive and ascend"},
                                  {"/damping_ratio", -0.1, "damping_ratio = -0.1"},
                                  {"/damping_ratio", 1.0, "damping_ratio = 1"}});
    seal(folder_);
    change<double>("mode_shape.npy", [](auto& values) { values[4] = HUGE_VAL; });
    expect_refused("mode_shape.npy", "number 4 of it is not finite");
}

TEST(TamperedClusters, OfACouplingThatPullAreRefused) {
    const TemporaryFolder temporary;
    const fs::path folder = temporary.path() / "tables";
    Scene scene = cube_scene(6, 0.3);
    scene.contact.fingers = 2;
    scene.tables.columns = ColumnRows::kNone;
    scene.tables.coupling_bytes = 60'000;
    Progress quiet(true);
    precompute(scene, folder, quiet);
    ASSERT_TRUE(fs::exists(folder / "coupling_fine.npy")) << "all pairs fit: give fewer bytes";
    Array<std::int16_t> fine = read_npy<std::int16_t>(folder / "coupling_fine.npy");
    for (std::int16_t& entry : fine.values) entry = static_cast<std::int16_t>(-entry);
    write_npy<std::int16_t>(folder / "coupling_fine.npy", fine.shape, fine.values);
    const auto said = [&] { return error_of([&] { const LoadedScene scene_of{TablesFolder(folder)}; }); };
    EXPECT_TRUE(says(said(), "coupling_fine.npy: is not the file"));
    seal(folder);
    EXPECT_TRUE(says(said(), "coupling_fine.npy: couples a place of patch 0 with itself by a block"));
}

TEST_F(TamperedTables, EveryPartIsInTheTablesHash) {
    SceneFiles files = read_scene_files(folder_);
    const std::uint64_t whole = LoadedScene(files).model().hash;
    EXPECT_EQ(whole, TablesFolder(folder_).tables_hash());
    const auto other = [&](const std::function<void(SceneFiles&)>& change) {
        SceneFiles changed = files;
        change(changed);
        return LoadedScene(changed).model().hash;
    };
    const std::set<std::uint64_t> hashes{whole,
                                         other([](SceneFiles& f) { f.pair->block[1][0] *= 0.999; }),
                                         other([](SceneFiles& f) { f.pair->meeting_m *= 2.0; }),
                                         other([](SceneFiles& f) { f.body->mass_kg *= 1.001F; }),
                                         other([](SceneFiles& f) { f.body->gravity_m_per_s2[2] = 0.0F; }),
                                         other([](SceneFiles& f) { f.body_modes->omega_rad_per_s[0] *= 0.999; }),
                                         other([](SceneFiles& f) { f.body_modes->shape[0][0] *= 1.001; }),
                                         other([](SceneFiles& f) { f.pair.reset(); }),
                                         other([](SceneFiles& f) { f.body.reset(); }),
                                         other([](SceneFiles& f) { f.body_modes.reset(); })};
    EXPECT_EQ(hashes.size(), 10U);
    // model.h and the page say the same.
    EXPECT_TRUE(says(read_file(folder_ / "model.h"), fmt::format("_HASH 0x{:016x}ULL", whole)));
}

// A name that leads out of the folder would have an endless file read; so would a link to one.
TEST_F(TamperedTables, NoOtherFilesThanTheFoldersAreRead) {
    json names = facts();
    for (const char* name : {"../../dev/zero", "/dev/zero", "..", ".", "", "a/b", "../tables/patch.npy"}) {
        json other = names;
        other["hash"][name] = "0123456789abcdef";
        write_file(folder_ / "tables.json", json_text(other));
        for (const Reader& reader : readers())
            EXPECT_EQ(refusal(reader), (folder_ / "tables.json").string() + ": names \"" + name +
                                           "\", which is no file of its folder: make the tables again");
    }
    write_file(folder_ / "tables.json", json_text(names));
    fs::remove(folder_ / "patch.npy");
    fs::create_symlink("/dev/zero", folder_ / "patch.npy");
    EXPECT_EQ(refusal(readers()[0]), (folder_ / "patch.npy").string() + ": is missing: make the tables again");
    fs::remove(folder_ / "tables.json");
    fs::create_symlink("/dev/zero", folder_ / "tables.json");
    EXPECT_EQ(refusal(readers()[0]), (folder_ / "tables.json").string() + ": is no file: make the tables again");
    // Tables that somebody broke are made again; haptable-precompute does not wait for an end that never comes.
    Progress quiet(true);
    fs::remove(folder_ / "tables.json");
    names["hash"]["../../dev/zero"] = "0123456789abcdef";
    fs::remove(folder_ / "patch.npy");
    write_file(folder_ / "tables.json", json_text(names));
    EXPECT_FALSE(precompute(every_part(), folder_, quiet).unchanged);
    EXPECT_TRUE(precompute(every_part(), folder_, quiet).unchanged);
}

}  // namespace
}  // namespace haptable::test
