# SPDX-License-Identifier: GPL-2.0-or-later
"""What a person reads who wrote a scene that cannot be: file, line, key, what is wrong and what to do, word by word;
and what an editor underlines before the program is run."""

import json
import re
import tomllib

import jsonschema
import pytest
from programs import ROOT, program, run

#: A scene of one cube. A text that begins as one of these stands in its place, any other one at the end.
PARTS = {"name = ": 'name = "a"', "[mesh]\n": '[mesh]\ngenerate = "cube"',
         "[material]\n": "[material]\nyoung = 1000\npoisson = 0.3", "": ""}
WOOD = ('[material]\nlaw = "orthotropic"\nyoung = [4e4, 1e4, 1e4]\npoisson = [0.3, 0.3, 0.4]\nshear = [5e3, 5e3, 4e3]\n'
        "axes = [[0, 0, 2], [1, 0, 0]]\n")
FIBRE = ('[material]\nlaw = "fibre"\nyoung_along = 4e4\nyoung_across = 1e4\npoisson = 0.3\nshear = 5e3\n'
         "direction = [0, 1, 0]\n")
BEYOND = "docs/scene.schema.json lets it pass: numbers that only together are wrong, or none"
# What is wrong in a scene, and the error behind the file's name.
WRONG = [
    ("name = 3", "1: name: must be a text in quotes, not a whole number"),
    ('name = "../a"', "1: name: must be a letter and then at most 63 letters, digits, '_' and '-'"),
    ('name = "tests"', '1: name: "tests" is a folder of the build itself: choose another', BEYOND),
    ('[mesh]\nnodes_per_sid = 3\ngenerate = "cube"',
     "3: mesh.nodes_per_sid: unknown key; did you mean nodes_per_side?"),
    ('[mesh]\ngenerate = "cube"\nfile = "a.msh"',
     "4: mesh.file: there is a generator too; keep either generate or file"),
    ("[mesh]\nscale = 1", '2: mesh.file: is missing; give a mesh file, or generate = "cube"'),
    ('[mesh]\ngenerate = "cube"\nscale = 2.0',
     "4: mesh.scale: belongs to a mesh file; give the cube's side in metres and remove it"),
    ('[mesh]\ngenerate = "cube"\nlinearize = true',
     "4: mesh.linearize: belongs to a mesh file; the cube is linear: remove it"),
    ('[mesh]\ngenerate = "cube"\nwrap = true',
     "4: mesh.wrap: belongs to a surface file that is filled; give the cube nodes_per_side"),
    ('[mesh]\nfile = "a.msh"\nside = 1', '4: mesh.side: belongs to generate = "cube"; remove it or the file'),
    ('[mesh]\nfile = ""', "3: mesh.file: is empty; name a mesh file, relative to the scene"),
    ('[mesh]\nfile = "a.msh"\nnode_count = 100\nedge_length = 0.1',
     "4: mesh.node_count: there is an edge_length too; keep one of them"),
    ('[mesh]\nfile = "a.msh"\nwrap = true',
     "4: mesh.wrap: belongs to a surface that is filled; give node_count or edge_length, or remove it"),
    ('[mesh]\nfile = "a.msh"\nnode_count = 3', "4: mesh.node_count: is 3 and must be 20 or more"),
    ('[mesh]\ngenerate = "cube"\nnodes_per_side = 101', "4: mesh.nodes_per_side: is 101 and must lie in 2..100"),
    ('[mesh]\ngenerate = "cube"\nnodes_per_side = 3.0',
     "4: mesh.nodes_per_side: must be a whole number, not a number", BEYOND),
    ('[mesh]\ngenerate = "cube"\nside = 0', "4: mesh.side: is 0 and must be greater than 0"),
    ('[mesh]\ngenerate = "ball"', '3: mesh.generate: "ball" is not known; known here: cube'),
    ('[mesh]\ngenerate = "cube"\nelement = "quadratc"',
     '4: mesh.element: "quadratc" is not known; did you mean quadratic?'),
    ('[mesh]\ngenerate = "cube"\nsize = 0.03', "4: mesh.size: unknown key; did you mean side?"),
    ('[mesh]\ngenerate = "cube"\nedge_length = 0.1',
     "4: mesh.edge_length: belongs to a surface file that is filled; give the cube nodes_per_side"),
    ('[mesh]\ngenerate = "cube"\nnodes_per_side = 1', "4: mesh.nodes_per_side: is 1 and must lie in 2..100"),
    ('[mesh]\nfile = "a.msh"\nnodes_per_side = 3',
     '4: mesh.nodes_per_side: belongs to generate = "cube"; remove it or the file'),
    ("[material]\npoisson = 0.3", "4: material.young: is missing; give a number"),
    ("[material]\nyoung = true\npoisson = 0.3", "5: material.young: must be a number, not true or false"),
    ("[material]\nyoung = 1e300\npoisson = 0.3",
     "5: material.young: is 1e+300 Pa and must lie in 0.001..1000000000000000"),
    ("[material]\nyoung = inf\npoisson = 0.3", "5: material.young: must be a finite number"),
    ("[material]\nyoung = 1000\npoisson = 0.5", "6: material.poisson: is 0.5 and must lie between -1 and 0.5, both "
     "excluded; 0.5 is incompressible, which this method cannot do: use 0.49"),
    ("[material]\nyoung = 1000\npoisson = 0.49995", "6: material.poisson: is 0.49995, and linear tetrahedra above "
     "0.4999 give the mesh's stiffness, not the body's: write element = \"average-nodal-pressure\" in [mesh]", BEYOND),
    ("[material]\nyoung = 1000\npoisson = 0.3\nshear = 1",
     '7: material.shear: does not belong to law = "isotropic", whose keys are young, poisson, stiffening', BEYOND),
    ("[material]\nyoung = 1000\npoisson = 0.3\nstiffening = 2",
     "7: material.stiffening: must be a law in braces: { yeoh = [y2, y3] }, or { fung = b }"),
    *(("[material]\nyoung = 1000\npoisson = 0.3\nstiffening = " + law, "7: material.stiffening" + said, *beyond)
      for law, said, *beyond in (
      ("{ yeho = [1] }", ".yeho: unknown key; did you mean yeoh?"),
      ("{ yeoh = [1], fung = 2 }", '.yeoh: give one law, { yeoh = [y2, y3] } or { fung = b }, or { curve = [c1, c2, '
       'c3], energy = e0 }, or { curve = "press.csv", at = [x, y, z] }'),
      ('{ curve = "none.csv", at = [0, 0, 1] }', ".curve: none.csv: cannot be read: No such file or directory",
       BEYOND),
      ('{ curve = "press.csv" }', ".at: is missing; give the place that was pressed, [x, y, z] in metres"),
      ("{ yeoh = [1], radius = 0.01 }", '.radius: belongs to curve = "press.csv": remove it'),
      ('{ curve = "p.csv", at = [0, 0, 1], energy = 1 }', ".energy: is the record's own: remove it"),
      ("{ yeoh = [-1, 2] }", ".yeoh: has -1 and must lie in 0..10000: a body that stiffens"),
      ("{ curve = [0, -3, 0], energy = 1 }",
       ".curve: has a force that does not grow with the dent: take the numbers of haptable-fit", BEYOND),
      ("{ fung = 0 }", ".fung: is 0, a body that does not stiffen: remove stiffening"),
      )),
    *(("[material]\nyoung = 1000\npoisson = 0.3\nstiffening = { fung = 2 }\n" + more,
       "7: material.stiffening: is of " + why) for more, why in (
          ('[tool]\npoints = [[0, 0, 0], [0, 0, 1]]\n[contact]\nforce = "consistent"',
           "the dent of one finger: remove it, or [tool]"),
          ("[body]\nmodes = 2\ndensity = 1e3",
           "the whole dent, of which modes take a part that stays linear: remove it, or modes"),
          ("[contact]\ncoupling = 500.0", "the body alone, and a coupling is in series with it: remove one of them"),
      )),
    ("[material]\nyuong = 1000\npoisson = 0.3", "5: material.yuong: unknown key; did you mean young?"),
    ("[material]\nyoung = 0\npoisson = 0.3", "5: material.young: is 0 and must be greater than 0"),
    ("[material]\nyoung = 1000\npoisson = nan", "6: material.poisson: must be a finite number", BEYOND),
    ("[material]\nyoung = 1000\npoisson = -1.0", "6: material.poisson: is -1 and must lie between -1 and 0.5, both "
     "excluded; 0.5 is incompressible, which this method cannot do: use 0.49"),
    ("[mateial]", "7: mateial: unknown key; did you mean material?"),
    ('[tool]\npoints = 12\n[contact]\nforce = "consistent"',
     "8: tool.points: is a number: give the shape that has so many, or a list of points", BEYOND),
    ('[tool]\nshape = "disc"\nradius = 0.01\npoints = [[0, 0, 0], [0, 0, 1]]\n[contact]\nforce = "consistent"',
     "10: tool.points: are given one by one, and there is a shape too: give their number, or remove shape", BEYOND),
    ("[tool]\npoints = [[0, 0, 0], [0, 0, 1]]",
     '8: tool.points: are coupled by the body: set force = "pressure-mask" or "consistent" in [contact]'),
    ('[tool]\npoints = [[0, 0], [0, 0, 1]]\n[contact]\nforce = "consistent"',
     "8: tool.points: must be a list of points, like [[-0.004, 0, 0], [0.004, 0, 0]], m about the handle"),
    ('[tool]\npoints = [[0, 0, 0]]\n[contact]\nforce = "consistent"', "8: tool.points: are 1, and a tool has 2 to 32"),
    ('[tool]\nshape = "disc"\npoints = 12\n[contact]\nforce = "consistent"',
     "7: tool.radius: is missing; give a number, m"),
    ('[tool]\nshape = "mesh"\npoints = 12\n[contact]\nforce = "consistent"',
     "7: tool.file: is missing; name a mesh file"),
    ('[tool]\npoints = [[0, 0, 0], [0, 0, 1]]\n[contact]\nforce = "consistent"\nfingers = 2',
     "8: tool.points: are of one hand: remove fingers in [contact]"),
    ('[tool]\npoints = [[0, 0, 0], [0, 0, 1]]\nradius = 1\n[contact]\nforce = "consistent"',
     "9: tool.radius: belongs to a sphere, a capsule or a disc; remove it or choose that shape"),
    ('[tool]\npoints = [[0, 0, 0], [0, 0, 1]]\nstiffness = 1\n[contact]\nforce = "consistent"',
     "9: tool.stiffness: needs turn_stiffness, N m/rad, of the same coupling; give it"),
    ("[fixed]", "7: fixed: must be a list of tables, [[fixed]] with two brackets, not a table"),
    ("[[fixed]]", "7: fixed.below: give a box, a group or below"),
    ('[[fixed]]\naxis = "x"\nbox = [0, 0, 0, 1, 1, 1]', "8: fixed.axis: belongs to below, metres; give it"),
    ('[[fixed]]\nbelow = 1\ngroup = "a"', "9: fixed.group: there is below too; keep one of them"),
    ("[[fixed]]\nbelow = -1", "8: fixed.below: is -1 and must not be less than 0"),
    ('[[fixed]]\nbelow = 1\naxis = "w"', '9: fixed.axis: "w" is not known; did you mean z?'),
    ("[[fixed]]\nbox = [0,0,0,1,1,1]\n[body]\nfree = true\nmass = 1",
     "10: body.free: is true, and [[fixed]] holds the body; remove one of them"),
    ("[[fixed]]\nbox = [0, 0, 0, 1, 1, 1]\nbelow = 1", "8: fixed.box: there is below too; keep one of them"),
    ("[[touch]]", "7: touch.box: give either a box or a group"),
    ("[[touch]]\nbox = [0, 0, 2, 1, 1, 1]", "8: touch.box: zmin 2 is greater than zmax 1; swap them", BEYOND),
    ('[[touch]]\nbox = [0, 0, "low", 1, 1, 1]', "8: touch.box: entry 2 must be a finite number"),
    ("[[touch]]\nbox = [0, 0, 0]", "8: touch.box: must be six numbers: xmin ymin zmin xmax ymax zmax (m)"),
    ('[[touch]]\ngroup = ""', "8: touch.group: is empty; name a group of the mesh file"),
    ('[[touch]]\ngroup = "a"\ncavities = 1', "9: touch.cavities: must be true or false, not a whole number"),
    ("[[touch]]\nbelow = 1", "8: touch.below: unknown key; known here: box, group, cavities"),
    ("[[touch]]\nbx = [0, 0, 0, 1, 1, 1]", "8: touch.bx: unknown key; did you mean box?"),
    ('[[region]]\ngroup = "a"\nyoung = 1000\npoisson = 0.2\ndensity = 900',
     "11: region.density: belongs to a scene with [gravity]; add that table"),
    ('[[region]]\ngroup = "a"\nyoung = 1\npoisson = 0.49999',
     "10: region.poisson: is 0.49999, and linear tetrahedra above 0.4999 give the mesh's stiffness, not the body's: "
     "write element = \"average-nodal-pressure\" in [mesh]", BEYOND),
    ('[[region]]\ngroup = "a"', "7: region.young: is missing; give a number"),
    ("[[region]]\nyoung = 1\npoisson = 0.3", "7: region.box: give either a box or a group"),
    ('[[membrane]]\ngroup = "a"\nyoung = 1e6\npoisson = 0.3', "7: membrane.thickness: is missing; give a number"),
    ('[[membrane]]\ngroup = "a"\nthickness = 1e-4\nyoung = 1e6\npoisson = 0.51',
     "11: membrane.poisson: is 0.51 and must lie above -1 and be at most 0.5"),
    ('[[bed]]\ngroup = "a"', "7: bed.normal: give normal or tangential, in N/m^3, greater than 0"),
    ('[[bed]]\ngroup = "a"\nnormal = 1\n[body]\nfree = true\nmass = 1',
     "11: body.free: is true, and [[bed]] holds the body; remove one of them"),
    ("[[bed]]\nnormal = 1e5", "7: bed.box: give either a box or a group"),
    ("[gravity]\nprestress = true", "7: gravity.density: is missing; give a number"),
    ("[gravity]\ndensity = 1\ndirection = [0, 0]", "9: gravity.direction: must be a direction, [0, 0, -1]"),
    ("[gravity]\ndensity = 1\ndirection = [0, 0, 0]", "9: gravity.direction: is 0, which is no direction"),
    ("[gravity]\ndensity = 1\nacceleration = -9.81", "9: gravity.acceleration: is -9.81 and must be greater than 0"),
    ("[gravity]\ndensity = 9\n[body]\nfree = true\ndensity = 1",
     "11: body.density: is in [gravity] already; remove one of them"),
    ("[gravity]\ndensity = 9\nprestress = true\n[body]\nmodes = 2",
     "11: body.modes: are those of the body without stress; remove prestress, or modes"),
    ("[gravity]\ndensity = 9\nprestress = true\n[body]\nfree = true",
     "11: body.free: is true, and prestress needs a body that is held under its weight; remove that"),
    ("[[relaxation]]\nshare = 0.5", "7: relaxation.time: is missing; give a number"),
    ("[[relaxation]]\nshare = 1.5\ntime = 1", "8: relaxation.share: brings the sum of all shares to 1.5, and a body "
     "whose stiffness relaxes to nothing flows: keep the sum below 1", BEYOND),
    (2 * "[[relaxation]]\nshare = 0.5\ntime = 1\n", "11: relaxation.share: brings the sum of all shares to 1, and a "
     "body whose stiffness relaxes to nothing flows: keep the sum below 1", BEYOND),
    (9 * "[[relaxation]]\nshare = 0.05\ntime = 1\n",
     "33: relaxation.time: is of term 9, and a servo has at most 8", BEYOND),
    ("[[relaxation]]\nshare = -0.5\ntime = 1", "8: relaxation.share: is -0.5 and must be greater than 0"),
    ("[[relaxation]]\nshare = 0.5\ntime = 0", "9: relaxation.time: is 0 and must be greater than 0"),
    ('[contact]\nforce = "nearest"',
     '8: contact.force: "nearest" is not known; known here: interpolated, consistent, pressure-mask'),
    ('[contact]\nforce = "pressure-mask"', "7: contact.mask_radius: is missing; give a number"),
    ("[contact]\nmask_radius = 0.01",
     '8: contact.mask_radius: belongs to force = "pressure-mask"; remove it or choose that force'),
    ("[contact]\nkinetic_friction = 0.2",
     "8: contact.kinetic_friction: needs friction, the static coefficient; give it or remove this line"),
    ("[contact]\nfriction = 0.2\nkinetic_friction = 0.3",
     "9: contact.kinetic_friction: is 0.3 and must not be greater than friction, 0.2", BEYOND),
    ("[contact]\nrelease_slew = -1", "8: contact.release_slew: is -1 and must not be less than 0"),
    ('[contact]\ncoupling = "always"', '8: contact.coupling: "always" is not known; known here: none, auto'),
    ("[contact]\ncoupling = 0", "8: contact.coupling: is 0 and must be greater than 0"),
    ("[contact]\npassivity = 1", "8: contact.passivity: must be true or false, not a whole number"),
    ("[contact]\nfingers = 9", "8: contact.fingers: is 9 and must be 1 to 8"),
    ("[contact]\nfingers = 3",
     '8: contact.fingers: are coupled by the body: set force = "pressure-mask" or "consistent" in [contact]'),
    ('[contact]\nforce = "consistent"\nfingers = 4\ngrab = true',
     "9: contact.fingers: push and do not hold: remove grab in [contact], or let two press it"),
    ('[contact]\nforce = "consistent"\nfingers = 3\n[body]\nfree = true\ndensity = 1000',
     "9: contact.fingers: press a body that is held: remove free = true in [body], or let two press it"),
    ('[contact]\nforce = "consistent"\nfingers = 3\n[body]\nmodes = 4\ndensity = 1000',
     "9: contact.fingers: press a body that follows at once: remove modes in [body], or let two press it"),
    ('[contact]\nforce = "consistent"\nfingers = 3\n[[relaxation]]\nshare = 0.5\ntime = 1',
     "9: contact.fingers: have no part for a body that relaxes: remove [[relaxation]], or let two press it"),
    ('[contact]\nforce = "consistent"\nfingers = 3\nrelease_slew = 0.1',
     "9: contact.fingers: end with their contacts: remove release_slew in [contact]"),
    ('[contact]\nforce = "pressure-mask"\nmask_radius = 0.01\n[tables]\ndisplay_rows = [1]',
     "11: tables.display_rows: a pressure mask spreads its load over nodes that only the host knows"),
    ('[contact]\ncolour = "red"', "8: contact.colour: unknown key; known here: force, mask_radius, god_object, "
     "rigid_stiffness, friction, kinetic_friction, fingers, release_slew, coupling, passivity, grab"),
    ('[contact]\nforce = "pressure-mask"\nmask_radius = 0', "9: contact.mask_radius: is 0 and must be greater than 0"),
    ('[contact]\ngod_object = "last-energy"',
     '8: contact.god_object: "last-energy" is not known; did you mean least-energy?'),
    ("[contact]\nfriction = -0.2", "8: contact.friction: is -0.2 and must not be less than 0"),
    ('[device]\nmodel = "phantm"', '8: device.model: "phantm" is not known; did you mean phantom?'),
    ("[device]\nmass = [1, -1, 1]", "8: device.mass: is -1 and must be greater than 0"),
    ("[device]\nmass = [1, 1]", "8: device.mass: must be three numbers: x y z"),
    ("[device]\ndelay = 0.1", "8: device.delay: is 0.1 s, and a servo takes what is 0.02 s old for silence"),
    ('[device]\nmax_speed = "none"', '8: device.max_speed: is "none": give a number above 0, or "off"'),
    ("[device]\nramp_time = 1", '8: device.ramp_time: belongs to force_return = "ramp"; remove it or choose that'),
    ('[device]\nhandedness = "both"', '8: device.handedness: "both" is not known; known here: right, left'),
    ('[device]\nmax_force = "8 N"', "8: device.max_force: must be a number, not a text"),
    ('[device]\nmean_force = "off"\nmean_force_time = 9',
     "9: device.mean_force_time: is of mean_force, which is off; remove one of them"),
    ("[device]\nmax_force_rate = 0", "8: device.max_force_rate: is 0 and must be greater than 0"),
    ('[device]\nmodel = "tuoch"', '8: device.model: "tuoch" is not known; did you mean touch?'),
    ("[device]\nmotion_scale = 0", "8: device.motion_scale: is 0 and must be greater than 0"),
    ("[device]\nforce_scale = -1", "8: device.force_scale: is -1 and must be greater than 0"),
    ("[device]\nposition = [0, 0]", "8: device.position: must be three numbers: x y z"),
    ("[device]\nposition = [0, 0, inf]", "8: device.position: entry 2 must be a finite number", BEYOND),
    ("[device]\nrotation = 90", "8: device.rotation: must be three numbers: x y z"),
    ("[device]\nworkspace = [1, 0, 0, 0, 1, 1]",
     "8: device.workspace: xmin 1 is greater than xmax 0; swap them", BEYOND),
    ("[device]\nclutches = 1", "8: device.clutches: unknown key; known here: model, max_force, mass, damping, "
     "friction, encoder_step, bandwidth, delay, max_speed, max_force_rate, mean_force, mean_force_time, force_return, "
     "ramp_time, position, rotation, handedness, motion_scale, force_scale, clutch_ramp, workspace"),
    ("[device]\nclutch_ramp = -0.1", "8: device.clutch_ramp: is -0.1 and must not be less than 0"),
    ("[device]\nmax_force = 0.0", "8: device.max_force: is 0 and must be greater than 0"),
    ("[device]\ndamping = -1", "8: device.damping: is -1 and must not be less than 0"),
    ("[device]\nmean_force = 0.01", "7: device.mean_force_time: is 30 s, too short for max_force = 8.5 N and "
     "mean_force = 0.01 N: give 1.5e+03 s or more", BEYOND),
    ("[tables]\nflash_budget = 0", "8: tables.flash_budget: is 0 and must be greater than 0 (bytes)"),
    ("[tables]\ncoupling_bytes = 1000",
     "8: tables.coupling_bytes: belongs to several fingers or a tool; write fingers = 2 in [contact], or remove it"),
    ("[tables]\ndisplay_rows = [1, 1]", "8: tables.display_rows: names node 1 twice"),
    ("[tables]\ndisplay_rows = [-1]", "8: tables.display_rows: must be a list of mesh nodes, whole numbers from 0 on"),
    ('[tables]\ndisplay_precision = "int16"',
     "8: tables.display_precision: is of display_rows, which the microcontroller computes; give them, or remove it"),
    ('[tables]\ndisplay_rows = [1]\ncolumns = "none"',
     '8: tables.display_rows: needs columns, and columns = "none" leaves them out'),
    ('[tables]\ndisplay_rows = [1]\ncolumn_precision = "float16"',
     "8: tables.display_rows: needs columns in float32: remove column_precision"),
    ('[tables]\ncolumns = "none"\ncolumn_precision = "float16"',
     '9: tables.column_precision: is of the columns, and columns = "none" leaves them out; remove one of them'),
    ('[tables]\ncolumns = "none"\ncolumn_budget = 1e6',
     '9: tables.column_budget: is of the columns, and columns = "none" leaves them out; remove one of them'),
    ('[tables]\ncolumn = "none"', "8: tables.column: unknown key; did you mean columns?"),
    ('[tables]\ncolumns = "some"', '8: tables.columns: "some" is not known; did you mean none?'),
    ('[tables]\nflash_budget = "64k"', "8: tables.flash_budget: must be a whole number, not a text"),
    ('[tables]\nprecision = "float8"', '8: tables.precision: "float8" is not known; did you mean float32?'),
    ("[body]\nfree = true",
     "7: body.density: is missing: a body that is not held needs a density or a mass, or [gravity]"),
    ("[body]\nfloor = 0", "8: body.floor: is of a body that is not held; add free = true"),
    ("[body]\nfree = true\nmass = 1\nfloor_friction = 1", "10: body.floor_friction: needs floor, its height; give it"),
    ("[body]\nmass = 1", "8: body.mass: is of a body that moves; add free = true or modes"),
    ("[body]\nfree = true\nmass = 1\nsuspension = [1, 2]",
     "10: body.suspension: must be six: along x, y, z, then about them"),
    ("[body]\nfree = true\nmass = 1\nsuspension = [1, 2, 3, -4, 5, 6]",
     "10: body.suspension: has -4, and none may be less than 0"),
    ("[body]\nfree = true\nmass = 1\nsuspension_damping = [1, 2, 3, 4, 5, 6]",
     "10: body.suspension_damping: needs suspension, six stiffnesses; give them"),
    ("[body]\nfree = true\nmass = 1\n[contact]\nrelease_slew = 0.01", "11: contact.release_slew: keeps a force up that "
     "has ended, and a body that is free would be thrown by it; remove it"),
    ("[body]\nfree = true\nmass = 1\n[contact]\npassivity = true",
     "11: contact.passivity: is what the motion of a body that is free does already; remove it"),
    ("[body]\nmodes = 17\nmass = 1", "8: body.modes: is 17, and a servo has 0 to 16"),
    ("[body]\nmodes = 2", "7: body.density: is missing: a body that rings needs a density or a mass, or [gravity]"),
    ("[body]\nmode_damping = 0.1", "8: body.mode_damping: needs modes, how many ring; give it"),
    ("[body]\nmodes = 2\nmass = 1\nmode_damping = 1",
     "10: body.mode_damping: is 1, the ratio to critical damping, and must be at least 0.0001 and below 1"),
    ("[body]\nmodes = 2\nmass = 1\n[[relaxation]]\nshare = 0.5\ntime = 1",
     "8: body.modes: are of an elastic body: remove [[relaxation]], or modes"),
    ("[body]\nfree = true\ndensity = -1", "9: body.density: is -1 and must be greater than 0"),
    ("[body]\nfree = true\nmass = 1\nweight = 1", "10: body.weight: unknown key; known here: free, density, mass, "
     "suspension, suspension_damping, floor, floor_normal, floor_friction, modes, mode_damping"),
    ("[body]\nfree = true\nmass = 1\nfloor = 0\nfloor_normal = [0, 0, 0]",
     "11: body.floor_normal: is 0, which is no direction"),
    ("[body]\nfloor_normal = [0, 0, 1]", "8: body.floor_normal: is of a body that is not held; add free = true"),
    ("[body]\nfloor_friction = 1", "8: body.floor_friction: is of a body that is not held; add free = true"),
    ("[body]\nfree = true\nmass = 0.99e-6",
     "9: body.mass: is 9.9e-07 kg, and a servo moves 1e-06 to 1e+06 kg: give it in kg"),
    ("[body]\nfree = true\nmass = 1.01e6",
     "9: body.mass: is 1.01e+06 kg, and a servo moves 1e-06 to 1e+06 kg: give it in kg"),
    ("[body]\nmodes = 4\nmass = 1e-15",
     "9: body.mass: is 1e-15 kg, and a servo moves 1e-06 to 1e+06 kg: give it in kg"),
    ("[body]\nmodes = 8\nmass = 1\nmode_damping = 0.00001",
     "10: body.mode_damping: is 1e-05, the ratio to critical damping, and must be at least 0.0001 and below 1"),
    ("[body]\nmodes = -1\nmass = 1", "8: body.modes: is -1, and a servo has 0 to 16"),
    ("[body]\nmodes = 2\nmass = 1\n[contact]\npassivity = true",
     "8: body.modes: count what contacts give themselves: remove passivity, or modes"),
    ("[devices]", "7: devices: unknown key; did you mean device?"),
]
# Of materials that are not isotropic, whose numbers the schema does not look at.
WOODEN = [
    (WOOD.replace("[0.3, 0.3", "[2.1, 0.3"), "7: material.poisson: the stiffness is not positive definite: nu12 = 2.1 "
     "must lie between -2 and 2, the root of E1 / E2"),
    (WOOD.replace("[0.3, 0.3", "[1.3, 1.3"), "7: material.poisson: the stiffness is not positive definite: 1 - nu12 "
     "nu21 - nu23 nu32 - nu31 nu13 - 2 nu21 nu32 nu13 = -0.343 must be greater than 0"),
    (WOOD.replace("[5e3", "[0"), "8: material.shear: is 0 and must be greater than 0"),
    (WOOD.replace("[4e4, 1e4, 1e4]", "4e4"), "6: material.young: must be three moduli, [E1, E2, E3]"),
    (WOOD.replace("[1, 0, 0]", "[0, 0, 1]"), "9: material.axes: its two directions must not be parallel, nor 0"),
    (WOOD.replace("axes = [[0, 0, 2], [1, 0, 0]]", 'axes_field = ["a", "a"]'),
     "9: material.axes_field: names one direction twice; a material has two"),
    (WOOD.replace("axes = [[0, 0, 2], [1, 0, 0]]\n", ""),
     "4: material.axes: say how the material lies by one of axes, axes_field and around"),
    (WOOD.replace("shear = [5e3, 5e3, 4e3]\n", ""),
     "4: material.shear: is missing; give three moduli, [G12, G13, G23]"),
    (WOOD.replace("axes = ", "direction = [1, 0, 0]\naxes = "), '9: material.direction: does not belong to law = '
     '"orthotropic", whose keys are young, poisson, shear, axes, axes_field, around'),
    (WOOD.replace("tropic", "tropc"), '5: material.law: "orthotropc" is not known; did you mean orthotropic?'),
    (FIBRE + "poisson_across = 1\n", "11: material.poisson_across: is 1 and must lie between -1 and 1, both excluded"),
]
# What stands in the scene of one cube, what is put in its place, and the error: some are no TOML.
CHANGED = [
    ("name", "nmae", "1: nmae: unknown key; did you mean name?"),
    ('name = "a"\n', "", "1: name: is missing; give a text"),
    ("[material]\nyoung = 1000\npoisson = 0.3\n", "", "1: material: is missing; add a table [material]"),
    ("[material]", "[[material]]", "4: material: must be one table, [material], not a list of tables"),
    ("0.3\n", "0.3.1\n", "6: Error while parsing floating-point: expected decimal digit or exponent, saw '.' (column "
     "14); docs/SCENE.md has every key"),
    ("0.3\n", "0.3\n[mesh]\n", "7: Error while parsing table header: cannot redefine existing table 'mesh' (column "
     "1); docs/SCENE.md has every key"),
]


