// SPDX-License-Identifier: GPL-2.0-or-later
// The library beside what codegen writes: the same bits, in every mode. And equation 8, hashes, and what is refused.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "codegen/loaded_scene.hpp"
#include "codegen/loads.hpp"
#include "host/base/file.hpp"
#include "host/base/hash.hpp"
#include "host/library/haptable_library.h"
#include "host/session/local_stepper.hpp"
#include "host/session/scene_state.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"
#include "host/view/deformation.hpp"
#include "host/view/drawn_modes.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

struct FreeObject {
    void operator()(haptable_object* object) const { haptable_object_free(object); }
};
struct FreeFingers {
    void operator()(haptable_fingers* fingers) const { haptable_fingers_free(fingers); }
};
using Fingers = std::unique_ptr<haptable_fingers, FreeFingers>;
struct FreeFinger {
    void operator()(haptable_finger* finger) const { haptable_finger_free(finger); }
};
using Object = std::unique_ptr<haptable_object, FreeObject>;
using Finger = std::unique_ptr<haptable_finger, FreeFinger>;

/// The scene of a mode, as people write it.
std::string scene_text(const Mode& mode, const std::string& precision) {
    std::string text = read_file("meshes/cube.toml");
    const std::size_t contact = text.find("[contact]"), device = text.find("[device]");
    std::string chosen = fmt::format("[contact]\nforce = \"{}\"\ngod_object = \"{}\"\nrigid_stiffness = 1000.0\n",
                                     word(mode.force), word(mode.god_object));
    if (mode.force == ForceLaw::kPressureMask) chosen += "mask_radius = 0.012\n";
    if (mode.more == "friction") chosen += "friction = 0.5\nkinetic_friction = 0.4\n";
    if (mode.more == "passivity") chosen += "passivity = true\nrelease_slew = 0.05\n";
    text.replace(contact, device - contact, chosen + "\n");
    const std::string stored = "precision = \"";
    const std::size_t at = text.find(stored) + stored.size();
    text.replace(at, text.find('"', at) - at, precision);
    if (mode.more == "relaxation")
        text += "\n[[relaxation]]\nshare = 0.3\ntime = 0.01\n[[relaxation]]\nshare = 0.2\ntime = 0.2\n";
    return text;
}

/// What both programs are: a file of positions in, struct haptable_touch out.
constexpr const char* kMain =
    "#include <stdio.h>\n"
    "int main(int argc, char** argv) {\n"
    "    FILE* in = fopen(argv[argc - 1], \"rb\");\n"
    "    struct haptable_touch touch;\n"
    "    float x[3];\n"
    "    uint32_t us = 0;\n"
    "    if (!in || begin(argv[1]) != 0) return 1;\n"
    "    for (; fread(x, sizeof x, 1, in) == 1; us += 1000) {\n"
    "        tick(x, us, &touch);\n"
    "        fwrite(&touch, sizeof touch, 1, stdout);\n"
    "    }\n"
    "    return 0;\n"
    "}\n";

constexpr const char* kOfLibrary =
    "#include \"haptable_library.h\"\n"
    "static struct haptable_finger* finger;\n"
    "static int begin(const char* folder) {\n"
    "    struct haptable_object* object = haptable_object_load(folder, 0);\n"
    "    finger = object ? haptable_finger_new(object) : 0;\n"
    "    haptable_object_free(object);\n"  // the finger keeps it
    "    return finger == 0;\n"
    "}\n"
    "static void tick(const float x[3], uint32_t us, struct haptable_touch* touch) {\n"
    "    haptable_finger_step(finger, x, us, touch);\n"
    "}\n";

