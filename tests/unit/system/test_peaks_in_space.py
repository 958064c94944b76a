"""Peaks of laws in joint coordinates of models in space."""

import math

import numpy as np
import pytest

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
        run = mbdsl.simulate(mbdsl.parse(text), stop=1.0, interval=0.1, tol=1e-5, method=method, general=True)
        w = run["hinge.w"]
        assert np.allclose(w[run.t < 0.45], 2.0, rtol=1e-6)
        assert abs(w[-1] - after) < 1e-4


def test_a_window_after_the_first_turn():
    """A torque of 40 N.m over 2 mrad, after a turn and 1 rad, takes 0.08 J; methods of the loop and of SciPy.

    The motion passes the window at (2 pi + 1)/(2 rad/s) = 3.64 s."""
    at = 2.0 * math.pi + 1.0
    law = f"torque = if phi > {at!r} rad and phi < {at + 0.002!r} rad then 40 N.m else 0 N.m"
    text = ROTOR.format(law=law)
    J = (0.3 + 4 * 0.4 + 4 * 0.5) / 9.0
    after = math.sqrt(2.0**2 - 2.0 * 0.08 / J)
    for method in ("hht-si2", "radau5", "scipy-lsoda"):
        run = mbdsl.simulate(mbdsl.parse(text), stop=4.0, interval=0.1, tol=1e-5, method=method, general=True)
        assert np.allclose(run["hinge.w"][run.t < 3.6], 2.0, rtol=1e-6), method
        assert abs(run["hinge.w"][-1] - after) < 1e-4, method


def test_fixed_steps_and_a_window_after_the_first_turn():
    """Steps of 1 ms, of 8 mrad, may pass over a window of 2 mrad. The motion, from 0 to 9.6 rad, passes that at one
    turn and 1 rad, but not those at other turns."""
    law = "torque = if phi > {0!r} rad and phi < {1!r} rad then 40 N.m else 0 N.m"
    warned = []
    for at in (2.0 * math.pi + 1.0, -4.0 * math.pi + 1.0, 12.0 * math.pi + 1.0):
        text = ROTOR.format(law=law.format(at, at + 0.002)).replace("2 rad/s", "8 rad/s")
        run = mbdsl.simulate(mbdsl.parse(text), stop=1.2, interval=0.1, step=1e-3, general=True)
        warned.append(any("law" in w for w in run.stats["warnings"]))
    assert warned == [True, False, False]


def test_terms_that_are_rounding_have_no_peaks():
    """The rate of a hinge with a skew axis contains products with components of axes that are zero except for rounding,
    whose noise is not a peak. A damper as a law equals the damper with the same constant."""
    text = """spatial model Damped
      Ground ground(n = {0, 0, -1});
      Body a(m = 1 kg, I = {1, 2, 2} kg.m2, frames(p = {0.3, 0.1, 0.2}, q = {-0.3, 0, 0}));
      Body b(m = 1 kg, I = {1, 2, 2} kg.m2, frames(p = {0.3, 0.1, 0.2}));
      Revolute J(ground, a.p, n = {1, 2, 2});
      Revolute K(a.q, b.p, n = {1, 0, 0});
      RotationalSpringDamper e(J, %s);
    end Damped;"""
    law, constant = (mbdsl.parse(text % x) for x in ("torque = (0.2 N.m.s)*e.w", "c = 0.2 N.m.s/rad"))
    given = {"stop": 0.1, "interval": 0.05}
    assert not mbdsl.simulate(law, step=1e-3, **given).stats["warnings"]
    one, other = (mbdsl.simulate(x, method="dop853", tol=1e-9, **given) for x in (law, constant))
    np.testing.assert_allclose(one["b.x"], other["b.x"], rtol=0, atol=2e-9)  # the tolerances of both runs


