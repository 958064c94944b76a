"""Modes and reports of models in space: displacements, pages, films and pictures."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.reporting.report import report

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


def test_modes_displace_bodies(modes):
    """Rotations about x move the tip along y, those about y along x, 2.4 times as far as the centre of mass."""
    swings = {"y": np.sqrt(2 * 9.81 * 0.5 / (0.1 + 0.5)), "x": np.sqrt(2 * 9.81 * 0.5 / (0.3 + 0.5))}
    page = modes.animate()
    shapes = page.shapes
    for key, w in swings.items():
        k = int(np.argmin([abs(2 * np.pi * mode.frequency - w) for mode in modes]))
        assert 2 * np.pi * modes[k].frequency == pytest.approx(w, rel=1e-9)
        tip, centre = (shapes.rest.displaced(shapes.rest.spots[f"bar.{at}"], shapes.tracks[k]) for at in ("tip", "c"))
        others = [j for j in range(3) if j != "xyz".index(key)]
        # differences of 1e-4 of a mode of about 1 have errors of 1e-8
        assert np.abs(tip[others]).max() < 1e-6 * np.abs(tip).max()
        np.testing.assert_allclose(tip["xyz".index(key)], 2.4 * centre["xyz".index(key)], rtol=1e-6)
    cycle = page.cycle(0)
    assert np.allclose(cycle.poses[0], cycle.poses[-1])
    assert np.linalg.norm(cycle.poses[..., 3:], axis=-1) == pytest.approx(1.0)


def test_pages_and_films(modes, tmp_path):
    modes.animate(tmp_path / "modes.html")
    modes.animate(tmp_path / "modes.gif", mode=0)
    assert '"modes"' in (tmp_path / "modes.html").read_text(encoding="utf-8")
    assert (tmp_path / "modes.gif").read_bytes()[:3] == b"GIF"


def test_report():
    """The picture, the animation, and pictures of the modes about the equilibrium: two swings and the twist."""
    run = mbdsl.simulate(mbdsl.parse(PENDULUM), step=1e-2, stop=0.1)
    page = report(run, eigen="static").html
    assert "Mechanism" in page and page.count("<figcaption>mode ") == 3
