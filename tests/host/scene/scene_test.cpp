// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/scene/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "tests/error_of.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable {

namespace {

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

class SceneFile : public testing::Test {
protected:
    Scene read(const std::string& text) {
        write_file(path_, text);
        return read_scene(path_);
    }
    /// kGood with `from` replaced by `to` is an error at `line` that has `part` in its one line of text.
    void expect_error(const std::string& from, const std::string& to, int line, const std::string& part) {
        std::string text = kGood;
        text.replace(text.find(from), from.size(), to);
        const std::string what = test::error_of([&] { read(text); });
        EXPECT_EQ(what.rfind(path_.string() + ":" + std::to_string(line) + ": ", 0), 0U) << what << " for: " << to;
        EXPECT_NE(what.find(part), std::string::npos) << what;
        EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    }

    const test::TemporaryFolder folder_;
    const std::filesystem::path path_ = folder_.path() / "scene.toml";
};

// Their number before each of them: 200,000 rows are refused at once.
TEST_F(SceneFile, DisplayRowsAreCountedFirst) {
    std::string rows = "columns = \"surface\"\ndisplay_rows = [7";
    for (int i = 1; i < 2000; ++i) rows += ", 7";
    expect_error("columns = \"none\"", rows + "]", 19, "names 2000 nodes, and a target's display has at most 1000");
}

TEST_F(SceneFile, IsNotCalledAsAFolderOfTheBuild) {
    expect_error("name = \"a\"", "name = \"tests\"", 1, "\"tests\" is a folder of the build itself");
    // What the Makefile and its scripts name below build/, but for the scenes among it.
    const test::Outcome named = test::run(
        R"(grep -ohP '\$[({]?BUILD[)}]?/\K[a-z]+(?=[/\s"'"'"')]|$)' Makefile */*.mk scripts/*.sh packaging/*.sh | sort -u)"
        " | grep -vxE 'cube|mouse|display|ringing|grasped|squeezed|wobbling|jelly'");
    std::istringstream folders(named.out);
    std::size_t count = 0;
    for (std::string folder; folders >> folder; ++count)
        EXPECT_THROW(read("name = \"" + folder + "\"" + kGood.substr(kGood.find('\n'))), Error) << folder;
    EXPECT_GT(count, 15U);
}

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
    std::string text = kGood;
    const std::string box = "box = [-1, -1, -1, 1, 1, 1e-9]";
    const auto layer = [&](const std::string& keys) {
        std::string other = text;
        const Scene scene = read(other.replace(other.find(box), box.size(), keys));
        EXPECT_FALSE(scene.fixed.at(0).box_m);
        return scene.fixed.at(0).below.value();
    };
    const Below z = layer("below = 0.002"), minus_x = layer("below = 0\naxis = \"-x\"");
    EXPECT_EQ(z.depth_m, 0.002);
    EXPECT_EQ(z.axis, 2);
    EXPECT_FALSE(z.is_turned);
    EXPECT_EQ(minus_x.axis, 0);
    EXPECT_TRUE(minus_x.is_turned);
    expect_error(box, "below = -1", 10, "fixed.below: is -1 and must not be less than 0");
    expect_error(box, box + "\nbelow = 1", 10, "fixed.box: there is below too");
    expect_error(box, box + "\naxis = \"z\"", 11, "fixed.axis: belongs to below");
    expect_error(box, "below = 1\naxis = \"w\"", 11, "fixed.axis: \"w\" is not known");
    expect_error(box, "", 9, "fixed.below: give a box, a group or below");
    expect_error("[[touch]]\nbox", "[[touch]]\nbelow = 1\nbox", 12, "touch.below: unknown key");
}

