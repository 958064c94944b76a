"""dop853 and Radau IIA with many stages at poses in which constraints lose rank, in space and in the plane.

A parallelogram of three equal rods that turns through its flat poses. Reference: the equation of its rocker's angle,
(2/3 + 1) m L^2 phi'' = -2 m g L cos(phi), solved by DOP853 of SciPy.
"""

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl
from mbdsl.errors import IntegrationError

G, W0 = 9.80665, {"space": 9.0, "plane": 7.0}
PARALLELOGRAM = """
model Parallelogram
  parameter AngularVelocity w0 = 9 rad/s;
  Ground ground(g = 9.80665 m/s2, frames(D = {1 m, 0}));
  Rod left(m = 1 kg, length = 1 m);
  Rod right(m = 1 kg, length = 1 m);
  Rod coupler(m = 1 kg, length = 1 m);
  Revolute A(ground, left.a);
  Revolute B(left.b, coupler.a);
  Revolute C(coupler.b, right.b);
  Revolute D(ground.D, right.a);
initial equation
  left.phi = 90 deg;
  left.w = w0;
  guess right.phi = 90 deg;
  guess right.w = w0;
  guess coupler.phi = 0;
  guess coupler.w = 0;
  annotation(experiment(StopTime = 3 s));
end Parallelogram;
"""


def scene(where):
    text = PARALLELOGRAM.replace("w0 = 9", f"w0 = {W0[where]:g}").lstrip()
    return mbdsl.parse(text if where == "plane" else f"spatial {text}")


def reference(w0, t):
    """x of the rocker's end at times t (N,)."""

    def rates(_, y):
        return [y[1], -1.2 * G * np.cos(y[0])]

    return np.cos(solve_ivp(rates, (0.0, 3.0), [np.pi / 2, w0], method="DOP853", rtol=1e-13, atol=1e-13, t_eval=t).y[0])


@pytest.mark.parametrize(("where", "tol"), [("space", 1e-7), ("space", 1e-8), ("plane", 1e-8)])
def test_what_has_been_computed_is_kept(where, tol):
    """Accelerations near such a pose change with the last digits of positions, by h |lambda| of 1e3 to 1e6. A run that
    does not get past one with its tolerance says until when it is kept, and has the results."""
    with pytest.raises(IntegrationError) as failed:
        mbdsl.simulate(scene(where), method="dop853", tol=tol, general=where == "space", interval=0.003)
    assert "stiff" not in str(failed.value)
    t = failed.value.trajectory
    kept = t.t <= t.stats["horizon"]
    assert t.stats["horizon"] > 0.03
    exact = reference(W0[where], t.t[kept])
    assert np.abs(t["left.b.x"][kept] - exact).max() < tol * 2.0  # positions of a mechanism of 2 m


@pytest.mark.parametrize("where", ["space", "plane"])
def test_fixed_steps_name_the_pose(where):
    """Which steps fail is decided by the last digits of positions; those that do name the pose. The redundant
    constraints of a planar loop in space are not the reason."""
    failed = []
    for step in (1e-3, 1.5e-3, 1.7e-3, 2.1e-3, 2.3e-3):
        try:
            mbdsl.simulate(scene(where), method="dop853", step=step, general=where == "space")
        except IntegrationError as problem:
            failed.append(str(problem))
    assert failed and all(re.search(r"the pose is singular, or close to it \(to 0\.\d+\)", x) for x in failed)
    assert not any("stiff" in x for x in failed)


@pytest.mark.parametrize("where", ["plane", "space"])
@pytest.mark.parametrize("tol", [1e-4, 1e-6, 1e-7])
@pytest.mark.parametrize("method", ["radau9", "radau13"])
def test_radau_passes_them(method, tol, where):
    """Nine flat poses in 3 s. One matrix corrects all stages of a step, while the Jacobian of the constraints changes
    its sign within the step along the direction that becomes free."""
    text = PARALLELOGRAM.lstrip() if where == "plane" else f"spatial {PARALLELOGRAM.lstrip()}"
    run = mbdsl.simulate(mbdsl.parse(text), method=method, tol=tol, general=where == "space", interval=0.01)
    # twice the tolerance of a mechanism of 2 m: which digits are lost in a singular pose is decided by the last ones
    assert np.abs(run["left.b.x"] - reference(9.0, run.t)).max() < 4.0 * tol
