"""Run by test_uncompiled.py in a process of its own, with MBDSL_NO_COMPILE=1: checks that are easier, or only
possible, without compilation.

Prints a JSON object: trajectories of a few steps; and for every method and shipped model, how one correction compares
with the Jacobian of the residual by differences.
"""

import json
import sys
from functools import cache
from pathlib import Path

import numpy as np

import mbdsl
from mbdsl.compilation import code_cache
from mbdsl.elements.kind import ForceKind
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators import compiled as methods
from mbdsl.integrators import modules
from mbdsl.integrators.loop import linear_solve, run_data, split_correction
from mbdsl.integrators.run import MethodRun
from mbdsl.kernels import buffer_layout as L
from mbdsl.mechanism import graph
from mbdsl.system import build

#: methods with the common step; those with their own have tests of their own
NAMES = [name for name in methods() if not hasattr(modules()[name], "take")]
MODELS = sorted((Path(__file__).parents[3] / "models").glob("*.mbd"))

#: laws, tables and drivers: all functions of the interpreter of expressions
EXPRESSIVE = """
model Expressive
  Ground ground;
  Table lift(table = [0 s, 0.1 rad; 0.02 s, 0.2 rad; 0.05 s, 0.25 rad; 0.1 s, 0.3 rad], smoothness = "cubic");
  Table brake(table = [-1 m/s, -2 N; 0 m/s, 0 N; 1 m/s, 3 N], extrapolation = "linear");
  Rod arm(m = 1 kg, length = 0.5 m);
  Rod tail(m = 0.5 kg, length = 0.3 m);
  Revolute O(ground, arm.a);
  Revolute A(arm.b, tail.a);
  RotationalDriver drive(O, phi = lift(time));
  SpringDamper law(ground, tail.b, force = if s > 0.5 m then 20 N/m*(s - 0.5 m) + brake(v) else 0 N);
  Torque twist(tail.a, tau = 0.1 N.m*sin(3 rad/s*time)*exp(-tail.phi*tail.phi));
  Force wind(tail.b, fx = 0.1 N.s/m*(1 m/s - tail.b.vx), fy = 0 N);
initial equation
  tail.phi = 0.4 rad;
  annotation(experiment(StopTime = 0.03 s));
end Expressive;
"""


def runs():
    """Name -> (t, q, v, lam) of short runs, for comparison with compiled ones."""
    crank = mbdsl.load(next(m for m in MODELS if m.stem == "slider_crank"))
    found = {}
    for scene, stop in ((crank, 0.0405), (mbdsl.parse(EXPRESSIVE), 0.0305)):
        for method in methods():
            r = mbdsl.simulate(scene, method=method, step=2e-3, stop=stop, interval=0.0017)
            found[f"{scene.name} {method}"] = [x.tolist() for x in (r.t, r.q, r.v, r.lam)]
    return found


#: steps of models that are too fast for 1 ms
STEPS = {"crank_ivp": 1e-5}
#: differences cannot resolve friction that reverses within 0.1 mm/s; Jacobians of long models are slow here
COMPARED = [m for m in MODELS if m.stem not in ("four_bar", "seven_body")]  # their elements are in smaller models
PARAMETERS = {"stick_slip_belt": {"v_s": 50.0}, "flexible_pendulum": {"elements": 3}, "chain": {"N": 4}}


@cache
def prepared(path):
    """Scene, system and consistent initial state of a model, the same for all methods; they are only read."""
    scene = mbdsl.load(path, PARAMETERS.get(path.stem, {}))
    mechanism = graph.build(scene)
    system = build(scene, mechanism)
    return scene, system, initial_state(system, mechanism, 0.0)


