# SPDX-License-Identifier: GPL-2.0-or-later
"""What a person reads who wrote a scene that cannot be: file, line, key, what is wrong and what to do, word by word;
and what an editor underlines before the program is run."""

import json
import re
import tomllib

import jsonschema
import pytest
from programs import ROOT, program, run

PARTS = {"name": '"a"', "mesh": 'generate = "cube"', "material": "young = 1000\npoisson = 0.3", "rest": ""}
BEYOND = "docs/scene.schema.json lets it pass: numbers that only together are wrong"
# A part of a scene of one cube that is wrong, and the error behind the file's name.
WRONG = [
    ("name", "3", "1: name: must be a text in quotes, not a whole number"),
    ("name", '"../a"', "1: name: must be a letter and then at most 63 letters, digits, '_' and '-'"),
    ("name", '"tests"', '1: name: "tests" is a folder of the build itself: choose another', BEYOND),
    ("mesh", 'nodes_per_sid = 3\ngenerate = "cube"',
     "3: mesh.nodes_per_sid: unknown key; did you mean nodes_per_side?"),
    ("mesh", 'generate = "cube"\nfile = "a.msh"',
     "4: mesh.file: there is a generator too; keep either generate or file"),
    ("mesh", "scale = 1", '2: mesh.file: is missing; give a mesh file, or generate = "cube"'),
    ("mesh", 'generate = "cube"\nscale = 2.0',
     "4: mesh.scale: belongs to a mesh file; give the cube's side in metres and remove it"),
    ("mesh", 'generate = "cube"\nlinearize = true',
     "4: mesh.linearize: belongs to a mesh file; the cube is linear: remove it"),
    ("mesh", 'generate = "cube"\nwrap = true',
     "4: mesh.wrap: belongs to a surface file that is filled; give the cube nodes_per_side"),
    ("mesh", 'file = "a.msh"\nside = 1', '4: mesh.side: belongs to generate = "cube"; remove it or the file'),
    ("mesh", 'file = ""', "3: mesh.file: is empty; name a mesh file, relative to the scene"),
    ("mesh", 'file = "a.msh"\nnode_count = 100\nedge_length = 0.1',
     "4: mesh.node_count: there is an edge_length too; keep one of them"),
    ("mesh", 'file = "a.msh"\nwrap = true',
     "4: mesh.wrap: belongs to a surface that is filled; give node_count or edge_length, or remove it"),
    ("mesh", 'file = "a.msh"\nnode_count = 3', "4: mesh.node_count: is 3 and must be 20 or more"),
    ("mesh", 'generate = "cube"\nnodes_per_side = 101', "4: mesh.nodes_per_side: is 101 and must lie in 2..100"),
    ("mesh", 'generate = "cube"\nnodes_per_side = 3.0',
     "4: mesh.nodes_per_side: must be a whole number, not a number", BEYOND),
    ("mesh", 'generate = "cube"\nside = 0', "4: mesh.side: is 0 and must be greater than 0"),
    ("mesh", 'generate = "ball"', '3: mesh.generate: "ball" is not known; known here: cube'),
    ("mesh", 'generate = "cube"\nelement = "quadratc"',
     '4: mesh.element: "quadratc" is not known; did you mean quadratic?'),
    ("material", "poisson = 0.3", "4: material.young: is missing; give a number"),
    ("material", "young = true\npoisson = 0.3", "5: material.young: must be a number, not true or false"),
    ("material", "young = -1\npoisson = 0.3", "5: material.young: is -1 and must be greater than 0"),
    ("material", "young = 1e300\npoisson = 0.3",
     "5: material.young: is 1e+300 Pa and must lie in 0.001..1000000000000000"),
    ("material", "young = inf\npoisson = 0.3", "5: material.young: must be a finite number"),
    ("material", "young = 1000\npoisson = 0.5",
     "6: material.poisson: is 0.5 and must lie between -1 and 0.5, both excluded; 0.5 is incompressible, which this "
     "method cannot do: use 0.49"),
    ("material", "young = 1000\npoisson = 0.49995",
     "6: material.poisson: is 0.49995, and linear tetrahedra above 0.4999 give the mesh's stiffness, not "
     "the body's: write element = \"average-nodal-pressure\" in [mesh]", BEYOND),
    ("material", "young = 1000\npoisson = 0.3\nshear = 1",
     '7: material.shear: does not belong to law = "isotropic", whose keys are young, poisson, stiffening', BEYOND),
    ("material", "young = 1000\npoisson = 0.3\nstiffening = 2",
     "7: material.stiffening: must be a law in braces: { yeoh = [y2, y3] }, or { fung = b }"),
    ("material", "young = 1000\npoisson = 0.3\nstiffening = { yeho = [1] }",
     "7: material.stiffening.yeho: unknown key; did you mean yeoh?", BEYOND),
    ("material", "young = 1000\npoisson = 0.3\nstiffening = { yeoh = [1], fung = 2 }",
     "7: material.stiffening.yeoh: give one law, { yeoh = [y2, y3] } or { fung = b }, or "
     "{ curve = [c1, c2, c3], energy = e0 }, or { curve = \"press.csv\", at = [x, y, z] }", BEYOND),
    ("material", "young = 1000\npoisson = 0.3\nstiffening = { curve = \"none.csv\", at = [0, 0, 1] }",
     "7: material.stiffening.curve: none.csv: cannot be read: No such file or directory", BEYOND),
    ("material", "young = 1000\npoisson = 0.3\nstiffening = { curve = \"press.csv\" }",
     "7: material.stiffening.at: is missing; give the place that was pressed, [x, y, z] in metres", BEYOND),
    ("material", "young = 1000\npoisson = 0.3\nstiffening = { yeoh = [1], radius = 0.01 }",
     "7: material.stiffening.radius: belongs to curve = \"press.csv\": remove it", BEYOND),
    ("material", "young = 1000\npoisson = 0.3\nstiffening = { curve = \"p.csv\", at = [0, 0, 1], energy = 1 }",
     "7: material.stiffening.energy: is the record's own: remove it", BEYOND),
    ("material", "young = 1000\npoisson = 0.3\nstiffening = { yeoh = [-1, 2] }",
     "7: material.stiffening.yeoh: has -1 and must lie in 0..10000: a body that stiffens", BEYOND),
    ("material", "young = 1000\npoisson = 0.3\nstiffening = { curve = [0, -3, 0], energy = 1 }",
     "7: material.stiffening.curve: has a force that does not grow with the dent: take the numbers of haptable-fit",
     BEYOND),
    ("material", "young = 1000\npoisson = 0.3\nstiffening = { fung = 0 }",
     "7: material.stiffening.fung: is 0, a body that does not stiffen: remove stiffening", BEYOND),
    *(("material", "young = 1000\npoisson = 0.3\nstiffening = { fung = 2 }\n" + more,
       "7: material.stiffening: is of " + why) for more, why in (
          ("[tool]\npoints = [[0, 0, 0], [0, 0, 1]]\n[contact]\nforce = \"consistent\"",
           "the dent of one finger: remove it, or [tool]"),
          ("[body]\nmodes = 2\ndensity = 1e3",
           "the whole dent, of which modes take a part that stays linear: remove it, or modes"),
          ("[contact]\ncoupling = 500.0", "the body alone, and a coupling is in series with it: remove one of them"),
      )),
    ("rest", "[mateial]", "7: mateial: unknown key; did you mean material?"),
    ("rest", '[tool]\npoints = 12\n[contact]\nforce = "consistent"',
     "8: tool.points: is a number: give the shape that has so many, or a list of points", BEYOND),
    ("rest", '[tool]\nshape = "disc"\nradius = 0.01\npoints = [[0, 0, 0], [0, 0, 1]]\n[contact]\nforce = "consistent"',
     "10: tool.points: are given one by one, and there is a shape too: give their number, or remove shape", BEYOND),
    ("rest", "[tool]\npoints = [[0, 0, 0], [0, 0, 1]]",
     '8: tool.points: are coupled by the body: set force = "pressure-mask" or "consistent" in [contact]'),
    ("rest", '[tool]\npoints = [[0, 0], [0, 0, 1]]\n[contact]\nforce = "consistent"',
     "8: tool.points: must be a list of points, like [[-0.004, 0, 0], [0.004, 0, 0]], m about the handle"),
    ("rest", '[tool]\npoints = [[0, 0, 0]]\n[contact]\nforce = "consistent"',
     "8: tool.points: are 1, and a tool has 2 to 32"),
    ("rest", '[tool]\nshape = "disc"\npoints = 12\n[contact]\nforce = "consistent"',
     "7: tool.radius: is missing; give a number, m"),
    ("rest", '[tool]\nshape = "mesh"\npoints = 12\n[contact]\nforce = "consistent"',
     "7: tool.file: is missing; name a mesh file"),
    ("rest", '[tool]\npoints = [[0, 0, 0], [0, 0, 1]]\n[contact]\nforce = "consistent"\nfingers = 2',
     "8: tool.points: are of one hand: remove fingers in [contact]"),
    ("rest", '[tool]\npoints = [[0, 0, 0], [0, 0, 1]]\nradius = 1\n[contact]\nforce = "consistent"',
     "9: tool.radius: belongs to a sphere, a capsule or a disc; remove it or choose that shape"),
    ("rest", '[tool]\npoints = [[0, 0, 0], [0, 0, 1]]\nstiffness = 1\n[contact]\nforce = "consistent"',
     "9: tool.stiffness: needs turn_stiffness, N m/rad, of the same coupling; give it"),
    ("rest", "[fixed]", "7: fixed: must be a list of tables, [[fixed]] with two brackets, not a table"),
    ("rest", "[[fixed]]", "7: fixed.below: give a box, a group or below"),
    ("rest", '[[fixed]]\naxis = "x"\nbox = [0, 0, 0, 1, 1, 1]', "8: fixed.axis: belongs to below, metres; give it"),
    ("rest", '[[fixed]]\nbelow = 1\ngroup = "a"', "9: fixed.group: there is below too; keep one of them"),
    ("rest", "[[fixed]]\nbelow = -1", "8: fixed.below: is -1 and must not be less than 0"),
    ("rest", '[[fixed]]\nbelow = 1\naxis = "w"', '9: fixed.axis: "w" is not known; did you mean z?'),
    ("rest", "[[touch]]", "7: touch.box: give either a box or a group"),
    ("rest", "[[touch]]\nbox = [0, 0, 2, 1, 1, 1]", "8: touch.box: zmin 2 is greater than zmax 1; swap them", BEYOND),
    ("rest", '[[touch]]\nbox = [0, 0, "low", 1, 1, 1]', "8: touch.box: entry 2 must be a finite number"),
    ("rest", "[[touch]]\nbox = [0, 0, 0]", "8: touch.box: must be six numbers: xmin ymin zmin xmax ymax zmax (m)"),
    ("rest", '[[touch]]\ngroup = ""', "8: touch.group: is empty; name a group of the mesh file"),
    ("rest", '[[touch]]\ngroup = "a"\ncavities = 1', "9: touch.cavities: must be true or false, not a whole number"),
    ("rest", '[[region]]\ngroup = "a"\nyoung = 1000\npoisson = 0.2\ndensity = 900',
     "11: region.density: belongs to a scene with [gravity]; add that table"),
    ("rest", '[[membrane]]\ngroup = "a"\nyoung = 1e6\npoisson = 0.3',
     "7: membrane.thickness: is missing; give a number"),
    ("rest", '[[membrane]]\ngroup = "a"\nthickness = 1e-4\nyoung = 1e6\npoisson = 0.51',
     "11: membrane.poisson: is 0.51 and must lie above -1 and be at most 0.5"),
    ("rest", '[[bed]]\ngroup = "a"', "7: bed.normal: give normal or tangential, in N/m^3, greater than 0"),
    ("rest", "[gravity]\nprestress = true", "7: gravity.density: is missing; give a number"),
    ("rest", "[gravity]\ndensity = 1\ndirection = [0, 0]", "9: gravity.direction: must be a direction, [0, 0, -1]"),
    ("rest", "[gravity]\ndensity = 1\ndirection = [0, 0, 0]",
     "9: gravity.direction: is 0, which is no direction", BEYOND),
    ("rest", "[gravity]\ndensity = 1\nacceleration = -9.81",
     "9: gravity.acceleration: is -9.81 and must be greater than 0"),
    ("rest", "[[relaxation]]\nshare = 0.5", "7: relaxation.time: is missing; give a number"),
    ("rest", "[[relaxation]]\nshare = 1.5\ntime = 1",
     "8: relaxation.share: brings the sum of all shares to 1.5, and a body whose stiffness relaxes to "
     "nothing flows: keep the sum below 1", BEYOND),
    ("rest", '[contact]\nforce = "nearest"',
     '8: contact.force: "nearest" is not known; known here: interpolated, consistent, pressure-mask'),
    ("rest", '[contact]\nforce = "pressure-mask"', "7: contact.mask_radius: is missing; give a number"),
    ("rest", "[contact]\nmask_radius = 0.01",
     '8: contact.mask_radius: belongs to force = "pressure-mask"; remove it or choose that force'),
    ("rest", "[contact]\nkinetic_friction = 0.2",
     "8: contact.kinetic_friction: needs friction, the static coefficient; give it or remove this line"),
    ("rest", "[contact]\nfriction = 0.2\nkinetic_friction = 0.3",
     "9: contact.kinetic_friction: is 0.3 and must not be greater than friction, 0.2", BEYOND),
    ("rest", "[contact]\nrelease_slew = -1", "8: contact.release_slew: is -1 and must not be less than 0"),
    ("rest", '[contact]\ncoupling = "always"', '8: contact.coupling: "always" is not known; known here: none, auto'),
    ("rest", "[contact]\ncoupling = 0", "8: contact.coupling: is 0 and must be greater than 0"),
    ("rest", "[contact]\npassivity = 1", "8: contact.passivity: must be true or false, not a whole number"),
    ("rest", "[contact]\nfingers = 9", "8: contact.fingers: is 9 and must be 1 to 8"),
    ("rest", "[contact]\nfingers = 3",
     '8: contact.fingers: are coupled by the body: set force = "pressure-mask" or "consistent" in [contact]'),
    ("rest", '[contact]\nforce = "consistent"\nfingers = 4\ngrab = true',
     "9: contact.fingers: push and do not hold: remove grab in [contact], or let two press it"),
    ("rest", '[contact]\nforce = "consistent"\nfingers = 3\n[body]\nfree = true\ndensity = 1000',
     "9: contact.fingers: press a body that is held: remove free = true in [body], or let two press it"),
    ("rest", '[contact]\nforce = "consistent"\nfingers = 3\n[body]\nmodes = 4\ndensity = 1000',
     "9: contact.fingers: press a body that follows at once: remove modes in [body], or let two press it"),
    ("rest", '[contact]\nforce = "consistent"\nfingers = 3\n[[relaxation]]\nshare = 0.5\ntime = 1',
     "9: contact.fingers: have no part for a body that relaxes: remove [[relaxation]], or let two press it"),
    ("rest", '[contact]\nforce = "consistent"\nfingers = 3\nrelease_slew = 0.1',
     "9: contact.fingers: end with their contacts: remove release_slew in [contact]"),
    ("rest", '[device]\nmodel = "phantm"', '8: device.model: "phantm" is not known; did you mean phantom?'),
    ("rest", "[device]\nmass = [1, -1, 1]", "8: device.mass: is -1 and must be greater than 0"),
    ("rest", "[device]\nmass = [1, 1]", "8: device.mass: must be three numbers: x y z"),
    ("rest", "[device]\ndelay = 0.1", "8: device.delay: is 0.1 s, and a servo takes what is 0.02 s old for silence"),
    ("rest", '[device]\nmax_speed = "none"', '8: device.max_speed: is "none": give a number above 0, or "off"'),
    ("rest", "[device]\nramp_time = 1",
     '8: device.ramp_time: belongs to force_return = "ramp"; remove it or choose that'),
    ("rest", '[device]\nhandedness = "both"', '8: device.handedness: "both" is not known; known here: right, left'),
    ("rest", '[device]\nmax_force = "8 N"', "8: device.max_force: must be a number, not a text"),
    ("rest", "[tables]\nflash_budget = 0", "8: tables.flash_budget: is 0 and must be greater than 0 (bytes)"),
    ("rest", "[tables]\ncoupling_bytes = 1000",
     "8: tables.coupling_bytes: belongs to several fingers or a tool; write fingers = 2 in [contact], or remove it"),
    ("rest", "[tables]\ndisplay_rows = [1, 1]", "8: tables.display_rows: names node 1 twice"),
    ("rest", "[tables]\ndisplay_rows = [-1]",
     "8: tables.display_rows: must be a list of mesh nodes, whole numbers from 0 on"),
    ("rest", '[tables]\ndisplay_precision = "int16"',
     "8: tables.display_precision: is of display_rows, which the microcontroller computes; give them, or remove it"),
    ("rest", '[tables]\ndisplay_rows = [1]\ncolumns = "none"',
     '8: tables.display_rows: needs columns, and columns = "none" leaves them out'),
    ("rest", '[tables]\ndisplay_rows = [1]\ncolumn_precision = "float16"',
     "8: tables.display_rows: needs columns in float32: remove column_precision"),
    ("rest", '[contact]\nforce = "pressure-mask"\nmask_radius = 0.01\n[tables]\ndisplay_rows = [1]',
     "11: tables.display_rows: a pressure mask spreads its load over nodes that only the host knows"),
    ("rest", "[body]\nfree = true",
     "7: body.density: is missing: a body that is not held needs a density or a mass, or [gravity]"),
    ("rest", "[body]\nfloor = 0", "8: body.floor: is of a body that is not held; add free = true"),
    ("rest", "[body]\nfree = true\nmass = 1\nfloor_friction = 1",
     "10: body.floor_friction: needs floor, its height; give it"),
    ("rest", "[body]\nmass = 1", "8: body.mass: is of a body that moves; add free = true or modes"),
    ("rest", "[body]\nfree = true\nmass = 1\nsuspension = [1, 2]",
     "10: body.suspension: must be six: along x, y, z, then about them"),
    ("rest", "[body]\nfree = true\nmass = 1\nsuspension = [1, 2, 3, -4, 5, 6]",
     "10: body.suspension: has -4, and none may be less than 0"),
    ("rest", "[body]\nfree = true\nmass = 1\nsuspension_damping = [1, 2, 3, 4, 5, 6]",
     "10: body.suspension_damping: needs suspension, six stiffnesses; give them"),
    ("rest", '[[bed]]\ngroup = "a"\nnormal = 1\n[body]\nfree = true\nmass = 1',
     "11: body.free: is true, and [[bed]] holds the body; remove one of them"),
    ("rest", "[gravity]\ndensity = 9\n[body]\nfree = true\ndensity = 1",
     "11: body.density: is in [gravity] already; remove one of them"),
    ("rest", "[body]\nfree = true\nmass = 1\n[contact]\nrelease_slew = 0.01",
     "11: contact.release_slew: keeps a force up that has ended, and a body that is free would be thrown by it; "
     "remove it"),
    ("rest", "[body]\nfree = true\nmass = 1\n[contact]\npassivity = true",
     "11: contact.passivity: is what the motion of a body that is free does already; remove it"),
    ("rest", "[body]\nmodes = 17\nmass = 1", "8: body.modes: is 17, and a servo has 0 to 16"),
    ("rest", "[body]\nmodes = 2",
     "7: body.density: is missing: a body that rings needs a density or a mass, or [gravity]"),
    ("rest", "[body]\nmode_damping = 0.1", "8: body.mode_damping: needs modes, how many ring; give it"),
    ("rest", "[body]\nmodes = 2\nmass = 1\nmode_damping = 1",
     "10: body.mode_damping: is 1, the ratio to critical damping, and must be at least 0.0001 and below 1"),
    ("rest", "[body]\nmodes = 2\nmass = 1\n[[relaxation]]\nshare = 0.5\ntime = 1",
     "8: body.modes: are of an elastic body: remove [[relaxation]], or modes"),
    ("rest", "[gravity]\ndensity = 9\nprestress = true\n[body]\nmodes = 2",
     "11: body.modes: are those of the body without stress; remove prestress, or modes"),
    ("rest", "[body]\nfree = true\ndensity = -1", "9: body.density: is -1 and must be greater than 0"),
    ("rest", "[body]\nfree = true\nmass = 1\nweight = 1",
     "10: body.weight: unknown key; known here: free, density, mass, suspension, suspension_damping, floor, "
     "floor_normal, floor_friction, modes, mode_damping"),
    ("rest", "[[fixed]]\nbox = [0,0,0,1,1,1]\n[body]\nfree = true\nmass = 1",
     "10: body.free: is true, and [[fixed]] holds the body; remove one of them"),
    ("rest", "[gravity]\ndensity = 9\nprestress = true\n[body]\nfree = true",
     "11: body.free: is true, and prestress needs a body that is held under its weight; remove that"),
    ("rest", "[body]\nfree = true\nmass = 1\nfloor = 0\nfloor_normal = [0, 0, 0]",
     "11: body.floor_normal: is 0, which is no direction", BEYOND),
    ("rest", "[body]\nfloor_normal = [0, 0, 1]",
     "8: body.floor_normal: is of a body that is not held; add free = true"),
    ("rest", "[body]\nfloor_friction = 1", "8: body.floor_friction: is of a body that is not held; add free = true"),
    ("rest", "[body]\nfree = true\nmass = 0.99e-6",
     "9: body.mass: is 9.9e-07 kg, and a servo moves 1e-06 to 1e+06 kg: give it in kg"),
    ("rest", "[body]\nfree = true\nmass = 1.01e6",
     "9: body.mass: is 1.01e+06 kg, and a servo moves 1e-06 to 1e+06 kg: give it in kg"),
    ("rest", "[body]\nmodes = 4\nmass = 1e-15",
     "9: body.mass: is 1e-15 kg, and a servo moves 1e-06 to 1e+06 kg: give it in kg"),
    ("rest", "[body]\nmodes = 8\nmass = 1\nmode_damping = 0.00001",
     "10: body.mode_damping: is 1e-05, the ratio to critical damping, and must be at least 0.0001 and below 1"),
    ("rest", "[body]\nmodes = -1\nmass = 1", "8: body.modes: is -1, and a servo has 0 to 16"),
    ("rest", "[body]\nmodes = 2\nmass = 1\n[contact]\npassivity = true",
     "8: body.modes: count what contacts give themselves: remove passivity, or modes"),
]
GOOD = """name = "a"
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
"""
ISOTROPIC = "young = 1000\npoisson = 0.3\n"
WOOD = ('law = "orthotropic"\nyoung = [4e4, 1e4, 1e4]\npoisson = [0.3, 0.3, 0.4]\nshear = [5e3, 5e3, 4e3]\n'
        "axes = [[0, 0, 2], [1, 0, 0]]\n")
