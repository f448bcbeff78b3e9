# SPDX-License-Identifier: GPL-2.0-or-later
"""The page in a browser without a window: opened from the disk, pressed, replayed, damaged. What its servo, in
WebAssembly, feels is what the library feels, bit for bit."""

import base64
import itertools
import json
import re
import zlib

import numpy as np
import pytest
from programs import ROOT, done, haptable_package, program, read_csv, run

from lab import browser as browsers

TOP = (0.015, 0.015, 0.03)
# Without limits, as the page has none: it has no motors, and a pointer jumps.
SCENE = ('name = "page"\n[mesh]\ngenerate = "cube"\nnodes_per_side = {n}\n[material]\nyoung = {young}\npoisson = 0.3\n'
         '[device]\nmax_speed = "off"\nmax_force_rate = "off"\n')
FIXED = "[[fixed]]\nbox = [-1, -1, -1, 1, 1, 1e-9]\n"
TWO = '[contact]\nforce = "consistent"\ngod_object = "least-energy"\nfingers = 2\n'
FLOOR = ("[gravity]\ndensity = 1000.0\n[body]\nfree = true\nfloor = 0.0\nfloor_friction = 0.3\n"
         "[contact]\nfriction = 0.8\n")
DENTED = "haptable.frame().contact && haptable.frame().displacement.some(u => u < -2e-4)"


class Page:
    """A scene's tables, the body that the library has of them, and the page, open in a browser or not yet."""

    def __init__(self, folder, browser) -> None:
        self.folder, self.browser, self.file = folder, browser, folder / "touch.html"
        self.url = f"file://{self.file}"

    def make(self, more: str = FIXED, n: int = 7, young: float = 1e4, words=()) -> "Page":
        (self.folder / "scene.toml").write_text(SCENE.format(n=n, young=young) + more)
        self.tables = self.folder / "tables"
        done([program("haptable-precompute"), "scene.toml", "-o", self.tables, "--quiet"], self.folder)
        done([program("haptable-view"), self.tables, "--page", self.file, "--quiet", *words], self.folder)
        self.body = haptable_package().load(self.tables)
        return self

    def open(self, query: str = "") -> "Page":
        self.browser.mouse("Released", 0, 0)  # as the test before may have left it
        self.browser.resize(1280, 800)
        self.browser.open(self.url + query)
        assert self("haptable.ready.then(() => 'ready', error => error.message)") == "ready"
        return self

    def __call__(self, expression: str):
        return self.browser.evaluate(expression)

    def until(self, expression: str) -> None:
        assert self.browser.wait_until(expression), (expression, self("haptable.frame()"))

    def at(self, x, y, z) -> tuple:
        """Where a point of the body, as it is now, is on the page."""
        return tuple(self(f"(p => p.project(p.in_world([{x}, {y}, {z}])))(haptable.picture())")[:2])

    def press(self, *where) -> tuple:
        x, y = self.at(*(where or TOP))
        self.browser.mouse("Moved", x - 20, y)
        self.browser.mouse("Moved", x, y)
        self.browser.mouse("Pressed", x, y)
        return x, y

    def let_go(self, x=0.0, y=0.0) -> None:
        self.browser.mouse("Released", x, y)

    def which(self, selector: str, condition: str) -> list:
        """Elements of the page for which a condition on `e` holds."""
        return self(f"Array.from(document.querySelectorAll('{selector}')).filter(e => {condition})"
                    ".map(e => e.id || e.textContent)")

    def expect_quiet(self) -> None:
        """No error in the console, and nothing asked for but the file itself."""
        assert self.browser.complaints == []
        assert [url for url in self.browser.requests if not url.startswith(self.url)] == []

    def replay(self, path: str) -> str:
        self(f"globalThis.file = Data.parse_csv(`{path}`, haptable.scene().fingers, "
             "Boolean(haptable.scene().tool)); 0")
        return self("haptable.replay(file, 0).then(done => done.csv)")

    def expect_the_hosts(self, csv: str) -> np.ndarray:
        """The rows of a session's CSV: what the library feels on its path is what they say, bit for bit."""
        (self.folder / "felt.csv").write_text(csv)
        rows = read_csv(self.folder / "felt.csv")
        (expect_held if "qw" in rows.dtype.names else expect_felt)(self.body, rows)
        return rows

    def recorded(self) -> np.ndarray:
        self.until("haptable.saved")
        return self.expect_the_hosts(self("haptable.saved.csv"))


@pytest.fixture
def page(tmp_path, browser, need):
    need("lib/page/servo.wasm", "lib/page/page.html", "lib/page/three.min.js", "lib/libhaptable.so.1")
    return Page(tmp_path, browser)


def columns(rows, name: str, of: str = "", letters="xyz") -> np.ndarray:
    return np.stack([rows[name + letter + of] for letter in letters], axis=1).astype(np.float32)


