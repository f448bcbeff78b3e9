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
#include "host/body/body.hpp"
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
    scene.file = "a/cube.toml";
    scene.device.max_force_n = 3.5;
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

/// What somebody does to a file.
using Change = std::function<void(const fs::path&)>;
struct Case {
    const char* file;
    Change change;
    const char* why;
};

template <typename T>
Change array_of(const std::vector<std::size_t>& shape, const std::vector<T>& values) {
    return [=](const fs::path& path) { write_npy<T>(path, shape, values); };
}

template <typename T>
Change values(const std::function<void(std::vector<T>&)>& to) {
    return [=](const fs::path& path) {
        Array<T> array = read_npy<T>(path);
        to(array.values);
        write_npy<T>(path, array.shape, array.values);
    };
}

template <typename T>
Change one_fewer() {
    return [](const fs::path& path) {
        Array<T> array = read_npy<T>(path);
        array.values.resize(array.values.size() - array.values.size() / array.shape[0]--);
        write_npy<T>(path, array.shape, array.values);
    };
}

Change times(double factor) {
    return values<double>([=](auto& values) {
        for (double& entry : values) entry *= factor;
    });
}

/// Another text for a value of a file of JSON.
Change with(const char* pointer, const std::string& value) {
    return [=](const fs::path& path) {
        json content = parse_json(read_file(path));
        content[json::json_pointer(pointer)] = "here";
        write_file(path, replaced(json_text(content), "\"here\"", value));
    };
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
            EXPECT_TRUE(says(said, "make the tables again")) << reader.name << ": " << said;
        }
    }
    /// With each of these changes alone, of which tables.json knows, a file is refused.
    void expect_refused(const std::vector<Case>& cases) const {
        const std::string known = read_file(folder_ / "tables.json");
        for (const auto& [file, change, why] : cases) {
            const std::string good = read_file(folder_ / file);
            change(folder_ / file);
            if (file != std::string("tables.json")) seal(folder_);
            expect_refused(file, why);
            write_file(folder_ / file, good);
            write_file(folder_ / "tables.json", known);
        }
    }

    const TemporaryFolder temporary_;
    const fs::path folder_ = temporary_.path() / "copy";
};

TEST_F(TamperedTables, AreWholeToBeginWith) {
    expect_accepted();
    seal(folder_);
    EXPECT_EQ(facts().at("tables_hash"), parse_json(read_file(made() / "tables.json")).at("tables_hash"));
    const Body body = make_body(every_part(), make_mesh(every_part().mesh));
    const Tables tables = read_tables(folder_);
    EXPECT_EQ(tables.options.text("device.handedness"), "right");  // that no member has
    EXPECT_EQ(tables.name, "cube4nu30");
    EXPECT_EQ(tables.scene_file, "cube.toml");
    EXPECT_EQ(tables.max_force_n, 3.5);
    EXPECT_EQ(tables.rigid_stiffness_n_per_m, 1000.0);
    EXPECT_NE(tables.model_hash, 0U);
    EXPECT_EQ(tables.surface, body.surface.patch);
    EXPECT_EQ(tables.patch, body.touch_patch);
    EXPECT_EQ(tables.node_id, body.touch_node);
    EXPECT_EQ(tables.node_id.size(), 4U * 4U * 4U - 8U) << "of a body that nothing holds all are free";
    EXPECT_EQ(tables.row_id, body.free_surface_node);
    ASSERT_EQ(tables.position.size(), body.mesh.position_m.size());
    for (std::size_t i = 0; i < tables.position.size(); ++i)
        EXPECT_EQ(Eigen::Vector3d(tables.position[i].data()), body.mesh.position_m[i]);
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
        for (const std::size_t left : {std::size_t{0}, good.size() / 2}) {  // where its hash is that of what is left
            write_file(folder_ / file, good.substr(0, left));
            seal(folder_);
            EXPECT_EQ(refusal(readers()[2]).rfind((folder_ / file).string(), 0), 0U) << refusal(readers()[2]);
        }
        write_file(folder_ / file, good);
        seal(folder_);
    }
    const std::string known = read_file(folder_ / "tables.json");
    for (const std::size_t left : {std::size_t{0}, known.size() / 2}) {
        write_file(folder_ / "tables.json", known.substr(0, left));
        expect_refused("tables.json", "");
    }
    EXPECT_GE(seen, 4U * 10U);
}

