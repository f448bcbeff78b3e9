// SPDX-License-Identifier: GPL-2.0-or-later
// What a person reads who wrote a scene that cannot be: file, line, key, what is wrong and what to do, word by word.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "host/base/file.hpp"
#include "host/scene/scene.hpp"
#include "tests/error_of.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable {
namespace {

/// A scene of one cube, in which one part is wrong, and the error behind the file's name.
struct Wrong {
    const char* name = R"("a")";
    const char* mesh = R"(generate = "cube")";
    const char* material = "young = 1000\npoisson = 0.3";
    const char* rest = "";  ///< behind all of these
    const char* error;
    bool beyond_schema = false;  ///< docs/scene.schema.json lets it pass: numbers that only together are wrong
};

constexpr Wrong kWrong[] = {
    {.name = "3", .error = "1: name: must be a text in quotes, not a whole number"},
    {.name = R"("../a")", .error = "1: name: must be a letter and then at most 63 letters, digits, '_' and '-'"},
    {.name = R"("tests")",
     .error = R"(1: name: "tests" is a folder of the build itself: choose another)",
     .beyond_schema = true},
    {.mesh = "nodes_per_sid = 3\ngenerate = \"cube\"",
     .error = "3: mesh.nodes_per_sid: unknown key; did you mean nodes_per_side?"},
    {.mesh = "generate = \"cube\"\nfile = \"a.msh\"",
     .error = "4: mesh.file: there is a generator too; keep either generate or file"},
    {.mesh = "scale = 1", .error = R"(2: mesh.file: is missing; give a mesh file, or generate = "cube")"},
    {.mesh = "generate = \"cube\"\nscale = 2.0",
     .error = "4: mesh.scale: belongs to a mesh file; give the cube's side in metres and remove it"},
    {.mesh = "generate = \"cube\"\nlinearize = true",
     .error = "4: mesh.linearize: belongs to a mesh file; the cube is linear: remove it"},
    {.mesh = "generate = \"cube\"\nwrap = true",
     .error = "4: mesh.wrap: belongs to a surface file that is filled; give the cube nodes_per_side"},
    {.mesh = "file = \"a.msh\"\nside = 1",
     .error = R"(4: mesh.side: belongs to generate = "cube"; remove it or the file)"},
    {.mesh = R"(file = "")", .error = "3: mesh.file: is empty; name a mesh file, relative to the scene"},
    {.mesh = "file = \"a.msh\"\nnode_count = 100\nedge_length = 0.1",
     .error = "4: mesh.node_count: there is an edge_length too; keep one of them"},
    {.mesh = "file = \"a.msh\"\nwrap = true",
     .error = "4: mesh.wrap: belongs to a surface that is filled; give node_count or edge_length, or remove it"},
    {.mesh = "file = \"a.msh\"\nnode_count = 3", .error = "4: mesh.node_count: is 3 and must be 20 or more"},
    {.mesh = "generate = \"cube\"\nnodes_per_side = 101",
     .error = "4: mesh.nodes_per_side: is 101 and must lie in 2..100"},
    {.mesh = "generate = \"cube\"\nnodes_per_side = 3.0",
     .error = "4: mesh.nodes_per_side: must be a whole number, not a number",
     .beyond_schema = true},
    {.mesh = "generate = \"cube\"\nside = 0", .error = "4: mesh.side: is 0 and must be greater than 0"},
    {.mesh = R"(generate = "ball")", .error = R"(3: mesh.generate: "ball" is not known; known here: cube)"},
    {.mesh = "generate = \"cube\"\nelement = \"quadratc\"",
     .error = R"(4: mesh.element: "quadratc" is not known; did you mean quadratic?)"},
    {.material = "poisson = 0.3", .error = "4: material.young: is missing; give a number"},
    {.material = "young = true\npoisson = 0.3", .error = "5: material.young: must be a number, not true or false"},
    {.material = "young = -1\npoisson = 0.3", .error = "5: material.young: is -1 and must be greater than 0"},
    {.material = "young = 1e300\npoisson = 0.3",
     .error = "5: material.young: is 1e+300 Pa and must lie in 0.001..1000000000000000"},
    {.material = "young = inf\npoisson = 0.3", .error = "5: material.young: must be a finite number"},
    {.material = "young = 1000\npoisson = 0.5",
     .error = "6: material.poisson: is 0.5 and must lie between -1 and 0.5, both excluded; 0.5 is incompressible, "
              "which this method cannot do: use 0.49"},
    {.material = "young = 1000\npoisson = 0.49995",
     .error =
         R"(6: material.poisson: is 0.49995, and linear tetrahedra above 0.4999 give the mesh's stiffness, not the body's: write element = "average-nodal-pressure" in [mesh])",
     .beyond_schema = true},
    {.material = "young = 1000\npoisson = 0.3\nshear = 1",
     .error = R"(7: material.shear: does not belong to law = "isotropic", whose keys are young, poisson)",
     .beyond_schema = true},
    {.rest = "[mateial]", .error = "7: mateial: unknown key; did you mean material?"},
    {.rest = "[fixed]", .error = "7: fixed: must be a list of tables, [[fixed]] with two brackets, not a table"},
    {.rest = "[[fixed]]", .error = "7: fixed.below: give a box, a group or below"},
    {.rest = "[[fixed]]\naxis = \"x\"\nbox = [0, 0, 0, 1, 1, 1]",
     .error = "8: fixed.axis: belongs to below, metres; give it"},
    {.rest = "[[fixed]]\nbelow = 1\ngroup = \"a\"", .error = "9: fixed.group: there is below too; keep one of them"},
    {.rest = "[[fixed]]\nbelow = -1", .error = "8: fixed.below: is -1 and must not be less than 0"},
    {.rest = "[[fixed]]\nbelow = 1\naxis = \"w\"", .error = R"(9: fixed.axis: "w" is not known; did you mean z?)"},
    {.rest = "[[touch]]", .error = "7: touch.box: give either a box or a group"},
    {.rest = "[[touch]]\nbox = [0, 0, 2, 1, 1, 1]",
     .error = "8: touch.box: zmin 2 is greater than zmax 1; swap them",
     .beyond_schema = true},
    {.rest = "[[touch]]\nbox = [0, 0, \"low\", 1, 1, 1]", .error = "8: touch.box: entry 2 must be a finite number"},
    {.rest = "[[touch]]\nbox = [0, 0, 0]",
     .error = "8: touch.box: must be six numbers: xmin ymin zmin xmax ymax zmax (m)"},
    {.rest = "[[touch]]\ngroup = \"\"", .error = "8: touch.group: is empty; name a group of the mesh file"},
    {.rest = "[[touch]]\ngroup = \"a\"\ncavities = 1",
     .error = "9: touch.cavities: must be true or false, not a whole number"},
    {.rest = "[[region]]\ngroup = \"a\"\nyoung = 1000\npoisson = 0.2\ndensity = 900",
     .error = "11: region.density: belongs to a scene with [gravity]; add that table"},
    {.rest = "[[membrane]]\ngroup = \"a\"\nyoung = 1e6\npoisson = 0.3",
     .error = "7: membrane.thickness: is missing; give a number"},
    {.rest = "[[membrane]]\ngroup = \"a\"\nthickness = 1e-4\nyoung = 1e6\npoisson = 0.51",
     .error = "11: membrane.poisson: is 0.51 and must lie above -1 and be at most 0.5"},
    {.rest = "[[bed]]\ngroup = \"a\"", .error = "7: bed.normal: give normal or tangential, in N/m^3, greater than 0"},
    {.rest = "[gravity]\nprestress = true", .error = "7: gravity.density: is missing; give a number"},
    {.rest = "[gravity]\ndensity = 1\ndirection = [0, 0]",
     .error = "9: gravity.direction: must be a direction, [0, 0, -1]"},
    {.rest = "[gravity]\ndensity = 1\ndirection = [0, 0, 0]",
     .error = "9: gravity.direction: is 0, which is no direction",
     .beyond_schema = true},
    {.rest = "[gravity]\ndensity = 1\nacceleration = -9.81",
     .error = "9: gravity.acceleration: is -9.81 and must be greater than 0"},
    {.rest = "[[relaxation]]\nshare = 0.5", .error = "7: relaxation.time: is missing; give a number"},
    {.rest = "[[relaxation]]\nshare = 1.5\ntime = 1",
     .error = "8: relaxation.share: brings the sum of all shares to 1.5, and a body whose stiffness relaxes to nothing "
              "flows: keep the sum below 1",
     .beyond_schema = true},
    {.rest = "[contact]\nforce = \"nearest\"",
     .error = R"(8: contact.force: "nearest" is not known; known here: interpolated, consistent, pressure-mask)"},
    {.rest = "[contact]\nforce = \"pressure-mask\"", .error = "7: contact.mask_radius: is missing; give a number"},
    {.rest = "[contact]\nmask_radius = 0.01",
     .error = R"(8: contact.mask_radius: belongs to force = "pressure-mask"; remove it or choose that force)"},
    {.rest = "[contact]\nkinetic_friction = 0.2",
     .error = "8: contact.kinetic_friction: needs friction, the static coefficient; give it or remove this line"},
    {.rest = "[contact]\nfriction = 0.2\nkinetic_friction = 0.3",
     .error = "9: contact.kinetic_friction: is 0.3 and must not be greater than friction, 0.2",
     .beyond_schema = true},
    {.rest = "[contact]\nrelease_slew = -1", .error = "8: contact.release_slew: is -1 and must not be less than 0"},
    {.rest = "[contact]\ncoupling = \"always\"",
     .error = R"(8: contact.coupling: "always" is not known; known here: none, auto)"},
    {.rest = "[contact]\ncoupling = 0", .error = "8: contact.coupling: is 0 and must be greater than 0"},
    {.rest = "[contact]\npassivity = 1", .error = "8: contact.passivity: must be true or false, not a whole number"},
    {.rest = "[contact]\nfingers = 3", .error = "8: contact.fingers: is 3 and must be 1 or 2"},
    {.rest = "[device]\nmodel = \"phantm\"",
     .error = R"(8: device.model: "phantm" is not known; did you mean phantom?)"},
    {.rest = "[device]\nmass = [1, -1, 1]", .error = "8: device.mass: is -1 and must be greater than 0"},
    {.rest = "[device]\nmass = [1, 1]", .error = "8: device.mass: must be three numbers: x y z"},
    {.rest = "[device]\ndelay = 0.1",
     .error = "8: device.delay: is 0.1 s, and a servo takes what is 0.02 s old for silence"},
    {.rest = "[device]\nmax_speed = \"none\"",
     .error = R"(8: device.max_speed: is "none": give a number above 0, or "off")"},
    {.rest = "[device]\nramp_time = 1",
     .error = R"(8: device.ramp_time: belongs to force_return = "ramp"; remove it or choose that)"},
    {.rest = "[device]\nhandedness = \"both\"",
     .error = R"(8: device.handedness: "both" is not known; known here: right, left)"},
    {.rest = "[device]\nmax_force = \"8 N\"", .error = "8: device.max_force: must be a number, not a text"},
    {.rest = "[tables]\nflash_budget = 0", .error = "8: tables.flash_budget: is 0 and must be greater than 0 (bytes)"},
    {.rest = "[tables]\ncoupling_bytes = 1000",
     .error = "8: tables.coupling_bytes: belongs to two fingers; write fingers = 2 in [contact], or remove it"},
    {.rest = "[tables]\ndisplay_rows = [1, 1]", .error = "8: tables.display_rows: names node 1 twice"},
    {.rest = "[tables]\ndisplay_rows = [-1]",
     .error = "8: tables.display_rows: must be a list of mesh nodes, whole numbers from 0 on"},
    {.rest = "[tables]\ndisplay_precision = \"int16\"",
     .error = "8: tables.display_precision: is of display_rows, which the microcontroller computes; give them, or "
              "remove it"},
    {.rest = "[tables]\ndisplay_rows = [1]\ncolumns = \"none\"",
     .error = R"(8: tables.display_rows: needs columns, and columns = "none" leaves them out)"},
    {.rest = "[tables]\ndisplay_rows = [1]\ncolumn_precision = \"float16\"",
     .error = "8: tables.display_rows: needs columns in float32: remove column_precision"},
    {.rest = "[contact]\nforce = \"pressure-mask\"\nmask_radius = 0.01\n[tables]\ndisplay_rows = [1]",
     .error = "11: tables.display_rows: a pressure mask spreads its load over nodes that only the host knows"},
    {.rest = "[body]\nfree = true",
     .error = "7: body.density: is missing: a body that is not held needs a density or a mass, or [gravity]"},
    {.rest = "[body]\nfloor = 0", .error = "8: body.floor: is of a body that is not held; add free = true"},
    {.rest = "[body]\nfree = true\nmass = 1\nfloor_friction = 1",
     .error = "10: body.floor_friction: needs floor, its height; give it"},
    {.rest = "[body]\nmass = 1", .error = "8: body.mass: is of a body that moves; add free = true or modes"},
    {.rest = "[body]\nfree = true\nmass = 1e-9",
     .error = "9: body.mass: is 1e-09 kg, and a servo moves 1e-06 to 1e+06 kg: give it in kg"},
    {.rest = "[body]\nfree = true\nmass = 1\nsuspension = [1, 2]",
     .error = "10: body.suspension: must be six: along x, y, z, then about them"},
    {.rest = "[body]\nfree = true\nmass = 1\nsuspension = [1, 2, 3, -4, 5, 6]",
     .error = "10: body.suspension: has -4, and none may be less than 0"},
    {.rest = "[body]\nfree = true\nmass = 1\nsuspension_damping = [1, 2, 3, 4, 5, 6]",
     .error = "10: body.suspension_damping: needs suspension, six stiffnesses; give them"},
    {.rest = "[[bed]]\ngroup = \"a\"\nnormal = 1\n[body]\nfree = true\nmass = 1",
     .error = "11: body.free: is true, and [[bed]] holds the body; remove one of them"},
    {.rest = "[gravity]\ndensity = 9\n[body]\nfree = true\ndensity = 1",
     .error = "11: body.density: is in [gravity] already; remove one of them"},
    {.rest = "[body]\nfree = true\nmass = 1\n[contact]\nrelease_slew = 0.01",
     .error = "11: contact.release_slew: keeps a force up that has ended, and a body that is free would be thrown by "
              "it; remove it"},
    {.rest = "[body]\nfree = true\nmass = 1\n[contact]\npassivity = true",
     .error = "11: contact.passivity: is what the motion of a body that is free does already; remove it"},
    {.rest = "[body]\nmodes = 17\nmass = 1", .error = "8: body.modes: is 17, and a servo has 0 to 16"},
    {.rest = "[body]\nmodes = 2",
     .error = "7: body.density: is missing: a body that rings needs a density or a mass, or [gravity]"},
    {.rest = "[body]\nmode_damping = 0.1", .error = "8: body.mode_damping: needs modes, how many ring; give it"},
    {.rest = "[body]\nmodes = 2\nmass = 1\nmode_damping = 1",
     .error = "10: body.mode_damping: is 1, the ratio to critical damping, and must be at least 0.0001 and below 1"},
    {.rest = "[body]\nmodes = 2\nmass = 1\n[[relaxation]]\nshare = 0.5\ntime = 1",
     .error = "8: body.modes: are of an elastic body: remove [[relaxation]], or modes"},
    {.rest = "[gravity]\ndensity = 9\nprestress = true\n[body]\nmodes = 2",
     .error = "11: body.modes: are those of the body without stress; remove prestress, or modes"},
};

std::string text_of(const Wrong& wrong) {
    return fmt::format("name = {}\n[mesh]\n{}\n[material]\n{}\n{}\n", wrong.name, wrong.mesh, wrong.material,
                       wrong.rest);
}

TEST(SceneMessages, NameLineKeyAndRemedy) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.path() / "scene.toml";
    for (const Wrong& wrong : kWrong) {
        write_file(path, text_of(wrong));
        EXPECT_EQ(test::error_of([&] { read_scene(path); }), path.string() + ":" + wrong.error) << text_of(wrong);
    }
}

// What an editor underlines before the program is run.
TEST(SceneMessages, TheSchemaRefusesWhatTheProgramDoes) {
    const test::TemporaryFolder folder;
    std::string files;
    std::size_t number = 0;
    for (const Wrong& wrong : kWrong) {
        const auto file = folder.path() / fmt::format("{}.toml", number++);
        write_file(file, text_of(wrong));
        files += " " + file.string();
    }
    const test::Outcome judged = test::run("python3 tests/host/scene/validate.py docs/scene.schema.json" + files);
    EXPECT_EQ(judged.status, 0) << judged.err;
    number = 0;
    for (const Wrong& wrong : kWrong)
        EXPECT_EQ(judged.out.find(fmt::format("/{}.toml: ", number++)) == std::string::npos, wrong.beyond_schema)
            << text_of(wrong);
}

}  // namespace
}  // namespace haptable