def text_of(text: str) -> str:
    own = next(begin for begin in PARTS if text.startswith(begin))
    return "\n".join({**PARTS, own: text}.values()) + "\n"


def error_of(folder, text, name: str = "scene.toml") -> str:
    """What haptable-precompute says of a scene, in one line behind the file's name."""
    file = folder / name
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    ended = run([program("haptable-precompute"), "--print-name", "--", file])
    assert (ended.status, ended.out, ended.err.count("\n")) == (1, "", 1), (text, ended)
    return ended.err.removesuffix("\n").removeprefix(f"haptable-precompute: {file}:").replace(f"{folder}/", "")


def name_of(folder, text: str) -> str:
    (folder / "good.toml").write_text(text)
    return run([program("haptable-precompute"), "--print-name", "--", folder / "good.toml"]).out


def test_errors_name_line_key_and_remedy(tmp_path, need):
    need("bin/haptable-precompute")
    assert name_of(tmp_path, text_of("")) == "a\n"
    wrong = WRONG + WOODEN
    assert [error_of(tmp_path, text_of(text)) for text, *_ in wrong] == [error for _, error, *_ in wrong]
    for old, new, error in CHANGED:
        assert old in text_of("")
        assert error_of(tmp_path, text_of("").replace(old, new, 1)) == error