constexpr const char* kOfGenerated =
    "#include <string.h>\n"
    "#include \"haptable_library.h\"\n"
    "#include \"model.h\"\n"
    "static HAPTABLE_MODEL_STATE state;\n"
    "static int begin(const char* folder) {\n"
    "    (void)folder;\n"
    "    haptable_init(&HAPTABLE_MODEL_SCENE, &state);\n"
    "    haptable_check(&HAPTABLE_MODEL_SCENE, &state, HAPTABLE_CHECK_ALL);\n"
    "    return 0;\n"
    "}\n"
    "static void tick(const float x[3], uint32_t us, struct haptable_touch* touch) {\n"
    "    struct haptable_output out;\n"
    "    struct haptable_input in;\n"
    "    int c;\n"
    "    memcpy(in.finger_m, x, sizeof in.finger_m);\n"
    "    in.buttons = 0;\n"
    "    in.is_there = 1;\n"
    "    haptable_step(&HAPTABLE_MODEL_SCENE, &state, &in, us, &out);\n"
    "    touch->state = out.state;\n"
    "    touch->faults = out.faults;\n"
    "    for (c = 0; c < 3; ++c)\n"
    "        touch->node[c] = out.vertex[c] == HAPTABLE_NONE ? -1 : (int32_t)HAPTABLE_MODEL_NODE[out.vertex[c]];\n"
    "    memcpy(touch->alpha, out.alpha, sizeof out.alpha);\n"
    "    memcpy(touch->god_object_m, out.god_object_m, sizeof out.god_object_m);\n"
    "    memcpy(touch->force_n, out.force_n, sizeof out.force_n);\n"
    "    memcpy(touch->nodal_force_n, out.nodal_force_n, sizeof out.nodal_force_n);\n"
    "}\n";

std::string lib() { return fs::absolute(build_folder() / "lib").string(); }

class Library : public testing::Test {
protected:
    void SetUp() override {
        if (!fs::exists(lib() + "/libhaptable.so.1")) GTEST_SKIP() << "libhaptable.so.1 is not built: make library";
    }
    /// Tables and C of a scene in `folder_`/tables.
    void precompute(const std::string& scene) const {
        write_file(folder_.path() / "scene.toml", scene);
        const Outcome made =
            run(program("haptable-precompute").string() + " --quiet scene.toml -o tables", folder_.path());
        ASSERT_EQ(made.status, 0) << made.err;
    }
    /// They are `object` then.
    void load(const std::string& scene) {
        ASSERT_NO_FATAL_FAILURE(precompute(scene));
        object.reset(haptable_object_load(tables_.c_str(), 0));
        ASSERT_NE(object, nullptr) << haptable_library_error();
    }
    /// The same in memory, with the host's servo.
    LoadedScene in_host() const { return LoadedScene(TablesFolder(tables_)); }
    void compile(const std::string& name, const std::string& text, const std::string& with) const {
        write_file(folder_.path() / (name + ".c"), text + kMain);
        const Outcome compiled =
            run(fmt::format(
                    "gcc -std=c99 -O2 -ffp-contract=off -I{0}/host/library -I{0}/firmware -Itables {1}.c {2} -o {1}",
                    fs::current_path().string(), name, with),
                folder_.path());
        ASSERT_EQ(compiled.status, 0) << compiled.err;
    }
    std::string touches_of(const std::string& name) const {
        const Outcome felt = run("./" + name + " tables path", folder_.path());
        EXPECT_EQ(felt.status, 0) << felt.err;
        return felt.out;
    }
    void write_path(const std::vector<std::array<float, 3>>& path_m) const {
        write_file(folder_.path() / "path", {reinterpret_cast<const char*>(path_m.data()), path_m.size() * 12});
    }
    void expect_same_bits(const Mode& mode, const std::string& precision) const {
        SCOPED_TRACE(mode.name() + " " + precision);
        ASSERT_NO_FATAL_FAILURE(precompute(scene_text(mode, precision)));
        compile("generated", kOfGenerated, "tables/model.c " + fs::absolute(build_folder()).string() + "/firmware/*.o");
        if (!fs::exists(folder_.path() / "loaded"))  // of any mode
            compile("loaded", kOfLibrary, "-L" + lib() + " -lhaptable -Wl,-rpath," + lib());
        const std::vector<std::array<float, 3>> path_m = hard_path(read_tables(folder_.path() / "tables"), 100);
        write_path(path_m);
        const std::string loaded = touches_of("loaded"), generated = touches_of("generated");
        ASSERT_EQ(loaded.size(), path_m.size() * sizeof(haptable_touch));
        EXPECT_EQ(loaded == generated, true) << "other bits";
        std::size_t contacts = 0;
        for (std::size_t i = 0; i < loaded.size(); i += sizeof(haptable_touch))
            contacts += loaded[i] == HAPTABLE_TOUCH_CONTACT;
        EXPECT_GT(contacts, path_m.size() / 4);
    }

    const TemporaryFolder folder_;
    const fs::path tables_ = folder_.path() / "tables";
    Object object;
};

TEST_F(Library, HasTheBitsOfTheGeneratedServoInEveryMode) {
    for (const Mode& mode : every_mode()) ASSERT_NO_FATAL_FAILURE(expect_same_bits(mode, "float32"));
}

