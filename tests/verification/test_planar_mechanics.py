"""Examples of PlanarMechanics, a Modelica library of DLR, against its published results.

They come from Dassl with a relative tolerance of 1e-6, whose errors accumulate: compared at 100 times this tolerance.
The double pendulum amplifies errors by a thousand in 10 s. SciPy's DOP853 confirms the run here to 1e-7, so that the
difference of 1.4e-3 is an error of the published result.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl
from mbdsl.mechanism.graph import build

MODELS = ("Pendulum", "DoublePendulum", "PistonEngine", "CraneCrab", "SpringDamperDemo")


@pytest.fixture(scope="module")
def published(reference):
    return reference("planar_mechanics")["models"]


@pytest.fixture(scope="module")
def run(pytestconfig, published):
    """``run(name)``: the trajectory of an example at the times of its published results."""
    done = {}

    def simulated(name):
        if name not in done:
            times = published[name]["time"]
            scene = mbdsl.load(pytestconfig.rootpath / "tests" / "data" / "planar_mechanics.mbd", model=name)
            assert not scene.warnings and not build(scene).warnings
            done[name] = mbdsl.simulate(scene, method="radau5", tol=1e-10, interval=times[1])
            np.testing.assert_allclose(done[name].t, times, atol=1e-12)
        return done[name]

    return simulated


@pytest.mark.parametrize("name", MODELS)
def test_published_results(name, published, run):
    allowed = 3e-3 if name == "DoublePendulum" else 1e-4
    for signal, values in published[name].items():
        if signal != "time":
            error = np.abs(run(name)[signal] - values).max()
            assert error <= allowed * np.abs(values).max(), signal


def double_pendulum(t, y):
    """Lagrange's equations of two bodies on massless rods; both angles from the x axis."""
    m1, I1, L1, m2, I2, L2, g = 1.0, 0.1, 1.0, 0.2, 0.01, 0.4, 9.81
    a, b, va, vb = y
    coupling = m2 * L1 * L2
    mass = [[(m1 + m2) * L1**2 + I1, coupling * np.cos(a - b)], [coupling * np.cos(a - b), m2 * L2**2 + I2]]
    force = [
        -coupling * np.sin(a - b) * vb**2 - (m1 + m2) * g * L1 * np.cos(a),
        coupling * np.sin(a - b) * va**2 - m2 * g * L2 * np.cos(b),
    ]
    return [va, vb, *np.linalg.solve(mass, force)]


def test_double_pendulum_by_another_integrator(published, run):
    times = published["DoublePendulum"]["time"]
    other = solve_ivp(double_pendulum, (0.0, 10.0), np.zeros(4), "DOP853", times, rtol=1e-12, atol=1e-12).y
    trajectory = run("DoublePendulum")
    a, va = trajectory["revolute.phi"], trajectory["revolute.w"]
    here = [a, a + trajectory["revolute1.phi"], va, va + trajectory["revolute1.w"]]
    assert np.abs(here - other).max() < 1e-7  # tolerances of 1e-10 and 1e-12, amplified by a thousand