def test_the_schema_refuses_what_the_program_does():
    schema = jsonschema.Draft7Validator(json.loads((ROOT / "docs/scene.schema.json").read_text()))
    for text, _, *beyond in WRONG:
        assert schema.is_valid(tomllib.loads(text_of(text))) == bool(beyond), text


def test_rows_of_a_display_are_counted_first(tmp_path):
    """Their number before each of them: 200,000 rows are refused at once."""
    error = error_of(tmp_path, text_of(f'[tables]\ncolumns = "surface"\ndisplay_rows = [{", ".join(["7"] * 2000)}]'))
    assert error.startswith("9: ") and "names 2000 nodes, and a target's display has at most 1000" in error


def test_a_scene_is_not_called_as_a_folder_of_the_build(tmp_path):
    """What the Makefile and its scripts name below build/, but for the scenes among it."""
    files = [file for pattern in ("Makefile", "*/*.mk", "scripts/*.sh") for file in ROOT.glob(pattern)]
    text = "".join(file.read_text() for file in files)
    named = set(re.findall(r"\$[({]?BUILD[)}]?/([a-z]+)(?=[/\s\"')]|$)", text, re.M))
    named -= {"cube", "mouse", "display", "ringing", "grasped", "squeezed", "wobbling", "jelly"}
    assert len(named) > 15
    for folder in named:
        assert "is a folder of the build itself" in error_of(tmp_path, text_of(f'name = "{folder}"')), folder


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
