// SPDX-License-Identifier: GPL-2.0-or-later
// What a scene's file reads; what it refuses is in test_messages.py.
#include "host/scene/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/base/file.hpp"
#include "host/base/scene_options.hpp"
#include "host/scene/keys.hpp"
#include "host/scene/tool.hpp"
#include "tests/error_of.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

class SceneFile : public testing::Test {
protected:
    Scene read(const std::string& text) const {
        write_file(path_, text);
        return read_scene(path_);
    }

    const TemporaryFolder folder_;
    const std::filesystem::path path_ = folder_.path() / "scene.toml";
};

const std::string kGood = R"(name = "a"
[mesh]
generate = "cube"
nodes_per_side = 3
side = 0.03
[material]
young = 1000
poisson = 0.3
[[fixed]]
box = [-1, -1, -1, 1, 1, 1e-9]
[[touch]]
box = [-1.0, -1.0, 0.01, 1, 1, 1]
[contact]
force = "interpolated"
[device]
max_force = 3.0
[tables]
columns = "none"
)";

TEST_F(SceneFile, ValuesAreRead) {
    const Scene scene = read(kGood);
    EXPECT_EQ(scene.name, "a");
    EXPECT_EQ(scene.mesh.nodes_per_side, 3);
    EXPECT_EQ(scene.mesh.side_m, 0.03);
    EXPECT_EQ(scene.material.young_pa, 1000.0);
    EXPECT_EQ(scene.fixed.size(), 1U);
    EXPECT_EQ((*scene.fixed[0].box_m)[5], 1e-9);
    EXPECT_EQ(scene.touch.at(0).line, 11);
    EXPECT_EQ(scene.device.max_force_n, 3.0);
    EXPECT_EQ(scene.tables.columns, ColumnRows::kNone);
    EXPECT_EQ(scene.contact.rigid_stiffness_n_per_m, ContactOptions().rigid_stiffness_n_per_m);
}

TEST_F(SceneFile, ALayerIsHeldFromTheOutermostNodeOn) {
    const auto layer = [this](const std::string& keys) {
        const Scene scene = read(replaced(kGood, "box = [-1, -1, -1, 1, 1, 1e-9]", keys));
        EXPECT_FALSE(scene.fixed.at(0).box_m);
        return scene.fixed.at(0).below.value();
    };
    const Below z = layer("below = 0.002"), minus_x = layer("below = 0\naxis = \"-x\"");
    EXPECT_EQ(z.depth_m, 0.002);
    EXPECT_EQ(z.axis, 2);
    EXPECT_FALSE(z.is_turned);
    EXPECT_EQ(minus_x.axis, 0);
    EXPECT_TRUE(minus_x.is_turned);
}

// On unless switched off by name; the rise of the force goes by the largest.
TEST_F(SceneFile, LimitsAreOnUnlessTheyAreSwitchedOff) {
    EXPECT_EQ(read(kGood).device.limits, (SafetyLimits{5.0, 3.0 / 0.01, 1.4, 30.0, 0.0, false, true}));
    const std::string off =
        replaced(kGood, "[device]\nmax_force = 3.0",
                 "grab = true\n[device]\nmax_speed = \"off\"\nmax_force_rate = \"off\"\nmean_force = \"off\"\n"
                 "force_return = \"ramp\"\nramp_time = 0.5");
    EXPECT_EQ(read(off + "check = false\n").device.limits, (SafetyLimits{0.0, 0.0, 0.0, 30.0, 0.5, true, false}));
}

