// SPDX-License-Identifier: GPL-2.0-or-later
// The library beside a session: the same bits, in every mode. And equation 8, hashes, and what is refused.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>
#include <regex>
#include <sstream>

#include "codegen/loaded_scene.hpp"
#include "codegen/loads.hpp"
#include "host/base/file.hpp"
#include "host/base/hash.hpp"
#include "host/library/haptable_library.h"
#include "host/precompute/precompute.hpp"
#include "host/session/local_stepper.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"
#include "host/view/deformation.hpp"
#include "host/view/drawn_modes.hpp"
#include "tests/error_of.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

template <auto free_it>
struct Freed {
    void operator()(auto* it) const { free_it(it); }
};
using Object = std::unique_ptr<haptable_object, Freed<haptable_object_free>>;
using Finger = std::unique_ptr<haptable_finger, Freed<haptable_finger_free>>;
using Fingers = std::unique_ptr<haptable_fingers, Freed<haptable_fingers_free>>;

using Places = std::vector<std::array<float, 3>>;

float (*rows_of(Places& places))[3] { return reinterpret_cast<float(*)[3]>(places.data()); }
const float (*rows_of(const Places& places))[3] { return reinterpret_cast<const float(*)[3]>(places.data()); }

template <typename T>
bool same(const T& a, const T& b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

/// The paper's cube, as it is touched in that mode.
Scene scene_of(const Mode& mode, int fingers = 1) {
    Scene scene = read_scene("meshes/cube.toml");
    ContactOptions& contact = scene.contact;
    contact.force = mode.force;
    contact.god_object = mode.god_object;
    contact.fingers = fingers;
    contact.mask_radius_m = mode.force == ForceLaw::kPressureMask ? 0.012 : 0.0;
    contact.release_n_per_ms = mode.god_object == GodObject::kLeastEnergy ? 0.01 : 0.0;
    if (mode.more == "friction") contact.static_friction = 0.5, contact.kinetic_friction = 0.4;
    if (mode.more == "passivity") contact.passivity = true, contact.release_n_per_ms = 0.05;
    if (mode.more == "stiffening") scene.material.stiffening = Stiffening{.curve = {{0.5, -0.5, 3.0}, 1e-4}};
    if (mode.more == "relaxation") scene.relaxation = {{0.3, 0.01}, {0.2, 0.2}};
    return scene;
}
const Mode kPlain{ForceLaw::kInterpolated, GodObject::kNearest, ""};

/// A program in C: a folder and a file of positions in, struct haptable_touch out.
constexpr const char* kProgram = R"(#include <stdio.h>
#include "haptable_library.h"
int main(int argc, char** argv) {
    FILE* in = fopen(argv[argc - 1], "rb");
    struct haptable_object* object = haptable_object_load(argv[1], 0);
    struct haptable_finger* finger = object ? haptable_finger_new(object) : 0;
    struct haptable_touch touch;
    float x[3];
    uint32_t us = 0;
    haptable_object_free(object); /* the finger keeps it */
    if (!in || !finger) return 1;
    for (; fread(x, sizeof x, 1, in) == 1; us += 1000) {
        haptable_finger_step(finger, x, us, &touch);
        fwrite(&touch, sizeof touch, 1, stdout);
    }
    return 0;
}
)";

std::string lib() { return fs::absolute(build_folder() / "lib").string(); }

class Library : public testing::Test {
protected:
    void SetUp() override {
        if (!fs::exists(lib() + "/libhaptable.so.1")) GTEST_SKIP() << "libhaptable.so.1 is not built: make library";
    }
    /// Tables of a scene in the folder; they are `object` then.
    void load(const Scene& scene) {
        Progress quiet(true);
        precompute(scene, tables_, quiet, {.code = false});
        object.reset(haptable_object_load(tables_.c_str(), 0));
        ASSERT_NE(object, nullptr) << haptable_library_error();
    }
    Finger new_finger() const { return Finger(haptable_finger_new(object.get())); }
    Places deformed(const haptable_touch& touch) const {
        Places u(haptable_object_describe(object.get()).row_count);
        EXPECT_EQ(haptable_object_deform(object.get(), &touch, nullptr, u.size(), rows_of(u)), 0)
            << haptable_library_error();
        return u;
    }
    /// The same in memory, with the host's servo.
    LoadedScene in_host() const { return LoadedScene(TablesFolder(tables_)); }
    const TemporaryFolder folder_;
    const fs::path tables_ = folder_.path() / "tables";
    Object object;
};