def expect_felt(body, rows) -> None:
    pair = body.fingers == 2
    servo = body.hands() if pair else body.servo()
    suffixes = ["", "2"][:body.fingers]

    def expect(name: str, told: np.ndarray, felt: list, known=slice(None)) -> None:
        np.testing.assert_array_equal(told[known], np.array(felt)[known], name)

    known = [rows["state" + of] != 0 if pair else np.full(len(rows), True) for of in suffixes]
    held, at = [rows["buttons" + of].astype(int) for of in suffixes], [columns(rows, "", of) for of in suffixes]
    felt, swung, pose = [[] for _ in suffixes], [], []
    for tick in range(len(rows)):
        for finger in range(len(suffixes)):
            servo.buttons(*[finger][:pair], grab=held[finger][tick] & 2, acknowledge=held[finger][tick] & 4)
        places = [here[tick] if is_known[tick] else None for here, is_known in zip(at, known)]
        for contacts, contact in zip(felt, servo.step(*places) if pair else (servo.step(places[0]),)):
            contacts.append(contact)
        swung.append(servo.swung if body.modes else ())
        pose.append((*servo.pose.centre, *servo.pose.turn) if body.free else ())
    for contacts, of, is_known in zip(felt, suffixes, known):
        expect("state", rows["state" + of], [contact.state for contact in contacts])
        expect("faults", rows["faults" + of], [contact.faults for contact in contacts], is_known)
        for name, letters, value in (("node_", "ijk", "nodes"), ("alpha_", "ijk", "alpha"),
                                     ("god_", "xyz", "god_object"), ("force_", "xyz", "force")):
            told = columns(rows, name, of, letters)
            expect(name + of, told, [getattr(contact, value) for contact in contacts], is_known)
    if body.modes:
        expect("mode", columns(rows, "mode_", letters=[str(k + 1) for k in range(body.modes)]), swung)
    if body.free:  # with nobody there it rests
        told = np.hstack([columns(rows, "body_"), columns(rows, "turn_", letters="wxyz")])
        expect("pose", told, np.float32(pose), np.logical_or.reduce(known))


def expect_held(body, rows) -> None:
    """The same of its tool."""
    tool, states, wrenches, points = body.tool(), [], [], []
    for handle, turn in zip(columns(rows, ""), columns(rows, "q", letters="wxyz")):
        felt = tool.step(handle, turn)
        states.append(int(felt["state"]))
        wrenches.append((*felt["force"], *felt["torque"]))
        points.append([(point["state"] == haptable_package().State.CONTACT, *point["force"]) for point in tool.points])
    np.testing.assert_array_equal(rows["state"], states)
    np.testing.assert_array_equal(np.hstack([columns(rows, "force_"), columns(rows, "torque_")]), np.float32(wrenches))
    for p, point in enumerate(np.float32(points).swapaxes(0, 1), 1):
        np.testing.assert_array_equal(rows[f"contact_p{p}"] != 0, point[:, 0] != 0, f"point {p}")
        np.testing.assert_array_equal(columns(rows, "force_", f"_p{p}"), point[:, 1:], f"point {p}")


def expect_the_bodys_surface(page, epsilon: float = 2.0**-24, least_m: float = 1e-4) -> None:
    """The displacements that the page shows are the library's of its loads and of how its modes have swung, to the
    rounding of its columns. Each row moves by at most the load times the softest block."""
    frame = page("(f => ({fingers: [f, f.second].filter(one => one && one.contact).map(one => ({nodal: "
                 "Array.from(one.nodal), nodes: Array.from(one.vertex, v => haptable.scene().node[v])})), "
                 "u: Array.from(f.displacement), swung: f.swung}))(haptable.frame())")
    haptable, swung = haptable_package(), np.float32(frame["swung"])
    contacts = [np.zeros((), haptable.CONTACT)] * (not frame["fingers"])
    for finger in frame["fingers"]:
        contacts.append(np.zeros((), haptable.CONTACT))
        contacts[-1]["state"], contacts[-1]["nodes"] = haptable.State.CONTACT, finger["nodes"]
        contacts[-1]["nodal_forces"] = np.reshape(finger["nodal"], (3, 3))
    u = sum(page.body.deform(contact, swung=swung if i == 0 else 0 * swung) for i, contact in enumerate(contacts))
    # First those of a column each, then the others.
    column_nodes = np.load(page.tables / "node_id.npy")
    place = {node: row for row, node in enumerate(page.body.row_nodes)}
    rows = [*column_nodes, *sorted(set(page.body.row_nodes) - set(column_nodes))]
    u = u[[place[node] for node in rows]]
    softest = (3 / np.diagonal(np.load(page.tables / "stiffness.npy"), axis1=1, axis2=2).min(axis=1)).max()
    size_n = sum(np.abs(contact["nodal_forces"]).sum() for contact in contacts)
    shown = np.reshape(frame["u"], (-1, 3))
    assert (np.abs(shown - u) <= 8 * epsilon * (size_n * softest + np.abs(u))).all()
    assert np.abs(u).max() > least_m


