"""Friction that sticks, against closed forms: where and when joints stop and slide, and orders of methods."""

from math import cos, pi, radians, sin
from pathlib import Path

import numpy as np
import pytest

import mbdsl

ROOT = Path(__file__).parents[2]
OSCILLATOR = """
model Oscillator "k = 100 N/m, m = 1 kg, mu N = 2 N"
  Ground ground(g = 10 m/s2);
  Frame wall(ground, r = {-1 m, 0});
  Body block(m = 1 kg, I = 1 kg.m2);
  Prismatic slide(ground, block.c, mu = 0.2, sticks = true);
  SpringDamper spring(wall, block.c, k = 100 N/m, s0 = 1 m);
initial equation
  slide.s = 0.25 m; slide.v = 0 m/s;
end Oscillator;
"""
STACK = """
model Stack "a block carries another one"
  parameter Force F = 8 N;
  Ground ground(g = 10 m/s2);
  Body lower(m = 1 kg, I = 1 kg.m2), upper(m = 0.5 kg, I = 1 kg.m2);
  Prismatic floor(ground, lower.c, mu = 0.2, mu_s = 0.3, sticks = true);
  Prismatic top(lower.c, upper.c, mu = 0.3, mu_s = 0.4, sticks = true);
  Force pull(lower.c, fx = F);
initial equation
  floor.s = 0 m; floor.v = 0 m/s; top.s = 0 m; top.v = 0 m/s;
end Stack;
"""


def belt() -> mbdsl.Scene:
    text = (ROOT / "models" / "stick_slip_belt.mbd").read_text()
    return mbdsl.parse(text.replace("v_s = v_s, v_st = v_st", "sticks = true"))


def on_belt(t: float) -> float:
    """The block carried at 0.1 m/s to 50 mm, where the spring pulls with mu_s N = 5 N; it slips about 30 mm, where it
    pulls with mu N = 3 N, with 10 rad/s, until it has the speed of the belt again, after 0.406888787 s at 10 mm."""
    if t < 0.5:
        return 0.1 * t
    after = (t - 0.5) % 0.806888787
    return (
        0.03 + 0.02 * cos(10 * after) + 0.01 * sin(10 * after) if after < 0.406888787 else 0.1 * (after - 0.306888787)
    )


@pytest.mark.parametrize(("h", "error"), [(0.01, 3e-5), (0.0025, 5e-7)])
def test_an_oscillator_with_dry_friction_comes_to_rest(h, error):
    run = mbdsl.simulate(mbdsl.parse(OSCILLATOR), stop=2.5, step=h, method="hht-si2", interval=h)
    assert run["slide.s"][-1] == pytest.approx(0.01, abs=error)
    moving = np.flatnonzero(run["slide.sliding"])
    assert run.t[moving[-1]] == pytest.approx(6 * pi / 10, abs=1.1 * h)
    assert run["slide.v"][-1] == pytest.approx(0.0, abs=1e-12)
    assert run["slide.friction"][-1] == pytest.approx(-100 * run["slide.s"][-1])


def test_a_block_on_a_belt_sticks_and_slips():
    run = mbdsl.simulate(belt(), stop=2.0, tol=1e-7, interval=0.01)
    assert run["block.x"] == pytest.approx([on_belt(t) for t in run.t], abs=1e-6)
    sliding = [0.5 < t < 0.906888 or 1.306889 < t < 1.713777 for t in run.t]
    assert (run["contact.sliding"][1:] == -np.array(sliding, float)[1:]).mean() > 0.98  # but at the changes
    assert {"contact.sliding", "contact.friction"} <= set(run.signals)


