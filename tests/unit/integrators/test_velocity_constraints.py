"""Stabilised methods keep the velocity constraints up to the error that the termination of the iteration leaves."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl

CRANK = Path(__file__).parents[3] / "models" / "slider_crank.mbd"
#: largest error of velocities at which the iteration ends, relative to the largest velocity (docs/theory-methods.md)
LEFT = 8e-12
#: gamma/beta, by which velocities change more than positions over the step, is about 2 for alpha = -0.1
AMPLIFIED = 2.0
#: the remaining error is estimated from the contraction of the iteration, which may be that of an earlier step
MARGIN = 4.0


@pytest.mark.parametrize("method", ["hht-si2", "hht-add", "nstiff-si2"])
@pytest.mark.parametrize(
    ("step", "parameters"), [(5e-4, {}), (4e-3, {}), (1e-3, {"c": "2e5 N.s/m"})], ids=["small", "large", "stiff"]
)
def test_velocity_constraints_hold_up_to_the_end_of_the_iteration(method, step, parameters):
    run = mbdsl.simulate(CRANK, method=method, step=step, stop=0.5, interval=step, parameters=parameters)
    scale = run.system.tables.scale
    speed = np.abs(run.v * scale).max()
    left = MARGIN * AMPLIFIED * LEFT * speed / scale  # (n,) in the units of the coordinates
    for t, q, v in zip(run.t, run.q, run.v, strict=True):
        J = np.asarray(run.system.velocity_jacobian(t, q, v))
        # the scleronomic constraints have Phi_t = 0; the second term is rounding of the sum
        assert (np.abs(J @ v) <= np.abs(J) @ left + 4 * len(v) * np.finfo(float).eps * (np.abs(J) @ np.abs(v))).all()
