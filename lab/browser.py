# SPDX-License-Identifier: GPL-2.0-or-later
"""Chromium without a window, over the DevTools protocol on a pipe.

https://chromedevtools.github.io/devtools-protocol"""

import base64
import contextlib
import json
import os
import select
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

from lab import LabError

PROGRAM = "/usr/bin/chromium"
PATIENCE_S = 120.0
_OPTIONS = ("--headless=new --remote-debugging-pipe --no-first-run --disable-background-networking "
            "--disable-component-update --mute-audio --hide-scrollbars --disable-dev-shm-usage "
            "--use-angle=swiftshader --enable-unsafe-swiftshader --disable-gpu-compositing").split()
_READ_BACK = "GL Driver Message (OpenGL, Performance"  # a picture that the processor puts into its page
# The browser's own moves (focus, sliders) want the number of the key.
_NUMBERS = {"Tab": 9, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39}


class Browser:
    """A browser with one page, ended by close. What goes wrong in it is raised as LabError."""

    def __init__(self, *words: str) -> None:
        """words: more of its command line, as "--disable-3d-apis"."""
        self.complaints: list[dict[str, Any]] = []  #: errors, and warnings of the console
        self.requests: list[str] = []  #: URLs, but blob: and data:
        self._profile = tempfile.mkdtemp(prefix="haptable-browser-")
        self._session, self._id, self._received = "", 0, b""
        self._loaded = self._pressed = False
        # The browser reads from descriptor 3 and writes to 4.
        self._process = subprocess.Popen(
            ["sh", "-c", 'exec "$@" 3<&0 4>&1 </dev/null >/dev/null', "sh", PROGRAM, *_OPTIONS,
             f"--user-data-dir={self._profile}", "--window-size=1280,800",
             *(["--no-sandbox"] if os.getuid() == 0 else []), *words],  # root has no sandbox
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, start_new_session=True)
        assert self._process.stdin and self._process.stdout
        self._to, self._from = self._process.stdin.fileno(), self._process.stdout.fileno()
        target = self.command("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.command("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.command(f"{domain}.enable")
        self.resize(1280, 800)

    def close(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        with self._process:  # its pipes are closed, too
            self._process.wait()
        shutil.rmtree(self._profile, ignore_errors=True)

    def open(self, url: str) -> None:
        """Opens a file or URL and waits until it is loaded."""
        self._loaded = False
        self.complaints.clear()
        self.requests.clear()
        opened = self.command("Page.navigate", url=url)
        if "errorText" in opened:
            raise LabError(f"{url}: {opened['errorText']}")
        while not self._loaded:
            self._note(self._receive())

    def evaluate(self, expression: str) -> Any:
        """The value of an expression of JavaScript, awaited where it is a promise."""
        answer = self.command("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            details = answer["exceptionDetails"]
            raise LabError(details.get("exception", {}).get("description", str(details)))
        return answer["result"].get("value")

    def wait_until(self, expression: str, patience_s: float = PATIENCE_S) -> bool:
        """Evaluates until it is true. False after its patience."""
        give_up = time.monotonic() + patience_s
        while not (met := self.evaluate(f"Boolean({expression})")) and time.monotonic() < give_up:
            time.sleep(0.02)
        return bool(met)

    def command(self, method: str, **parameters: Any) -> dict[str, Any]:
        """One command of the protocol in the page, and its result."""
        self._id += 1
        session = {"sessionId": self._session} if self._session else {}
        text = json.dumps({"id": self._id, "method": method, "params": parameters, **session}).encode() + b"\0"
        while text:
            text = text[os.write(self._to, text):]
        while (answer := self._receive()).get("id") != self._id:
            self._note(answer)
        if "error" in answer:
            raise LabError(f"{method}: {answer['error']}")
        return answer["result"]

    def mouse(self, kind: str, x: float, y: float, wheel: float = 0.0) -> None:
        """kind: "Pressed", "Moved", "Released", "Wheel"; x, y, wheel: CSS pixels."""
        self._pressed = kind == "Pressed" or self._pressed and kind != "Released"
        held = {"button": "left", "clickCount": 1} if self._pressed or kind == "Released" else {}
        turned = {"deltaX": 0, "deltaY": wheel} if kind == "Wheel" else {}
        self.command("Input.dispatchMouseEvent", type=f"mouse{kind}", x=x, y=y, buttons=int(self._pressed), **held,
                     **turned)

    def touch(self, kind: str, *fingers: tuple[float, float]) -> None:
        """Fingers on the screen, by place: "Start", "Move", "End"."""
        self.command("Input.dispatchTouchEvent", type=f"touch{kind}",
                     touchPoints=[{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(fingers)])

    def resize(self, width: int, height: int, phone: bool = False) -> None:
        """A page of this size, CSS pixels; a phone's has a touch screen."""
        self.command("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1,
                     mobile=phone)
        self.command("Emulation.setTouchEmulationEnabled", enabled=phone, maxTouchPoints=2)

    def key(self, name: str) -> None:
        """A key of one letter, or one that has a name, as "Tab"."""
        number = _NUMBERS.get(name)
        more = {} if number is None else {"code": name, "windowsVirtualKeyCode": number}
        text = {"text": name} if len(name) == 1 else {}
        self.command("Input.dispatchKeyEvent", type="keyDown", key=name, **more, **text)
        self.command("Input.dispatchKeyEvent", type="keyUp", key=name, **more)

    def screenshot(self, **options: Any) -> bytes:
        """The page as a PNG. options: of Page.captureScreenshot."""
        return base64.b64decode(self.command("Page.captureScreenshot", format="png", **options)["data"])

    def _receive(self) -> dict[str, Any]:
        """The next message of the browser: JSON up to a zero byte."""
        while b"\0" not in self._received:
            if not select.select([self._from], [], [], PATIENCE_S)[0]:
                raise LabError("the browser says nothing")
            piece = os.read(self._from, 1 << 20)
            if not piece:
                raise LabError("the browser is gone")
            self._received += piece
        text, self._received = self._received.split(b"\0", 1)
        return json.loads(text)

    def _note(self, event: dict[str, Any]) -> None:
        method, parameters = event.get("method"), event.get("params", {})
        self._loaded = self._loaded or method == "Page.loadEventFired"
        read_back = _READ_BACK in parameters.get("entry", {}).get("text", "")
        if method == "Runtime.exceptionThrown" or method == "Log.entryAdded" and not read_back or (
                method == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning")):
            self.complaints.append(parameters)
        if method == "Network.requestWillBeSent":
            url = parameters["request"]["url"]
            if not url.startswith(("blob:", "data:")):
                self.requests.append(url)


def missing() -> str:
    """Why there is no browser here; empty where there is one."""
    return "" if os.access(PROGRAM, os.X_OK) else "no chromium: sh scripts/setup.sh test installs it"


def touch_picture(page: Path, to: Path) -> None:
    """A picture of a page that a pointer presses and drags; with two fingers one is left in its dent, and the other
    presses beside it. Raises LabError without a dent."""
    with contextlib.closing(Browser()) as browser:
        browser.open(f"file://{page.resolve()}?theme=light&ratio=1&smooth=on")
        browser.evaluate("haptable.ready")
        (_press_two if browser.evaluate("haptable.scene().fingers") == 2 else _press_and_drag)(browser)
        # Without the footer, whose rate of pictures is that of the machine that ran this.
        browser.evaluate("document.getElementById('about').style.visibility = 'hidden'; 0")
        to.write_bytes(browser.screenshot())


def _want(browser: Browser, expression: str, what: str) -> None:
    if not browser.wait_until(expression):
        raise LabError(f"the page shows no {what}")


def _wait_ticks(browser: Browser, ticks: int) -> None:
    """Ticks of the page's servo, at a thousand a second of its time."""
    now = browser.evaluate("haptable.frame().tick")
    _want(browser, f"haptable.frame().tick > {now + ticks}", "time that goes on")


def _press(browser: Browser, x: float, y: float) -> None:
    for kind, at in (("Moved", x - 20), ("Moved", x), ("Pressed", x)):
        browser.mouse(kind, at, y)


def _press_two(browser: Browser) -> None:
    for share in (0.28, 0.74):
        x, y = browser.evaluate(f"(p => p.project([p.low[0] + {share} * (p.high[0] - p.low[0]), p.centre[1], "
                                "p.high[2]]))(haptable.picture())")[:2]
        _press(browser, x, y)
        _wait_ticks(browser, 1500)
        browser.key("f")
        browser.mouse("Released", x, y)
    _wait_ticks(browser, 500)
    _want(browser, "haptable.frame().contact && haptable.frame().second.contact", "two dents")


def _press_and_drag(browser: Browser) -> None:
    middle = browser.evaluate("haptable.picture().project(haptable.picture().centre)")
    x, y = middle[0] - 90, middle[1] - 40
    _press(browser, x, y)
    _want(browser, "haptable.frame().contact", "contact")
    for step in range(1, 21):  # as a hand drags, from rest to rest
        share = step / 20
        share *= share * (3 - 2 * share)
        browser.mouse("Moved", x + 130 * share, y + 50 * share)
        _wait_ticks(browser, 60)
    for kind, ticks in (("Released", 300), ("Pressed", 700)):
        browser.mouse(kind, x + 130, y + 50)
        _wait_ticks(browser, ticks)
    for _ in range(4):
        browser.mouse("Wheel", x + 130, y + 50, -100)
    _wait_ticks(browser, 900)
    _want(browser, "haptable.frame().contact && haptable.frame().displacement.some(u => u < -1e-3)", "dent")
