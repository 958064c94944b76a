"""Starts with speed and without acceleration: racks, belts and gears on a spring from its free length.

The closed form is v/W sin(W t), with W^2 = k/(m + I/r^2) of everything that moves along. The acceleration at the start
is zero except for rounding, which differs with the direction in which the model lies, and is no scale for the first
step: neither the direction nor a stiffness that is 2 % larger changes the steps much.
"""

import numpy as np
import pytest

import mbdsl

R, MASS, INERTIA = 0.03, 1.0, 4e-3

RACK = """model Rack
  Ground ground(g = 0);
  Frame guide(ground, phi = {direction} deg);
  Frame hub(guide, r = {{0 m, 30 mm}});
  Body rack(m = 1 kg, I = 1e-3 kg.m2);
  Body pinion(m = 2 kg, I = 4e-3 kg.m2);
  Prismatic slide(guide, rack.c);
  Revolute pin(hub, pinion.c);
  RackAndPinion mesh(rack.c, pinion.c, radius = 30 mm);
  TranslationalSpringDamper spring(slide, k = {k} N/m);
initial equation
  slide.s = 0 m; slide.v = 1 m/s;
  annotation(experiment(StopTime = 0.5 s, Interval = 50 ms));
end Rack;"""

RACK_IN_SPACE = """spatial model Rack
  Ground ground(g = 0, frames(guide(phi = {direction} deg)));
  Frame hub(ground.guide, r = {{0 m, 30 mm, 0 m}});
  Body rack(m = 1 kg, I = 1e-3 kg.m2);
  Body pinion(m = 2 kg, I = 4e-3 kg.m2);
  Prismatic slide(ground.guide, rack.c, n = {{1, 0, 0}});
  Revolute pin(hub, pinion.c);
  RackAndPinion mesh(rack.c, pinion.c, radius = 30 mm);
  TranslationalSpringDamper spring(slide, k = {k} N/m);
initial equation
  slide.s = 0 m; slide.v = 1 m/s;
  annotation(experiment(StopTime = 0.5 s, Interval = 50 ms));
end Rack;"""

WHEELS = """model Wheels
  Ground ground(g = 0);
  Frame left(ground, phi = {direction} deg);
  Frame right(left, r = {{{distance} mm, 0 m}});
  Body a(m = 1 kg, I = 1e-3 kg.m2);
  Body b(m = 2 kg, I = 4e-3 kg.m2);
  Revolute A(left, a.c);
  Revolute B(right, b.c);
  {drive}(a.c, b.c, r_a = 30 mm, r_b = 60 mm);
  RotationalSpringDamper spring(A, k = {k} N.m/rad);
initial equation
  A.phi = 0 deg; A.w = 1 rad/s;
  annotation(experiment(StopTime = 0.5 s, Interval = 50 ms));
end Wheels;"""


def wheels(drive, distance):
    return WHEELS.replace("{drive}", drive).replace("{distance}", distance)


#: text, the coordinate from rest at the free length, its moving mass or inertia, and a stiffness
CASES = {
    "rack": (RACK, "slide.s", MASS + INERTIA / R**2, 20.0),
    "stiff rack": (RACK, "slide.s", MASS + INERTIA / R**2, 2e4),
    "rack in space": (RACK_IN_SPACE, "slide.s", MASS + INERTIA / R**2, 20.0),
    "gears": (wheels("GearPair mesh", "90"), "A.phi", 1e-3 + 4e-3 / 4, 0.5),
    "belt": (wheels("BeltDrive mesh", "150"), "A.phi", 1e-3 + 4e-3 / 4, 0.5),
}


def run(case, direction, k):
    text, name, inertia, _ = CASES[case]
    t = mbdsl.simulate(mbdsl.parse(text.format(direction=direction, k=k)), method="hht-si2", tol=1e-4)
    w = np.sqrt(k / inertia)
    np.testing.assert_allclose(t[name], np.sin(w * t.t) / w, rtol=0, atol=3e-4 / w)
    return t.stats["steps"] + t.stats["trial_steps"]


@pytest.mark.parametrize("case", CASES)
def test_rounding_of_the_first_acceleration_does_not_change_the_steps(case):
    k = CASES[case][3]
    steps = [run(case, direction, k) for direction in (0, 30, 90, 137)]
    assert max(steps) <= 1.02 * min(steps)
    assert run(case, 30, 1.02 * k) == pytest.approx(steps[1], rel=0.05)
