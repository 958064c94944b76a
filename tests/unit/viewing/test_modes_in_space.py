"""Modes, equilibria and reports of models in space as pictures: a parallel projection."""

import re
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import viewing
from mbdsl.reporting.report import report
from mbdsl.viewing.projection import pictured
from mbdsl.viewing.shapes import drawing

SPACE = Path(__file__).parents[3] / "models" / "space"
#: hangs from a ball joint; its moments of inertia differ, so that it swings about x and y with different frequencies
PENDULUM = """spatial model Pendulum
  Ground ground(n = {0, 0, -1});
  Body bar(m = 2 kg, I = {0.1, 0.3, 0.05} kg.m2, frames(top = {0, 0, 0.5} m, tip = {0, 0, -0.7} m));
  Spherical ball(ground, bar.top);
  RotationalSpringDamper twist(ground, bar.top, k = 1 N.m/rad);
initial equation
  bar.z = -0.5 m;
end Pendulum;"""


@pytest.fixture(scope="module")
def modes():
    return mbdsl.eigen(mbdsl.parse(PENDULUM))


def test_modes_are_projected(modes):
    """Rotations about x move the tip along y, those about y along x, 2.4 times as far as the centre of mass."""
    swings = {"y": np.sqrt(2 * 9.81 * 0.5 / (0.1 + 0.5)), "x": np.sqrt(2 * 9.81 * 0.5 / (0.3 + 0.5))}
    page = modes.animate()
    shapes, names = page.shapes, page.shapes.rest.tracks
    for key, w in swings.items():
        k = int(np.argmin([abs(2 * np.pi * mode.frequency - w) for mode in modes]))
        assert 2 * np.pi * modes[k].frequency == pytest.approx(w, rel=1e-9)
        tip, centre = (shapes.tracks[k, names.index(name), :2] for name in ("bar.tip", "bar.c"))
        axis = shapes.rest.seen.of(np.eye(3)["xyz".index(key)])[:2]
        # differences of 1e-4 of a mode of about 1 have errors of 1e-8
        assert abs(tip[0] * axis[1] - tip[1] * axis[0]) < 1e-6 * np.abs(tip).max()
        np.testing.assert_allclose(tip, 2.4 * centre, rtol=1e-6)
    cycle = page.cycle(0)
    assert np.allclose(cycle.poses[0], cycle.poses[-1]) and cycle.rims == {}


def test_pages_and_films(modes, tmp_path):
    modes.animate(tmp_path / "modes.html")
    modes.animate(tmp_path / "modes.gif", mode=0)
    assert '"modes"' in (tmp_path / "modes.html").read_text(encoding="utf-8")
    assert (tmp_path / "modes.gif").read_bytes()[:3] == b"GIF"


def test_every_shape_in_space_is_drawn_by_the_page():
    scripts = "".join(path.read_text(encoding="utf-8") for path in Path(viewing.__file__).parent.glob("*.js"))
    drawn = {name.replace("_", "-") for name in re.findall(r"draw_(\w+)\(", scripts)}
    found = set()
    for name in ("gyroscope", "stewart_platform", "flyball_governor", "rolling_coin", "trebuchet"):
        trajectory = mbdsl.simulate(SPACE / f"{name}.mbd", step=1e-4, stop=1e-3, interval=1e-3)
        found |= {shape.draw for shape in drawing(pictured(trajectory)).shapes}
    assert {"bar", "disc", "pin", "weld"} <= found
    assert found <= drawn


def test_report():
    """The picture, the animation, and pictures of the modes about the equilibrium: two swings and the twist."""
    run = mbdsl.simulate(mbdsl.parse(PENDULUM), step=1e-2, stop=0.1)
    page = report(run, eigen="static").html
    assert "Mechanism" in page and page.count("<figcaption>mode ") == 3