TEST_F(SceneFile, ADeviceByItsNameAndItsPlace) {
    const Scene scene =
        read(replaced(kGood, "max_force = 3.0",
                      "model = \"touch\"\nmass = [0.1, 0.2, 0.3]\ndelay = 0.002\nbandwidth = 50\n"
                      "position = [0.0, 0.1, 0.2]\nrotation = [90, 0, 0]\nhandedness = \"left\"\nmotion_scale = 0.5\n"
                      "force_scale = 2\nclutch_ramp = 0.2\nworkspace = [-1, -1, -1, 1, 1, 1]"));
    EXPECT_EQ(scene.device.max_force_n, 3.3);
    EXPECT_EQ(scene.device.friction_n, 0.26);
    EXPECT_EQ(scene.device.mass_kg, (std::array<double, 3>{0.1, 0.2, 0.3}));
    EXPECT_EQ(scene.device_map.position_m, (std::array<double, 3>{0.0, 0.1, 0.2}));
    EXPECT_EQ(scene.device_map.rotation_deg[0], 90.0);
    EXPECT_TRUE(scene.device_map.left_handed);
    EXPECT_EQ(scene.device_map.ramp_s, 0.2);
    EXPECT_EQ(scene.device_map.workspace_m->at(4), 1.0);
    EXPECT_EQ(servo_force_limit_n(scene), 3.3 / 2.0) << "the motors meet their limit where the servo cuts";
    EXPECT_EQ(scene.device.limits.mean_force_n, 0.88) << "what the Touch gives all day";
    EXPECT_EQ(servo_limits(scene).mean_force_n, 0.88 / 2.0);
    EXPECT_EQ(servo_limits(scene).max_force_rate_n_per_s, 330.0 / 2.0);
    EXPECT_EQ(servo_limits(scene).max_speed_m_s, 5.0 * 0.5);
    EXPECT_EQ(whole_delay_s(scene.device), 0.002 + 1.0 / (2.0 * M_PI * 50.0));
    EXPECT_EQ(read(kGood).device.mass_kg, Device().mass_kg);
    EXPECT_EQ(read(kGood).device_map.motion_scale, 1.0);
}

const std::string kCube = "generate = \"cube\"\nnodes_per_side = 3\nside = 0.03";

TEST_F(SceneFile, MeshFilesAreRelativeToTheScene) {
    const Scene scene = read("\xEF\xBB\xBF" + replaced(kGood, kCube, "file = \"b.msh\"\nscale = 0.001"));
    EXPECT_EQ(scene.mesh.file, folder_.path() / "b.msh");
    EXPECT_EQ(scene.mesh.scale_m, 0.001);
    EXPECT_EQ(scene.name, "a") << "a mark of UTF-8 is skipped";
}

TEST_F(SceneFile, ElementsAreRead) {
    const auto with = [](const char* element) {
        return replaced(kGood, "[mesh]", std::string("[mesh]\nelement = \"") + element + "\"");
    };
    EXPECT_EQ(read(kGood).mesh.element, Element::kLinear);
    EXPECT_EQ(read(with("quadratic")).mesh.element, Element::kQuadratic);
    const Scene stiff = read(replaced(with("average-nodal-pressure"), "poisson = 0.3", "poisson = 0.49999"));
    EXPECT_EQ(stiff.mesh.element, Element::kAverageNodalPressure);
    EXPECT_EQ(stiff.material.poisson, 0.49999);
}

// A least-energy god-object jumps from one minimum to another: no click unless the scene asks for it.
TEST_F(SceneFile, JumpsAreBroughtDownUnlessTheSceneSaysOtherwise) {
    const auto release_of = [this](const std::string& lines) {
        return read(replaced(kGood, "[device]", lines + "[device]")).contact.release_n_per_ms;
    };
    EXPECT_EQ(release_of(""), 0.0);
    EXPECT_EQ(release_of("god_object = \"least-energy\"\n"), 0.01);
    EXPECT_EQ(release_of("god_object = \"least-energy\"\nrelease_slew = 0\n"), 0.0);
    EXPECT_EQ(release_of("release_slew = 0.2\n"), 0.2);
}

