"""Peaks of laws in joint coordinates of models in space."""

import math

import numpy as np

import mbdsl
from mbdsl.system.peaks_along_motion import OnTheWay
from mbdsl.system.system import build

ROTOR = """
spatial model Rotor
  Ground ground(g = 0);
  Body rotor(m = 1 kg, I = {{0.3, 0.4, 0.5}} kg.m2);
  Revolute hinge(ground, rotor.c, n = {{1, 2, 2}});
  RotationalSpringDamper law(ground, rotor.c, n = {{1, 2, 2}}, {law});
initial equation
  hinge.w = 2 rad/s;
end Rotor;
"""


def test_linear_springs_are_not_searched():
    system = build(mbdsl.parse(ROTOR.format(law="k = 3 N.m/rad, c = 0.1 N.m.s/rad")))
    assert OnTheWay(system).terms == []


def test_a_narrow_window_of_an_angle_is_not_passed():
    # a torque of 40 N.m over 2 mrad changes the energy by 0.08 J; the inertia about n/|n| = (1, 2, 2)/3 is 3.9/9 kg.m2
    text = ROTOR.format(law="torque = if phi > 1 rad and phi < 1.002 rad then 40 N.m else 0 N.m")
    J = (0.3 + 4 * 0.4 + 4 * 0.5) / 9.0
    after = math.sqrt(2.0**2 - 2.0 * 0.08 / J)
    for method in ("hht-si2", "nstiff"):
        run = mbdsl.simulate(mbdsl.parse(text), stop=1.0, interval=0.1, tol=1e-5, method=method)
        w = run["hinge.w"]
        assert np.allclose(w[run.t < 0.45], 2.0, rtol=1e-6)
        assert abs(w[-1] - after) < 1e-4