FIBRE = ('law = "fibre"\nyoung_along = 4e4\nyoung_across = 1e4\npoisson = 0.3\npoisson_across = 0.4\nshear = 5e3\n'
         "direction = [0, 1, 0]\n")
# What stands in this scene, what is put in its place, and the error.
CHANGED = [
    ("box = [-1, -1, -1, 1, 1, 1e-9]", "box = [-1, -1, -1, 1, 1, 1e-9]\nbelow = 1",
     "10: fixed.box: there is below too; keep one of them"),
    ("[[touch]]\nbox", "[[touch]]\nbelow = 1\nbox", "12: touch.below: unknown key; known here: box, group, cavities"),
    ('columns = "none"', 'columns = "none"\ncolumn_precision = "float16"',
     '19: tables.column_precision: is of the columns, and columns = "none" leaves them out; remove one of them'),
    ('columns = "none"', 'columns = "none"\ncolumn_budget = 1e6',
     '19: tables.column_budget: is of the columns, and columns = "none" leaves them out; remove one of them'),
    ("max_force = 3.0", 'mean_force = "off"\nmean_force_time = 9',
     "17: device.mean_force_time: is of mean_force, which is off; remove one of them"),
    ("max_force", "max_force_rate = 0\nmax_force", "16: device.max_force_rate: is 0 and must be greater than 0"),
    ("max_force = 3.0", 'damping = 0\nmodel = "tuoch"', '17: device.model: "tuoch" is not known; did you mean touch?'),
    ("max_force = 3.0", "damping = 0\nmotion_scale = 0", "17: device.motion_scale: is 0 and must be greater than 0"),
    ("max_force = 3.0", "damping = 0\nforce_scale = -1", "17: device.force_scale: is -1 and must be greater than 0"),
    ("max_force = 3.0", "damping = 0\nposition = [0, 0]", "17: device.position: must be three numbers: x y z"),
    ("max_force = 3.0", "damping = 0\nposition = [0, 0, inf]", "17: device.position: entry 2 must be a finite number"),
    ("max_force = 3.0", "damping = 0\nrotation = 90", "17: device.rotation: must be three numbers: x y z"),
    ("max_force = 3.0", "damping = 0\nworkspace = [1, 0, 0, 0, 1, 1]",
     "17: device.workspace: xmin 1 is greater than xmax 0; swap them"),
    ("max_force = 3.0", "damping = 0\nclutches = 1",
     "17: device.clutches: unknown key; known here: model, max_force, mass, damping, friction, encoder_step, "
     "bandwidth, delay, max_speed, max_force_rate, mean_force, mean_force_time, force_return, ramp_time, position, "
     "rotation, handedness, motion_scale, force_scale, clutch_ramp, workspace"),
    ("max_force = 3.0", "damping = 0\nclutch_ramp = -0.1",
     "17: device.clutch_ramp: is -0.1 and must not be less than 0"),
    ("name", "nmae", "1: nmae: unknown key; did you mean name?"),
    ("young", "yuong", "7: material.yuong: unknown key; did you mean young?"),
    ("[device]", "[devices]", "15: devices: unknown key; did you mean device?"),
    ("side = 0.03", "size = 0.03", "5: mesh.size: unknown key; did you mean side?"),
    ("box = [-1.0", "bx = [-1.0", "12: touch.bx: unknown key; did you mean box?"),
    ("force = ", "colour = ",
     "14: contact.colour: unknown key; known here: force, mask_radius, god_object, rigid_stiffness, friction, "
     "kinetic_friction, fingers, release_slew, coupling, passivity, grab"),
    ("columns", "column", "18: tables.column: unknown key; did you mean columns?"),
    ("[device]", '[[region]]\ngroup = "a"\nyoung = 1\npoisson = 0.49999\n[device]',
     "18: region.poisson: is 0.49999, and linear tetrahedra above 0.4999 give the mesh's stiffness, not the body's: "
     "write element = \"average-nodal-pressure\" in [mesh]"),
    ('"interpolated"', '"pressure-mask"\nmask_radius = 0', "15: contact.mask_radius: is 0 and must be greater than 0"),
    ("[device]", 'god_object = "last-energy"\n[device]',
     '15: contact.god_object: "last-energy" is not known; did you mean least-energy?'),
    ("columns", 'flash_budget = "64k"\ncolumns', "18: tables.flash_budget: must be a whole number, not a text"),
    ("columns", 'precision = "float8"\ncolumns', '18: tables.precision: "float8" is not known; did you mean float32?'),
    ("[device]", '[[region]]\ngroup = "a"\n[device]', "15: region.young: is missing; give a number"),
    ("[device]", "[[region]]\nyoung = 1\npoisson = 0.3\n[device]", "15: region.box: give either a box or a group"),
    ("side = 0.03", "edge_length = 0.1",
     "5: mesh.edge_length: belongs to a surface file that is filled; give the cube nodes_per_side"),
    ("[device]", "friction = -0.2\n[device]", "15: contact.friction: is -0.2 and must not be less than 0"),
    ("[material]", "[[material]]", "6: material: must be one table, [material], not a list of tables"),
    ("0.3\n", "0.3.1\n",
     "8: Error while parsing floating-point: expected decimal digit or exponent, saw '.' (column 14); docs/SCENE.md "
     "has every key"),
    ("[tables]\n", "[mesh]\n",
     "17: Error while parsing table header: cannot redefine existing table 'mesh' (column 1); docs/SCENE.md has "
     "every key"),
    ("0.3\n", "-1.0\n",
     "8: material.poisson: is -1 and must lie between -1 and 0.5, both excluded; 0.5 is incompressible, which this "
     "method cannot do: use 0.49"),
    ("0.3\n", "nan\n", "8: material.poisson: must be a finite number"),
    ("1000", "0", "7: material.young: is 0 and must be greater than 0"),
    ("= 3\n", "= 1\n", "4: mesh.nodes_per_side: is 1 and must lie in 2..100"),
    ("3.0", "0.0", "16: device.max_force: is 0 and must be greater than 0"),
    ("max_force", "damping = -1\nmax_force", "16: device.damping: is -1 and must not be less than 0"),
    ('"none"', '"some"', '18: tables.columns: "some" is not known; did you mean none?'),
    ('generate = "cube"', 'file = "a.msh"',
     '4: mesh.nodes_per_side: belongs to generate = "cube"; remove it or the file'),
    ('name = "a"\n', "", "1: name: is missing; give a text"),
    ("[material]\nyoung = 1000\npoisson = 0.3\n", "", "1: material: is missing; add a table [material]"),
    (ISOTROPIC, WOOD.replace("[0.3, 0.3", "[2.1, 0.3"),
     "9: material.poisson: the stiffness is not positive definite: nu12 = 2.1 must lie between -2 and 2, the root "
     "of E1 / E2"),
    (ISOTROPIC, WOOD.replace("[0.3, 0.3", "[1.3, 1.3"),
     "9: material.poisson: the stiffness is not positive definite: 1 - nu12 nu21 - nu23 nu32 - nu31 nu13 - 2 nu21 "
     "nu32 nu13 = -0.343 must be greater than 0"),
    (ISOTROPIC, WOOD.replace("[5e3", "[0"), "10: material.shear: is 0 and must be greater than 0"),
    (ISOTROPIC, WOOD.replace("[4e4, 1e4, 1e4]", "4e4"), "8: material.young: must be three moduli, [E1, E2, E3]"),
    (ISOTROPIC, WOOD.replace("[1, 0, 0]", "[0, 0, 1]"),
     "11: material.axes: its two directions must not be parallel, nor 0"),
    (ISOTROPIC, WOOD.replace("axes = [[0, 0, 2], [1, 0, 0]]\n", ""),
     "6: material.axes: say how the material lies by one of axes, axes_field and around"),
    (ISOTROPIC, WOOD.replace("shear = [5e3, 5e3, 4e3]\n", ""),
     "6: material.shear: is missing; give three moduli, [G12, G13, G23]"),
    (ISOTROPIC, WOOD.replace("axes = ", "direction = [1, 0, 0]\naxes = "),
     '11: material.direction: does not belong to law = "orthotropic", whose keys are young, poisson, shear, axes, '
     'axes_field, around'),
    (ISOTROPIC, WOOD.replace('"orthotropic"', '"orthotropc"'),
     '7: material.law: "orthotropc" is not known; did you mean orthotropic?'),
    (ISOTROPIC, FIBRE.replace("poisson_across = 0.4", "poisson_across = 1"),
     "11: material.poisson_across: is 1 and must lie between -1 and 1, both excluded"),
    ('columns = "none"\n', 'columns = "none"\n[[relaxation]]\nshare = -0.5\ntime = 1\n',
     "20: relaxation.share: is -0.5 and must be greater than 0"),
    ('columns = "none"\n', 'columns = "none"\n[[relaxation]]\nshare = 0.5\ntime = 0\n',
     "21: relaxation.time: is 0 and must be greater than 0"),
    ('columns = "none"\n', 'columns = "none"\n' + 2 * "[[relaxation]]\nshare = 0.5\ntime = 1\n",
     "23: relaxation.share: brings the sum of all shares to 1, and a body whose stiffness relaxes to nothing flows: "
     "keep the sum below 1"),
    ('columns = "none"\n', 'columns = "none"\n' + 9 * "[[relaxation]]\nshare = 0.05\ntime = 1\n",
     "45: relaxation.time: is of term 9, and a servo has at most 8"),
    ('columns = "none"\n', 'columns = "none"\n[[bed]]\nnormal = 1e5\n', "19: bed.box: give either a box or a group"),
]