const std::string kIsotropic = "young = 1000\npoisson = 0.3\n";
const std::string kOrthotropic =
    "law = \"orthotropic\"\nyoung = [4e4, 1e4, 1e4]\npoisson = [0.3, 0.3, 0.4]\nshear = [5e3, 5e3, 4e3]\n";
const std::string kFibre =
    "law = \"fibre\"\nyoung_along = 4e4\nyoung_across = 1e4\npoisson = 0.3\npoisson_across = 0.4\nshear = 5e3\n";

TEST_F(SceneFile, MaterialsWithDirectionsAreRead) {
    const auto read_with = [this](const std::string& material) {
        return read(replaced(kGood, kIsotropic, material)).material.orthotropic.value();
    };
    const auto wood = read_with(kOrthotropic + "axes = [[0, 0, 2], [1, 0, 0]]\n");
    EXPECT_EQ(wood.young_pa, (std::array<double, 3>{4e4, 1e4, 1e4}));
    EXPECT_EQ(wood.poisson, (std::array<double, 3>{0.3, 0.3, 0.4}));
    EXPECT_EQ(wood.shear_pa, (std::array<double, 3>{5e3, 5e3, 4e3}));
    EXPECT_EQ(wood.axes.direction[0], (std::array<double, 3>{0, 0, 2}));
    EXPECT_EQ(read_with(kFibre + "direction = [0, 1, 0]\n").shear_pa, (std::array<double, 3>{5e3, 5e3, 1e4 / 2.8}));
    const auto tube = read_with(kFibre + "around = [[0, 0, 1], [0, 1, 0]]\n");
    EXPECT_EQ((*tube.axes.around)[1], (std::array<double, 3>{0, 1, 0}));
    const std::string file =
        replaced(replaced(kGood, kCube, "file = \"a.vtu\""), kIsotropic, kFibre + "direction_field = \"grain\"\n");
    EXPECT_EQ(read(file).mesh.directions, std::vector<std::string>{"grain"});
}

TEST_F(SceneFile, MembranesBedsAndGravityAreRead) {
    const Scene scene = read(kGood +
                             "[[membrane]]\nbox = [-1, -1, 0.02, 1, 1, 1]\nthickness = 1e-4\nyoung = 1e6\npoisson = "
                             "0.5\n[[bed]]\ngroup = \"back\"\nnormal = 1e5\n[gravity]\ndensity = 1060\ndirection = "
                             "[0, 3, 4]\n[[region]]\ngroup = \"a\"\nyoung = 1e3\npoisson = 0.2\ndensity = 900\n");
    ASSERT_EQ(scene.membranes.size(), 1U);
    EXPECT_EQ(scene.membranes[0].thickness_m, 1e-4);
    EXPECT_EQ(scene.membranes[0].poisson, 0.5);
    ASSERT_EQ(scene.beds.size(), 1U);
    EXPECT_EQ(scene.beds[0].normal_n_per_m3, 1e5);
    EXPECT_EQ(scene.beds[0].tangential_n_per_m3, 0.0);
    ASSERT_TRUE(scene.gravity);
    EXPECT_WITHIN(std::abs(scene.gravity->acceleration_m_per_s2[2] - 0.8 * 9.81), .count = 8, .size = 9.81);
    EXPECT_EQ(scene.density_of(-1), 1060.0);
    EXPECT_EQ(scene.density_of(0), 900.0);
    EXPECT_FALSE(scene.gravity->prestress);
}

TEST_F(SceneFile, TwoFingersMayHaveWhatOneHas) {
    const std::string two = replaced(kGood, "\"interpolated\"", "\"consistent\"\nfingers = 2");
    for (const char* more :
         {"coupling_bytes = 1000\n", "precision = \"int16\"\n", "[[relaxation]]\nshare = 0.3\ntime = 1.0\n"})
        EXPECT_EQ(read(two + more).contact.fingers, 2) << more;
    EXPECT_TRUE(fails_with([&] { read(two + "coupling_bytes = 0\n"); }, ":20: "));
}