ARM = """
spatial model Arm
  Ground ground(n = {0, 0, -1});
  Body first(m = 3 kg, I = {0.02, 0.03, 0.04} kg.m2, frames(a = {0, 0, 0}, b = {0.3, 0, 0.05} m));
  Body second(m = 1 kg, I = {1e-3, 2e-2, 2e-2} kg.m2, frames(a = {0, 0, 0}, tip = {0.5, 0, 0} m));
  Revolute q1(ground, first.a, n = {0, 0, 1});
  Revolute q2(first.b, second.a, n = {0.6, 0.8, 0});
  LAWS
initial equation
  q1.phi = 0 rad; q2.phi = 0.3 rad; q1.w = 1 rad/s; q2.w = -2 rad/s;
  annotation(experiment(StopTime = 0.5 s));
end Arm;
"""


def searched(laws):
    return OnTheWay(build(mbdsl.parse(ARM.replace("LAWS", laws)))).terms


@pytest.mark.parametrize(
    "laws",
    [
        "RotationalVelocityDriver d1(q1, w = 0.5 rad/s); RotationalVelocityDriver d2(q2, w = 1 rad/s2*time);",
        "VelocityConstraint c(gamma = q1.w - 2*q2.w);",
        "VelocityConstraint c(gamma = second.tip.x*second.tip.vx + second.tip.z*second.tip.vz);",
        "Torque t1(q1, tau = -2e3 N.m/rad*(q1.phi - 1 rad) - 40 N.m.s/rad*q1.w);",
        "Torque t2(q2, tau = -2e3 N.m/rad*q2.phi - 40 N.m.s/rad*q2.w);",
        "RotationalSpringDamper s(q2, torque = 3 N.m/rad*phi + 4 N.m.s/rad*w);",
    ],
)
def test_linear_laws_and_residuals_of_constraints_are_not_searched(laws):
    assert searched(laws) == []


@pytest.mark.parametrize(
    "laws",
    [
        "RotationalVelocityDriver d1(q1, w = if abs(q2.phi - 0.5 rad) < 1e-3 rad then 5 rad/s else 0 rad/s);",
        "VelocityConstraint c(gamma = q1.w - (if abs(q2.phi - 0.5 rad) < 1e-3 rad then 5 rad/s else 0 rad/s));",
        "Torque t2(q2, tau = -40 N.m.s/rad*tanh(q2.w/(1e-3 rad/s))*(1 rad/s));",
    ],
)
def test_abrupt_laws_are_searched(laws):
    assert searched(laws)


STOPPED = """
spatial model Door
  Ground ground;
  Box car(m = 10 kg, length = 1 m, width = 1 m, height = 1 m, frames(h = {0.5, 0, 0}));
  Spherical pivot(ground, car.a);
  Box door(m = 1 kg, length = 0.5 m, width = 0.5 m, height = 0.02 m);
  Revolute hinge(car.h, door.a, n = {0, 1, 0});
  LAW
initial equation
  hinge.phi = 10 deg; hinge.w = 1 rad/s;
  annotation(experiment(StopTime = 0.3 s));
end Door;
"""


@pytest.mark.parametrize(
    "law",
    [
        "RotationalStop open(hinge, phi_min = 0, phi_max = 80 deg, k = 1e3, e = 0.3, w_0 = 1);",
        "Torque brake(hinge, tau = if time < 0.5 s then 0 N.m else -(5 N.m.s/rad)*hinge.w);",
    ],
)
@pytest.mark.parametrize("method", ["hht-i3", "radau5", "dop853"])
def test_a_law_that_is_zero_does_not_end_a_run(law, method):
    """Neither acts: the motion is that without them."""
    free, held = (
        mbdsl.simulate(mbdsl.parse(STOPPED.replace("LAW", x)), method=method, tol=1e-6, interval=0.1) for x in ("", law)
    )
    assert held.t[-1] == 0.3
    assert held["hinge.phi"] == pytest.approx(free["hinge.phi"], abs=2e-6)