TEST_F(TamperedTables, ProgramsSaySo) {
    times(-1.0)(folder_ / "coupling.npy");
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

TEST_F(TamperedTables, ThatDoNotFitEachOtherAreRefused) {
    expect_refused({{"patch.npy", array_of<std::int32_t>({1, 3}, {0, 1, 64}), "names node 64 of a mesh of 64"},
                    {"node_id.npy", array_of<std::int32_t>({1}, {-1}), "names node -1"},
                    {"surface.npy", array_of<std::int32_t>({1, 2}, {0, 1}), "has 2 values a row where 3 belong"},
                    {"stiffness.npy", array_of({1, 3, 3}, std::vector<double>(9)), "has 1 entries where"},
                    {"tables.json", [](const fs::path& path) { write_file(path, "{\"name\": 3}"); }, ""},
                    {"tables.json", with("/model_hash", "\"x123456789abcdef\""), ""}});
}

// An object that pulls the finger in, and limits that limit nothing.
TEST_F(TamperedTables, AnObjectThatWouldPullIsRefused) {
    std::vector<Case> cases;
    for (const double factor : {-1.0, 0.0, std::nan("")})
        cases.push_back({"stiffness.npy", times(factor), "is not positive definite: it would pull"});
    for (const char* limit : {"/device/max_force", "/contact/rigid_stiffness"})
        for (const char* value : {"-1.0", "0.0", "1e999"}) cases.push_back({"options.json", with(limit, value), ""});
    for (const char* limit : {"/device/damping", "/device/encoder_step"})
        cases.push_back({"options.json", with(limit, "-1e-3"), "is no limit"});
    cases.push_back({"options.json", with("/contact/force", "\"harder\""), ""});
    expect_refused(cases);
}

TEST_F(TamperedTables, ACouplingThatPullsOrGivesMoreThanTheBodyIsRefused) {
    const auto of_places_1_and_0 = [](double entry) {  // 9 numbers behind those of 0 and 0
        return values<double>([=](auto& values) { std::fill_n(values.begin() + 9, 9, entry); });
    };
    expect_refused({{"coupling.npy", times(-1.0), "not positive definite"},
                    {"coupling.npy", of_places_1_and_0(100.0), "couple by more than they give"},
                    {"coupling.npy", of_places_1_and_0(std::nan("")), "couple by more than they give"}});
}

TEST_F(TamperedTables, ABodyThatFeedsAMotionIsRefused) {
    expect_refused({{"body.json", with("/mass_kg", "-1.0"), "mass_kg holds -1"},
                    {"body.json", with("/mass_kg", "0.0"), "mass_kg holds 0"},
                    {"body.json", [](const fs::path& path) { write_file(path, "{\"mass_kg\": 1}"); }, "centre_m"},
                    {"body.json", with("/inertia_kg_m2/1", "-1e-6"), "inertia_kg_m2 is not positive definite"},
                    {"body.json", with("/inertia_kg_m2/3", "1.0"), "inertia_kg_m2 is not positive definite"},
                    {"body.json", with("/damping_n_s_per_m/0", "-1.0"), "damping_n_s_per_m holds -1"},
                    {"body.json", with("/floor_friction", "-0.5"), "floor_friction holds -0.5"},
                    {"body.json", with("/floor_normal/2", "2.0"), "floor_normal has length 2"},
                    {"body.json", with("/point_m/0/0", "1e300"), "point_m"}});
}

TEST_F(TamperedTables, ModesThatGrowAreRefused) {
    const Change endless = values<double>([](auto& values) { values[4] = HUGE_VAL; });
    expect_refused({{"modes.json", with("/omega_rad_per_s/0", "-300.0"), "positive and ascend"},
                    {"modes.json", with("/omega_rad_per_s/1", "0.0"), "positive and ascend"},
                    {"modes.json", with("/damping_ratio", "-0.1"), "damping_ratio = -0.1"},
                    {"modes.json", with("/damping_ratio", "1.0"), "damping_ratio = 1"},
                    {"mode_shape.npy", endless, "number 4 of it is not finite"}});
}

/// Two fingers whose coupling is in clusters: of points, or of a mask's patches.
class TamperedClusters : public TamperedTables {
protected:
    void SetUp() override {}
    void make(ForceLaw force) const {
        Scene scene = for_two(cube_scene(6, 0.3), 60'000);
        scene.contact.force = force;
        scene.contact.mask_radius_m = force == ForceLaw::kPressureMask ? 0.006 : 0.0;
        Progress quiet(true);
        precompute(scene, folder_, quiet);
        ASSERT_TRUE(fs::exists(folder_ / "coupling_fine.npy")) << "all pairs fit: give fewer bytes";
    }
    void expect_written_as_read() const {
        const fs::path again = temporary_.path() / "again";
        fs::create_directory(again);
        write_pair(*read_pair(folder_), again);
        for (const fs::directory_entry& file : fs::directory_iterator(again))
            EXPECT_TRUE(read_file(file.path()) == read_file(folder_ / file.path().filename())) << file;
    }
};

TEST_F(TamperedClusters, ThatPullOrDoNotFitAreRefused) {
    make(ForceLaw::kConsistent);
    expect_written_as_read();
    const Change negative = values<std::int16_t>([](auto& values) {
        for (std::int16_t& entry : values) entry = static_cast<std::int16_t>(-entry);
    });
    const Change form = values<std::uint8_t>([](auto& values) { values.front() = 13; });
    expect_refused({{"coupling_fine.npy", negative, "couples a place of patch 0 with itself by a block"},
                    {"coupling_place.npy", values<std::int32_t>([](auto& values) { values[7] = 10'000; }), ""},
                    {"coupling_core.npy", one_fewer<std::int8_t>(), ""},
                    {"coupling_fine.npy", one_fewer<std::int16_t>(), ""},
                    {"coupling_form.npy", form, ""},
                    {"coupling_step.npy", one_fewer<float>(), ""},
                    {"tables.json", with("/pair", "{\"meeting_m\": 1, \"controls\": 100, \"rank\": 3}"),
                     ""}});  // of an earlier one
}

TEST_F(TamperedClusters, ThatPatchesLoadDoNotFitAreRefused) {
    make(ForceLaw::kPressureMask);
    expect_written_as_read();
    expect_refused({{"coupling_load_place.npy", values<std::int32_t>([](auto& values) { values[2] = 10'000; }), ""},
                    {"coupling_load_begin.npy", values<std::int32_t>([](auto& values) { values[1] = 10'000; }), ""}});
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
