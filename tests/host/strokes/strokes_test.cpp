// SPDX-License-Identifier: GPL-2.0-or-later
// A short part of `make strokes`: fixed seeds over our own meshes and, where they are, over other people's.
#include <gtest/gtest.h>

#include "host/base/file.hpp"
#include "host/mesh/cube.hpp"
#include "host/mesh/write_tetgen.hpp"
#include "tests/host/strokes/stroked.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

// All but kBrake, which is by design (docs/STROKES.md).
constexpr std::array kKept{Fault::kOutside, Fault::kLost,   Fault::kForce, Fault::kArea,     Fault::kLaw, Fault::kDrawn,
                           Fault::kJump,    Fault::kEnergy, Fault::kCone,  Fault::kMomentum, Fault::kPull};

/// Modes over the bodies of `places` whose names hold one of `meshes`.
void expect_promises_kept(const std::vector<std::string>& meshes, const std::vector<TouchMode>& modes,
                          std::size_t strokes, const std::vector<fs::path>& places = kOurMeshes) {
    for (const std::string& mesh : meshes)
        for (const TouchMode& mode : modes) {
            SCOPED_TRACE(mesh + " " + mode.name());
            const Tally tally = Stroked(tables_of(mesh, places), mode).tally(1, strokes);
            EXPECT_GT(tally.contact_ticks, 20 * strokes);
            EXPECT_TRUE(!mode.is_coupled() || tally.both_ticks > strokes) << tally.both_ticks;
            for (const Broken& broken : tally.broken)
                for (const Fault fault : kKept)
                    EXPECT_FALSE(broken.verdict.has(fault))
                        << "stroke " << broken.number << ": " << name_of(fault) << "; haptable-strokes shrinks it";
        }
}

enum class Hands { kAlone, kTool, kMany, kOther };

/// Of one finger on a body at rest; of a tool; of three to eight hands; or the others.
std::vector<TouchMode> modes_of(Hands hands) {
    std::vector<TouchMode> modes;
    for (const TouchMode& mode : all_modes()) {
        const bool alone = mode.fingers == 1 && mode.body == BodyKind{};
        if (hands == (mode.tool          ? Hands::kTool
                      : mode.has_hands() ? Hands::kMany
                      : alone            ? Hands::kAlone
                                         : Hands::kOther))
            modes.push_back(mode);
    }
    return modes;
}

TEST(Strokes, OverOurMeshesKeepWhatContactPromises) {
    expect_promises_kept({"cube-consistent", "mouse", "needle", "torus"}, modes_of(Hands::kAlone), 120);
}

TEST(Strokes, OfTwoFingersAndOnWhatMovesKeepWhatIsPromised) {
    expect_promises_kept({"cube-consistent", "torus"}, modes_of(Hands::kOther), 10);
}

TEST(Strokes, OfAToolKeepWhatIsPromised) {
    expect_promises_kept({"cube-consistent", "torus"}, modes_of(Hands::kTool), 60);
}

TEST(Strokes, OfHandsKeepWhatIsPromised) {
    expect_promises_kept({"cube-consistent", "torus"}, modes_of(Hands::kMany), 20);
}

/// A scene of these whose dents stiffen to 2.5 times, written beside its mesh.
void write_stiffened(const fs::path& scene, const fs::path& folder) {
    for (const char* part : {".node", ".ele"})
        if (const fs::path mesh = fs::path(scene).replace_extension(part); fs::exists(mesh))
            fs::copy_file(mesh, folder / mesh.filename());
    std::string text = read_file(scene);
    text.insert(text.find("poisson"), "stiffening = { curve = [0.5, -0.5, 1.5], energy = 5.0e-5 }\n");
    write_file(folder / scene.filename(), text);
}

TEST(Strokes, OnDentsThatStiffenKeepWhatIsPromised) {
    const TemporaryFolder folder;
    std::vector<TouchMode> modes = all_modes();
    std::erase_if(modes, [](const TouchMode& mode) { return mode.body.rings; });  // docs/MATERIALS.md: refused
    write_stiffened("meshes/cube-consistent.toml", folder.path());
    write_stiffened("meshes/hard/needle.toml", folder.path());
    expect_promises_kept({"cube-consistent", "needle"}, modes, 20, {folder.path()});
    EXPECT_NE(Stroked(tables_of("needle", {folder.path()}), modes[0]).touched.model.stiffen, nullptr);
}

// Of pair 258 of least energy both settle where nobody looks.
TEST(Strokes, OfTwoAreNeitherLostNorThrough) {
    std::vector<TouchMode> modes;
    for (const TouchMode& mode : modes_of(Hands::kOther))
        if (mode.force == ForceLaw::kConsistent && mode.fingers == 2 && mode.body == BodyKind{} && !mode.friction)
            modes.push_back(mode);
    expect_promises_kept({"cube-consistent"}, modes, 300);
}

// Its lower edges are sharp. In stroke 61 the first finger meets the surface in the tick in which the other comes out
// over such an edge.
TEST(Strokes, OfTwoComeOutOverASharpEdge) {
    const TemporaryFolder folder;
    TetMesh mesh = make_cube(3, 0.04);
    for (Vector3d& x : mesh.position_m) {
        const double narrower = 1.0 - 20.0 * x.z();
        x = {narrower * (x.x() - 0.02), narrower * (x.y() - 0.02), 0.5 * x.z()};
    }
    write_tetgen(mesh.position_m, mesh.tet, folder.path() / "frustum");
    const TouchMode mode{ForceLaw::kInterpolated, GodObject::kLeastEnergy, false, 2, {true, false}};
    expect_promises_kept({"frustum"}, {mode}, 400, {folder.path()});
}