/// A scene's fingers in the library and in a session: in every tick they have the same bits.
class BesideASession {
public:
    BesideASession(const haptable_object* object, const LoadedScene& scene, std::size_t fingers)
        : session({&scene.model(), nullptr, "it", fingers > 1 ? scene.pair() : nullptr, scene.modes(), scene.body()}),
          scene_(scene),
          one_(fingers > 1 ? nullptr : haptable_finger_new(object)),
          two_(fingers > 1 ? haptable_fingers_new(object) : nullptr) {
        EXPECT_TRUE(one_ || two_) << haptable_library_error();
    }
    /// An empty one: the second finger is away.
    void tick(const std::array<float, 3>& first_m, const std::optional<std::array<float, 3>>& second_m = {}) {
        const float* const each_m[] = {first_m.data(), second_m ? second_m->data() : nullptr};
        FingerInputs in{FingerInput{first_m}};
        if (second_m) in[1] = FingerInput{*second_m};
        if (one_) haptable_finger_step(one_.get(), first_m.data(), time_us, touch);
        if (two_) haptable_fingers_step(two_.get(), each_m, time_us, touch);
        session.tick(in, time_us);
        for (std::size_t finger = 0; finger < (one_ ? 1U : 2U); ++finger) {
            const haptable_output& out = session.output(finger);
            ASSERT_EQ(touch[finger].state, out.state) << time_us;
            ASSERT_EQ(touch[finger].faults, out.faults) << time_us;
            for (int c = 0; c < 3; ++c)
                ASSERT_EQ(touch[finger].node[c],
                          out.vertex[c] == HAPTABLE_NONE ? -1 : int(scene_.node()[out.vertex[c]]));
            ASSERT_TRUE(same(touch[finger].alpha, out.alpha)) << time_us;
            ASSERT_TRUE(same(touch[finger].force_n, out.force_n)) << time_us;
            ASSERT_TRUE(same(touch[finger].god_object_m, out.god_object_m)) << time_us;
            ASSERT_TRUE(same(touch[finger].nodal_force_n, out.nodal_force_n)) << time_us;
        }
        if (scene_.body() != nullptr) {
            ASSERT_NO_FATAL_FAILURE(expect_pose()) << time_us;
        }
        if (scene_.modes() != nullptr) {
            ASSERT_EQ(std::memcmp(swung().data(), session.state().modes()->q, kModes * sizeof(float)), 0) << time_us;
        }
        both_ticks += touch[0].state == HAPTABLE_TOUCH_CONTACT && touch[1].state == HAPTABLE_TOUCH_CONTACT ? 1 : 0;
        time_us += 1000;
    }
    haptable_pose pose() const { return one_ ? haptable_finger_pose(one_.get()) : haptable_fingers_pose(two_.get()); }
    std::vector<float> swung() const {
        std::vector<float> swung(kModes);
        if (one_) haptable_finger_swung(one_.get(), swung.data());
        if (two_) haptable_fingers_swung(two_.get(), swung.data());
        return swung;
    }
    void expect_energy() const {
        const haptable_touch_energy energy =
            one_ ? haptable_finger_energy(one_.get()) : haptable_fingers_energy(two_.get(), 0);
        EXPECT_GT(energy.most_stored_j, 0.0);
        EXPECT_EQ(energy.given_j, session.report(0).energy.given_j());
        EXPECT_EQ(energy.most_stored_j, session.report(0).energy.most_stored_j());
    }

    static constexpr std::size_t kModes = 4;
    LocalStepper session;
    haptable_touch touch[2]{};
    std::uint32_t time_us = 0;
    int both_ticks = 0;  ///< in which both touched

private:
    void expect_pose() const {
        const haptable_body_state& state = *session.state().touched();
        ASSERT_TRUE(same(pose().rest_centre_m, scene_.body()->centre_m));
        ASSERT_TRUE(same(pose().centre_m, state.position_m));
        ASSERT_TRUE(same(pose().turn, state.turn));
        ASSERT_TRUE(same(pose().velocity_m_per_s, state.velocity_m_per_s));
        ASSERT_TRUE(same(pose().spin_rad_per_s, state.spin_rad_per_s));
        ASSERT_EQ(pose().on_floor, state.on_floor);
    }

    const LoadedScene& scene_;
    Finger one_;
    Fingers two_;
};

