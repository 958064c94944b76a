"""A wheel that spins on a free carrier, at steps in which it turns by up to two radians, as a body on its own
(``general``; as a rotor of a gyrostat it is in test_gyrostats.py).

Reference: a gyrostat. The wheel is symmetric about its axle, and no torque acts about it; with the locked inertia I
about the common centre of mass, the axle e and the wheel's moment of inertia C about it,

    (I - C e e^T) Omega' + Omega x (I Omega + C sigma e) = 0,   sigma' = -e . Omega',

for the carrier's Omega and the wheel's speed sigma relative to it; solved by DOP853 of SciPy.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl
from mbdsl.errors import IntegrationError

M, WHEEL, SEAT = 200.0, 5.0, np.array([0.3, 0.1, -0.2])
BUS, LENGTH, RADIUS = np.array([80.0, 95.0, 60.0]), 0.05, 0.15
START, SPIN = np.array([0.02, -0.03, 0.05]), 100.0
SATELLITE = """
spatial model Satellite
  Ground ground(g = 0);
  Body bus(m = 200 kg, I = {80, 95, 60} kg.m2, frames(seat = {0.3, 0.1, -0.2} m));
  Cylinder wheel(m = 5 kg, length = 0.05 m, radius = 0.15 m, n = {1, 0, 0});
  FreeMotion free(ground, bus.c);
  Revolute j(bus.seat, wheel.c, n = {1, 0, 0});
initial equation
  bus.wx_local = 0.02 rad/s; bus.wy_local = -0.03 rad/s; bus.wz_local = 0.05 rad/s;
  bus.vx = 0 m/s; bus.vy = 0 m/s; bus.vz = 0 m/s;
  j.w = 100 rad/s;
  annotation(experiment(StopTime = 4 s, Interval = 0.4 s));
end Satellite;
"""
STABILISED = ("hht-si2", "nstiff-si2", "hht-add", "generalized-alpha")
OF_BUS = [f"bus.w{x}_local" for x in "xyz"]


@pytest.fixture(scope="module")
def satellite():
    return mbdsl.parse(SATELLITE)


@pytest.fixture(scope="module")
def exact():
    """Omega of the carrier at 0, 0.4, ..., 4 s, (11, 3)."""
    C, A = WHEEL * RADIUS**2 / 2, WHEEL * (3 * RADIUS**2 + LENGTH**2) / 12
    reduced, e = M * WHEEL / (M + WHEEL), np.array([1.0, 0.0, 0.0])
    locked = np.diag(BUS + [C, A, A]) + reduced * (SEAT @ SEAT * np.eye(3) - np.outer(SEAT, SEAT))
    moving = locked - C * np.outer(e, e)

    def rates(_t, y):
        w = np.linalg.solve(moving, np.cross(locked @ y[:3] + C * y[3] * e, y[:3]))
        return [*w, -w[0]]

    t = np.linspace(0.0, 4.0, 11)
    return solve_ivp(rates, (0.0, 4.0), [*START, SPIN], method="DOP853", rtol=1e-12, atol=1e-13, t_eval=t).y[:3].T


@pytest.fixture(scope="module")
def of_index_3(satellite):
    """Iterations and factorisations of hht-i3 per step, at each step."""
    return {
        h: work(mbdsl.simulate(satellite, method="hht-i3", step=h, general=True)) for h in (2.5e-3, 5e-3, 1e-2, 2e-2)
    }


def work(run):
    return np.array([run.stats["iterations"], run.stats["factorisations"]]) / run.stats["steps"]


@pytest.mark.parametrize("h", [2.5e-3, 5e-3, 1e-2, 2e-2])
@pytest.mark.parametrize("method", STABILISED)
def test_iterations_are_few(satellite, of_index_3, method, h):
    """At most 1.3 times those of the index-3 method, and matrices last, at 0.25, 0.5, 1 and 2 rad a step.

    A splitting that leaves terms of the order of this angle to the next iteration takes 16 iterations and 5 matrices a
    step at 1 rad, and fails at 2 rad.
    """
    iterations, factorisations = work(mbdsl.simulate(satellite, method=method, step=h, general=True))
    assert iterations < 1.3 * of_index_3[h][0]
    assert factorisations < 0.1


@pytest.mark.parametrize("method", STABILISED)
def test_motion_of_a_gyrostat(satellite, exact, method):
    """Of order 2 in the step, with errors of 1e-4 of the rates at 0.05 rad a step; and with a tolerance."""
    errors = []
    for h in (1e-3, 5e-4):
        run = mbdsl.simulate(satellite, method=method, step=h, general=True)
        errors.append(np.abs(np.transpose([run[x] for x in OF_BUS]) - exact).max())
        assert max(np.abs(run[f"j.dPhi[{k}]"]).max() for k in range(1, 6)) < 1e-11 * max(1.0, SPIN * 0.15)
    assert errors[1] < errors[0] / 3.5
    assert errors[1] < 1e-3 * np.abs(exact).max()


@pytest.mark.parametrize("method", STABILISED)
def test_controlled_steps(satellite, exact, method):
    """Steps of about 1 rad; an iteration that does not contract shortens them to a tenth and takes 27 iterations.

    The tolerance refers to the largest velocity, the spin; the carrier's rates are 1/2000 of it."""
    run = mbdsl.simulate(satellite, method=method, tol=1e-2, general=True)
    assert np.abs(np.transpose([run[x] for x in OF_BUS]) - exact).max() < 1e-5 * SPIN
    assert (work(run) < (4.0, 0.5)).all()


#: an unbalanced wheel without symmetry, whose motion steps of 3 rad cannot follow
UNBALANCED = """
spatial model Unbalanced
  Ground ground(g = 9.81 m/s2);
  Body bus(m = 2 kg, I = {0.08, 0.095, 0.06} kg.m2, frames(seat = {0.3, 0.1, -0.2} m));
  Body wheel(m = 5 kg, I = {0.02, 0.05, 0.09} kg.m2, frames(axle = {0.05, 0.1, 0.02} m));
  Spherical hip(ground, bus.c);
  Revolute j(bus.seat, wheel.axle, n = {1, 0.3, 0});
initial equation
  bus.wx_local = 1 rad/s; bus.wy_local = -0.03 rad/s; bus.wz_local = 0.05 rad/s;
  j.w = 100 rad/s;
  annotation(experiment(StopTime = 3 s));
end Unbalanced;
"""


@pytest.mark.parametrize("method", ["hht-i3", "hht-add"])
def test_a_failure_names_the_body_and_its_angle(method):
    with pytest.raises(IntegrationError, match=r"wheel turns by \d\.?\d* rad in this step") as failed:
        mbdsl.simulate(mbdsl.parse(UNBALANCED), method=method, step=3e-2)
    assert "turns by less than 0.5 rad" in failed.value.hint