class Step:
    """One method on one model at a state off the motion, with all data that its residual reads."""

    def __init__(self, path, name, h, at_rest):
        scene, system, start = prepared(path)
        self.run = MethodRun(system, name, h, 0.0, 1.0, np.array([1.0]))
        self.run.use_solver(linear_solve.DENSE)  # a solver that finds any pivot
        self.run.begin(start.q, start.v, start.a, start.lam)
        self.method, self.h, self.n, self.N = modules()[name], h, system.n, system.unknowns
        self.rows = min(2, self.method.METHOD.sets)
        rng, vectors = np.random.default_rng(3), self.run.vectors
        n, N = self.n, self.N
        vectors[L.POSITION0, :n] += rng.uniform(-0.1, 0.1, n)
        vectors[L.UNKNOWN0, :n] += rng.normal(size=n)
        vectors[L.UNKNOWN] = vectors[L.UNKNOWN0] + rng.normal(size=N)
        vectors[L.FORCE0, :n] += rng.normal(size=n)
        vectors[L.UNKNOWN2] = 0.0 if at_rest else 0.3 * rng.normal(size=N)
        vectors[L.VELOCITY0, :n] += rng.normal(size=n)
        # one step earlier
        vectors[L.KEPT, :n] = vectors[L.POSITION0, :n] - h * vectors[L.VELOCITY0, :n]
        vectors[L.KEPT2, :n] = vectors[L.VELOCITY0, :n] - h * rng.normal(size=n)
        if at_rest:
            vectors[L.VELOCITY0] = 0.0
            if name == "hht-add":  # the pose does not change: the old Phi_q is the new one
                vectors[L.UNKNOWN, :n] = vectors[L.UNKNOWN2, :n] = 0.0
            else:  # v at the end of the step is zero
                vectors[L.KEPT2] = 0.0
                ends = []
                for vectors[L.VELOCITY0, :n] in (0.0, 1.0):
                    self.residual()
                    ends.append(vectors[L.VELOCITY, :n].copy())
                vectors[L.VELOCITY0, :n] = ends[0] / (ends[0] - ends[1])
        if any(c.friction is not None for c in scene.components.values()):
            for row in (
                L.UNKNOWN,
                L.UNKNOWN2,
            ):  # far from where a normal force changes its sign
                vectors[row, n:] += 1e5
        # the start of the step holds the history
        vectors[L.POSITION, :n], vectors[L.VELOCITY, :n] = (
            vectors[L.POSITION0, :n],
            vectors[L.VELOCITY0, :n],
        )
        run_data.evaluate(0.0, self.data)
        self.run.layout[L.KEEP] = 1
        # not unknowns: the second multipliers of nonholonomic constraints
        self.active = np.ones((self.rows, N), bool)
        self.active[1:, n + system.m :] = False

    @property
    def data(self):
        return self.run.data()

    def residual(self):
        self.method.motion(self.h, self.data)
        run_data.evaluate(self.h, self.data)
        self.method.residual(self.h, self.data)
        rows = slice(L.RESIDUAL, L.RESIDUAL + self.rows)
        return self.run.vectors[rows, : self.N].ravel().copy()

    def unknowns(self):
        return self.run.vectors[L.UNKNOWN : L.UNKNOWN + self.rows]

    def jacobian(self):
        """d(residuals)/d(unknowns) by five-point differences."""
        x = self.unknowns()
        J = np.zeros((x.size, x.size))
        for k in range(x.size):
            # a change of the unknowns moves q by h^2 times it, v by h; but q' - v, an unknown of nstiff-si2, moves q by
            # h
            of_velocity = k >= self.N and self.method.METHOD.name == "nstiff-si2"
            d = (3e-5 if of_velocity else 1e-2) / self.h
            kept, f = x.flat[k], []
            for s in (1, -1, 2, -2):
                x.flat[k] = kept + s * d
                f.append(self.residual())
            x.flat[k] = kept
            J[:, k] = (8 * (f[0] - f[1]) - (f[2] - f[3])) / (12 * d)
        return J

    def corrections(self):
        """The linear map from residuals to corrections by the method's matrix and solve."""
        self.residual()
        assert self.method.matrix(self.h, self.h, self.data)
        x, B = self.unknowns(), np.zeros((self.rows * self.N,) * 2)
        kept = x.copy()
        for k in range(x.size):
            x[:] = 0.0
            self.run.vectors[L.RESIDUAL : L.RESIDUAL + self.rows] = 0.0
            self.run.vectors[L.RESIDUAL + k // self.N, k % self.N] = 1.0
            self.method.correct(0, self.h, self.data)
            B[:, k] = -x.ravel()
        x[:] = kept
        return B


def contraction(path, name, h, at_rest=False):
    """Error matrix of one correction, zero for Newton's method with the exact Jacobian: its largest entry and its
    spectral radius, which does not depend on units."""
    step = Step(path, name, h, at_rest)
    left = np.eye(step.rows * step.N) - step.corrections() @ step.jacobian()
    active = step.active.ravel()
    left = left[np.ix_(active, active)]
    return float(np.abs(left).max()), float(np.abs(np.linalg.eigvals(left)).max())


if __name__ == "__main__":
    assert not code_cache.enabled()
    split_correction.EARLY = split_correction.LATE = 0.0  # no term is left to the next iteration on purpose
    found: dict[str, dict] = {"runs": runs(), "contraction": {}, "at rest": {}}
    for path in COMPARED:
        for name in NAMES:
            key = f"{path.stem} {name}"
            h = STEPS.get(path.stem, 1e-3)
            # the longer step shows terms of order h, which exact matrices do not neglect
            steps = (h,) if modules()[name].METHOD.index == 3 else (4 * h, h)
            found["contraction"][key] = [contraction(path, name, x) for x in steps]
            forces = [c.kind for c in mbdsl.load(path).components.values() if isinstance(c.kind, ForceKind)]
            if not any(kind.springs or "damping" in kind.effects for kind in forces):
                steps = (4 * h, h) if name == "hht-add" else (h,)  # it neglects a term of order h^2
                found["at rest"][key] = [contraction(path, name, x, at_rest=True) for x in steps]
    json.dump(found, sys.stdout)