TEST_F(SceneFile, AMeshIsNoScene) {
    const std::string stl = "solid duck\nfacet normal 0 0 1\n";
    for (const auto& [name, text] : {std::pair<std::string, std::string>{"duck.STL", std::string(100, '\0')},
                                     {"duck", stl},
                                     {"duck.txt", "ply\nformat ascii 1.0\n"},
                                     {"duck.msh", "$MeshFormat\n"}}) {
        write_file(folder_.path() / name, text);
        const std::string what = test::error_of([&] { read_scene(folder_.path() / name); });
        EXPECT_NE(what.find(name + ": is a mesh, and a scene is asked for: write a file scene.toml with file = \"" +
                            name + "\""),
                  std::string::npos)
            << what;
        EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    }
}

// A key that would do nothing is an error.
TEST_F(SceneFile, KeysThatWouldDoNothingAreRefused) {
    expect_error("columns = \"none\"", "display_precision = \"int16\"", 18,
                 "tables.display_precision: is of display_rows");
    expect_error("generate = \"cube\"\nnodes_per_side = 3\nside = 0.03", "file = \"a.stl\"\nwrap = true", 4,
                 "mesh.wrap: belongs to a surface that is filled; give node_count");
    expect_error("side = 0.03", "side = 0.03\nwrap = true", 6, "mesh.wrap: belongs to a surface file");
    const std::string none = "columns = \"none\"";
    expect_error(none, none + "\ncolumn_precision = \"float16\"", 19, "tables.column_precision: is of the columns");
    expect_error(none, none + "\ncolumn_budget = 1e6", 19, "tables.column_budget: is of the columns");
    expect_error("max_force = 3.0", "mean_force = \"off\"\nmean_force_time = 9", 17,
                 "device.mean_force_time: is of mean_force, which is off");
    expect_error(none, none + "\n[body]\nmodes = 0\nmode_damping = 0.1", 21, "body.mode_damping: needs modes");
    expect_error(none, none + "\n[body]\n[[region]]\ngroup = \"a\"\nyoung = 1\npoisson = 0\ndensity = 9", 24,
                 "region.density: belongs to a scene with [gravity]");
}

// On unless switched off by name; the rise of the force goes by the largest.
TEST_F(SceneFile, LimitsAreOnUnlessTheyAreSwitchedOff) {
    const SafetyLimits limits = read(kGood).device.limits;
    EXPECT_EQ(limits.max_speed_m_s, 5.0);
    EXPECT_EQ(limits.max_force_rate_n_per_s, 3.0 / 0.01);
    EXPECT_EQ(limits.mean_force_n, 1.4);
    EXPECT_EQ(limits.ramp_s, 0.0);
    EXPECT_FALSE(limits.grab);
    EXPECT_TRUE(limits.check);
    std::string text = kGood;
    text.replace(text.find("max_force = 3.0"), 15,
                 "max_speed = \"off\"\nmax_force_rate = \"off\"\nmean_force = \"off\"\nforce_return = \"ramp\"\n"
                 "ramp_time = 0.5");
    text.replace(text.find("[device]"), 8, "grab = true\n[device]");
    const SafetyLimits off = read(text + "check = false\n").device.limits;
    EXPECT_EQ(off, (SafetyLimits{0.0, 0.0, 0.0, 30.0, 0.5, true, false}));
    expect_error("max_force", "max_speed = \"none\"\nmax_force", 16, "device.max_speed: is \"none\": give a number");
    expect_error("max_force", "max_force_rate = 0\nmax_force", 16, "device.max_force_rate");
    expect_error("max_force", "ramp_time = 1.0\nmax_force", 16, "device.ramp_time: belongs to");
}