TEST_F(Library, HasTheBitsOfPackedTables) {
    for (const char* precision : {"float16", "int16"})
        ASSERT_NO_FATAL_FAILURE(expect_same_bits({ForceLaw::kConsistent, GodObject::kLeastEnergy, ""}, precision));
}

TEST_F(Library, HasTheBitsOfBodiesThatRelax) {
    for (const GodObject god_object : every<GodObject>())
        ASSERT_NO_FATAL_FAILURE(expect_same_bits({ForceLaw::kConsistent, god_object, "relaxation"}, "float32"));
}

/// What a body remembers is each finger's own; and where a finger has left, its dent is still there.
TEST_F(Library, GivesEachFingerItsOwnPast) {
    haptable_touch expected{}, touch{}, aside{};
    for (const char* more : {"friction", "relaxation"}) {
        ASSERT_NO_FATAL_FAILURE(load(scene_text({ForceLaw::kInterpolated, GodObject::kLeastEnergy, more}, "float32")));
        const Finger alone(haptable_finger_new(object.get())), one(haptable_finger_new(object.get())),
            other(haptable_finger_new(object.get()));
        for (std::uint32_t tick = 0; tick < 100; ++tick) {
            const float way_m = 4e-5F * float(tick);  // friction holds, and then slips
            const float x[3] = {0.013F + way_m, 0.015F, 0.0262F}, above[3] = {0.013F + way_m, 0.015F, 0.031F},
                        y[3] = {0.01F, 0.02F - way_m, tick > 0 ? 0.027F : 0.031F};
            const bool is_in = tick > 0 && tick < 99;
            haptable_finger_step(alone.get(), is_in ? x : above, 1000 * tick, &expected);
            haptable_finger_step(one.get(), is_in ? x : above, 1000 * tick, &touch);
            haptable_finger_step(other.get(), y, 1000 * tick, &aside);
            ASSERT_EQ(std::memcmp(&touch, &expected, sizeof touch), 0) << more << ", tick " << tick;
        }
        EXPECT_EQ(aside.state, std::uint32_t{HAPTABLE_TOUCH_CONTACT}) << more;
    }
    EXPECT_EQ(touch.state, std::uint32_t{HAPTABLE_TOUCH_FREE});
    ASSERT_GE(touch.node[0], 0) << "no dent";
    std::vector<std::array<float, 3>> u(haptable_object_describe(object.get()).row_count);
    ASSERT_EQ(haptable_object_deform(object.get(), &touch, nullptr, u.size(), reinterpret_cast<float(*)[3]>(u.data())),
              0);
    const auto deepest = std::min_element(u.begin(), u.end(), [](const auto& a, const auto& b) { return a[2] < b[2]; });
    EXPECT_LT((*deepest)[2], -1e-4F) << "of 3.8 mm";
}

TEST_F(Library, ExportsItsOwnNamesAlone) {
    const Outcome names = run("nm -D --defined-only " + lib() + "/libhaptable.so.1 | awk '$2 != \"A\" { print $3 }'");
    ASSERT_EQ(names.status, 0);
    EXPECT_NE(names.out.find("haptable_finger_step@@HAPTABLE_1\n"), std::string::npos);
    const Outcome others = run("nm -D --defined-only " + lib() +
                               "/libhaptable.so.1 | grep -vE ' (A HAPTABLE_1|T "
                               "haptable_(library|object|fingers?|held)_[a-z_]*@@HAPTABLE_1)$'");
    EXPECT_EQ(others.out, "");
}

