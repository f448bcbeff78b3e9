# SPDX-License-Identifier: GPL-2.0-or-later
"""haptable-view --serve over a real session, with browsers without a window: a page that looks, one whose pointer is
the device, a second one that looks while it touches, and what goes wrong."""

import signal
from pathlib import Path

import pytest
from programs import BUILT, done, ends, program, read_csv, run, wait_until

from lab import browser as browsers

TOP = "[0.015, 0.015, 0.03]"
FELT = "haptable.frame().contact && haptable.frame().force[2] > 1e-3"
FREE = "haptable.frame().state === 1 && haptable.frame().force[2] === 0"


class Live:
    """A session and the program that serves its page."""

    def __init__(self, folder, start, browser) -> None:
        self.folder, self._start, self.browser = folder, start, browser

    def servo(self, tables=BUILT / "cube", csv: str = "servo.csv"):
        self.server = self._start([tables / "servo", "--lcm", "--no-realtime", "--quiet", "--csv", self.folder / csv])
        return self.server

    def device(self, *words, scene: str = "meshes/cube.toml"):
        return self._start([program("haptable-device"), scene, "--no-realtime", "--quiet", *words])

    def serve(self, tables=BUILT / "cube", *words) -> str:
        """The address that it prints."""
        out = self.folder / "view.out"
        self.view = self._start([program("haptable-view"), tables, "--lcm", "--serve", *words], out=out,
                                err=self.folder / "view.err")
        assert wait_until(lambda: "\n" in out.read_text()), self.said()
        return out.read_text().split("\n")[0]

    def said(self) -> str:
        return (self.folder / "view.err").read_text()

    def end_view(self) -> None:
        assert ends(self.view, by=signal.SIGINT) == 0, self.said()

    def end_servo(self) -> None:
        assert ends(self.server, by=signal.SIGTERM) == 0

    def open(self, url: str, browser=None):
        browser = browser or self.browser
        browser.mouse("Released", 0, 0)  # as the test before may have left it
        browser.open(url)
        assert browser.evaluate("haptable.ready.then(() => 'ready', error => error.message)") == "ready"
        until(browser, "haptable.live().touch !== undefined")  # it hears from its server
        return browser


@pytest.fixture
def live(tmp_path, start, browser, need, lcm_url) -> Live:
    need("cube/servo", "bin/haptable-device", "bin/haptable-view", "lib/page/servo.wasm")
    return Live(tmp_path, start, browser)


@pytest.fixture
def first(live):
    """A browser beside the shared one."""
    one = browsers.Browser()
    yield one
    one.close()


def until(browser, expression: str) -> None:
    assert browser.wait_until(expression), (expression, browser.evaluate("document.body.innerText"))


def says(browser, text: str) -> None:
    until(browser, f"document.getElementById('link').textContent.includes('{text}')")


def place(browser, point: str = TOP) -> tuple:
    """Of a point of the body, where it is now."""
    return tuple(browser.evaluate(f"(p => p.project(p.in_world({point})))(haptable.picture())")[:2])


def press(browser, point: str = TOP) -> tuple:
    x, y = place(browser, point)
    browser.mouse("Moved", x - 20, y)
    browser.mouse("Moved", x, y)
    browser.mouse("Pressed", x, y)
    return x, y


def press_until(browser, *seen, point: str = TOP, tries: int = 60) -> tuple:
    """Presses as a hand does, until every (page, expression) of `seen` was true. Where the machine has no time for the
    loop for 20 ms, the servo falls silent, and the finger that it finds inside next it did not see come in: it is free,
    for as long as it stays there. So a hand lets go after a while, and presses again."""
    for _ in range(tries):
        at = press(browser, point)
        if all(page.wait_until(expression, patience_s=4) for page, expression in seen):
            return at
        browser.mouse("Released", *at)
        browser.wait_until("!haptable.frame().contact", patience_s=4)
    raise AssertionError((seen, browser.evaluate("document.body.innerText")))


def expect_quiet(browser, url: str) -> None:
    """Nothing but the page itself is asked for, and the console is empty."""
    assert browser.complaints == [] and set(browser.requests) == {url}


