// SPDX-License-Identifier: GPL-2.0-or-later
// A short part of `make strokes`: fixed seeds over our own meshes and, where they are, over other people's.
#include <gtest/gtest.h>

#include "host/base/file.hpp"
#include "host/strokes/report.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kStrokes = 120;  // a body and mode
// All but kBrake, which is by design (docs/STROKES.md).
constexpr std::array kKept{Fault::kOutside, Fault::kLost, Fault::kForce,  Fault::kLaw,
                           Fault::kDrawn,   Fault::kJump, Fault::kEnergy, Fault::kCone};

/// Every mode over the bodies of `places` whose names hold one of `only`.
void expect_promises_kept(const std::vector<fs::path>& places, const std::vector<std::string>& only) {
    const TemporaryFolder folder;
    const StrokedMeshes meshes = collect_meshes(places, only, 50'000, folder.path() / "meshes");
    ASSERT_EQ(meshes.taken.size(), only.size()) << (meshes.left_out.empty() ? "" : meshes.left_out[0].why);
    Workers workers(1);
    Progress progress(true);
    for (const StrokedMesh& mesh : meshes.taken)
        for (ForceLaw force : every<ForceLaw>()) {
            const StrokedBody body(in_mode(mesh.scene, {force, GodObject::kNearest, false}),
                                   folder.path() / (mesh.name + word(force)), progress);
            const StrokeMaker maker(body.servo());
            for (const TouchMode& mode : all_modes()) {
                if (mode.force != force) continue;
                const haptable_model model = body.model(in_mode(mesh.scene, mode).contact);
                const Tally tally = run_strokes(body.touched(model), maker, 1, kStrokes, workers, [](std::size_t) {});
                EXPECT_GT(tally.contact_ticks, 20 * kStrokes);
                for (const Broken& broken : tally.broken)
                    for (const Fault fault : kKept)
                        EXPECT_FALSE(broken.verdict.has(fault))
                            << mesh.name << " " << mode.name() << ", stroke " << broken.number << ": " << name_of(fault)
                            << "; haptable-strokes shrinks it";
            }
        }
}

TEST(Strokes, OverOurMeshesKeepWhatContactPromises) {
    expect_promises_kept({"meshes", "meshes/hard"}, {"cube-consistent", "mouse", "needle", "torus"});
}

TEST(Strokes, OverOtherPeoplesMeshesKeepWhatContactPromises) {
    if (!fs::exists("../shared/contact")) GTEST_SKIP() << "no ../shared: other people's meshes are not in a clone";
    expect_promises_kept({"../shared/meshes", "../shared/contact"},
                         {"liver_181", "shark_429", "two_parts_285", "screw_1732", "ossicles_1733"});
}

TEST(Strokes, AreTheSameForTheSameNumbers) {
    const TemporaryFolder folder;
    StrokedMeshes meshes = collect_meshes({"meshes/hard"}, {"needle"}, 1000, folder.path());
    ASSERT_EQ(meshes.taken.size(), 1U);
    Progress progress(true);
    const StrokedBody body(in_mode(meshes.taken[0].scene, {}), folder.path(), progress);
    const StrokeMaker maker(body.servo());
    for (std::uint64_t number = 0; number < 50; ++number) {
        const Stroke stroke = maker.make(3, number);
        EXPECT_EQ(stroke, maker.make(3, number));
        EXPECT_NE(stroke, maker.make(4, number));
        write_file(folder.path() / "stroke.csv", to_csv(stroke));
        EXPECT_EQ(read_stroke(folder.path() / "stroke.csv"), stroke) << "to the last bit";
    }
}

TEST(Strokes, SceneOfAFaultReadsBack) {
    const TemporaryFolder folder;
    const StrokedMeshes meshes = collect_meshes({"meshes", "meshes/hard"}, {"torus", "cube"}, 1000, folder.path());
    for (const StrokedMesh& mesh : meshes.taken)
        for (const TouchMode& mode : all_modes()) {
            const Scene scene = in_mode(mesh.scene, mode);
            write_file(folder.path() / "scene.toml", to_toml(scene));
            const Scene again = read_scene(folder.path() / "scene.toml");
            EXPECT_EQ(again.contact.force, mode.force);
            EXPECT_EQ(again.contact.god_object, mode.god_object);
            EXPECT_EQ(again.contact.static_friction, scene.contact.static_friction);
            EXPECT_EQ(again.contact.release_n_per_ms, scene.contact.release_n_per_ms);
            EXPECT_EQ(again.contact.mask_radius_m, scene.contact.mask_radius_m);
            ASSERT_EQ(again.fixed.size(), scene.fixed.size());
            EXPECT_EQ(again.fixed[0].box_m, scene.fixed[0].box_m);
            EXPECT_EQ(to_toml(again), to_toml(scene));
        }
}

}  // namespace
}  // namespace haptable::test