TEST_F(Library, DeformsByEquation8) {
    for (const char* columns : {"", "column_precision = \"float16\"\n"}) {
        ASSERT_NO_FATAL_FAILURE(
            load(scene_text({ForceLaw::kPressureMask, GodObject::kNearest, ""}, "float32") + columns));
        const Finger finger(haptable_finger_new(object.get()));
        haptable_touch touch;
        for (std::uint32_t tick = 0; tick < 60; ++tick) {
            const float position_m[3] = {0.014F, 0.016F, 0.032F - 1e-4F * static_cast<float>(tick)};
            haptable_finger_step(finger.get(), position_m, 1000 * tick, &touch);
        }
        ASSERT_EQ(touch.state, std::uint32_t{HAPTABLE_TOUCH_CONTACT});

        const Tables tables = read_tables(tables_);
        const ContactLoads loads(tables);
        Deformation deformation(tables, tables_);
        std::vector<NodalForce> on_patch;
        for (std::size_t c = 0; c < 3; ++c) on_patch.push_back({touch.node[c], std::to_array(touch.nodal_force_n[c])});
        const std::vector<NodalForce> spread = loads.spread(on_patch);
        const std::span<const float> expected = deformation.displace(spread);
        const std::size_t rows = tables.row_id.size();
        std::vector<std::array<float, 3>> u(rows);
        auto* const out = reinterpret_cast<float(*)[3]>(u.data());
        ASSERT_EQ(haptable_object_deform(object.get(), &touch, nullptr, rows, out), 0) << haptable_library_error();
        float largest_m = 0.0F, error_m = 0.0F;
        for (std::size_t i = 0; i < 3 * rows; ++i) {
            largest_m = std::max(largest_m, std::abs(expected[i]));
            error_m = std::max(error_m, std::abs(expected[i] - u[i / 3][i % 3]));
        }
        EXPECT_GT(largest_m, 1e-3F);
        // Both round each product and sum of 3 of every load once; the loads of a mask do not cancel.
        EXPECT_WITHIN(error_m, .count = 2.0 * std::sqrt(6.0 * static_cast<double>(spread.size())), .epsilon = kFloat,
                      .size = 2.0 * static_cast<double>(largest_m));

        const std::uint32_t chosen[] = {static_cast<std::uint32_t>(rows - 1), 7};
        std::array<std::array<float, 3>, 2> two{};
        ASSERT_EQ(haptable_object_deform(object.get(), &touch, chosen, 2, reinterpret_cast<float(*)[3]>(two.data())),
                  0);
        EXPECT_EQ(two[0], u[rows - 1]);
        EXPECT_EQ(two[1], u[7]);
        const std::uint32_t none = static_cast<std::uint32_t>(rows);
        EXPECT_EQ(haptable_object_deform(object.get(), &touch, &none, 1, out), -1);
        EXPECT_EQ(haptable_library_error(), fmt::format("there is no row {}: {} has {}", rows, tables.name, rows));
    }
}

TEST_F(Library, RefusesTablesThatWereChanged) {
    ASSERT_NO_FATAL_FAILURE(load(scene_text({ForceLaw::kInterpolated, GodObject::kNearest, ""}, "float32")));
    const std::uint64_t hash = haptable_object_describe(object.get()).tables_hash;
    EXPECT_NE(Object(haptable_object_load(tables_.c_str(), hash)), nullptr);
    EXPECT_EQ(Object(haptable_object_load(tables_.c_str(), hash + 1)), nullptr);
    EXPECT_NE(std::string(haptable_library_error()).find("that are wanted"), std::string::npos);
    EXPECT_EQ(Object(haptable_object_load("no/such/folder", 0)), nullptr);
    EXPECT_NE(std::string(haptable_library_error()).find("no/such/folder/tables.json: is not there: make"),
              std::string::npos);

    for (const char* file : {"stiffness.npy", "columns.npy"}) {
        const std::string before = read_file(tables_ / file);
        std::string after = before;
        after.back() = static_cast<char>(after.back() ^ 1);
        write_file(tables_ / file, after);
        EXPECT_EQ(Object(haptable_object_load(tables_.c_str(), 0)), nullptr) << file;
        EXPECT_NE(std::string(haptable_library_error()).find(file), std::string::npos) << haptable_library_error();
        write_file(tables_ / file, before);
    }
    // An option, and then its hash: the tables are of another.
    const std::string options = read_file(tables_ / "options.json");
    std::string other = options, facts = read_file(tables_ / "tables.json");
    const std::size_t at = other.find("\"max_force\": 8.5");
    ASSERT_NE(at, std::string::npos);
    const std::string known = hash_file(tables_ / "options.json");
    write_file(tables_ / "options.json", other.replace(at, 16, "\"max_force\": 9.5"));
    EXPECT_EQ(Object(haptable_object_load(tables_.c_str(), 0)), nullptr);
    EXPECT_NE(std::string(haptable_library_error()).find("options.json: is not the file"), std::string::npos);
    write_file(tables_ / "tables.json",
               facts.replace(facts.find(known), known.size(), hash_file(tables_ / "options.json")));
    EXPECT_EQ(Object(haptable_object_load(tables_.c_str(), 0)), nullptr);
    EXPECT_NE(std::string(haptable_library_error()).find("not its tables_hash"), std::string::npos);
}