def test_shows_a_session_as_the_servo_records_it(live, need):
    """What the page records is what the servo recorded, number for number, of a body that rings how far; it is drawn;
    and a program that only looks is no device."""
    jelly = need("ringing/servo").parent
    live.servo(jelly)
    url = live.serve(jelly)
    browser = live.open(url)
    says(browser, "The servo waits for a device.")
    browser.key("r")
    partner = live.device("--seconds", "300", "--path", "poke,drag", scene="tests/firmware/modes.toml")
    until(browser, "haptable.frame().recorded > 300 && haptable.frame().contact && "
                   "haptable.frame().displacement.some(u => u < -1e-4)")
    says(browser, "this page only looks")
    press(browser)
    assert ends(partner, by=signal.SIGINT) == 0
    browser.key("r")
    until(browser, "haptable.saved")
    live.end_servo()
    (live.folder / "page.csv").write_text(browser.evaluate("haptable.saved.csv"))
    servos, pages = read_csv(live.folder / "servo.csv"), read_csv(live.folder / "page.csv")
    assert servos.dtype.names == pages.dtype.names and "mode_8" in servos.dtype.names
    # The messages carry no tick and no area coordinates; the servo's last word, with which it falls silent, is no tick.
    columns = [name for name in servos.dtype.names if name != "tick" and not name.startswith("alpha")]
    known = {tuple(float(row[name]) for name in columns) for row in servos}
    shown = [tuple(float(row[name]) for name in columns) for row in pages if row["state"] != 0]
    assert len(shown) > 100 and set(shown) <= known
    assert browser.evaluate("haptable.live().goals[0]") is None
    expect_quiet(browser, url)


def test_closing_it_changes_nothing_in_the_loop(live):
    """A session in lockstep with a page that is opened and closed while it runs has the bytes of one without."""
    for watched in (False, True):
        live.servo(csv=f"{watched}.csv")
        browser = live.open(live.serve(), browsers.Browser()) if watched else None
        partner = live.device("--lockstep", "--seconds", "12", "--path", "poke,drag,circle")
        if browser:
            until(browser, "haptable.live().ticks > 0")
            browser.close()
        assert ends(partner) == 0
        live.end_servo()
    assert (live.folder / "True.csv").read_bytes() == (live.folder / "False.csv").read_bytes()


def test_its_pointer_is_the_device_and_a_second_page_looks(live, first):
    """The real servo answers. A second page sees it, and cannot touch; with the first closed the servo is silent, and
    the next page has the pointer."""
    live.servo()
    url = live.serve(BUILT / "cube", "--touch")
    live.open(url, first)
    says(first, "press on the body")
    second = live.open(url)
    assert [page.evaluate("haptable.live().yours") for page in (first, second)] == [True, False]

    at = press_until(first, (first, f"{FELT} && haptable.frame().displacement.some(u => u < -1e-4)"), (second, FELT))
    says(first, "your pointer is the device")
    says(second, "another page has the pointer")
    first.mouse("Released", *at)
    until(first, FREE)
    press(second)
    second.mouse("Released", *at)
    assert second.evaluate("haptable.live().goals[0]") is None
    # Nor does the server take a wish of it.
    second.evaluate("haptable.live().socket.send(JSON.stringify({kind: 'goal', at: [0.015, 0.015, 0.02], "
                    "place: true})); globalThis.before = haptable.live().ticks; 0")
    until(second, "haptable.live().ticks > before + 500")
    assert second.evaluate("!haptable.frame().contact && !(haptable.frame().finger[2] <= 0.03)")
    expect_quiet(first, url)
    expect_quiet(second, url)

    press_until(first, (second, "haptable.frame().contact"))
    first.open("about:blank")
    until(second, "haptable.frame().state === 0")  # the servo is silent
    live.open(url, second)
    assert second.evaluate("haptable.live().yours")
    press_until(second, (second, FELT))
    live.end_view()
    says(second, "The program that serves this page has ended")
    live.end_servo()
    assert read_csv(live.folder / "servo.csv")["force_z"].max() > 1e-3