def csv_text(names: str, parts: list) -> str:
    return names + "\n" + "".join(",".join(f"{value:.9g}" for value in row) + "\n"
                                  for row in np.float32(np.column_stack(parts)))


def csv_of(path: np.ndarray) -> str:
    """A path [ticks, 3 fingers], m, with every combination of buttons."""
    held = np.arange(len(path)) // 500 % 8
    if path.shape[1] == 3:
        return csv_text("x,y,z,buttons", [path, held])
    return csv_text("x,y,z,buttons,x2,y2,z2,buttons2", [path[:, :3], held, path[:, 3:], 0 * held])


def strokes(body, count: int, seed: int = 1) -> np.ndarray:
    """[20 count, 3] m: a position that is none, then from just outside of a patch inwards for 10 ticks and aside for 9,
    at 0.01 to 5 m/s, whatever stands in the way."""
    lot = np.random.default_rng(seed)
    corners = body.rest[body.patches[lot.integers(len(body.patches), size=count)]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    inwards, aside = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in lot.normal(size=(2, count, 3)))
    inwards -= (0.5 + 2 * np.maximum((inwards * normal).sum(axis=1), 0))[:, None] * normal
    step = 1e-5 * 500 ** lot.random((count, 1))
    begin = (lot.dirichlet([1, 1, 1], count)[:, :, None] * corners).sum(axis=1)
    begin += (lot.random((count, 1)) * step + 2e-6) * normal
    tick = np.arange(19)[:, None, None]
    way = begin + step * (np.minimum(tick, 10) * inwards + np.maximum(tick - 10, 0) * aside)
    return np.concatenate([np.full((1, count, 3), np.nan), way]).swapaxes(0, 1).reshape(-1, 3)


def test_the_plot_says_how_deep_the_force_is_good(page):
    """A dashed line at the tables' depth, and none where that lies beyond the axis."""
    page.make().open()
    good_m = page("haptable.scene().small_strain.depth_m")
    assert good_m == json.loads((page.tables / "tables.json").read_text())["small_strain"]["depth_m"]
    drawn = page("""((good_m) => {
        const plot = new Plot(document.getElementById('by_depth')), ratio = window.devicePixelRatio;
        return [3.0, 0.1].map(share => {
            const history = new History(8);
            history.add(1.0, share * good_m, 1);
            draw_by_depth(plot, [history], 1e-6, 1e-9, good_m);
            const x = Math.floor(ratio * plot.x(good_m)), height = plot.canvas.height;
            if (x >= plot.canvas.width) return 0;
            const column = plot.canvas.getContext('2d').getImageData(x, 0, 1, height).data;
            return column.filter((value, i) => (i & 3) === 3 && value > 0).length / height;
        });
    })(%r)""" % good_m)
    assert drawn[0] > 0.3 and drawn[1] < 0.1


def test_opens_from_the_disk_and_is_pressed(page):
    """Without a network: the body is drawn, a press is felt and dents it, letting go frees the finger."""
    page.make().open()
    x, y = page.at(*TOP)
    body, ground = page(f"haptable.picture().pixel({x}, {y + 40})"), page("haptable.picture().pixel(8, 400)")
    # The processor draws the ground in the page's own colour, a graphics processor none.
    own = page("getComputedStyle(document.documentElement).getPropertyValue('--ground').match(/[0-9a-f]{2}/g)"
               ".map(x => parseInt(x, 16)).concat(255)")
    assert body[0] < 0xc0 and body[3] == 255 and (ground == own or ground[3] == 0)
    rest = page.browser.screenshot()
    assert rest[1:4] == b"PNG"
    page.press()
    page.until("haptable.frame().contact && haptable.frame().force[2] > 0")
    page.until("haptable.frame().displacement.some(u => u < -1e-4)")
    assert page.browser.screenshot() != rest
    page.let_go(x, y)
    page.until("haptable.frame().state === 1 && haptable.frame().force[2] === 0")
    page.expect_quiet()


def test_turns_and_zooms_and_keeps_its_axes_as_pictures_get_coarser(page):
    """A drag beside the body turns it, and the wheel brings it nearer."""
    page.make(n=4).open()
    azimuth, distance = page("[haptable.picture().azimuth, haptable.picture().distance]")
    page.browser.mouse("Pressed", 30, 400)
    page.browser.mouse("Moved", 130, 400)
    page.browser.mouse("Released", 130, 400)
    page.browser.mouse("Wheel", 400, 400, -100)
    page.until(f"haptable.picture().azimuth < {azimuth} && haptable.picture().distance < {distance}")
    assert page("haptable.frame().state") == 0
    drawn = ("(c => c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some(v => v > 0))"
             "(document.getElementById('overlay'))")
    page.until(drawn)
    page("haptable.picture().coarser(); haptable.picture().draw(); 0")
    assert page(drawn)


