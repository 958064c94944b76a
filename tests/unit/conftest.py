"""Fixtures of several rooms: commands, kernels as Python, mechanisms with a known motion, and a headless browser for
pages, controlled by the DevTools protocol over two pipes."""

import fcntl
import itertools
import json
import os
import shutil
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest

from mbdsl import cli, load, parse
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.system import build

MODELS = Path(__file__).parents[2] / "models"
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
SECONDS = 300  #: after which the browser counts as dead


@pytest.fixture
def say(capsys, tmp_path, monkeypatch):
    """Run a command in an empty folder: exit code, standard output, standard error."""
    monkeypatch.chdir(tmp_path)

    def run(*argv):
        return (cli.main([str(a) for a in argv]), *capsys.readouterr())

    return run


@pytest.fixture
def plain():
    """A kernel as a Python function: kernels of modules are never replaced by compiled ones."""
    return lambda kernel: kernel


def made(scene, t, states):
    """A trajectory from the coordinates (N, n) of bodies, by name."""
    system = build(scene)
    q = np.zeros((len(t), system.n))
    for name, values in states.items():
        d = system.tables.coordinates[name]
        q[:, d : d + values.shape[1]] = values
    return Trajectory(system, np.asarray(t), q, np.zeros_like(q), None, {"status": "done"})


@pytest.fixture(scope="session")
def trajectory_of():
    """``trajectory_of(scene, t, {body: coordinates (N, n)})``: a trajectory without a simulation."""
    return made


@pytest.fixture(scope="session")
def model_file():
    """``model_file(name)``: a file of the folder models."""
    return lambda name: MODELS / f"{name}.mbd"


@pytest.fixture(scope="session")
def slider_crank():
    """The slider crank with its crank at phi = 2 t: its other coordinates follow from the lengths 0.3 and 0.6."""
    t = np.linspace(0.0, 3.0, 301)
    phi = 2.0 * t
    psi = -np.arcsin(0.5 * np.sin(phi))
    pin = 0.3 * np.stack([np.cos(phi), np.sin(phi)], axis=1)
    half = 0.3 * np.stack([np.cos(psi), np.sin(psi)], axis=1)
    states = {"crank": np.column_stack([pin / 2, phi]), "rod": np.column_stack([pin + half, psi])}
    return made(load(MODELS / "slider_crank.mbd"), t, states)


@pytest.fixture(scope="session")
def arm_in_space():
    """An arm of 1 m that turns about z by 2 t, and a mass on a helix: their motion in closed form."""
    scene = parse(
        """spatial model Arm "an arm and a mass"
          Ground ground(n = {0, 0, -1}); Rod arm(m = 1 kg, length = 1 m); PointMass ball(m = 1 kg);
          Revolute pin(ground, arm.a); FreeMotion free(ground, ball); end Arm;"""
    )
    t = np.linspace(0.0, 4.0, 201)
    phi = np.angle(np.exp(2j * t))  # rotation vectors are up to pi long
    arm = np.column_stack([0.5 * np.cos(phi), 0.5 * np.sin(phi), 0 * t, 0 * t, 0 * t, phi])
    return made(scene, t, {"arm": arm, "ball": np.column_stack([np.cos(t), np.sin(t), 0.3 * t])})


@pytest.fixture(scope="session")
def arm_page(arm_in_space, tmp_path_factory):
    """The page of `arm_in_space`."""
    path = tmp_path_factory.mktemp("space") / "arm.html"
    arm_in_space.animate(path)
    return path


