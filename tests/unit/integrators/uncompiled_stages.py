"""Run by test_radau5.py in a process of its own, with MBDSL_NO_COMPILE=1: checks that are easier, or only possible,
without compilation.

Prints a JSON object: for every shipped model, how one correction of all stages compares with the Jacobian of their
equations by differences.
"""

import json
import sys
from pathlib import Path

import numpy as np

import mbdsl
from mbdsl.compilation import code_cache
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators.loop import linear_solve, run_data
from mbdsl.integrators.methods import radau_matrices, radau_stages
from mbdsl.integrators.methods.radau5 import SCHEME as R
from mbdsl.integrators.run import MethodRun
from mbdsl.kernels import buffer_layout as L
from mbdsl.mechanism import graph
from mbdsl.system import build

MODELS = sorted((Path(__file__).parents[3] / "models").glob("*.mbd"))
#: steps of a model that is too fast for 1 ms
STEPS = {"crank_ivp": 1e-5}


class Stages:
    """The stages on one model at a state off the motion; with ``at_rest`` they are all at the same state, and w = mu =
    0."""

    def __init__(self, path, h, at_rest=False, spoilt=False):
        # Differences cannot resolve friction that reverses within 0.1 mm/s.
        scene = mbdsl.load(path, {"v_s": 50.0} if path.stem == "stick_slip_belt" else {})
        mechanism = graph.build(scene)
        system = build(scene, mechanism)
        start = initial_state(system, mechanism, 0.0)
        self.run = run = MethodRun(system, "radau5", h, 0.0, 1.0, np.array([1.0]))
        run.use_solver(linear_solve.DENSE)  # a solver that finds any pivot
        run.begin(start.q, start.v, start.a, start.lam)
        radau_stages.set_metric(run.data())
        self.h, self.n, self.m, self.N, self.spoilt = h, system.n, system.m, system.unknowns, spoilt
        rng, vectors, n, N = np.random.default_rng(3), run.vectors, system.n, system.unknowns
        vectors[L.POSITION0, :n] += rng.uniform(-0.1, 0.1, n)
        lam = rng.normal(size=N - n)
        for k in range(3):
            vectors[R.STAGE + k, n:] = (
                vectors[L.UNKNOWN0, n:] + lam + (0.0 if at_rest else 0.1 * rng.normal(size=N - n))
            )
        if at_rest:
            vectors[L.VELOCITY0] = 0.0
        else:
            vectors[L.VELOCITY0, :n] += rng.normal(size=n)
            vectors[R.STAGE : R.STAGE + 3, :n] = rng.normal(size=(3, n))
            vectors[R.STAGE2 : R.STAGE2 + 3, : n + self.m] = 0.01 * h**2 * rng.normal(size=(3, n + self.m))
        if any(c.friction is not None for c in scene.components.values()):
            vectors[R.STAGE : R.STAGE + 3, n:] += 1e5  # far from where a normal force changes its sign
        # not unknowns: the second multipliers of nonholonomic constraints
        self.active = np.ones((6, N), bool)
        self.active[3:, n + self.m :] = False

    def residual(self):
        data = self.run.data()
        for k in (0, 2, 1):
            radau_stages.motion(R, k, self.h, data)
            data.layout[L.NEW_MASS] = 1
            run_data.evaluate(R.nodes[k] * self.h, data)
            radau_stages.residual(R, k, data)
        return data.vectors[R.RESIDUAL : R.RESIDUAL + 6].ravel().copy()

    def unknowns(self):
        return self.run.vectors[R.STAGE : R.STAGE + 6]

    def jacobian(self):
        """d(residuals)/d(unknowns) by five-point differences."""
        x = self.unknowns()
        J = np.zeros((x.size, x.size))
        for k in range(x.size):
            d = (1e-2 if k < 3 * self.N else 3e-5) / self.h  # a moves q by h^2, w by h
            kept, f = x.flat[k], []
            for s in (1, -1, 2, -2):
                x.flat[k] = kept + s * d
                f.append(self.residual())
            x.flat[k] = kept
            J[:, k] = (8 * (f[0] - f[1]) - (f[2] - f[3])) / (12 * d)
        return J

    def corrections(self):
        """The linear map from residuals to corrections."""
        self.residual()

        def tangent(t, cM, cK, *more):
            self.run.tangent(t, cM, (1.01 if self.spoilt else 1.0) * cK, *more)

        data = self.run.data()._replace(tangent_at=tangent)
        assert radau_matrices.matrices(R, 0.0, self.h, 1e-12, data)
        x = self.unknowns()
        B, kept = np.zeros((x.size, x.size)), x.copy()
        for k in range(x.size):
            x[:] = 0.0
            data.vectors[R.RESIDUAL : R.RESIDUAL + 6] = 0.0
            data.vectors[R.RESIDUAL + k // self.N, k % self.N] = 1.0
            radau_stages.correct(R, self.h, self.h, data)
            B[:, k] = -x.ravel()
        x[:] = kept
        return B


def contraction(path, h, **how):
    """The spectral radius of the error matrix of one correction, zero for Newton's method."""
    step = Stages(path, h, **how)
    left = np.eye(6 * step.N) - step.corrections() @ step.jacobian()
    active = step.active.ravel()
    return float(np.abs(np.linalg.eigvals(left[np.ix_(active, active)])).max())


if __name__ == "__main__":
    assert not code_cache.enabled()
    found: dict[str, dict] = {"moving": {}, "at rest": {}, "spoilt": {}}
    for path in MODELS:
        h = STEPS.get(path.stem, 1e-3)
        if path.stem in ("flexible_pendulum", "spin_up_beam", "chain", "seven_body", "four_bar"):
            continue  # hundreds of unknowns; other models have the same elements
        found["moving"][path.stem] = [contraction(path, k * h) for k in (4, 1)]
        found["at rest"][path.stem] = contraction(path, h, at_rest=True)
        if path.stem == "slider_crank":
            found["spoilt"][path.stem] = contraction(path, 0.1, at_rest=True, spoilt=True)
    json.dump(found, sys.stdout)
