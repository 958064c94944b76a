"""Motions that begin, or are stopped, exactly on the threshold of a condition: its side follows from the motion."""

import numpy as np
import pytest

import mbdsl
from mbdsl.integrators import compiled

METHODS = sorted(set(compiled()) - {"kinematic", "moreau-jean"})
G = 9.81
REST = """model Rest
  Ground ground;
  Body box(m = 1 kg, I = 0.1 kg.m2, frames(p = {-0.2 m, -0.1 m}, q = {0.2 m, -0.1 m}));
  PointContact a(ground, box.p, k = 1e5, e = 0.5), b(ground, box.q, k = 1e5, e = 0.5);
initial equation
  box.x = 0 m; box.y = 0.1 m; box.phi = 0; box.vx = 0 m/s; box.vy = 0 m/s; box.w = 0 rad/s;
end Rest;"""
REST_IN_SPACE = """spatial model Rest
  Ground ground;
  Body box(m = 1 kg, I = {0.1, 0.1, 0.1} kg.m2);
  BoxContact c(ground, box.c, length = 0.4 m, width = 0.2 m, height = 0.2 m, n = {0, 1, 0}, k = 1e5 N/m, e = 0.5);
initial equation
  box.y = 0.1 m;
end Rest;"""
FALL = """model M
  Ground ground;
  Frame up(ground, phi = 90 deg);
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic rail(up, b.c);
  Integer n(start = 0);
initial equation
  rail.s = {s} m; rail.v = {v} m/s;
equation
  when {condition} then {action} n = pre(n) + 1; end when;
end M;"""


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tol", [1e-3, 1e-6])
def test_a_box_that_rests_on_its_contacts(method, tol):
    """It sinks in by less than its weight over the stiffness, and is damped as by the least speed of touch."""
    run = mbdsl.simulate(mbdsl.parse(REST), method=method, tol=tol, stop=0.2, interval=0.01)
    depth = 0.1 - run["box.y"]
    assert (np.diff(depth) >= 0.0).all() and 0.0 < depth[-1] < 9.81 / 2e5


def test_a_box_that_rests_on_its_contacts_in_space():
    run = mbdsl.simulate(mbdsl.parse(REST_IN_SPACE), tol=1e-4, stop=0.2, interval=0.01)
    depth = 0.1 - run["box.y"]
    assert (np.diff(depth) >= 0.0).all() and 0.0 < depth[-1] < 9.81 / 4e5


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("given", [{"tol": 1e-5}, {"step": 7e-3}], ids=str)
@pytest.mark.parametrize(
    ("s", "v", "condition", "action", "counts", "end"),
    [
        (0.1, 0.0, "rail.s < 0.1 m", "", 1, 0.1 - G / 2),
        (0.1, 0.0, "rail.s <= 0.1 m", "", 0, 0.1 - G / 2),
        (0.1, 0.0, "rail.v < 0 m/s", "", 1, 0.1 - G / 2),
        (0.0, 1.0, "rail.s < 0 m", "", 1, 1.0 - G / 2),
        (0.3, 0.0, "rail.s <= 0.1 m", "reinit(rail.v, 0 m/s);", 1, 0.1 - G / 2 * (1 - np.sqrt(0.4 / G)) ** 2),
    ],
)
def test_the_side_of_a_threshold(method, given, s, v, condition, action, counts, end):
    text = FALL.format(s=s, v=v, condition=condition, action=action)
    run = mbdsl.simulate(mbdsl.parse(text), method=method, stop=1.0, interval=0.5, **given)
    assert run["n"][-1] == counts
    assert run["rail.s"][-1] == pytest.approx(end, abs=1e-8)