TEST_F(SceneFile, RelaxationIsRead) {
    const Scene scene =
        read(kGood + "[[relaxation]]\nshare = 0.3\ntime = 0.1\n[[relaxation]]\nshare = 0.2\ntime = 5\n");
    EXPECT_EQ(scene.relaxation, (std::vector<RelaxationTerm>{{0.3, 0.1}, {0.2, 5.0}}));
}

const std::string kBare = "name = \"a\"\n[mesh]\ngenerate = \"cube\"\n[material]\nyoung = 1000\npoisson = 0.3\n";

TEST_F(SceneFile, ABodyThatIsFreeHasWhatHoldsIt) {
    const Scene scene = read(kBare +
                             "[body]\nfree = true\nmass = 0.5\nsuspension = [1, 2, 3, 4, 5, 6]\n"
                             "suspension_damping = [0, 0, 0, 0, 0, 7]\nfloor = -0.01\nfloor_normal = [0, 0, 2]\n");
    ASSERT_TRUE(scene.free_body);
    EXPECT_EQ(scene.free_body->mass_kg, 0.5);
    EXPECT_EQ(scene.free_body->stiffness, (std::array<double, 6>{1, 2, 3, 4, 5, 6}));
    EXPECT_EQ(scene.free_body->damping[5], 7.0);
    ASSERT_TRUE(scene.free_body->floor);
    EXPECT_EQ(scene.free_body->floor->height_m, -0.01);
    EXPECT_EQ(scene.free_body->floor->normal[2], 1.0);
    EXPECT_EQ(scene.free_body->floor->friction, 0.5);
    EXPECT_FALSE(read(kBare + "[body]\nfree = false\n").free_body);
    EXPECT_FALSE(read(kBare).free_body);
}

TEST_F(SceneFile, AFloorIsBelowByGravity) {
    const Scene scene =
        read(kBare + "[gravity]\ndensity = 900\ndirection = [1, 0, 0]\n[body]\nfree = true\nfloor = 0\n");
    EXPECT_EQ(scene.free_body->floor->normal, (std::array<double, 3>{-1.0, 0.0, 0.0}));
    EXPECT_EQ(scene.density_of(-1), 900.0);
    EXPECT_EQ(read(kBare + "[body]\nfree = true\ndensity = 700\n").density_of(-1), 700.0);
}

TEST_F(SceneFile, ABodyMayBeAsLightAndAsHeavyAsAServoMoves) {
    for (const char* mass_kg : {"1e-6", "1e6"})
        EXPECT_EQ(read(kBare + std::string("[body]\nfree = true\nmass = ") + mass_kg).free_body->mass_kg,
                  std::stod(mass_kg));
}

// Only its contacts push it: no force goes on after one. It goes by the least energy unless the scene says otherwise.
TEST_F(SceneFile, ContactsAloneActOnABodyThatIsFree) {
    const std::string free = "[body]\nfree = true\nmass = 1\n", least = "[contact]\ngod_object = \"least-energy\"\n";
    EXPECT_GT(read(kBare + least).contact.release_n_per_ms, 0.0);
    EXPECT_EQ(read(kBare + free + least).contact.release_n_per_ms, 0.0);
    EXPECT_EQ(read(kBare + free + least + "release_slew = 0\npassivity = false\n").contact.release_n_per_ms, 0.0);
    EXPECT_EQ(read(kBare).contact.god_object, GodObject::kNearest);
    EXPECT_EQ(read(kBare + free).contact.god_object, GodObject::kLeastEnergy);
    EXPECT_EQ(read(kBare + free + "[contact]\ngod_object = \"nearest\"\n").contact.god_object, GodObject::kNearest);
}