def text_of(part: str, text: str) -> str:
    return "name = {name}\n[mesh]\n{mesh}\n[material]\n{material}\n{rest}\n".format(**{**PARTS, part: text})


def error_of(folder, text, name: str = "scene.toml") -> str:
    """What haptable-precompute says of a scene, in one line behind the file's name."""
    file = folder / name
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    ended = run([program("haptable-precompute"), "--print-name", "--", file])
    assert (ended.status, ended.out, ended.err.count("\n")) == (1, "", 1), (text, ended)
    return ended.err.removesuffix("\n").removeprefix(f"haptable-precompute: {file}:").replace(f"{folder}/", "")


def test_errors_name_line_key_and_remedy(tmp_path, need):
    need("bin/haptable-precompute")
    assert name_of(tmp_path, GOOD) == "a\n"
    said = [error_of(tmp_path, text_of(part, text)) for part, text, *_ in WRONG]
    assert said == [error for _, _, error, *_ in WRONG]
    for old, new, error in CHANGED:
        assert old in GOOD
        assert error_of(tmp_path, GOOD.replace(old, new, 1)) == error


def name_of(folder, text: str) -> str:
    (folder / "good.toml").write_text(text)
    return run([program("haptable-precompute"), "--print-name", "--", folder / "good.toml"]).out


