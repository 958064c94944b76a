"""Close approaches to conditions, against the closed form of an oscillation, and the contacts that are undecided.

A unit mass on a unit spring, s = cos(t), turns back at s = -1 with the acceleration 1. A stop at s = -gap is missed by
gap - 1, or the mass would turn back by 1 - gap behind it.
"""

from math import pi

import numpy as np
import pytest

import mbdsl
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.simulate import simulated
from mbdsl.simulation.undecided_contacts import undecided
from mbdsl.system.close_approaches import Approaches, _far


def model(law):
    return mbdsl.parse(f"""
model Stop
  Ground ground(g = 0);
  Body b(m = 1, I = 1);
  Prismatic rail(ground, b.c);
  TranslationalSpringDamper law(rail, force = (1*s) + ({law}));
initial equation
  rail.s = 1.0;
  rail.v = 0.0;
  annotation(experiment(StopTime = 10.0));
end Stop;
""")


def run(law, tol=1e-7, method="radau5"):
    """The integration of the only part, run to its end."""
    found: list[MechanismRun] = []
    simulated(model(law), method=method, tol=tol, inspect=found.append)
    return found[0].parts[0].integration


@pytest.mark.parametrize("method", ["radau5", "hht-si2"])
@pytest.mark.parametrize("law", ["if s < -1.001 then 1e6*((1*s) + 1.001) else 0", "1e6*min((1*s) + 1.001, 0)"])
def test_missed(law, method):
    approaches = run(law, 1e-5, method).approaches
    assert [x.t for x in approaches] == pytest.approx([pi, 3 * pi], abs=1e-4)
    assert [x.d for x in approaches] == pytest.approx([1e-3] * 2, abs=1e-5)
    assert [x.curvature for x in approaches] == pytest.approx([1.0] * 2, rel=0.02)
    assert [x.side for x in approaches] == [1.0, 1.0]
    assert approaches[0].state == pytest.approx([-1.0, 0, 0, 0, 0, 0], abs=1e-4)


def test_touched():
    first = run("if s < -0.999 then 1e6*((1*s) + 0.999) else 0").approaches[0]
    # with s'' = 0.999 there, not 1, the parabola turns back by (1 - 0.999^2)/(2*0.999) behind the stop
    assert first.d == pytest.approx(-(1 - 0.999**2) / (2 * 0.999), rel=1e-3)
    assert first.side == 1.0


LAWS = ["0.1*(1*s)^3", "if time > 3 then 1 else 0", "1*tanh(100*(1*s))"]


@pytest.mark.parametrize("law", LAWS)
def test_without_conditions_on_the_motion_nothing_is_recorded(law):
    found = run(law, 1e-4)
    assert found.system.kept(Approaches).arguments == []
    assert found.approaches == []


@pytest.mark.parametrize("method", ["radau5", "hht-si2", "scipy-dop853"])
@pytest.mark.parametrize(
    "law", ["if 1*v > 1.001 then 1e3 else 0", "1e3*max(1*v - 1.001, 0)", "1e3*max(v*v - 1.002001, 0)"]
)
def test_of_velocities(law, method):
    """v = -sin(t) comes near its limit at 3 pi/2 by 1e-3; its square twice in a period, by twice that."""
    *_, only = found = [x for x in run(law, 1e-5, method).approaches if abs(x.d) < 0.01]
    factor, times = (2.0, [0.5, 1.5, 2.5]) if "v*v" in law else (1.0, [1.5])
    assert [x.t for x in found] == pytest.approx([x * pi for x in times], abs=1e-3)
    assert only.d == pytest.approx(factor * 1e-3, abs=3e-5)
    assert only.curvature == pytest.approx(factor, rel=0.02)