class Browser:
    """A page in a headless browser, with what it loads and writes to its console."""

    def __init__(self, program, folder):
        ours, theirs = os.pipe(), os.pipe()
        ends = [fcntl.fcntl(fd, fcntl.F_DUPFD, 50) for fd in (ours[0], theirs[1])]
        flags = ("--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--remote-debugging-pipe")
        flags += ("--disable-dev-shm-usage", "--enable-unsafe-swiftshader")  # WebGL without a graphics card
        quiet = [(os.POSIX_SPAWN_OPEN, fd, os.devnull, os.O_WRONLY, 0) for fd in (1, 2)]
        moves = [(os.POSIX_SPAWN_DUP2, ends[0], 3), (os.POSIX_SPAWN_DUP2, ends[1], 4)]
        arguments = [program, *flags, f"--user-data-dir={folder}", "--no-first-run", "about:blank"]
        self.process = os.posix_spawn(program, arguments, os.environ, file_actions=quiet + moves)
        for fd in (*ends, ours[0], theirs[1]):
            os.close(fd)
        self.input, self.output = ours[1], theirs[0]
        os.set_blocking(self.output, False)
        self.numbers, self.rest, self.session = itertools.count(1), b"", None
        self.said, self.loaded, self.finished = [], [], 0
        target = self.send("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.send(f"{domain}.enable")

    def send(self, method, **parameters):
        number = next(self.numbers)
        message = {"id": number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.input, json.dumps(message).encode() + b"\0")
        while True:
            found = self.receive()
            if found.get("id") == number:
                assert "error" not in found, found["error"]
                return found["result"]

    def receive(self):
        begun = time.monotonic()
        while b"\0" not in self.rest:
            try:
                self.rest += os.read(self.output, 1 << 20)
            except BlockingIOError:
                time.sleep(0.002)
            assert time.monotonic() < begun + SECONDS, "the browser does not respond"
        line, _, self.rest = self.rest.partition(b"\0")
        found = json.loads(line)
        method, about = found.get("method"), found.get("params", {})
        if method in ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded"):
            self.said.append(about)
        elif method == "Network.requestWillBeSent":
            self.loaded.append(about["request"]["url"])
        elif method == "Page.loadEventFired":
            self.finished += 1
        return found

    def open(self, path, width=1000, height=640, scheme="light", still=True):
        """Open a file; ``still``: with the preference for reduced motion, so that it does not play at once."""
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        motion = "reduce" if still else "no-preference"
        features = [("prefers-color-scheme", scheme), ("prefers-reduced-motion", motion)]
        features = [{"name": name, "value": value} for name, value in features]
        self.send("Emulation.setEmulatedMedia", media="screen", features=features)
        self.said.clear(), self.loaded.clear()
        before = self.finished
        self.send("Page.navigate", url=Path(path).as_uri())
        while self.finished == before:
            self.receive()
        self.settle()

    def open_small(self, path, **how):
        """Open a page whose picture is small, because browsers without a graphics card paint scenes slowly."""
        self.open(path, **{"width": 820, "height": 420, **how})

    def messages(self):
        """What the page writes to the console, without remarks of the driver on speed without a graphics card."""
        return [x for x in self.said if "GL Driver Message" not in x.get("entry", {}).get("text", "")]

    def settle(self):
        """Wait until the page is painted."""
        self.value("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(0))))")

    def value(self, expression):
        found = self.send("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def key(self, key, code=0, text=""):
        about = {"key": key, "windowsVirtualKeyCode": code}
        self.send("Input.dispatchKeyEvent", type="keyDown", text=text, **about)
        self.send("Input.dispatchKeyEvent", type="keyUp", **about)
        self.settle()

    def scrub(self, part):
        """Move the time bar to a part of its length, as a drag would."""
        self.value(
            f"(() => {{ const bar = document.getElementById('time'); bar.value = {round(part * 1e6)};"
            " bar.dispatchEvent(new Event('input', { bubbles: true })); })()"
        )
        self.settle()

    def state(self):
        """Time, frame and view of the page, from its attributes."""
        found = self.value(
            "({...document.getElementById('status').dataset, ...document.getElementById('picture').dataset})"
        )
        return {key: value == "true" if key == "playing" else float(value) for key, value in found.items()}

    def close(self):
        os.write(self.input, json.dumps({"id": 0, "method": "Browser.close"}).encode() + b"\0")
        os.waitpid(self.process, 0)
        os.close(self.input), os.close(self.output)


@pytest.fixture(scope="session")
def browser():
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None or not hasattr(os, "posix_spawn"):
        pytest.skip(f"needs a browser to play pages in: none of {', '.join(NAMES)} is installed")
    with tempfile.TemporaryDirectory(prefix="mbdsl-browser-", ignore_cleanup_errors=True) as folder:
        found = Browser(program, folder)
        yield found
        found.close()
