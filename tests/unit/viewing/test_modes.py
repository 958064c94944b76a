"""Mode shapes and equilibria as pictures: displacements against closed forms, pixels, and the commands."""

import json
import re
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest

from mbdsl import load, parse, static
from mbdsl.errors import UsageError
from mbdsl.system.system import build
from mbdsl.viewing.marks import THEME
from mbdsl.viewing.mode_animation import ModeAnimation, ModeRow
from mbdsl.viewing.mode_shapes import mode_shapes

PENDULUM = """model Pendulum
  Ground ground; PointMass mass(m = 2 kg); Distance rod(ground, mass, length = 1 m);
initial equation
  mass.x = 1 m; mass.vx = 0; guess mass.y = 0.1 m; end Pendulum;
"""
ROD = "model R Ground ground; Rod rod(m = 1 kg, length = 1 m); Revolute pin(ground, rod.a); end R;"
BEAM = """model B Ground ground;
  FlexibleBeam beam(length = 2 m, density = 7800, S = 1 cm2, I = 1 cm4, E = 210 GPa, modes = 2);
  Revolute pin(ground, beam.a); end B;"""
ROWS = [ModeRow(1.5, 1.5, 0.0, "mass 100%", False), ModeRow(2.0, 0.0, 1.0, "mass 100%", False)]


def data(path):
    return json.loads(path.read_text(encoding="utf-8").partition('id="data">')[2].partition("</script>")[0])


def test_a_hanging_rod():
    """It turns about its upper end: the tip moves sideways by a tenth of the extent, 1 m, and the middle by half."""
    system = build(parse(ROD))
    q = np.array([0.0, -0.5, -np.pi / 2])
    found = mode_shapes(system, 0.0, q, np.array([[0.5, 0.0, 1.0]], complex))
    assert found.largest == pytest.approx([0.1])
    cycle = found.cycle(0, np.array([0.0, np.pi / 2, np.pi]))
    tip, middle, pin = (cycle.pose(cycle.spots[name])[:, :2] for name in ("rod.b", "rod.c", "rod.a"))
    # a body stays rigid, so that frames are displaced to first order in the angle 0.1 only: 0.1^2/2 = 0.005
    assert tip == pytest.approx(np.array([[0.1, -1.0], [0.0, -1.0], [-0.1, -1.0]]), abs=0.005)
    assert middle == pytest.approx(np.array([[0.05, -0.5], [0.0, -0.5], [-0.05, -0.5]]), abs=1e-12)
    assert pin == pytest.approx(np.zeros((3, 2)), abs=0.005)