TEST_F(Library, HasASessionsBitsInEveryMode) {
    std::vector<std::pair<Mode, Storage>> cases;
    for (const Mode& mode : every_mode()) cases.emplace_back(mode, Storage::kFloat32);
    for (const Storage packed : {Storage::kFloat16, Storage::kInt16})
        cases.push_back({{ForceLaw::kConsistent, GodObject::kLeastEnergy, ""}, packed});
    for (const GodObject god_object : every<GodObject>())
        cases.push_back({{ForceLaw::kConsistent, god_object, "relaxation"}, Storage::kFloat32});
    for (const auto& [mode, precision] : cases) {
        SCOPED_TRACE(testing::Message() << mode.name() << ' ' << precision);
        Scene scene = scene_of(mode);
        scene.tables.precision = precision;
        ASSERT_NO_FATAL_FAILURE(load(scene));
        const LoadedScene in_memory = in_host();
        BesideASession hand(object.get(), in_memory, 1);
        const Finger other = new_finger();
        const Places path_m = hard_path(in_memory.tables(), 100);
        for (std::size_t i = 0; i < path_m.size(); ++i) {
            haptable_touch touch;  // what a body remembers is each finger's own
            haptable_finger_step(other.get(), path_m[path_m.size() - 1 - i].data(), hand.time_us, &touch);
            ASSERT_NO_FATAL_FAILURE(hand.tick(path_m[i]));
        }
        EXPECT_GT(hand.session.report().counters.contact_ticks, path_m.size() / 4);
    }
}