// Each was a fault once: of the judge, but for the free needle, which spun up by itself, and for the tools, which were
// the firmware's.
TEST(Strokes, ThatWereFaultsAreClean) {
    struct Case {
        const char *what, *mesh;
        TouchMode mode;
        std::uint64_t seed, number;
    };
    const Case cases[] = {
        {"a force of 2e-23 N has no square", "torus", {ForceLaw::kInterpolated, kLeast, false, 2, kFree}, 1, 1993},
        {"two that bend a rod are nearly one, and C of both nearly singular",
         "needle",
         {ForceLaw::kPressureMask, kLeast, true, 2},
         2,
         73},
        {"420 rad/s about its own axis", "needle", {ForceLaw::kPressureMask, kNearest, false, 2, kFree}, 2, 540},
        {"a surface that swings at 0.7 m/s", "needle", {ForceLaw::kPressureMask, kNearest, true, 2, kRings}, 2, 723},
        {"a search whose last step took a point out of T left the loads of the others as they were",
         "cube-consistent",
         {ForceLaw::kConsistent, kLeast, false, 1, {}, true},
         0x44aab30871a52d4aULL,
         12},
        {"12 points near one place, whose C is not definite, by the error of its tables",
         "torus",
         {ForceLaw::kPressureMask, kLeast, false, 1, {}, true},
         0xc8cbb70839f26475ULL,
         190},
        {"no active set is found",
         "needle",
         {ForceLaw::kPressureMask, kLeast, true, 1, {}, true},
         0xa5b56048600b271cULL,
         1182},
        {"the one point that is left to press lies outside",
         "torus",
         {ForceLaw::kPressureMask, kLeast, true, 1, {}, true},
         0xedb662018356d2ecULL,
         2604},
    };
    for (const Case& one : cases)
        EXPECT_TRUE(Stroked(tables_of(one.mesh), one.mode).judged(one.seed, one.number).is_clean()) << one.what;
}

TEST(Strokes, OverOtherPeoplesMeshesKeepWhatContactPromises) {
    if (!fs::exists("../shared/contact")) GTEST_SKIP() << "no ../shared: other people's meshes are not in a clone";
    expect_promises_kept({"liver_181", "shark_429", "two_parts_285", "screw_1732", "ossicles_1733"},
                         modes_of(Hands::kAlone), 120, {"../shared/meshes", "../shared/contact"});
}

TEST(Strokes, AreTheSameForTheSameNumbers) {
    const TemporaryFolder folder;
    const StrokeMaker& maker = tables_of("needle").body({}).maker;
    for (std::uint64_t number = 0; number < 50; ++number) {
        const int fingers = static_cast<int>(number % (1 + HAPTABLE_HANDS));
        const auto make = [&](std::uint64_t seed) {
            return fingers == kToolHand ? maker.make_poses(seed, number) : maker.make(seed, number, fingers);
        };
        const Stroke stroke = make(3);
        EXPECT_EQ(stroke, make(3));
        EXPECT_NE(stroke, make(4));
        write_file(folder.path() / "stroke.csv", to_csv(stroke, fingers));
        EXPECT_EQ(read_stroke(folder.path() / "stroke.csv"), stroke) << "to the last bit";
    }
}

TEST(Strokes, SceneOfAFaultReadsBack) {
    const TemporaryFolder folder;
    const StrokedMeshes meshes = collect_meshes({"meshes", "meshes/hard"}, {"torus", "cube"}, 1000, folder.path());
    for (const StrokedMesh& mesh : meshes.taken)
        for (const TouchMode& mode : all_modes()) {
            const Tool tool{{{0.001, 0.0, 0.0}, {0.0, 0.002, -1.0 / 3.0}}, {}, 0.07};
            Scene scene = mesh.scene;
            scene.tool = tool;
            scene = in_mode(scene, mode);
            if (mode.tool) scene.tool = tool;
            write_file(folder.path() / "scene.toml", to_toml(scene));
            const Scene again = read_scene(folder.path() / "scene.toml");
            EXPECT_EQ(again.contact.force, mode.force);
            EXPECT_EQ(again.contact.god_object, mode.god_object);
            EXPECT_EQ(again.contact.static_friction, scene.contact.static_friction);
            EXPECT_EQ(again.contact.release_n_per_ms, scene.contact.release_n_per_ms);
            EXPECT_EQ(again.contact.mask_radius_m, scene.contact.mask_radius_m);
            EXPECT_EQ(again.contact.fingers, mode.fingers);
            EXPECT_EQ(again.free_body.has_value(), mode.body.motion > 0);
            EXPECT_EQ(again.body_modes.has_value(), mode.body.rings);
            EXPECT_EQ(again.tool.has_value(), mode.tool);
            ASSERT_EQ(again.fixed.size(), scene.fixed.size());
            if (mode.body.motion == 0) {
                EXPECT_EQ(again.fixed[0].box_m, scene.fixed[0].box_m);
            }
            EXPECT_EQ(to_toml(again), to_toml(scene));
        }
}

}  // namespace
}  // namespace haptable::test