TEST_F(SceneFile, ABodyMayRingHeldOrFree) {
    const Scene held = read(kBare + "[body]\nmodes = 6\ndensity = 900\nmass = 0.1\n");
    ASSERT_TRUE(held.body_modes);
    EXPECT_FALSE(held.free_body);
    EXPECT_EQ(held.body_modes->modes, 6);
    EXPECT_EQ(held.body_modes->line, 8) << "for codegen's errors";
    EXPECT_EQ(held.body_modes->damping_ratio, 0.05);
    EXPECT_EQ(held.density_of(-1), 900.0);
    EXPECT_EQ(held.mass_kg(), 0.1);
    EXPECT_FALSE(read(kBare + "[body]\nmodes = 0\n").body_modes);
    const Scene free =
        read(kBare +
             "[body]\nfree = true\nmodes = 8\nmode_damping = 0.1\ndensity = 700\nmass = 0.2\n[contact]\nfingers = 2\n");
    ASSERT_TRUE(free.body_modes && free.free_body);
    EXPECT_EQ(free.body_modes->damping_ratio, 0.1);
    EXPECT_EQ(free.density_of(-1), 700.0);
    EXPECT_EQ(free.mass_kg(), 0.2);
    EXPECT_EQ(free.contact.fingers, 2);
}

const std::string kMasked = kBare + "[[fixed]]\nbelow = 0\n[contact]\nforce = \"pressure-mask\"\nmask_radius = 0.002\n";

TEST_F(SceneFile, AToolOfPointsByHand) {
    const Scene scene = read(
        kMasked +
        "[tool]\npoints = [[-0.004, 0, 0], [0.004, 0, 0.001]]\nmax_torque = 0.1\nstiffness = 900\nturn_stiffness = "
        "2\n");
    ASSERT_TRUE(scene.tool);
    EXPECT_FALSE(scene.tool->shape);
    EXPECT_EQ(scene.tool->point_m, (std::vector<std::array<double, 3>>{{-0.004, 0, 0}, {0.004, 0, 0.001}}));
    EXPECT_EQ(scene.tool->max_torque_n_m, 0.1);
    EXPECT_EQ(scene.tool->stiffness_n_per_m, 900.0);
    EXPECT_EQ(scene.tool->turn_stiffness_n_m_per_rad, 2.0);
    EXPECT_FALSE(read(kMasked).tool);
}

TEST_F(SceneFile, AToolOfAShape) {
    const Scene scene =
        read(kMasked + "[tool]\nshape = \"mesh\"\nfile = \"blade.stl\"\nscale = 0.001\npoints = 12\nangle = 30\n");
    ASSERT_TRUE(scene.tool && scene.tool->shape);
    const ToolShape& shape = *scene.tool->shape;
    EXPECT_EQ(shape.kind, ToolShape::Kind::kMesh);
    EXPECT_EQ(shape.points, 12);
    EXPECT_EQ(shape.file, folder_.path() / "blade.stl");
    EXPECT_EQ(shape.scale_m, 0.001);
    EXPECT_EQ(shape.angle_deg, 30.0);
    EXPECT_EQ(read(kMasked + "[tool]\nshape = \"sphere\"\nradius = 0.01\npoints = 7\n").tool->shape->angle_deg, 60.0);
}

/// Tables are of the points as they are sampled: what moves one changes the hash; a scene without a tool has no key of
/// it.
TEST_F(SceneFile, AToolIsHashedByItsPoints) {
    Scene scene = read(kMasked + "[tool]\nshape = \"disc\"\nradius = 0.01\npoints = 2\n");
    scene.tool->point_m = {{0.001, 0, 0}, {0.002, 0, 0}};
    const std::string before = text_of_tables(options_of(scene));
    EXPECT_EQ(options_of(scene).at("tool.points"), nlohmann::ordered_json(scene.tool->point_m));
    scene.tool->point_m[0][0] = 0.0011;
    EXPECT_NE(text_of_tables(options_of(scene)), before);
    EXPECT_EQ(text_of_tables(options_of(read(kMasked))).find("tool"), std::string::npos);
}

}  // namespace
}  // namespace haptable::test