@pytest.mark.parametrize("method", ["hht-i3", "hht-si2", "nstiff-si2"])
def test_no_order_is_lost_where_a_block_sticks_and_slips(method):
    scene, errors = belt(), []
    for steps in (200, 400, 800):
        run = mbdsl.simulate(scene, stop=2.0, step=1.0 / steps, method=method)
        errors.append(abs(run["block.x"][-1] - on_belt(2.0)))
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize(
    ("force", "lower", "upper"),
    [
        (4.0, 0.0, 0.0),  # less than 0.3*15 N: both rest
        (8.0, (8.0 - 3.0) / 1.5, (8.0 - 3.0) / 1.5),  # the lower one slides and carries the upper one
        (12.0, 12.0 - 3.0 - 1.5, 3.0),  # the upper one would need 3 N, more than 0.4*5 N: both slide
    ],
)
def test_several_joints_stick_or_slide(force, lower, upper):
    run = mbdsl.simulate(mbdsl.parse(STACK).with_parameters(F=force), stop=0.2, step=0.01, method="hht-si2")
    assert run["lower.ax"][-1] == pytest.approx(lower, abs=1e-9)
    assert run["upper.ax"][-1] == pytest.approx(upper, abs=1e-9)
    assert run["lower.x"][-1] == pytest.approx(lower * 0.02, abs=1e-9)
    assert run["upper.x"][-1] == pytest.approx(upper * 0.02, abs=1e-9)


def test_a_pin_with_friction_holds_a_pendulum():
    text = """
model Pin
  Ground ground(g = 10 m/s2);
  Rod rod(m = 1 kg, length = 0.1 m);
  Revolute pin(ground, rod.a, radius = 0.1 m, mu = 0.2, sticks = true);
initial equation
  pin.phi = -90 deg + 10 deg; pin.w = 0 rad/s;
end Pin;
"""
    run = mbdsl.simulate(mbdsl.parse(text), stop=1.0, step=0.01, method="hht-i3")
    # the weight needs 10*0.05*sin(10 deg) = 0.087 N.m; 0.2*0.1*10 = 0.2 N.m are there
    assert run["pin.phi"] == pytest.approx(np.full(len(run.t), radians(-80)), abs=1e-14)
    assert run["pin.friction"] == pytest.approx(np.full(len(run.t), -10 * 0.05 * sin(radians(-10))) * -1, rel=1e-6)


def test_a_slide_in_space_holds_its_load():
    text = """
spatial model Incline
  Ground ground;
  Body block(m = 1 kg, I = {1e-3, 1e-3, 1e-3} kg.m2);
  Prismatic slide(ground, block.c, n = {cos(20 deg), -sin(20 deg), 0}, mu = MU, mu_s = 0.5, sticks = true);
initial equation
  slide.s = 0 m; slide.v = 0.5 m/s;
end Incline;
"""
    N, pull = 9.81 * cos(radians(20)), 9.81 * sin(radians(20))
    run = mbdsl.simulate(mbdsl.parse(text.replace("MU", "0.4")), stop=6.0, step=0.01, method="hht-si2")
    assert run["slide.s"][-1] == pytest.approx(0.5**2 / 2 / (0.4 * N - pull), rel=1e-5)
    assert run["slide.v"][-1] == pytest.approx(0.0, abs=1e-12)
    assert run["slide.friction"][-1] == pytest.approx(pull)


def test_joints_that_hold_the_same_motion_are_refused():
    text = """
model Two
  Ground ground(g = 10 m/s2);
  Body a(m = 1 kg, I = 1 kg.m2), b(m = 1 kg, I = 1 kg.m2);
  Prismatic p(ground, a.c, mu = 0.5, sticks = true), q(ground, b.c, mu = 0.5, sticks = true);
  Distance rod(a.c, b.c, length = 1 m);
initial equation
  p.s = 0 m; p.v = V; guess q.s = 1 m;
end Two;
"""
    for speed in ("0 m/s", "0.1 m/s"):  # at the start, and where they stop
        with pytest.raises(mbdsl.InitialisationError, match=r"friction of `p`, `q` .* is not unique"):
            mbdsl.simulate(mbdsl.parse(text.replace("V", speed)), stop=1, step=0.01, method="hht-si2")


def test_backends_are_refused():
    with pytest.raises(mbdsl.UsageError, match="does not know friction that sticks, of `slide`"):
        mbdsl.simulate(mbdsl.parse(OSCILLATOR), stop=1, tol=1e-5, method="scipy-radau")


def test_a_stribeck_speed_is_refused():
    with pytest.raises(mbdsl.ModelError, match="leave the Stribeck speed out"):
        mbdsl.parse(OSCILLATOR.replace("sticks = true", "sticks = true, v_st = 1 mm/s"))