def test_the_schema_refuses_what_the_program_does():
    schema = jsonschema.Draft7Validator(json.loads((ROOT / "docs/scene.schema.json").read_text()))
    jsonschema.Draft7Validator.check_schema(schema.schema)
    for part, text, _, *beyond in WRONG:
        assert schema.is_valid(tomllib.loads(text_of(part, text))) == bool(beyond), text


def test_rows_of_a_display_are_counted_first(tmp_path):
    """Their number before each of them: 200,000 rows are refused at once."""
    rows = f'columns = "surface"\ndisplay_rows = [{", ".join(["7"] * 2000)}]'
    error = error_of(tmp_path, GOOD.replace('columns = "none"', rows))
    assert error.startswith("19: ") and "names 2000 nodes, and a target's display has at most 1000" in error


def test_a_scene_is_not_called_as_a_folder_of_the_build(tmp_path):
    """What the Makefile and its scripts name below build/, but for the scenes among it."""
    files = [file for pattern in ("Makefile", "*/*.mk", "scripts/*.sh") for file in ROOT.glob(pattern)]
    text = "".join(file.read_text() for file in files)
    named = set(re.findall(r"\$[({]?BUILD[)}]?/([a-z]+)(?=[/\s\"')]|$)", text, re.M))
    named -= {"cube", "mouse", "display", "ringing", "grasped", "squeezed", "wobbling", "jelly"}
    assert len(named) > 15
    for folder in named:
        assert "is a folder of the build itself" in error_of(tmp_path, text_of("name", f'"{folder}"')), folder


@pytest.mark.parametrize("name, text", [("duck.STL", "\0"), ("duck", "solid duck\nfacet normal 0 0 1\n"),
                                        ("duck.txt", "ply\nformat ascii 1.0\n"), ("duck.msh", "$MeshFormat\n")])
def test_a_mesh_is_no_scene(tmp_path, name, text):
    assert error_of(tmp_path, text, name) == (
        f' is a mesh, and a scene is asked for: write a file scene.toml with file = "{name}" in its '
        '[mesh], a [material] and what holds it; README.md has one under "Your own mesh"')


def test_utf16_is_named(tmp_path):
    assert "UTF-16" in error_of(tmp_path, b"\xff\xfen\0")


def test_the_readmes_scene_is_read(tmp_path):
    scene = (ROOT / "README.md").read_text().split("```toml\n", 1)[1].split("```", 1)[0]
    assert name_of(tmp_path, scene) == "duck\n"
    tables = tomllib.loads(scene).get("tables", {})
    assert "precision" not in tables and "flash_budget" not in tables, "a copier wants the defaults"