TEST_F(Library, ReplayIsManySteps) {
    ASSERT_NO_FATAL_FAILURE(load(scene_text({ForceLaw::kInterpolated, GodObject::kNearest, ""}, "float32")));
    const std::vector<std::array<float, 3>> path_m = hard_path(read_tables(tables_), 50);
    std::vector<haptable_touch> at_once(path_m.size()), singly(path_m.size());
    const Finger one(haptable_finger_new(object.get())), other(haptable_finger_new(object.get()));
    haptable_finger_replay(one.get(), reinterpret_cast<const float(*)[3]>(path_m.data()), path_m.size(), 5000,
                           at_once.data());
    for (std::size_t i = 0; i < path_m.size(); ++i)
        haptable_finger_step(other.get(), path_m[i].data(), 5000 + 1000 * static_cast<std::uint32_t>(i), &singly[i]);
    EXPECT_EQ(std::memcmp(at_once.data(), singly.data(), path_m.size() * sizeof(haptable_touch)), 0);
    EXPECT_EQ(haptable_finger_energy(one.get()).given_j, haptable_finger_energy(other.get()).given_j);
    EXPECT_GT(haptable_finger_energy(one.get()).most_stored_j, 0.0);
    ASSERT_STREQ(haptable_library_counter_name(0), "ticks");
    EXPECT_EQ(haptable_finger_counter(one.get(), 0), path_m.size());
    EXPECT_EQ(haptable_library_counter_name(haptable_library_counters()), nullptr);
    // Without a position for 20 ms the force ends.
    const auto last_us = 5000 + 1000 * static_cast<std::uint32_t>(path_m.size() - 1);
    haptable_touch touch{};
    EXPECT_EQ(haptable_finger_watch(one.get(), last_us + 19'000, &touch), 0);
    EXPECT_EQ(haptable_finger_watch(one.get(), last_us + 20'000, &touch), 1);
    EXPECT_EQ(touch.state, std::uint32_t{HAPTABLE_TOUCH_SILENT});
}

// Both at once as the firmware has it, and where the other is away what one finger feels.
TEST_F(Library, TwoFingersHaveTheServosBits) {
    std::string text = scene_text({ForceLaw::kConsistent, GodObject::kLeastEnergy, ""}, "float32");
    text.insert(text.find("[contact]\n") + 10, "fingers = 2\n");
    ASSERT_NO_FATAL_FAILURE(load(text));
    EXPECT_EQ(haptable_object_fingers(object.get()), 2U);
    const LoadedScene in_memory = in_host();
    SceneState host{in_memory.model(), in_memory.pair(), nullptr, nullptr};
    host.check(HAPTABLE_CHECK_ALL);

    const std::vector<std::array<float, 3>> first_m = hard_path(in_memory.tables(), 30);
    std::vector<std::array<float, 3>> second_m(first_m.rbegin(), first_m.rend());
    const auto* const firsts = reinterpret_cast<const float(*)[3]>(first_m.data());
    const auto* const seconds = reinterpret_cast<const float(*)[3]>(second_m.data());
    const Fingers fingers(haptable_fingers_new(object.get()));
    std::vector<std::array<haptable_touch, 2>> felt(first_m.size());
    std::vector<std::array<float, 3>> both_m;
    for (std::size_t i = 0; i < first_m.size(); ++i) both_m.insert(both_m.end(), {first_m[i], second_m[i]});
    haptable_fingers_replay(fingers.get(), reinterpret_cast<const float(*)[3]>(both_m.data()), first_m.size(), 0,
                            felt[0].data());
    std::size_t both = 0;
    for (std::size_t i = 0; i < first_m.size(); ++i) {
        haptable_input in[2]{};
        haptable_output out[2];
        for (haptable_input& one : in) one.is_there = 1;
        std::copy_n(firsts[i], 3, in[0].finger_m);
        std::copy_n(seconds[i], 3, in[1].finger_m);
        host.step(in, static_cast<std::uint32_t>(1000 * i), out);
        for (std::size_t f = 0; f < 2; ++f) {
            ASSERT_EQ(felt[i][f].state, out[f].state) << i;
            ASSERT_EQ(std::memcmp(felt[i][f].force_n, out[f].force_n, sizeof out[f].force_n), 0) << i;
            ASSERT_EQ(std::memcmp(felt[i][f].nodal_force_n, out[f].nodal_force_n, sizeof out[f].nodal_force_n), 0) << i;
        }
        both += felt[i][0].state == HAPTABLE_TOUCH_CONTACT && felt[i][1].state == HAPTABLE_TOUCH_CONTACT;
    }
    EXPECT_GT(both, 30U);
    EXPECT_EQ(haptable_fingers_counter(fingers.get(), 1, 0), first_m.size());
    EXPECT_GT(haptable_fingers_energy(fingers.get(), 1).most_stored_j, 0.0);

    const Fingers half(haptable_fingers_new(object.get()));
    const Finger alone(haptable_finger_new(object.get()));
    for (std::size_t i = 0; i < first_m.size(); ++i) {
        haptable_touch expected{}, touch[2]{};
        const float* const each_m[] = {nullptr, seconds[i]};
        haptable_fingers_step(half.get(), each_m, static_cast<std::uint32_t>(1000 * i), touch);
        haptable_finger_step(alone.get(), seconds[i], static_cast<std::uint32_t>(1000 * i), &expected);
        ASSERT_EQ(std::memcmp(&touch[1], &expected, sizeof expected), 0) << i;
        ASSERT_EQ(touch[0].state, std::uint32_t{HAPTABLE_TOUCH_SILENT});
    }
}

constexpr const char* kLoose = R"(name = "loose"
[mesh]
generate = "cube"
[material]
young = 20000.0
poisson = 0.45
[gravity]
density = 1000.0
[body]
free = true
floor = 0.0
floor_friction = 0.5
[contact]
force = "consistent"
god_object = "least-energy"
friction = 0.8
fingers = 2
)";

void expect_pose(const haptable_pose& pose, const haptable_body& body, const haptable_body_state& state) {
    EXPECT_EQ(std::memcmp(pose.rest_centre_m, body.centre_m, sizeof pose.rest_centre_m), 0);
    EXPECT_EQ(std::memcmp(pose.centre_m, state.position_m, sizeof pose.centre_m), 0);
    EXPECT_EQ(std::memcmp(pose.turn, state.turn, sizeof pose.turn), 0);
    EXPECT_EQ(std::memcmp(pose.velocity_m_per_s, state.velocity_m_per_s, sizeof pose.velocity_m_per_s), 0);
    EXPECT_EQ(std::memcmp(pose.spin_rad_per_s, state.spin_rad_per_s, sizeof pose.spin_rad_per_s), 0);
    EXPECT_EQ(pose.on_floor, state.on_floor);
}

// Two fingers grasp a body that nothing holds, and lift it; then one lets go, and it falls: as in a session.
TEST_F(Library, MovesAFreeBodyAsASessionDoes) {
    ASSERT_NO_FATAL_FAILURE(load(kLoose));
    EXPECT_EQ(haptable_object_is_free(object.get()), 1);
    const LoadedScene in_memory = in_host();
    haptable::LocalStepper session({&in_memory.model(), nullptr, "loose", in_memory.pair(), nullptr, in_memory.body()});

    const Fingers fingers(haptable_fingers_new(object.get()));
    ASSERT_NE(fingers, nullptr) << haptable_library_error();
    float most_lifted_m = 0.0F;
    for (std::uint32_t tick = 0; tick < 1500; ++tick) {
        const float in_m = 4e-6F * static_cast<float>(std::min(tick, 400U)) - 1e-4F;
        const float up_m = tick < 500 ? 0.0F : 2e-5F * static_cast<float>(tick - 500);
        const float first_m[3] = {in_m, 0.015F, 0.015F + up_m}, second_m[3] = {0.03F - in_m, 0.015F, 0.015F + up_m};
        const bool second_there = tick < 1300;
        haptable_touch touch[2];
        const float* const each_m[] = {first_m, second_there ? second_m : nullptr};
        haptable_fingers_step(fingers.get(), each_m, 1000 * tick, touch);
        FingerInputs in{FingerInput{std::to_array(first_m)}};
        if (second_there) in[1] = FingerInput{std::to_array(second_m)};
        session.tick(in, 1000 * tick);
        for (std::size_t finger = 0; finger < 2; ++finger) {
            const haptable_output& out = session.output(finger);
            ASSERT_EQ(touch[finger].state, out.state) << tick;
            ASSERT_EQ(std::memcmp(touch[finger].force_n, out.force_n, sizeof out.force_n), 0) << tick;
            ASSERT_EQ(std::memcmp(touch[finger].god_object_m, out.god_object_m, sizeof out.god_object_m), 0) << tick;
            ASSERT_EQ(std::memcmp(touch[finger].nodal_force_n, out.nodal_force_n, sizeof out.nodal_force_n), 0) << tick;
        }
        const haptable_pose pose = haptable_fingers_pose(fingers.get());
        ASSERT_NO_FATAL_FAILURE(expect_pose(pose, *in_memory.body(), *session.state().touched())) << tick;
        most_lifted_m = std::max(most_lifted_m, pose.centre_m[2] - pose.rest_centre_m[2]);
    }
    EXPECT_GT(most_lifted_m, 0.01F) << "of 16 mm that the hands rise";
    EXPECT_LT(haptable_fingers_pose(fingers.get()).centre_m[2], most_lifted_m + in_memory.body()->centre_m[2] - 0.005F)
        << "it falls";
    const haptable_touch_energy energy = haptable_fingers_energy(fingers.get(), 0);
    EXPECT_EQ(energy.given_j, session.report(0).energy.given_j());
    EXPECT_EQ(energy.most_stored_j, session.report(0).energy.most_stored_j());

    // One finger pushes it aside; another servo's body is its own.
    const Finger finger(haptable_finger_new(object.get()));
    haptable::LocalStepper pushed({&in_memory.model(), nullptr, "loose", nullptr, nullptr, in_memory.body()});
    for (std::uint32_t tick = 0; tick < 600; ++tick) {
        const float at_m[3] = {1e-5F * static_cast<float>(tick) - 1e-3F, 0.015F, 0.01F};
        haptable_touch touch;
        haptable_finger_step(finger.get(), at_m, 1000 * tick, &touch);
        pushed.tick({FingerInput{std::to_array(at_m)}}, 1000 * tick);
        ASSERT_EQ(std::memcmp(touch.force_n, pushed.output(0).force_n, sizeof touch.force_n), 0) << tick;
    }
    ASSERT_NO_FATAL_FAILURE(
        expect_pose(haptable_finger_pose(finger.get()), *in_memory.body(), *pushed.state().touched()));
    EXPECT_GT(haptable_finger_pose(finger.get()).centre_m[0], in_memory.body()->centre_m[0] + 1e-3F);
    EXPECT_EQ(haptable_finger_energy(finger.get()).most_stored_j, pushed.report(0).energy.most_stored_j());
}

// Held with friction, and free: knocks on a body that rings, as in a session; and the viewer's surface as it swings.
TEST_F(Library, RingsAsASessionDoes) {
    std::string held = scene_text({ForceLaw::kConsistent, GodObject::kNearest, "friction"}, "float32");
    held += "\n[body]\nmodes = 4\n[gravity]\ndensity = 1000.0\n";
    std::string loose = kLoose;
    loose.replace(loose.find("fingers = 2\n"), 12, "");
    loose.replace(loose.find("free = true\n"), 12, "free = true\nmodes = 4\n");
    for (const std::string& scene : {held, loose}) {
        ASSERT_NO_FATAL_FAILURE(load(scene));
        ASSERT_EQ(haptable_object_modes(object.get()), 4U);
        const LoadedScene in_memory = in_host();
        haptable::LocalStepper session(
            {&in_memory.model(), nullptr, "jelly", nullptr, in_memory.modes(), in_memory.body()});
        const Finger finger(haptable_finger_new(object.get())), other(haptable_finger_new(object.get()));
        std::vector<float> swung(4), others(4);
        const auto path = knock_path();
        for (std::size_t i = 0; i < path.size(); ++i) {
            const auto us = static_cast<std::uint32_t>(1000 * i);
            haptable_touch touch;
            haptable_finger_step(other.get(), path[(i + 350) % path.size()].data(), us, &touch);  // with its own past
            haptable_finger_step(finger.get(), path[i].data(), us, &touch);
            session.tick({FingerInput{path[i]}}, us);
            ASSERT_EQ(std::memcmp(touch.force_n, session.output(0).force_n, sizeof touch.force_n), 0) << i;
            haptable_finger_swung(finger.get(), swung.data());
            ASSERT_EQ(std::memcmp(swung.data(), session.state().modes()->q, 4 * sizeof(float)), 0) << i;
        }
        haptable_finger_swung(other.get(), others.data());
        ASSERT_NE(swung, others);

        const std::uint32_t count = haptable_object_describe(object.get()).row_count;
        std::vector<float> u(3 * std::size_t{count});
        auto* rows = reinterpret_cast<float(*)[3]>(u.data());
        ASSERT_EQ(haptable_object_swing(object.get(), swung.data(), nullptr, count, rows), 0);
        std::optional<DrawnModes> drawn = read_drawn_modes(in_memory.tables(), tables_);
        ContactFrame frame;
        frame.modes = swung;
        const auto wanted = drawn->add_to(std::vector<float>(u.size()), frame);
        double size_m = 0.0;
        for (const float x : wanted) size_m = std::max(size_m, std::abs(static_cast<double>(x)));
        EXPECT_GT(size_m, 1e-6);
        for (std::size_t k = 0; k < u.size(); ++k)
            EXPECT_WITHIN(std::abs(static_cast<double>(u[k] - wanted[k])), .count = 8, .epsilon = kFloat,
                          .size = size_m);
        const std::uint32_t one = count / 2, beyond = count;
        float three[1][3] = {{1.0F, 0.0F, 0.0F}};
        ASSERT_EQ(haptable_object_swing(object.get(), swung.data(), &one, 1, three), 0);
        EXPECT_WITHIN(std::abs(static_cast<double>(three[0][0] - 1.0F - u[3 * one])), .count = 8, .epsilon = kFloat)
            << "it adds";
        EXPECT_EQ(haptable_object_swing(object.get(), swung.data(), &beyond, 1, three), -1);
    }
}

// Held and free.
TEST_F(Library, TwoFingersRingAsASessionDoes) {
    std::string held = scene_text({ForceLaw::kConsistent, GodObject::kLeastEnergy, "friction"}, "float32");
    held.insert(held.find("[contact]\n") + 10, "fingers = 2\n");
    held += "\n[body]\nmodes = 4\n[gravity]\ndensity = 1000.0\n";
    std::string loose = kLoose;
    loose.replace(loose.find("free = true\n"), 12, "free = true\nmodes = 4\n");
    for (const std::string& scene : {held, loose}) {
        ASSERT_NO_FATAL_FAILURE(load(scene));
        const LoadedScene in_memory = in_host();
        haptable::LocalStepper session(
            {&in_memory.model(), nullptr, "jelly", in_memory.pair(), in_memory.modes(), in_memory.body()});
        const Fingers fingers(haptable_fingers_new(object.get()));
        ASSERT_NE(fingers, nullptr) << haptable_library_error();
        const auto path = knock_path();
        std::vector<float> swung(4);
        int both = 0;
        for (std::size_t i = 0; i < path.size(); ++i) {
            const auto us = static_cast<std::uint32_t>(1000 * i);
            const std::array<float, 3> second_m{0.022F, 0.014F, path[(i + 40) % path.size()][2]};
            const bool second_there = i % 200 > 30;
            haptable_touch touch[2];
            const float* const each_m[] = {path[i].data(), second_there ? second_m.data() : nullptr};
            haptable_fingers_step(fingers.get(), each_m, us, touch);
            FingerInputs in{FingerInput{path[i]}};
            if (second_there) in[1] = FingerInput{second_m};
            session.tick(in, us);
            for (std::size_t f = 0; f < 2; ++f)
                ASSERT_EQ(std::memcmp(touch[f].force_n, session.output(f).force_n, sizeof touch[f].force_n), 0) << i;
            haptable_fingers_swung(fingers.get(), swung.data());
            ASSERT_EQ(std::memcmp(swung.data(), session.state().modes()->q, 4 * sizeof(float)), 0) << i;
            both += touch[0].state == HAPTABLE_TOUCH_CONTACT && touch[1].state == HAPTABLE_TOUCH_CONTACT;
        }
        EXPECT_GT(both, 100);
    }
}

TEST_F(Library, HasNoPoseOfABodyThatIsHeld) {
    std::string scene = scene_text({ForceLaw::kInterpolated, GodObject::kNearest, ""}, "float32");
    ASSERT_NO_FATAL_FAILURE(load(scene));
    EXPECT_EQ(haptable_object_is_free(object.get()), 0);
    const Finger finger(haptable_finger_new(object.get()));
    const haptable_pose pose = haptable_finger_pose(finger.get());
    EXPECT_EQ(pose.turn[0], 1.0F);
    EXPECT_EQ(pose.centre_m[2], 0.0F);
    EXPECT_EQ(haptable_object_modes(object.get()), 0U);
}

TEST_F(Library, RefusesTwoFingersOfASceneWithOne) {
    ASSERT_NO_FATAL_FAILURE(load(scene_text({ForceLaw::kInterpolated, GodObject::kNearest, ""}, "float32")));
    EXPECT_EQ(haptable_object_fingers(object.get()), 1U);
    EXPECT_EQ(haptable_fingers_new(object.get()), nullptr);
    EXPECT_NE(std::string(haptable_library_error()).find("fingers = 2"), std::string::npos);
}

}  // namespace
}  // namespace haptable::test