def test_a_beam_between_its_ends():
    """The first bending mode of a beam with pinned ends is half a sine wave."""
    system = build(parse(BEAM))
    shape = np.zeros((1, system.n), complex)
    shape[0, 3] = 1.0
    found = mode_shapes(system, 0.0, np.zeros(system.n), shape)
    u = found.points[0][0]
    assert np.abs(u[:, 0]).max() < 1e-9
    expected = np.sin(np.pi * np.linspace(0.0, 1.0, len(u)))
    # the mode is one of 16 cubic finite elements, whose error is of fourth order in their number
    assert np.abs(u[:, 1].real / u[len(u) // 2, 1].real) == pytest.approx(expected, abs=1e-4)
    assert found.largest == pytest.approx([0.2])  # a tenth of 2 m


def test_an_ellipse_has_its_longest_radius():
    """A point that moves by (3 cos, 4 sin) has the largest displacement 4, not 5."""
    system = build(parse("model A Ground ground; PointMass m(m = 1 kg); FreeMotion free(ground, m); end A;"))
    found = mode_shapes(system, 0.0, np.zeros(2), np.array([[3.0, -4.0j]]))
    assert found.largest == pytest.approx([0.1])  # of a mechanism without extent: of 1 m
    x, y = found.cycle(0, np.linspace(0.0, np.pi / 2, 3)).poses[:, 0, :2].T
    assert x == pytest.approx(0.075 * np.cos([0, np.pi / 4, np.pi / 2]))
    assert y == pytest.approx(0.1 * np.sin([0, np.pi / 4, np.pi / 2]))


@pytest.fixture(scope="module")
def circling(model_file):
    """A mass at (1, 0) that moves on a circle in the first mode, and along x in the second."""
    system = build(load(model_file("pendulum")))
    return ModeAnimation(system, 0.0, np.array([1.0, 0.0]), np.array([[1.0, -1.0j], [1.0, 0.0]]), ROWS, "test")


CENTRE = """((colour) => {
  const rgb = [1, 3, 5].map((k) => parseInt(mixed(colour, theme.paper, 0.25).substr(k, 2), 16));
  const { width, height } = canvas;
  const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
  let [n, x, y] = [0, 0, 0];
  for (let k = 0; k < width * height; k += 1)
    if ([0, 1, 2].every((j) => data[4 * k + j] === rgb[j]))
      [n, x, y] = [n + 1, x + (k % width) + 0.5, y + Math.floor(k / width) + 0.5];
  return [x / n, y / n, n];
})(theme.bodies[0])"""


def test_the_page_moves_the_mass_as_the_mode_says(browser, circling, tmp_path):
    """Pixels at phases of both modes and two amplitudes; the list chooses, and so do the keys."""
    circling.save(tmp_path / "modes.html")
    browser.open(tmp_path / "modes.html")
    assert browser.said == [] and len(browser.loaded) == 1

    def place(part):
        browser.scrub(part)
        x, y, count = browser.value(CENTRE)
        assert count > 40
        state = browser.state()
        return (x - state["x"]) / state["scale"], (state["y"] - y) / state["scale"], 1.0 / state["scale"]

    # the rod of the model is 1 m long and lies along x, so that its extent is 1 m
    for part, amplitude in ((0.0, 1.0), (0.25, 1.0), (0.6, 2.0)):
        browser.value(f"setAmplitude({amplitude})")
        x, y, pixel = place(part)
        assert x == pytest.approx(1.0 + 0.1 * amplitude * np.cos(2 * np.pi * part), abs=pixel)
        assert y == pytest.approx(0.1 * amplitude * np.sin(2 * np.pi * part), abs=pixel)
    assert browser.value("document.getElementById('status').textContent") == "phase 216°"
    browser.value("setAmplitude(1)")
    browser.key("PageDown", 34)
    x, y, pixel = place(0.0)
    assert (x, y) == pytest.approx((1.1, 0.0), abs=pixel)
    rows = browser.value("[...document.querySelectorAll('#modes tbody tr')].map((r) => r.textContent.trim())")
    assert rows == ["11.5 Hz0mass 100%", "22 Hz1mass 100%"]
    browser.value("document.querySelectorAll('#modes input')[0].click()")
    assert browser.value("motion.mode") == 0
    assert browser.value("document.querySelectorAll('#modes input')[0].checked") is True


def test_modes_that_there_are_not(circling):
    system = build(circling.scene)
    assert circling.first == 0 and repr(circling) == "<ModeAnimation of Pendulum: 2 modes>"
    with pytest.raises(UsageError, match="there is no mode 3"):
        ModeAnimation(system, 0.0, np.zeros(2), np.eye(2), ROWS, "", 2)
    with pytest.raises(UsageError, match="Pendulum has no modes to show"):
        ModeAnimation(system, 0.0, np.zeros(2), np.zeros((0, 2)), [], "")
    later = ModeAnimation(system, 0.0, np.zeros(2), np.eye(2), [SimpleNamespace(**vars(r)) for r in ROWS[::-1]], "")
    assert later.first == 1, "the first that oscillates"


def test_the_commands(say, tmp_path):
    """A mass on a rod of 1 m hangs at (0, -1) and vibrates sideways; it started at (1, 0.1)."""
    Image = pytest.importorskip("PIL.Image")
    (tmp_path / "p.mbd").write_text(PENDULUM)
    code, out, _ = say("eigen", "p.mbd", "--animate")
    assert code == 0 and "p-modes.html: " in out and out.endswith(" KB, 1 mode\n")
    page = data(tmp_path / "p-modes.html")
    assert page["modes"]["list"][0]["f"] == pytest.approx(np.sqrt(9.81) / (2 * np.pi))
    assert page["modes"]["list"][0]["largest"] == pytest.approx(0.1)
    code, out, _ = say("eigen", "p.mbd", "--animate", "--out", "p.gif", "--mode", "1", "--size", "100x80")
    with Image.open(tmp_path / "p.gif") as film:
        assert code == 0 and film.size == (100, 80)
        assert 25 <= film.n_frames <= 50  # Pillow joins pictures that are equal
    assert out.endswith(" KB, mode 1\n")
    code, out, _ = say("static", "p.mbd", "--show")
    assert code == 0 and out.splitlines()[-1].startswith("p-equilibrium.html: ")
    page = data(tmp_path / "p-equilibrium.html")
    assert page["largest"] == pytest.approx({"forces force": 19.62, "reactions force": 19.62}, rel=1e-6)
    assert sorted(v["group"] for v in page["vectors"]) == ["forces", "reactions"]
    assert page["ghost"]["tracks"] == ["mass"] and page["ghost"]["poses"] != page["poses"]
    assert say("static", "p.mbd", "--show", "--out", "p.png", "--size", "200x100")[0] == 0
    with Image.open(tmp_path / "p.png") as picture:
        assert picture.size == (200, 100)


def test_an_equilibrium_as_vectors(tmp_path):
    """The weight of the mass, 2 kg x 9.81 m/s2, points down, and the equal force of the rod points up."""
    still = static(parse(PENDULUM))
    still.show(tmp_path / "p.svg")
    still.show(tmp_path / "p.pdf")
    assert (tmp_path / "p.pdf").read_bytes().startswith(b"%PDF-")
    root = ElementTree.parse(tmp_path / "p.svg").getroot()
    arrows = {}
    for path in root:
        if path.get("fill") == "none" and path.get("stroke") in (THEME["load"], THEME["reaction"]):
            numbers = [float(x) for x in re.findall(r"-?[\d.]+", path.get("d"))]
            arrows[path.get("stroke")] = np.subtract(numbers[-2:], numbers[:2])
    assert arrows[THEME["load"]] == pytest.approx(-arrows[THEME["reaction"]], abs=0.02)  # the file has two decimals
    assert arrows[THEME["load"]][0] == pytest.approx(0.0, abs=0.02) and arrows[THEME["load"]][1] > 20.0  # y is down


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("eigen", "--out", "x.html"), "--out belongs to --animate"),
        (("eigen", "--mode", "2"), "--mode belongs to --animate"),
        (("eigen", "--animate", "--out", "p.mbd"), "unknown suffix"),
        (("eigen", "--animate", "--mode", "2"), "there is no mode 2"),
        (("static", "--out", "x.html"), "--out belongs to --show"),
        (("static", "--show", "--out", "x.gif"), "unknown suffix `.gif` of `x.gif`"),
    ],
)
def test_what_the_commands_refuse(say, tmp_path, arguments, words):
    (tmp_path / "p.mbd").write_text(PENDULUM)
    code, _, err = say(arguments[0], "p.mbd", *arguments[1:])
    assert code == 2 and words in err
    assert [path.name for path in tmp_path.iterdir()] == ["p.mbd"]