@pytest.mark.parametrize("k", [0.01, 1e6])
def test_effect(k):
    """A stop at 1.000001 that the runs do not resolve: the bound is the velocity that a stiff stop returns, or k times
    the depth times the duration of contact with a soft one, both from the path s = -1 + (t - pi)^2/2."""
    law = f"if s < -1.000001 then {k}*((1*s) + 1.000001) else 0"
    last = run(law, 1e-9)
    depth = 1e-4
    before = run(law.replace("1.000001", str(1.000001 + depth)), 1e-9)
    found = undecided(last, before, (), 1.0, 10.0)
    assert len(found) == 2
    t = np.linspace(-1, 1, 20001) * np.sqrt(2 * depth)
    impulse = np.trapezoid(k * np.maximum(depth - t**2 / 2, 0.0), t)
    bound = min(impulse, 2 * np.sqrt(2 * depth))
    assert bound <= found[0].effect * 1.02 <= 2 * bound
    assert found[0].time == pytest.approx(pi, abs=1e-3)
    assert undecided(last, last, (), 1.0, 10.0) == []


BALL = """model Ball
  Ground ground;
  PointMass b(m = 1 kg);
  Contact floor(gap = b.y, e = 0.5);
initial equation
  b.x = 0 m; b.y = 1 m; b.vx = 0 m/s; b.vy = 0 m/s;
  annotation(experiment(StopTime = 0.1 s));
end Ball;"""


@pytest.mark.parametrize(
    ("y", "v", "h", "count"),
    [
        ([2e-17, 2e-17, 4e-17], [-1e-8, 1e-8, 1e-8], 1e-8, 0),  # a contact that opens: rounding
        ([-9e-15, -9.9e-15, 0.0], [-1e-5, 1e-5, 1e-5], 1e-9, 0),  # the overlap at which an impact is found
        ([1e-6 + 5e-6, 1e-6, 1e-6 + 5e-6], [-1e-2, -1e-9, 1e-2], 1e-3, 1),  # 1 um above the floor
        ([5e-6, 1e-15, 5e-6], [-1e-2, -1e-9, 1e-2], 1e-3, 1),  # hardly above it, but the steps show that it turns
    ],
)
def test_gaps_of_rigid_contacts_that_are_closed_are_no_approaches(y, v, h, count):
    found: list[MechanismRun] = []
    simulated(mbdsl.parse(BALL), method="radau5", tol=1e-4, inspect=found.append)
    system = found[0].parts[0].integration.system
    q, w = np.zeros((3, system.n)), np.zeros((3, system.n))
    q[:, 1], w[:, 1] = y, v
    approaches, rows = [], (h * np.arange(3.0), q, w, np.zeros((3, system.m + system.p)))
    search = system.kept(Approaches)
    past = np.zeros((5, len(search.arguments)))
    past[4] = 1.0
    numbers = dict.fromkeys(system.tables.inputs, 0.0)
    search.add(approaches, past, rows, numbers)
    assert sum(x.number in search.contacts for x in approaches) == count


def test_arguments_that_stay_far_from_zero():
    """Random cubics by values and rates at the ends of two steps, against their values at many points."""
    rng = np.random.default_rng(1)
    h, y, rate = np.array([0.5, 2.0]), rng.normal(0.5, 1.0, (400, 3)), rng.normal(0.0, 1.0, (400, 3))
    before, near = rng.normal(0.5, 1.0, 400), np.full(400, 0.05)
    x = np.linspace(0.0, 1.0, 101)[:, None, None]
    dy, r0, r1 = np.diff(y), h * rate[:, :-1], h * rate[:, 1:]
    dense = y[:, :-1] + x * (r0 + x * (3.0 * dy - 2.0 * r0 - r1 + x * (r0 + r1 - 2.0 * dy)))
    side = np.sign(before)[:, None]
    stays = np.where(side > 0.0, dense.min(axis=0) > 0.05, dense.max(axis=0) < -0.05).all(axis=1)
    far = _far(h, y, rate, before, near)
    assert not (far & ~stays).any()
    assert far.sum() > 20