// A program in C steps through a path; a replay here is as many steps.
TEST_F(Library, ReplaysAsAProgramInCSteps) {
    ASSERT_NO_FATAL_FAILURE(load(scene_of(kPlain)));
    write_file(folder_.path() / "program.c", kProgram);
    const Places path_m = hard_path(read_tables(tables_), 100);
    write_file(folder_.path() / "path", {reinterpret_cast<const char*>(path_m.data()), path_m.size() * 12});
    const Outcome felt = run(fmt::format("gcc -std=c99 -Wall -Werror -I{}/host/library program.c -L{} -lhaptable "
                                         "-Wl,-rpath,{} -o program && ./program tables path",
                                         fs::current_path().string(), lib(), lib()),
                             folder_.path());
    ASSERT_EQ(felt.status, 0) << felt.err;
    const Finger finger = new_finger();
    std::vector<haptable_touch> replayed(path_m.size());
    haptable_finger_replay(finger.get(), rows_of(path_m), path_m.size(), 0, replayed.data());
    ASSERT_EQ(felt.out.size(), path_m.size() * sizeof(haptable_touch));
    EXPECT_EQ(std::memcmp(felt.out.data(), replayed.data(), felt.out.size()), 0) << "other bits";

    EXPECT_GT(haptable_finger_energy(finger.get()).most_stored_j, 0.0);
    ASSERT_STREQ(haptable_library_counter_name(0), "ticks");
    EXPECT_EQ(haptable_finger_counter(finger.get(), 0), path_m.size());
    EXPECT_EQ(haptable_library_counter_name(haptable_library_counters()), nullptr);
    // Without a position for 20 ms the force ends.
    const auto last_us = std::uint32_t(1000 * (path_m.size() - 1));
    haptable_touch touch{};
    EXPECT_EQ(haptable_finger_watch(finger.get(), last_us + 19'000, &touch), 0);
    EXPECT_EQ(haptable_finger_watch(finger.get(), last_us + 20'000, &touch), 1);
    EXPECT_EQ(touch.state, std::uint32_t{HAPTABLE_TOUCH_SILENT});
}

// Where a finger has left a body that relaxes, its dent is still there.
TEST_F(Library, DrawsTheDentThatAFingerLeft) {
    ASSERT_NO_FATAL_FAILURE(load(scene_of({ForceLaw::kInterpolated, GodObject::kLeastEnergy, "relaxation"})));
    const Finger finger = new_finger();
    haptable_touch touch{};
    for (std::uint32_t tick = 0; tick < 100; ++tick) {
        const float x[3] = {0.013F, 0.015F, tick > 0 && tick < 99 ? 0.0262F : 0.031F};
        haptable_finger_step(finger.get(), x, 1000 * tick, &touch);
    }
    EXPECT_EQ(touch.state, std::uint32_t{HAPTABLE_TOUCH_FREE});
    ASSERT_GE(touch.node[0], 0) << "no dent";
    const Places u = deformed(touch);
    const auto deepest = std::min_element(u.begin(), u.end(), [](const auto& a, const auto& b) { return a[2] < b[2]; });
    EXPECT_LT((*deepest)[2], -1e-4F) << "of 3.8 mm";
}

TEST_F(Library, ExportsItsOwnNamesAlone) {
    const Outcome names = run("nm -D --defined-only " + lib() + "/libhaptable.so.1");
    ASSERT_EQ(names.status, 0);
    EXPECT_TRUE(says(names.out, " T haptable_finger_step@@HAPTABLE_1\n"));
    const std::regex own(".* (A HAPTABLE_1|T haptable_(library|object|fingers?|held)_[a-z_]*@@HAPTABLE_1)");
    std::istringstream lines(names.out);
    for (std::string line; std::getline(lines, line);) EXPECT_TRUE(std::regex_match(line, own)) << line;
}

TEST_F(Library, DeformsByEquation8) {
    Scene scene = scene_of({ForceLaw::kPressureMask, GodObject::kNearest, ""});
    for (const Storage columns : {Storage::kFloat32, Storage::kFloat16}) {
        scene.tables.column_precision = columns;
        ASSERT_NO_FATAL_FAILURE(load(scene));
        const Finger finger = new_finger();
        haptable_touch touch;
        for (std::uint32_t tick = 0; tick < 60; ++tick) {
            const float position_m[3] = {0.014F, 0.016F, 0.032F - 1e-4F * float(tick)};
            haptable_finger_step(finger.get(), position_m, 1000 * tick, &touch);
        }
        ASSERT_EQ(touch.state, std::uint32_t{HAPTABLE_TOUCH_CONTACT});

        const Tables tables = read_tables(tables_);
        Deformation deformation(tables, tables_);
        std::vector<NodalForce> on_patch;
        for (std::size_t c = 0; c < 3; ++c) on_patch.push_back({touch.node[c], std::to_array(touch.nodal_force_n[c])});
        const std::vector<NodalForce> spread = ContactLoads(tables).spread(on_patch);
        const std::span<const float> expected = deformation.displace(spread);
        Places u = deformed(touch);
        ASSERT_EQ(expected.size(), 3 * u.size());
        double largest_m = 0.0, error_m = 0.0;
        for (std::size_t i = 0; i < expected.size(); ++i) {
            largest_m = std::max(largest_m, double(std::abs(expected[i])));
            error_m = std::max(error_m, double(std::abs(expected[i] - u[i / 3][i % 3])));
        }
        EXPECT_GT(largest_m, 1e-3);
        // Both round each product and sum of 3 of every load once; the loads of a mask do not cancel.
        EXPECT_WITHIN(error_m, .count = 2.0 * std::sqrt(6.0 * double(spread.size())), .epsilon = kFloat,
                      .size = 2.0 * largest_m);

        const auto rows = std::uint32_t(u.size());
        const std::uint32_t chosen[] = {rows - 1, 7};
        Places two(2);
        ASSERT_EQ(haptable_object_deform(object.get(), &touch, chosen, 2, rows_of(two)), 0);
        EXPECT_EQ(two[0], u[rows - 1]);
        EXPECT_EQ(two[1], u[7]);
        EXPECT_EQ(haptable_object_deform(object.get(), &touch, &rows, 1, rows_of(two)), -1);
        EXPECT_EQ(haptable_library_error(), fmt::format("there is no row {}: {} has {}", rows, tables.name, rows));
    }
}

// That it refuses files that were changed, tests/host/tables/tampered_test.cpp says of every reader.
TEST_F(Library, RefusesOtherTables) {
    ASSERT_NO_FATAL_FAILURE(load(scene_of(kPlain)));
    const std::uint64_t hash = haptable_object_describe(object.get()).tables_hash;
    const auto refusal = [](const std::string& folder, std::uint64_t wanted) {
        const Object loaded(haptable_object_load(folder.c_str(), wanted));
        return loaded ? "no error" : std::string(haptable_library_error());
    };
    EXPECT_EQ(refusal(tables_, hash), "no error");
    EXPECT_TRUE(says(refusal(tables_, hash + 1), "that are wanted"));
    EXPECT_TRUE(says(refusal("no/such/folder", 0), "no/such/folder/tables.json: is not there: make"));
    // An option with its own hash: the tables are of another.
    const fs::path options = tables_ / "options.json", facts = tables_ / "tables.json";
    const std::string known = hash_file(options);
    write_file(options, replaced(read_file(options), "\"max_force\": 8.5", "\"max_force\": 9.5"));
    write_file(facts, replaced(read_file(facts), known, hash_file(options)));
    EXPECT_TRUE(says(refusal(tables_, 0), "not its tables_hash"));
}

// Both at once as a session has it, and where the other is away what one finger feels.
TEST_F(Library, TwoFingersHaveTheServosBits) {
    ASSERT_NO_FATAL_FAILURE(load(scene_of({ForceLaw::kConsistent, GodObject::kLeastEnergy, ""}, 2)));
    EXPECT_EQ(haptable_object_fingers(object.get()), 2U);
    const LoadedScene in_memory = in_host();
    const Places first_m = hard_path(in_memory.tables(), 30);
    Places both_m;
    for (std::size_t i = 0; i < first_m.size(); ++i)
        both_m.insert(both_m.end(), {first_m[i], first_m[first_m.size() - 1 - i]});
    const Fingers fingers(haptable_fingers_new(object.get())), half(haptable_fingers_new(object.get()));
    std::vector<haptable_touch> felt(both_m.size());
    haptable_fingers_replay(fingers.get(), rows_of(both_m), first_m.size(), 0, felt.data());
    BesideASession stepped(object.get(), in_memory, 2);
    const Finger alone = new_finger();
    for (std::size_t i = 0; i < both_m.size(); i += 2) {
        haptable_touch expected{}, touch[2]{};
        const float* const each_m[] = {nullptr, both_m[i + 1].data()};
        haptable_fingers_step(half.get(), each_m, stepped.time_us, touch);
        haptable_finger_step(alone.get(), both_m[i + 1].data(), stepped.time_us, &expected);
        ASSERT_TRUE(same(touch[1], expected)) << i;
        ASSERT_EQ(touch[0].state, std::uint32_t{HAPTABLE_TOUCH_SILENT});
        ASSERT_NO_FATAL_FAILURE(stepped.tick(both_m[i], both_m[i + 1]));
        ASSERT_TRUE(same(felt[i], stepped.touch[0]) && same(felt[i + 1], stepped.touch[1])) << i;
    }
    EXPECT_GT(stepped.both_ticks, 30);
    EXPECT_EQ(haptable_fingers_counter(fingers.get(), 1, 0), first_m.size());
    EXPECT_GT(haptable_fingers_energy(fingers.get(), 1).most_stored_j, 0.0);
}

/// A body that nothing holds.
Scene loose(int fingers, int modes) {
    Scene scene = read_scene("meshes/grasp-cube.toml");
    scene.mesh.nodes_per_side = 5;
    scene.contact.fingers = fingers;
    if (modes > 0) scene.body_modes = BodyModes{modes, 0.05, 0.0, 0.0, 1};
    return scene;
}

// Two fingers grasp a body that nothing holds, and lift it; then one lets go, and it falls: as in a session.
TEST_F(Library, MovesAFreeBodyAsASessionDoes) {
    ASSERT_NO_FATAL_FAILURE(load(loose(2, 0)));
    EXPECT_EQ(haptable_object_is_free(object.get()), 1);
    const LoadedScene in_memory = in_host();
    const float rest_m[] = {in_memory.body()->centre_m[0], in_memory.body()->centre_m[2]};
    BesideASession hands(object.get(), in_memory, 2);
    float most_lifted_m = 0.0F;
    for (int tick = 0; tick < 1500; ++tick) {
        const float in_m = 4e-6F * float(std::min(tick, 400)) - 1e-4F, up_m = 2e-5F * float(std::max(0, tick - 500));
        std::optional<std::array<float, 3>> second_m;
        if (tick < 1300) second_m = {0.03F - in_m, 0.015F, 0.015F + up_m};
        ASSERT_NO_FATAL_FAILURE(hands.tick({in_m, 0.015F, 0.015F + up_m}, second_m));
        most_lifted_m = std::max(most_lifted_m, hands.pose().centre_m[2] - rest_m[1]);
    }
    EXPECT_GT(most_lifted_m, 0.01F) << "of 16 mm that the hands rise";
    EXPECT_LT(hands.pose().centre_m[2], most_lifted_m + rest_m[1] - 0.005F) << "it falls";
    hands.expect_energy();

    // One finger pushes it aside; another servo's body is its own.
    BesideASession hand(object.get(), in_memory, 1);
    for (int tick = 0; tick < 600; ++tick)
        ASSERT_NO_FATAL_FAILURE(hand.tick({1e-5F * float(tick) - 1e-3F, 0.015F, 0.01F}));
    EXPECT_GT(hand.pose().centre_m[0], rest_m[0] + 1e-3F);
    hand.expect_energy();
}

// Held with friction, and free: knocks on a body that rings, as in a session; and the viewer's surface as it swings.
TEST_F(Library, RingsAsASessionDoes) {
    const auto held = [](GodObject god_object, int fingers) {
        Scene scene = scene_of({ForceLaw::kConsistent, god_object, "friction"}, fingers);
        scene.body_modes = BodyModes{4, 0.05, 1000.0, 0.0, 1};
        return scene;
    };
    const Places path = knock_path();
    for (const Scene& scene : {held(GodObject::kNearest, 1), loose(1, 4)}) {
        ASSERT_NO_FATAL_FAILURE(load(scene));
        ASSERT_EQ(haptable_object_modes(object.get()), 4U);
        const LoadedScene in_memory = in_host();
        BesideASession hand(object.get(), in_memory, 1);
        const Finger other = new_finger();
        for (std::size_t i = 0; i < path.size(); ++i) {
            haptable_touch touch;  // of a servo with its own past
            haptable_finger_step(other.get(), path[(i + 350) % path.size()].data(), hand.time_us, &touch);
            ASSERT_NO_FATAL_FAILURE(hand.tick(path[i]));
        }
        const std::vector<float> swung = hand.swung();
        std::vector<float> others(4);
        haptable_finger_swung(other.get(), others.data());
        ASSERT_NE(swung, others);

        Places u(haptable_object_describe(object.get()).row_count);
        ASSERT_EQ(haptable_object_swing(object.get(), swung.data(), nullptr, u.size(), rows_of(u)), 0);
        std::optional<DrawnModes> drawn = read_drawn_modes(in_memory.tables(), tables_);
        ContactFrame frame;
        frame.modes = swung;
        const auto wanted = drawn->add_to(std::vector<float>(3 * u.size()), frame);
        double size_m = 0.0;
        for (const float x : wanted) size_m = std::max(size_m, double(std::abs(x)));
        EXPECT_GT(size_m, 1e-6);
        for (std::size_t k = 0; k < 3 * u.size(); ++k)
            EXPECT_WITHIN(std::abs(u[k / 3][k % 3] - wanted[k]), .count = 8, .epsilon = kFloat, .size = size_m);
        const auto beyond = std::uint32_t(u.size()), middle = beyond / 2;
        Places added{{1.0F, 0.0F, 0.0F}};
        ASSERT_EQ(haptable_object_swing(object.get(), swung.data(), &middle, 1, rows_of(added)), 0);
        EXPECT_WITHIN(std::abs(added[0][0] - 1.0F - u[middle][0]), .count = 8, .epsilon = kFloat) << "it adds";
        EXPECT_EQ(haptable_object_swing(object.get(), swung.data(), &beyond, 1, rows_of(added)), -1);
    }
    for (const Scene& scene : {held(GodObject::kLeastEnergy, 2), loose(2, 4)}) {
        ASSERT_NO_FATAL_FAILURE(load(scene));
        const LoadedScene in_memory = in_host();
        BesideASession hands(object.get(), in_memory, 2);
        for (std::size_t i = 0; i < path.size(); ++i) {
            std::optional<std::array<float, 3>> second_m;
            if (i % 200 > 30) second_m = {0.022F, 0.014F, path[(i + 40) % path.size()][2]};
            ASSERT_NO_FATAL_FAILURE(hands.tick(path[i], second_m));
        }
        EXPECT_GT(hands.both_ticks, 100);
    }
}

TEST_F(Library, ABodyThatIsHeldHasNoPoseAndTheFingersOfItsScene) {
    ASSERT_NO_FATAL_FAILURE(load(scene_of(kPlain)));
    EXPECT_EQ(haptable_object_is_free(object.get()), 0);
    const Finger finger = new_finger();
    EXPECT_EQ(haptable_finger_pose(finger.get()).turn[0], 1.0F);
    EXPECT_EQ(haptable_finger_pose(finger.get()).centre_m[2], 0.0F);
    EXPECT_EQ(haptable_object_modes(object.get()), 0U);
    EXPECT_EQ(haptable_object_fingers(object.get()), 1U);
    EXPECT_EQ(haptable_fingers_new(object.get()), nullptr);
    EXPECT_TRUE(says(haptable_library_error(), "fingers = 2"));
}

}  // namespace
}  // namespace haptable::test