TEST_F(SceneFile, ADeviceByItsNameAndItsPlace) {
    std::string text = kGood;
    const std::string device = "max_force = 3.0";
    text.replace(text.find(device), device.size(),
                 "model = \"touch\"\nmass = [0.1, 0.2, 0.3]\ndelay = 0.002\nbandwidth = 50\n"
                 "position = [0.0, 0.1, 0.2]\nrotation = [90, 0, 0]\nhandedness = \"left\"\nmotion_scale = 0.5\n"
                 "force_scale = 2\nclutch_ramp = 0.2\nworkspace = [-1, -1, -1, 1, 1, 1]");
    const Scene scene = read(text);
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

TEST_F(SceneFile, ADeviceThatCannotBeIsAnErrorAtItsLine) {
    const std::string device = "max_force = 3.0";
    const auto expect = [&](const std::string& wrong, const std::string& part) {
        expect_error(device, "damping = 0\n" + wrong, 17, part);
    };
    expect("model = \"tuoch\"", "did you mean touch?");
    expect("motion_scale = 0", "device.motion_scale: is 0");
    expect("force_scale = -1", "greater than 0");
    expect("position = [0, 0]", "must be three numbers: x y z");
    expect("position = [0, 0, inf]", "entry 2 must be a finite number");
    expect("rotation = 90", "must be three numbers: x y z");
    expect("handedness = \"both\"", "\"both\" is not known");
    expect("workspace = [1, 0, 0, 0, 1, 1]", "xmin 1 is greater than xmax 0");
    expect("mass = [1, 1, 0]", "is 0 and must be greater than 0");
    expect("delay = 0.03", "silence");
    expect("clutches = 1", "unknown key");
    expect("clutch_ramp = -0.1", "must not be less than 0");
}

TEST_F(SceneFile, AMarkOfUtf8IsSkippedAndUtf16IsNamed) {
    EXPECT_EQ(read("\xEF\xBB\xBF" + kGood).mesh.nodes_per_side, 3);
    const std::string what = test::error_of([&] { read(std::string("\xFF\xFEn\0", 4)); });
    EXPECT_NE(what.find("UTF-16"), std::string::npos) << what;
}

TEST_F(SceneFile, MeshFilesAreRelativeToTheScene) {
    std::string text = kGood;
    const std::string generator = "generate = \"cube\"\nnodes_per_side = 3\nside = 0.03";
    text.replace(text.find(generator), generator.size(), "file = \"b.msh\"\nscale = 0.001");
    const Scene scene = read(text);
    EXPECT_EQ(scene.mesh.file, folder_.path() / "b.msh");
    EXPECT_EQ(scene.mesh.scale_m, 0.001);
}

TEST_F(SceneFile, ExampleScenesAreRead) {
    EXPECT_EQ(read_scene("meshes/cube.toml").name, "cube");
    EXPECT_EQ(read_scene("meshes/mouse.toml").name, "mouse");
}

TEST_F(SceneFile, TheReadmesSceneIsRead) {
    const std::string page = read_file("README.md"), begin = "```toml\n";
    const std::size_t from = page.find(begin) + begin.size();
    const Scene scene = read(page.substr(from, page.find("```", from) - from));
    EXPECT_EQ(scene.name, "duck");
    EXPECT_EQ(scene.tables.precision, Storage::kFloat32) << "a copier wants the defaults";
    EXPECT_EQ(scene.tables.flash_budget, 0U);
}

TEST_F(SceneFile, AMissingFileIsAnErrorThatNamesIt) {
    EXPECT_NE(test::error_of([&] { read_scene(path_); }).find(path_.string()), std::string::npos);
    EXPECT_THROW(read_scene(folder_.path()), Error);
}

TEST_F(SceneFile, UnknownKeysAreErrorsWithTheNearestKnownOne) {
    expect_error("name", "nmae", 1, "nmae: unknown key; did you mean name?");
    expect_error("young", "yuong", 7, "material.yuong: unknown key; did you mean young?");
    expect_error("[device]", "[devices]", 15, "devices: unknown key; did you mean device?");
    expect_error("side = 0.03", "size = 0.03", 5, "mesh.size");
    expect_error("box = [-1.0", "bx = [-1.0", 12, "touch.bx: unknown key; did you mean box?");
    expect_error("force = ", "colour = ", 14, "contact.colour: unknown key; known here:");
    expect_error("columns", "column", 18, "tables.column: unknown key; did you mean columns?");
}

TEST_F(SceneFile, LinearTetrahedraAreNotTakenNearIncompressibility) {
    std::string text = kGood;
    text.replace(text.find("generate"), 0, "element = \"average-nodal-pressure\"\n");
    EXPECT_EQ(read(text).mesh.element, Element::kAverageNodalPressure);
    EXPECT_EQ(read(kGood).mesh.element, Element::kLinear);
    std::string quadratic = kGood;
    quadratic.replace(quadratic.find("generate"), 0, "element = \"quadratic\"\n");
    EXPECT_EQ(read(quadratic).mesh.element, Element::kQuadratic);
    text.replace(text.find("0.3\n"), 3, "0.49999");
    EXPECT_EQ(read(text).material.poisson, 0.49999);
    expect_error("0.3\n", "0.49999\n", 8, "write element = \"average-nodal-pressure\" in [mesh]");
    expect_error("[device]", "[[region]]\ngroup = \"a\"\nyoung = 1\npoisson = 0.49999\n[device]", 18,
                 "region.poisson: is 0.49999");
    expect_error("generate", "element = \"avarage-nodal-pressure\"\ngenerate", 3,
                 "mesh.element: \"avarage-nodal-pressure\" is not known; did you mean average-nodal-pressure?");
}

TEST_F(SceneFile, AMaskNeedsItsRadiusAndOnlyAMaskHasOne) {
    expect_error("[device]", "mask_radius = 0.01\n[device]", 15, "contact.mask_radius: belongs to force");
    expect_error("interpolated", "pressure-mask", 13, "contact.mask_radius: is missing");
    expect_error("\"interpolated\"", "\"pressure-mask\"\nmask_radius = 0", 15, "must be greater than 0");
    expect_error("interpolated", "consistant", 14, "did you mean consistent?");
    expect_error("[device]", "god_object = \"last-energy\"\n[device]", 15, "did you mean least-energy?");
}

TEST_F(SceneFile, PrecisionAndBudgetOfTheTables) {
    expect_error("columns", "flash_budget = 0\ncolumns", 18, "tables.flash_budget: is 0 and must be greater than 0");
    expect_error("columns", "flash_budget = \"64k\"\ncolumns", 18, "tables.flash_budget: must be a whole number");
    expect_error("columns", "precision = \"float8\"\ncolumns", 18, "did you mean float");
}

TEST_F(SceneFile, ARegionHasAPlaceAndAMaterial) {
    expect_error("[device]", "[[region]]\ngroup = \"a\"\n[device]", 15, "region.young: is missing");
    expect_error("[device]", "[[region]]\nyoung = 1\npoisson = 0.3\n[device]", 15, "region.box: give either");
    expect_error("[device]", "[[region]]\ngroup = \"a\"\nyoung = 1\npoisson = 0.6\n[device]", 18, "region.poisson: is");
}

TEST_F(SceneFile, AFilledSurfaceHasOneTarget) {
    expect_error("side = 0.03", "edge_length = 0.1", 5, "mesh.edge_length: belongs to a surface file");
    expect_error("generate = \"cube\"\nnodes_per_side = 3\nside = 0.03",
                 "file = \"a.stl\"\nedge_length = 0.1\nnode_count = 100", 5,
                 "mesh.node_count: there is an edge_length");
    expect_error("generate = \"cube\"\nnodes_per_side = 3\nside = 0.03", "file = \"a.stl\"\nnode_count = 3", 4,
                 "mesh.node_count: is 3 and must be");
}

TEST_F(SceneFile, ContactOptionsAreChecked) {
    expect_error("[device]", "kinetic_friction = 0.2\n[device]", 15, "contact.kinetic_friction: needs friction");
    expect_error("[device]", "friction = 0.2\nkinetic_friction = 0.3\n[device]", 16,
                 "must not be greater than friction");
    expect_error("[device]", "friction = -0.2\n[device]", 15, "must not be less than 0");
    expect_error("[device]", "release_slew = -1\n[device]", 15, "contact.release_slew: is -1");
    expect_error("[device]", "coupling = \"always\"\n[device]", 15, "contact.coupling: \"always\" is not known");
    expect_error("[device]", "coupling = 0\n[device]", 15, "contact.coupling: is 0 and must be greater than 0");
    expect_error("[device]", "passivity = 1\n[device]", 15, "contact.passivity: must be true or false");
}

// A least-energy god-object jumps from one minimum to another: no click unless the scene asks for it.
TEST_F(SceneFile, JumpsAreBroughtDownUnlessTheSceneSaysOtherwise) {
    const auto release_of = [&](const std::string& lines) {
        std::string text = kGood;
        text.insert(text.find("[device]"), lines);
        return read(text).contact.release_n_per_ms;
    };
    EXPECT_EQ(release_of(""), 0.0);
    EXPECT_EQ(release_of("god_object = \"least-energy\"\n"), 0.01);
    EXPECT_EQ(release_of("god_object = \"least-energy\"\nrelease_slew = 0\n"), 0.0);
    EXPECT_EQ(release_of("release_slew = 0.2\n"), 0.2);
}

TEST_F(SceneFile, WrongTypesAreErrors) {
    expect_error("\"a\"", "3", 1, "name: must be a text");
    expect_error("1000", "\"soft\"", 7, "material.young: must be a number, not a text");
    expect_error("1000", "true", 7, "material.young: must be a number, not true or false");
    expect_error("= 3\n", "= 3.0\n", 4, "mesh.nodes_per_side: must be a whole number");
    expect_error("[[fixed]]", "[fixed]", 9, "fixed: must be a list of tables, [[fixed]]");
    expect_error("[material]", "[[material]]", 6, "material: must be one table, [material]");
    expect_error("[-1.0, -1.0,", "[-1.0,", 12, "touch.box: must be six numbers");
    expect_error("-1.0, 0.01", "\"low\", 0.01", 12, "touch.box: entry 1 must be a finite number");
    expect_error("[-1.0, -1.0, 0.01, 1, 1, 1]", "3", 12, "touch.box: must be six numbers");
    expect_error("0.3\n", "0.3.1\n", 8, "");
    expect_error("[tables]\n", "[mesh]\n", 17, "");
}

TEST_F(SceneFile, ImpossibleValuesAreErrors) {
    expect_error("0.3\n", "0.5\n", 8, "material.poisson: is 0.5 and must lie between -1 and 0.5");
    expect_error("0.3\n", "-1.0\n", 8, "material.poisson");
    expect_error("0.3\n", "nan\n", 8, "material.poisson: must be a finite number");
    expect_error("1000", "-1000", 7, "material.young: is -1000 and must be greater than 0");
    expect_error("1000", "0", 7, "material.young");
    expect_error("1000", "inf", 7, "material.young: must be a finite number");
    expect_error("1000", "1e300", 7, "material.young: is 1e+300 Pa and must lie in");
    expect_error("0.03", "0.0", 5, "mesh.side: is 0 and must be greater than 0");
    expect_error("= 3\n", "= 1\n", 4, "mesh.nodes_per_side: is 1 and must lie in 2..100");
    expect_error("= 3\n", "= 101\n", 4, "mesh.nodes_per_side");
    expect_error("0.01, 1, 1, 1]", "2, 1, 1, 1]", 12, "touch.box: zmin 2 is greater than zmax 1; swap them");
    expect_error("3.0", "0.0", 16, "device.max_force");
    expect_error("max_force", "damping = -1\nmax_force", 16, "device.damping");
    expect_error("\"none\"", "\"some\"", 18, "tables.columns: \"some\" is not known");
    expect_error("\"a\"", "\"../a\"", 1, "name: must be a letter");
    expect_error("\"a\"", "\"\"", 1, "name: must be a letter");
    expect_error("\"cube\"", "\"ball\"", 3, "mesh.generate: \"ball\" is not known; known here: cube");
}

TEST_F(SceneFile, ContradictionsAndGapsAreErrors) {
    expect_error("side = 0.03", "file = \"a.msh\"", 5, "keep either generate or file");
    expect_error("side = 0.03", "scale = 2.0", 5, "mesh.scale: belongs to a mesh file");
    expect_error("generate = \"cube\"", "file = \"a.msh\"", 4, "mesh.nodes_per_side: belongs to generate");
    expect_error("generate = \"cube\"\n", "", 2, "mesh.file: is missing");
    expect_error("young = 1000\n", "", 6, "material.young: is missing");
    expect_error("name = \"a\"\n", "", 1, "name: is missing");
    expect_error("[material]\nyoung = 1000\npoisson = 0.3\n", "", 1, "material: is missing; add a table [material]");
    expect_error("box = [-1.0, -1.0, 0.01, 1, 1, 1]", "", 11, "touch.box: give either a box or a group");
    expect_error("box = [-1.0", "group = \"a\"\nbox = [-1.0", 13, "touch.box: give either a box or a group");
    expect_error("box = [-1.0, -1.0, 0.01, 1, 1, 1]", "group = \"\"", 12, "touch.group: is empty");
}

const std::string kIsotropic = "young = 1000\npoisson = 0.3\n";
const std::string kOrthotropic =
    "law = \"orthotropic\"\nyoung = [4e4, 1e4, 1e4]\npoisson = [0.3, 0.3, 0.4]\nshear = [5e3, 5e3, 4e3]\n";
const std::string kFibre =
    "law = \"fibre\"\nyoung_along = 4e4\nyoung_across = 1e4\npoisson = 0.3\npoisson_across = 0.4\nshear = 5e3\n";

TEST_F(SceneFile, MaterialsWithDirectionsAreRead) {
    const auto read_with = [&](const std::string& material) {
        std::string text = kGood;
        return read(text.replace(text.find(kIsotropic), kIsotropic.size(), material)).material;
    };
    const Material wood = read_with(kOrthotropic + "axes = [[0, 0, 2], [1, 0, 0]]\n");
    ASSERT_TRUE(wood.orthotropic);
    EXPECT_EQ(wood.orthotropic->young_pa, (std::array<double, 3>{4e4, 1e4, 1e4}));
    EXPECT_EQ(wood.orthotropic->poisson, (std::array<double, 3>{0.3, 0.3, 0.4}));
    EXPECT_EQ(wood.orthotropic->shear_pa, (std::array<double, 3>{5e3, 5e3, 4e3}));
    EXPECT_EQ(wood.orthotropic->axes.direction[0], (std::array<double, 3>{0, 0, 2}));
    const Material muscle = read_with(kFibre + "direction = [0, 1, 0]\n");
    ASSERT_TRUE(muscle.orthotropic);
    EXPECT_EQ(muscle.orthotropic->shear_pa, (std::array<double, 3>{5e3, 5e3, 1e4 / 2.8}));
    const Material tube = read_with(kFibre + "around = [[0, 0, 1], [0, 1, 0]]\n");
    EXPECT_EQ((*tube.orthotropic->axes.around)[1], (std::array<double, 3>{0, 1, 0}));
    std::string file = kGood;
    const std::string cube = "generate = \"cube\"\nnodes_per_side = 3\nside = 0.03";
    file.replace(file.find(cube), cube.size(), "file = \"a.vtu\"");
    file.replace(file.find(kIsotropic), kIsotropic.size(), kFibre + "direction_field = \"grain\"\n");
    EXPECT_EQ(read(file).mesh.directions, std::vector<std::string>{"grain"});
}

TEST_F(SceneFile, AMaterialWithDirectionsThatCannotBeIsAnErrorAtItsLine) {
    const std::string axes = "axes = [[0, 0, 2], [1, 0, 0]]\n";
    const auto expect = [&](std::string material, const std::string& from, const std::string& to, int line,
                            const std::string& part) {
        material.replace(material.find(from), from.size(), to);
        expect_error(kIsotropic, material, line, part);
    };
    const std::string wood = kOrthotropic + axes, muscle = kFibre + "direction = [0, 1, 0]\n";
    expect(wood, "[0.3, 0.3", "[2.1, 0.3", 9, "material.poisson: the stiffness is not positive definite: nu12 = 2.1");
    expect(wood, "[0.3, 0.3", "[1.3, 1.3", 9, "1 - nu12 nu21 - nu23 nu32 - nu31 nu13");
    expect(wood, "[5e3", "[0", 10, "material.shear: is 0 and must be greater than 0");
    expect(wood, "[4e4, 1e4, 1e4]", "4e4", 8, "material.young: must be three moduli");
    expect(wood, "[1, 0, 0]", "[0, 0, 1]", 11, "material.axes: its two directions must not be parallel");
    expect(wood, axes, "", 6, "material.axes: say how the material lies by one of axes, axes_field and around");
    expect(wood, "shear = [5e3, 5e3, 4e3]\n", "", 6, "material.shear: is missing; give three moduli, [G12, G13, G23]");
    expect(wood, "axes = ", "direction = [1, 0, 0]\naxes = ", 11, "does not belong to law = \"orthotropic\"");
    expect(wood, "\"orthotropic\"", "\"orthotropc\"", 7, "did you mean orthotropic?");
    expect(muscle, "poisson_across = 0.4", "poisson_across = 1", 11, "material.poisson_across: is 1");
    expect(muscle, "direction = [0, 1, 0]", "direction = [0, 0, 0]", 13, "is 0, which is no direction");
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

TEST_F(SceneFile, RelaxationIsReadAndWhatCannotBeIsAnErrorAtItsLine) {
    const Scene scene =
        read(kGood + "[[relaxation]]\nshare = 0.3\ntime = 0.1\n[[relaxation]]\nshare = 0.2\ntime = 5\n");
    EXPECT_EQ(scene.relaxation, (std::vector<RelaxationTerm>{{0.3, 0.1}, {0.2, 5.0}}));
    const std::string end = "columns = \"none\"\n", term = "[[relaxation]]\nshare = 0.5\ntime = 1\n";
    const auto expect = [&](const std::string& more, int line, const std::string& part) {
        expect_error(end, end + more, line, part);
    };
    expect("[[relaxation]]\nshare = 0.5\n", 19, "relaxation.time: is missing");
    expect("[[relaxation]]\nshare = -0.5\ntime = 1\n", 20, "relaxation.share: is -0.5");
    expect("[[relaxation]]\nshare = 0.5\ntime = 0\n", 21, "relaxation.time: is 0");
    expect(term + term, 23, "relaxation.share: brings the sum of all shares to 1");
    std::string nine;
    for (int i = 0; i < 9; ++i) nine += "[[relaxation]]\nshare = 0.05\ntime = 1\n";
    expect(nine, 45, "relaxation.time: is of term 9, and a servo has at most 8");
}

TEST_F(SceneFile, MembranesBedsAndGravityThatCannotBeAreErrorsAtTheirLine) {
    const std::string end = "columns = \"none\"\n";
    const auto expect = [&](const std::string& more, int line, const std::string& part) {
        expect_error(end, end + more, line, part);
    };
    const std::string top = "[[membrane]]\nbox = [-1, -1, 0.02, 1, 1, 1]\n";
    expect(top + "young = 1e6\npoisson = 0.3\n", 19, "membrane.thickness: is missing");
    expect(top + "thickness = 1e-4\nyoung = 1e6\npoisson = 0.51\n", 23, "membrane.poisson: is 0.51");
    expect("[[bed]]\nbox = [-1, -1, -1, 1, 1, 0]\n", 19, "bed.normal: give normal or tangential, in N/m^3");
    expect("[[bed]]\nnormal = 1e5\n", 19, "bed.box: give either a box or a group");
    expect("[gravity]\ndirection = [0, 0, -1]\n", 19, "gravity.density: is missing");
    expect("[gravity]\ndensity = 1e3\ndirection = [0, 0, 0]\n", 21, "is 0, which is no direction");
    expect("[[region]]\ngroup = \"a\"\nyoung = 1e3\npoisson = 0.2\ndensity = 900\n", 23, "add that table");
}

}  // namespace

}  // namespace haptable
