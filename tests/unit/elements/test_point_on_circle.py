"""PointOnCircle against the pendulum of the same length, by hand, in the plane and in space."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest

import mbdsl

R, M, G, START = 0.5, 2.0, 9.81, -1.2
BEAD = """{head} Bead
  Ground ground;
  PointMass bead(m = 2 kg);
  PointOnCircle on(ground, bead, radius = 0.5 m);
initial equation
  on.theta = {start} rad;
  annotation(experiment(StopTime = 1 s));
end Bead;"""
#: in space the same circle about the axis n, here in the plane that gravity and {0, 0.6, 0.8} span
SPACE = BEAD.replace("Ground ground;", "Ground ground(n = {{0, -0.6, -0.8}});").replace(
    "radius = 0.5 m", "radius = 0.5 m, n = {{1, 0, 0}}"
)


def bead(spatial, start=START):
    head = "spatial model" if spatial else "model"
    return mbdsl.parse((SPACE if spatial else BEAD).format(head=head, start=start))


def down(trajectory, spatial):
    """Positions along gravity [m]."""
    y = np.asarray(trajectory["bead.y"])
    return 0.6 * -y + 0.8 * -np.asarray(trajectory["bead.z"]) if spatial else -y


@pytest.mark.parametrize("spatial", [False, True])
@pytest.mark.parametrize("method", ["hht-si2", "radau5"])
def test_it_swings_like_a_pendulum(spatial, method):
    """The energy is that of the height; the reaction is m v^2/r + m g cos(phi) to the centre."""
    run = mbdsl.simulate(bead(spatial), method=method, tol=1e-7)
    depth = down(run, spatial)
    square = (R * np.asarray(run["on.w"])) ** 2
    assert square == pytest.approx(2 * G * (depth - depth[0]), abs=1e-4)
    size = sqrt(sum(run[f"on.f{i}"][-1] ** 2 for i in ("xyz" if spatial else "xy")))
    assert size == pytest.approx(abs(M * square[-1] / R + M * G * depth[-1] / R), rel=1e-5)
    assert np.ptp(depth) > 0.03


@pytest.mark.parametrize("spatial", [False, True])
def test_statics_and_modes(spatial):
    """It rests at the lowest point, with the weight as reaction, and swings there with (g/r)^(1/2)."""
    rest = mbdsl.static(bead(spatial))
    assert abs(rest["on.w"]) < 1e-12
    load = -(rest["on.fy"] * 0.6 + rest["on.fz"] * 0.8) if spatial else rest["on.fy"]
    assert abs(load) == pytest.approx(M * G, rel=1e-9)
    modes = mbdsl.eigen(bead(spatial), at="static")
    assert max(abs(mode.eigenvalue.imag) for mode in modes) == pytest.approx(sqrt(G / R), rel=1e-6)


def start(value):
    return {"start": value, "fixed": True}


@pytest.mark.parametrize("spatial", [False, True])
def test_the_builder_has_it_and_turns_count(spatial):
    """Without gravity it runs round and round, at constant speed."""
    m = (mbdsl.SpatialBuilder if spatial else mbdsl.Builder)("Round")
    m.Ground("ground", g=0.0)
    m.PointMass("bead", m=1.0)
    m.PointOnCircle("on", "ground", "bead", radius=0.5, theta=start(0.3), w=start(7.0))
    run = mbdsl.simulate(m.scene(), stop=2.0, tol=1e-7)
    assert run["on.theta"][-1] == pytest.approx(0.3 + 14.0, abs=1e-4) and 4 * pi < 14.0
    assert run["bead.x"][-1] == pytest.approx(0.5 * cos(14.3), abs=1e-4)
    assert run["bead.y"][-1] == pytest.approx(0.5 * sin(14.3), abs=1e-4)


def test_pictures(tmp_path):
    for spatial in (False, True):
        run = mbdsl.simulate(bead(spatial), stop=0.1, step=0.01)
        run.animate(tmp_path / f"{spatial}.html")
        assert (tmp_path / f"{spatial}.html").stat().st_size > 10_000


def test_a_circle_in_the_plane_of_a_motion_is_solved_there():
    """In space, with hinges and the circle about one direction: the same motion as in the plane."""
    text = """{head} Slot
      Ground ground; Rod arm(m = 1 kg, length = 0.4 m); Rod tip(m = 1 kg, length = 0.8 m);
      Revolute a(ground, arm.a); Revolute b(arm.b, tip.a); PointOnCircle c(ground, tip.b, radius = 0.6 m);
    initial equation
      a.phi = 0.4 rad;
      annotation(experiment(StopTime = 0.5 s));
    end Slot;"""
    plane, space = (
        mbdsl.simulate(mbdsl.parse(text.format(head=head)), tol=1e-8) for head in ("model", "spatial model")
    )
    assert space["a.phi"][-1] == pytest.approx(plane["a.phi"][-1], abs=1e-6)
    assert space["c.fx"][-1] == pytest.approx(plane["c.fx"][-1], rel=1e-4)