def test_shows_two_fingers_that_lift_a_body_and_its_pointer_is_both(live, need):
    """Both of a session's fingers are drawn, and the body that they lift; and the pointer of a page leads either
    finger: F goes on with the other one."""
    two = need("grasped/servo").parent
    live.servo(two)
    url = live.serve(two, "--touch")
    browser = live.open(url)
    both_touch = ("haptable.frame().contact && haptable.frame().second.contact && haptable.picture().fingers.every("
                  "mark => mark.god.visible) && haptable.frame().second.force.some(f => Math.abs(f) > 1e-3)")
    browser.key("r")
    # In lockstep no machine is too slow for a finger to be believed; then the record tells what the page has seen.
    assert ends(live.device("--fingers", "2", "--path", "lift", "--lockstep", scene="tests/firmware/grasp.toml")) == 0
    until(browser, "((l, now) => { if (l.ticks !== globalThis.heard) { globalThis.heard = l.ticks; globalThis.since = "
                   "now; } return l.ticks > 0 && now - globalThis.since > 500; })(haptable.live(), performance.now())")
    browser.key("r")
    until(browser, "haptable.saved")
    (live.folder / "page.csv").write_text(browser.evaluate("haptable.saved.csv"))
    rows = read_csv(live.folder / "page.csv")
    assert (rows["contact"] + rows["contact2"] == 2).any()
    assert rows["body_z"].max() > browser.evaluate("haptable.scene().body.rest_centre[2]") + 0.01, "lifted"
    for _ in range(30):  # as press_until, but one that is left in its dent is lifted by its own press
        at = press_until(browser, (browser, "haptable.frame().contact"), point="[0.010, 0.015, 0.03]")
        browser.key("f")
        browser.mouse("Released", *at)
        at = press(browser, "[0.020, 0.015, 0.03]")
        if met := browser.wait_until(both_touch, patience_s=4):
            break
        browser.mouse("Released", *at)
        browser.key("f")
    assert met
    expect_quiet(browser, url)
    live.end_view()
    live.end_servo()


def test_says_that_another_device_has_the_servo(live):
    """The pointer of a page gets none, and is told so."""
    live.servo()
    url = live.serve(BUILT / "cube", "--touch")
    live.device("--seconds", "60", "--path", "circle")
    browser = live.open(url)
    until(browser, "haptable.live().ticks > 0")
    press(browser)
    says(browser, "Another device has the servo")


def test_says_that_it_is_served_from_another_folder(live):
    scene = Path("meshes/cube.toml").read_text().replace("poisson = ", "poisson = 0.1 # ")
    (live.folder / "other.toml").write_text(scene)
    done([program("haptable-precompute"), "other.toml", "-o", "other", "--quiet"], live.folder)
    servo = live.servo()
    live.device("--seconds", "60", "--path", "circle")
    browser = live.open(live.serve(live.folder / "other"))
    says(browser, "A servo of other tables")
    assert "a servo of other tables" in live.said()
    ends(servo, by=signal.SIGKILL)
    until(browser, "!haptable.frame().contact")


def test_dims_what_a_dead_servo_has_said(live):
    """And says that it is old."""
    servo = live.servo()
    browser = live.open(live.serve(BUILT / "cube", "--touch"))
    says(browser, "press on the body")
    numbers = "document.getElementById('numbers').textContent.includes"
    press_until(browser, (browser, f"haptable.frame().contact && {numbers}('in contact')"))
    assert not browser.evaluate("document.getElementById('felt').classList.contains('stale')")
    ends(servo, by=signal.SIGKILL)
    says(browser, "No servo is heard")
    until(browser, f"{numbers}('not heard; was: ')")
    assert browser.evaluate("getComputedStyle(document.querySelector('#force output')).color === "
                            "getComputedStyle(document.querySelector('#numbers dt')).color")
    assert browser.evaluate("Number(getComputedStyle(document.getElementById('picture')).opacity)") < 1


def test_says_that_no_servo_is_heard(live):
    """It says where, and what to start."""
    browser = live.open(live.serve())
    says(browser, "No servo is heard on udpm://239.255.72.84:")
    says(browser, "start build/cube/servo --lcm")


def test_answers_nothing_without_its_token(live):
    """Only who has the token gets the page or its socket, and only on this machine."""
    url = live.serve()
    at = "/".join(url.split("/")[:3])
    port, wrong = int(at.split(":")[-1]), f"{at}/{'0' * 32}/"
    browser = live.browser
    for other in (f"{at}/", wrong, f"{url}page.html"):
        browser.open(other)
        assert "not the whole address" in browser.evaluate("document.body.innerText"), other
    live.open(url)
    sockets = [browser.evaluate(f"new Promise(r => {{ const s = new WebSocket('ws{address[4:]}session'); "
                                "s.onopen = () => r('open'); s.onclose = () => r('closed'); })")
               for address in (url, wrong, f"{at}/")]
    assert sockets == ["open", "closed", "closed"]
    listening = run(f"grep ':{port:04X} 00000000:0000 0A' /proc/net/tcp*").out
    assert f"0100007F:{port:04X}" in listening and listening.count("\n") == 1
    second = run([program("haptable-view"), BUILT / "cube", "--lcm", "--serve", "--port", port])
    assert (second.status, second.out) == (1, "") and f"--port {port}: is in use" in second.err
    nowhere = run([program("haptable-view"), "no-such-folder", "--lcm", "--serve"])
    assert nowhere.status == 1 and "no-such-folder" in nowhere.err