def test_the_pale_positions_have_no_second_support(tmp_path):
    """A rod that starts upwards hangs from its support at rest; the ground does not move."""
    (tmp_path / "r.mbd").write_text(ROD.replace("end R", "initial equation rod.phi = 1.5 rad; end R"))
    page = tmp_path / "r.html"
    static(tmp_path / "r.mbd").show(page)
    # a support is a triangle and a hatched line
    drawn, pale = (sum("hatch" in item for item in part["items"]) for part in (data(page), data(page)["ghost"]))
    assert (drawn, pale) == (1, 0) and len(data(page)["items"]) == len(data(page)["ghost"]["items"]) + 2


def test_forces_of_springs_and_weights(trajectory_of):
    """A mass at (3, 4) on a spring of 2 N/m without free length is pulled by 2 N/m times (3, 4) to the origin. A
    stop into which it is pressed by 2 m pushes with 7 N/m times this depth; one without contact has no arrow."""
    from mbdsl.viewing.motion import motion
    from mbdsl.viewing.vectors import loads

    scene = parse(
        "model S Ground ground(g = 10); PointMass m(m = 3 kg); SpringDamper s(ground, m, k = 2 N/m, s0 = 0);"
        " TranslationalSpringDamper t(ground, m, k = 5 N/m);"
        " TranslationalStop u(ground, m, s_min = 5 m, k = 7 N/m);"
        " TranslationalStop free(ground, m, s_min = 0, k = 1); end S;"
    )
    trajectory = trajectory_of(scene, [0.0], {"m": np.array([[3.0, 4.0]])})
    found = {v.name: v.values[0].tolist() for v in loads(trajectory, motion(trajectory))}
    assert found == {
        "m": [0.0, -30.0],
        "s": pytest.approx([-6.0, -8.0]),
        "t": pytest.approx([-15.0, 0.0]),
        "u": pytest.approx([14.0, 0.0]),
    }


def test_ropes_are_straight_in_modes():
    """Their ends are on the tracks of the page; where a slack rope sags is known for motions only."""
    scene = parse("model R Ground g; PointMass m(m = 1 kg); Rope rope(g, m, k = 1 kN/m, length = 1 m); end R;")
    page = ModeAnimation(build(scene), 0.0, np.array([1.0, 0.0]), np.array([[1.0, 0.0], [0.0, 1.0]], complex), ROWS, "")
    (rope,) = [shape for shape in page._drawing.shapes if shape.draw == "rope"]
    assert [spot.track for spot in rope.at] == [-1, 0]
    assert page.shapes.rest.tracks == ["m"] and page.cycle(0).poses.shape[1] == 1