def test_is_pressed_by_a_finger_on_the_screen(page):
    """A touch screen: one finger presses, two come nearer."""
    page.make().open()
    page.browser.resize(1280, 800, phone=True)
    x, y = page.at(*TOP)
    page.browser.touch("Start", (x, y))
    page.until("haptable.frame().contact && haptable.frame().force[2] > 0")
    page.browser.touch("End")
    page.until("haptable.frame().state === 1")
    far = page("haptable.picture().distance")
    page.browser.touch("Start", (x, y), (x + 40, y))
    page.browser.touch("Move", (x, y), (x + 90, y))
    page.browser.touch("End")
    page.until(f"haptable.picture().distance < {far}")
    assert not page("haptable.frame().contact")
    page.expect_quiet()


def test_records_what_the_host_replays(page):
    """What came before is no part of it."""
    page.make().open()
    page.press()
    page.until("haptable.frame().contact")
    page.browser.key("r")
    page.let_go(*page.at(*TOP))
    page.until("haptable.frame().state === 1")
    x, y = page.press()
    page.until("haptable.frame().contact && haptable.frame().force[2] > 1e-3")
    for i in range(10):
        page.browser.mouse("Moved", x + 4 * i, y)
    page.let_go(x + 36, y)
    page.until("haptable.frame().state === 1")
    page.browser.key("r")
    rows = page.recorded()
    assert len(rows) > 100 and rows["contact"].any()
    page.expect_quiet()


MORE = {"": "", "friction": "friction = 0.5\nkinetic_friction = 0.4\n",
        "passivity": 'coupling = "auto"\nrelease_slew = 0.05\n'}
FORCES = {"interpolated": "", "consistent": "", "pressure-mask": "mask_radius = 0.012\n"}


@pytest.mark.parametrize("more", MORE)
@pytest.mark.parametrize("god_object", ["nearest", "least-energy"])
@pytest.mark.parametrize("force", FORCES)
def test_replays_the_hosts_bits_in_every_mode(page, force, god_object, more):
    page.make(f'[contact]\nforce = "{force}"\ngod_object = "{god_object}"\n{FORCES[force]}{MORE[more]}' + FIXED, n=5)
    rows = page.open("?worker=off").expect_the_hosts(page.replay(csv_of(strokes(page.body, 100))))
    assert rows["contact"].mean() > 0.2


@pytest.mark.parametrize("precision", ["float16", "int16"])
@pytest.mark.parametrize("force", FORCES)
def test_replays_the_hosts_bits_of_blocks_in_16_bits(page, force, precision):
    page.make(f'[contact]\nforce = "{force}"\n{FORCES[force]}[tables]\nprecision = "{precision}"\n' + FIXED, n=5)
    page.open("?worker=off").expect_the_hosts(page.replay(csv_of(strokes(page.body, 50))))


@pytest.mark.parametrize("more", [TWO + FIXED, FLOOR + "fingers = 2\n", FLOOR], ids=["held", "free", "free-one"])
def test_replays_the_hosts_bits_of_two_fingers_and_of_a_body_that_moves(page, more):
    page.make(more, n=5)
    path = strokes(page.body, 100)
    if page.body.fingers == 2:
        path = np.hstack([path, strokes(page.body, 100, seed=2)])
    rows = page.open("?worker=off").expect_the_hosts(page.replay(csv_of(path)))
    both = rows["contact"] + (rows["contact2"] if page.body.fingers == 2 else 1) == 2
    assert both.sum() > (10 if page.body.free else 100), "a body that is pushed moves out of the strokes' way"
    if page.body.free:
        assert np.hypot(rows["body_x"][-1] - 0.015, rows["body_y"][-1] - 0.015) > 1e-3, "they push it about"


TOOL = """[contact]
force = "{force}"
god_object = "{god_object}"
{more}[tool]
shape = "disc"
radius = 0.006
points = 7
"""


@pytest.mark.parametrize("force, god_object, more", [
    ("consistent", "nearest", ""), ("pressure-mask", "least-energy", "mask_radius = 0.012\nfriction = 0.3\n")])
def test_replays_the_hosts_bits_of_a_tool(page, force, god_object, more):
    page.make(TOOL.format(force=force, god_object=god_object, more=more) + FIXED, n=5)
    path = strokes(page.body, 30)
    angle = 0.01 * np.arange(len(path))
    turn = np.stack([np.cos(0.3 * np.sin(angle)), *(0.6 * np.sin(0.3 * np.sin(angle)) * s for s in (1, 1, 0.75))], 1)
    turn /= np.linalg.norm(turn, axis=1)[:, None]
    csv = page.open("?worker=off").replay(csv_text("x,y,z,qw,qx,qy,qz", [path, turn]))
    rows = page.expect_the_hosts(csv)
    assert len(rows) == len(path)
    assert sum(rows[f"contact_p{p}"] for p in range(1, 8)).max() > 2


