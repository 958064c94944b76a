"""The size of a mechanism without lengths of its own comes from its motion: lengths of rounding size do not count."""

import numpy as np
import pytest

import mbdsl
from mbdsl.initial.start_check import check_start
from mbdsl.mechanism.graph import build

#: a slider with 5.6 kg on 200 N/m, started with 1 m/s from the free length: v/W sin(W t)
RATE = np.sqrt(200 / 5.6)
SPRING = """model Slider
  Ground ground(g = 0);
  Body r(m = 5.6 kg, I = 1e-3 kg.m2{frames});
  Prismatic slide(ground, r.{at});
  TranslationalSpringDamper s(slide, k = 200 N/m, s0 = {s0} m);
initial equation
  slide.s = {s0} m; slide.v = 1 m/s;
  annotation(experiment(StopTime = 0.5 s, Interval = 50 ms));
end Slider;"""


def slider(s0, frames="", at="c"):
    return mbdsl.parse(SPRING.format(s0=s0, frames=frames, at=at))


def checked(scene, **given):
    """A run, whose error is that of the closed form, in the way of the motion: 1/W."""
    t = mbdsl.simulate(scene, tol=1e-4, **given)
    true = np.abs(t["slide.s"] - t["slide.s"][0] - np.sin(RATE * t.t) / RATE).max() * RATE
    assert true <= 3.0 * t.stats["error"] <= 3e-4
    return t


@pytest.mark.parametrize("method", ["hht-si2", "hht-i3", "radau5", "dop853"])
def test_a_tiny_length_does_not_change_the_steps(method):
    ordinary = checked(slider(1e-3), method=method).stats
    for s0 in (3e-17, 1e-9, 1e-6):
        t = checked(slider(s0), method=method)
        assert t.system.tables.size == pytest.approx(1 / RATE, rel=1e-3)
        assert t.stats["steps"] == ordinary["steps"]
        assert t.stats["trial_steps"] <= ordinary["trial_steps"] + 200  # until the motion is seen to be long


def test_a_frame_that_is_off_its_body_by_rounding_is_no_size():
    """sin(pi) m is 1.2e-16 m."""
    t = checked(slider(0.0, ", frames(tip = {0, 1.2246467991473532e-16 m, 0})", "tip"), method="hht-si2")
    assert t.stats["steps"] < 1000


def test_lengths_of_bodies_stay_the_size_of_long_motions():
    """A disc of 0.1 m that rolls 100 m is no mechanism of 100 m."""
    text = """model Rolling
      Ground road;
      Body wheel(m = 1 kg, I = 0.005 kg.m2, frames(rim = {0.1 m, 0}));
      SpringDamper air(road, wheel.rim, k = 0 N/m, s0 = 0 m);
      RollingDisc roll(road, wheel.c, radius = 0.1 m);
    initial equation
      wheel.y = 0.1 m; wheel.vx = 10 m/s;
      annotation(experiment(StopTime = 10 s));
    end Rolling;"""
    t = mbdsl.simulate(mbdsl.parse(text), tol=1e-4)
    assert t["wheel.x"][-1] == pytest.approx(100.0, rel=1e-6) and t.system.tables.size == 0.1


@pytest.mark.parametrize(
    ("scene", "line"),
    [
        (
            slider(1e-6),
            "errors of positions are relative to 1e-06 m, or to the largest displacement of a run if that is above "
            "1e-05 m",
        ),
        (slider(0.3, ", frames(tip = {0.5 m, 0, 0})", "tip"), "errors of positions are relative to 0.5 m"),
    ],
)
def test_check_states_the_size(scene, line):
    assert check_start(build(scene))[-1] == line