def test_presses_a_tool_that_keys_turn(page):
    page.make(TOOL.format(force="consistent", god_object="nearest", more="") + FIXED).open()
    page.browser.key("r")  # a session that begins outside
    page.press()
    touching = "haptable.frame().tool.points.filter(point => point.contact).length"
    page.until(f"{touching} > 3 && haptable.frame().displacement.some(u => u < -1e-4)")
    assert page("document.getElementById('numbers').textContent.includes('points that touch')")
    flat = page("haptable.frame().tool.turn")
    for _ in range(4):
        page.browser.command("Input.dispatchKeyEvent", type="keyDown", key="ArrowRight", modifiers=8)
        page.browser.command("Input.dispatchKeyEvent", type="keyUp", key="ArrowRight", modifiers=8)
    page.until(f"haptable.frame().tool.turn.some((q, a) => Math.abs(q - [{','.join(map(str, flat))}][a]) > 0.1)")
    page.until("Math.hypot(...haptable.frame().tool.torque) > 1e-6")
    page.let_go(*page.at(*TOP))
    page.until("haptable.frame().state === 1")
    page.browser.key("r")
    page.recorded()
    page.expect_quiet()


def test_replays_alike_with_a_worker_and_without(page):
    page.make(n=5)
    path, said = csv_of(strokes(page.body, 200)), set()
    for worker in ("on", "off"):
        page.open(f"?worker={worker}")
        assert page("Boolean(haptable.without_worker)") == (worker == "off")
        csv = page.replay(path)
        said.add(csv)
        same = page(f"haptable.play(`{csv}`)")
        assert same["same"] == same["ticks"]
        page.expect_quiet()
    assert len(said) == 1


def test_offers_every_mode_that_its_tables_hold(page):
    """Those of an interpolated scene are, bit for bit, what scenes of these modes have; consistent ones are felt."""
    page.make(n=5).open()
    modes = [(m["force"], m["god_object"], m["friction"]) for m in page("haptable.scene().modes")]
    assert sorted(modes) == sorted(
        itertools.product(("interpolated", "consistent"), ("nearest", "least-energy"), (0, 0.5)))
    path = csv_of(strokes(page.body, 20))
    page(f"globalThis.file = Data.parse_csv(`{path}`); 0")
    offered = [page(f"haptable.replay(file, {i}).then(done => done.csv)") for i in range(len(modes))]
    assert len(set(offered)) == len(modes)
    for (force, god_object, friction), csv in zip(modes, offered):
        if force == "interpolated":
            page.make(f'[contact]\ngod_object = "{god_object}"\nfriction = {friction}\n' + FIXED, n=5)
            page.expect_the_hosts(csv)


def test_a_model_that_is_damaged_is_refused(page):
    """Bytes that are none: cut, longer, or naming a function that there is not."""
    page.make(n=4).open()
    part = {name: text for name, text in re.findall(r'<script[^>]* id="(scene|wasm|data)"[^>]*>(.*?)</script>',
                                                    page.file.read_text(), re.S)}
    scene, data = json.loads(part["scene"]), base64.b64decode(part["data"])
    table = scene["tables"][scene["modes"][0]["model"]]
    model = data[table["offset"]:table["offset"] + table["bytes"]]
    page("globalThis.bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)); "
         f"WebAssembly.compile(bytes('{part['wasm'].strip()}')).then(m => {{ globalThis.module = m; return 0; }})")

    def opens(model: bytes) -> bool:
        return page("WebAssembly.instantiate(module, {}).then(({exports}) => { "
                    f"const model = bytes('{base64.b64encode(model).decode()}'), "
                    "at = exports.page_reserve(model.length); "
                    "new Uint8Array(exports.memory.buffer, at, model.length).set(model); "
                    "return exports.page_model(at, model.length) !== 0; })")

    assert opens(model)
    assert not opens(model[:len(model) // 2]) and not opens(model + b"more")
    # The number of a function stands among the first words: some byte of them names one that there is not.
    assert not all(opens(model[:i] + b"\x4d" + model[i + 1:]) for i in range(0, 256, 4))


@pytest.mark.parametrize("form, epsilon, more", [
    ("float32", 2.0**-24, ""), ("float16", 2.0**-11, ""),
    ("float32", 2.0**-24, '[contact]\nforce = "pressure-mask"\nmask_radius = 0.012\n')],
    ids=["float32", "float16", "mask"])
def test_deforms_as_the_viewer_does(page, form, epsilon, more):
    """A mask loads the nodes under it, not the patch's corners alone."""
    page.make(more + FIXED)
    if form == "float16":  # too little for float32
        page.make(words=["--megabytes", page.file.stat().st_size / 1e6 - 0.01])
    page.open().press()
    assert page("haptable.scene().columns.format") == form
    page.until(f"{DENTED} && haptable.frame().force[2] > 0.01")
    expect_the_bodys_surface(page, epsilon)
    page.expect_quiet()


def test_one_finger_feels_the_other(page):
    """F leaves the finger in its dent and takes up the other, which presses beside it: the first one feels another
    force than it would alone there, for the surface moves under it. Both are drawn. What was recorded is what the host
    replays."""
    page.make(TWO + FIXED).open()
    assert page("getComputedStyle(document.querySelector('.two')).display !== 'none'")
    page.browser.key("r")
    one = page.press(0.009, 0.015, 0.03)
    page.until("haptable.frame().contact && haptable.frame().force[2] > 0.01")
    page.browser.key("f")
    page.let_go(*one)
    assert page("haptable.frame().second.state") == 0
    other = page.press(0.021, 0.015, 0.03)
    page.until("haptable.frame().second.contact && haptable.frame().second.force[2] > 0.01")
    page.until("(t => (globalThis.begun = globalThis.begun || t, t > begun + 500))(haptable.frame().tick)")
    assert page("haptable.frame().contact"), "it is where it was left"
    assert page("haptable.picture().fingers.every(mark => mark.god.visible && mark.arrow.visible)")
    expect_the_bodys_surface(page)
    page.until("document.querySelectorAll('#force output').length === 2")
    page.let_go(*other)
    page.until("haptable.frame().second.state === 1")
    page.browser.key("r")
    rows, alone, apart = page.recorded(), page.body.hands(), []
    for row in rows:
        first, _ = alone.step(np.float32([row["x"], row["y"], row["z"]]) if row["state"] else None, None)
        if row["state"] == row["state2"] == 2:
            force = np.array([row["force_x"], row["force_y"], row["force_z"]])
            apart.append(np.linalg.norm(force - first.force) / np.linalg.norm(force))
    assert len(apart) > 300 and np.mean(apart[-300:]) > 0.01
    again = page("haptable.play(haptable.saved.csv)")
    assert again["same"] == again["ticks"]
    page.expect_quiet()


def test_pushes_a_body_that_nothing_holds(page):
    """It is drawn, pressed again and recorded where it is, as the host has it."""
    page.make(FLOOR, young=2e4).open()
    page.browser.key("r")
    side = page.press(0.015, 0, 0.015)  # of the face that is seen in front
    page.until("haptable.frame().pose && haptable.frame().pose.centre[1] > 0.0165")
    page.until("haptable.picture().body.position.y > 0.02")  # of the diagonal, 52 mm
    page.let_go(*side)
    page.until("haptable.frame().state === 1")
    page.until("(f => { const was = globalThis.was || {tick: 0, y: 0}, y = f.pose.centre[1]; "
               "if (f.tick < was.tick + 50) return false; globalThis.was = {tick: f.tick, y}; "
               "return Math.abs(y - was.y) < 1e-6; })(haptable.frame())")
    # The pointer finds its face where that is now: on y = 0 of the body, which has moved.
    world_y, body_y, pixels = page(
        "(p => { const at = p.project(p.in_world([0.015, 0, 0.015])), x = p.pick(...at).at_m, seen = p.project(x); "
        "return [x[1], p.into_body({origin: x, direction: x}).origin[1], "
        "Math.hypot(seen[0] - at[0], seen[1] - at[1])]; })(haptable.picture())")
    assert world_y > 1e-3
    assert abs(body_y) < 32 * 2.0**-24 * 0.052 and pixels < 32 * 2.0**-24 * 1280
    # Pressed from above the god-object is over the finger, though the body's frame has moved farther than that.
    page.press()
    page.until("(f => f.contact && Math.hypot(f.god[0] - f.finger[0], f.god[1] - f.finger[1]) < 1e-3)"
               "(haptable.frame())")
    page.browser.key("r")
    page.recorded()
    page.browser.command("Input.dispatchKeyEvent", type="keyDown", key="Home")
    page.until("haptable.frame().pose.centre[1] === haptable.scene().body.rest_centre[1]")
    page.expect_quiet()


@pytest.mark.parametrize("rest", [
    '[contact]\nforce = "consistent"\n' + FIXED,
    'free = true\nfloor = 0.0\n[contact]\nforce = "pressure-mask"\ngod_object = "nearest"\nmask_radius = 0.012\n'],
    ids=["held", "free"])
def test_rings_when_it_is_let_go(page, rest):
    """What was recorded is what the host replays."""
    page.make("[gravity]\ndensity = 1000.0\n[body]\nmodes = 3\nmode_damping = 0.001\n" + rest, n=4, young=6e3).open()
    page.browser.key("r")
    at = page.press()
    page.until(DENTED)
    page.let_go(*at)
    page.until("haptable.frame().state === 1")
    for side in "<>":  # free, it is drawn as the modes have it, and they go on to the other side
        page.until(f"haptable.frame().swung[0] {side} 0")
    expect_the_bodys_surface(page, least_m=0.0)
    page.browser.key("r")
    page.recorded()
    page.expect_quiet()


def test_replays_a_path_of_one_finger_on_a_page_of_two(page):
    """It is felt as in a scene with one; a path of two is refused by a page of one."""
    page.make(TWO + FIXED, n=5).open()
    path = strokes(page.body, 10)
    rows = page.expect_the_hosts(page.replay(csv_of(path)))
    assert rows["contact"].any() and np.isnan(rows["x2"]).all() and not rows["state2"].any()
    page.make(TWO.replace("fingers = 2\n", "") + FIXED, n=5).open()
    alone = page.expect_the_hosts(page.replay(csv_of(path)))
    for name in alone.dtype.names:
        np.testing.assert_array_equal(rows[name], alone[name], name)
    assert "of two fingers" in page("(() => { try { Data.parse_csv('x,y,z,x2,y2,z2\\n0,0,0,0,0,0\\n'); } "
                                    "catch (error) { return error.message; } return ''; })()")


def test_says_where_it_is_damaged(page):
    """A file that was copied half says so, wherever it ends; one whose tables were changed too."""
    page.make(n=4)
    whole = page.file.read_text()

    def said(text: str) -> str:
        page.file.write_text(text)
        page.browser.open(page.url)
        page.until("!document.getElementById('failed').hidden")
        return page("document.getElementById('failed').innerText")

    data = whole.index('id="data"')
    for end in (whole.index("</style>") + 2000, data - 1000, data + 5000, len(whole) - 40):
        assert "This file is cut off." in said(whole[:end]), end
    other = "B" if whole[data + 3000] == "A" else "A"
    assert "its tables are not those that were written" in said(whole[:data + 3000] + other + whole[data + 3001:])


def test_says_that_there_is_no_webgl(page):
    """There is no picture, and the servo runs all the same."""
    page.make(n=4)
    page.browser = browsers.Browser("--disable-3d-apis")
    try:
        page.open().until("document.body.innerText.includes('This browser gives no WebGL')")
        page.expect_the_hosts(page.replay(csv_of(strokes(page.body, 10))))
    finally:
        page.browser.close()


def seen(browser, x: int, y: int) -> bytes:
    """What is at a place of the page: r, g, b. A PNG of one pixel has them behind the filter's byte."""
    png = browser.screenshot(clip={"x": x, "y": y, "width": 1, "height": 1, "scale": 1})
    pixels, at = b"", 8
    while at < len(png):  # length, name, data, CRC
        size = int.from_bytes(png[at:at + 4], "big")
        pixels += png[at + 8:at + 8 + size] if png[at + 4:at + 8] == b"IDAT" else b""
        at += 12 + size
    return zlib.decompress(pixels)[1:4]


def test_shows_all_numbers_and_controls(page):
    """At 1280 x 720, with a bar of 15 pixels beside the column: no number is cut off, whatever the force's size, no bar
    lies across, and what can be set is seen."""
    page.make().open()
    page.browser.resize(1280, 720)
    page("document.querySelector('aside').style.paddingRight = '23px'; 0")
    page.press()
    page.until("haptable.frame().contact && Math.hypot(...haptable.frame().force) > 0.1")
    page.until("document.getElementById('numbers').textContent.includes('in contact')")
    assert page.which("aside, aside *",
                      "e.scrollWidth > e.clientWidth && getComputedStyle(e).display !== 'inline'") == []
    assert page.which("#numbers dd", "e.getBoundingClientRect().height > 20") == [], "on a line each"
    assert page.which("aside select, aside button, aside input:not([hidden])",
                      "e.getBoundingClientRect().bottom > innerHeight") == []
    assert page("document.documentElement.scrollWidth <= innerWidth")
    page.expect_quiet()


def test_is_not_black_while_it_loads(page):
    """The title stands on the page's ground: a canvas that nothing was drawn on is black."""
    page.make(n=4)
    stub = page.browser.command("Page.addScriptToEvaluateOnNewDocument",
                                source="WebAssembly.instantiate = () => new Promise(() => {});")
    for theme, least in (("light", 0xe0), ("dark", 0x0a)):
        page.browser.open(f"{page.url}?worker=off&theme={theme}")
        page.until("haptable.picture()")
        assert seen(page.browser, 8, 200)[0] > least, theme
    page.browser.command("Page.removeScriptToEvaluateOnNewDocument", identifier=stub["identifier"])


def test_is_used_by_keys(page):
    """Whoever hears the page or has no pointer: all controls have a name, the focus is drawn, and keys work while a
    slider has it, but those that move the slider."""
    page.make().open()
    browser = page.browser
    browser.command("Accessibility.enable")
    controls = [node for node in browser.command("Accessibility.getFullAXTree")["nodes"]
                if node.get("role", {}).get("value") in ("slider", "combobox", "button", "checkbox")]
    for control in controls:
        assert control["name"]["value"], control
    sliders = [control for control in controls if control["role"]["value"] == "slider"]
    assert len(sliders) == 3 and all("valuetext" in json.dumps(slider) for slider in sliders)
    before = seen(browser, 1, 300)
    page("document.activeElement.blur(); 0")
    browser.key("Tab")
    assert page("document.activeElement.id") == "stage" and seen(browser, 1, 300) != before
    page("document.getElementById('depth').focus(); 0")
    assert page("getComputedStyle(document.activeElement).outlineStyle") != "none"
    state = "[haptable.picture().azimuth, Number(document.getElementById('depth').value)]"
    azimuth, depth = page(state)
    browser.key("ArrowRight")
    after = page(state)
    assert after[0] == azimuth and after[1] > depth, "the arrow is the slider's"
    browser.key("p")
    page.until("haptable.frame().contact")
    browser.key("p")
    page.until("haptable.frame().state === 1")
    page.expect_quiet()


POOR_TEXT = (ROOT / "tests/host/page/poor_text.js").read_text()


def test_its_text_is_readable(page):
    """WCAG 2: 4.5 to 1 of all text, in both themes; the ground of the stage is the worse of its two ends."""
    page.make()
    for theme in ("light", "dark"):
        page.open(f"?theme={theme}").press()
        page.until("document.getElementById('numbers').textContent.includes('in contact')")
        assert page(POOR_TEXT) == [], theme


def test_has_the_viewers_colours(page):
    """Finger, god-object and force, and the legend says so; on a dark ground those for it."""
    page.make(TWO + FIXED, n=4)
    colours = {name: [int(light, 16), int(dark, 16)] for name, light, dark in re.findall(
        r"COLOR\((\w+), 0x(\w+), 0x(\w+)\)", (ROOT / "host/base/colors.inc").read_text())}
    for theme in ("light", "dark"):
        page.open(f"?theme={theme}")
        drawn = {"finger": "fingers[0].finger", "second_finger": "fingers[1].finger", "god_object": "fingers[1].god",
                 "force": "fingers[0].shaft"}
        for name, mark in drawn.items():
            shown = page(f"haptable.picture().{mark}.children[0].material.color.getHex()")
            assert shown == colours[name][theme == "dark"], name
        page.until("document.querySelector('#legend i:not(.part)') !== null")
        legend = page("Array.from(document.querySelectorAll('#legend i:not(.part)'), "
                      "e => getComputedStyle(e).backgroundColor)")
        assert legend == [f"rgb({value >> 16}, {value >> 8 & 255}, {value & 255})"
                          for value in (colours[name][theme == "dark"] for name in drawn)]


def test_is_touched_by_two_fingers_on_a_phone(page):
    """Help, legend, and a second touch on the body is the second finger; beside the body it brings nearer."""
    page.make(TWO + FIXED).open()
    browser = page.browser
    browser.resize(390, 844, phone=True)
    page.until("haptable.picture().width === 390")
    assert page.which("#legend, #ask, #hint .by_touch", "e.getClientRects().length === 0") == []
    assert page("document.documentElement.scrollWidth <= innerWidth")
    one, other = page.at(0.009, 0.015, 0.03), page.at(0.021, 0.015, 0.03)
    browser.touch("Start", one)
    page.until("haptable.frame().contact")
    browser.touch("Start", one, other)
    page.until("haptable.frame().contact && haptable.frame().second.contact")
    browser.touch("End")
    page.until("haptable.frame().state === 1 && haptable.frame().second.state === 1")
    far = page("haptable.picture().distance")
    browser.touch("Start", one, (12, 300))
    browser.touch("Move", (one[0] + 60, one[1]), (12, 300))
    browser.touch("End")
    page.until(f"haptable.picture().distance < {far}")
    page("document.getElementById('ask').click(); 0")
    assert page("document.getElementById('help').open")
    page("document.getElementById('help').close(); 0")
    page.expect_quiet()


def test_tells_what_is_wrong_with_a_csv(page):
    """By its line, and the page goes on."""
    page.make(n=4).open()
    for csv, said in (("a,b\n1,2\n", "line 1"), ("x,y,z\n0,0,0\n0,0\n", "line 3"), ("x,y,z\n0,zero,0\n", "line 2"),
                      ("x,y,z\n0.015,0.015,0.04\n15,15,29.5\n",
                       "line 3 (15, 15, 29.5) looks like millimetres, and a path is in metres: divide its places by "
                       "1000")):
        assert said in page(f"haptable.play(`{csv}`).then(() => '', error => error.message)")
    for csv in ("x,y,z\n0,nan,inf\n0.01,0.01,0.04\n", "x,y,z\n15000,15,29.5\n"):  # far in millimetres too
        assert page(f"haptable.play(`{csv}`).then(() => '', error => error.message)") == ""


@pytest.mark.parametrize("words, more, said", [
    (["nowhere"], "", "nowhere/tables.json"), (["tables", "--megabytes", "0.1"], "", "--megabytes"),
    (["tables"], '[tables]\ncolumns = "none"\n', "columns"), (["tables", "-o", "pictures"], "", "")])
def test_says_what_it_cannot_make_a_page_of(need, tmp_path, words, more, said):
    """One line, and no file."""
    need("lib/page/servo.wasm")
    (tmp_path / "scene.toml").write_text(SCENE.format(n=7, young=1e4) + FIXED + more)
    done([program("haptable-precompute"), "scene.toml", "-o", "tables", "--quiet"], tmp_path)
    ended = run([program("haptable-view"), *words, "--page", "touch.html"], tmp_path)
    assert ended.status == (1 if said else 2) and said in ended.err and (not said or ended.err.count("\n") == 1)
    assert not (tmp_path / "touch.html").exists()
