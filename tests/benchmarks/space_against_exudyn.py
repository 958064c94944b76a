"""mbdsl against Exudyn on models in space, at equal step and at equal error, in one process and one thread.

    python tests/benchmarks/space_against_exudyn.py [--only NAME] [--repeats 3]

Exudyn runs its generalised-alpha solver with its default settings on nodes with rotation vectors (Lie group) and with
Euler parameters, with dense and sparse matrices and full and modified Newton iteration; the fastest counts. Of mbdsl,
hht-si2 runs with the same damping. Times are those of the step loops without the time of a run of one step,
alternately, the least of all repeats. The error is that of a point at the end, relative to the size of the mechanism,
against hht-si2 with much smaller steps, extrapolated. At equal error, times are interpolated, both as logarithms; the
largest ratio counts. Nothing is asserted: times belong to a machine and an hour.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray

import mbdsl

Array = NDArray[np.float64]
ALPHA = -1 / 19  #: damping of high frequencies as with Exudyn's spectral radius of 0.9
#: options of Exudyn's solver: sparse or dense matrices, full or modified Newton
WAYS = {
    "dense": (False, False),
    "dense, modified": (False, True),
    "sparse": (True, False),
    "sparse, modified": (True, True),
}
#: a combination of nodes and solvers that is slower than the best at the largest step by this factor is not run again
HOPELESS = 1.5

TOP = """spatial model Top
  Ground ground(n = {0, 0, -1});
  Body last(m = 15 kg, I = {0.234375, 0.46875, 0.234375} kg.m2, frames(foot = {0, -1, 0} m, tip = {0, 0, 0}));
  Spherical ball(ground, last.foot);
initial equation
  last.y = 1; last.wy = 150; last.wz = -4.61538;
end Top;"""


def chain_text(n: int) -> str:
    """A zigzag of rods of 0.2 m in a horizontal plane, connected by ball joints, which falls."""
    rods = "".join(
        f"  Body link{k}(m = 1 kg, I = {{0.001, 0.004, 0.004}} kg.m2, frames(a = {{-0.1, 0, 0}}, b = {{0.1, 0, 0}}));\n"
        f"  Spherical J{k}({'ground' if k == 0 else f'link{k - 1}.b'}, link{k}.a);\n"
        for k in range(n)
    )
    start = "".join(f"  link{k}.phi = {bend(k)!r};\n" for k in range(n))
    return f"spatial model Chain\n  Ground ground(n = {{0, 0, -1}});\n{rods}initial equation\n{start}end Chain;"


def bend(k: int) -> float:
    return 0.5 * (-1.0) ** k


@dataclass
class Case:
    """A model, its duration [s], the numbers of steps, the point whose error counts, and the size [m]."""

    name: str
    text: str
    stop: float
    steps: tuple[int, ...]
    point: str
    size: float
    theirs: Callable[[Any, Any, Any], tuple[int, list[float]]]  #: builds; returns the body of the point, its place


def their_top(exu: Any, mbs: Any, node: Any) -> tuple[int, list[float]]:
    import exudyn.utilities as eu

    body = mbs.CreateRigidBody(
        inertia=eu.RigidBodyInertia(mass=15, inertiaTensor=np.diag([0.234375, 0.46875, 0.234375])),
        nodeType=node,
        referencePosition=[0, 1, 0],
        initialVelocity=np.cross([0, 150, -4.61538], [0, 1, 0]).tolist(),
        initialAngularVelocity=[0, 150, -4.61538],
        gravity=[0, 0, -9.81],
    )
    ground = mbs.CreateGround()
    mbs.CreateSphericalJoint(itemNumbers=[ground, body], position=[0, 0, 0], useGlobalFrame=True, show=False)
    return body, [0, 0, 0]


def their_chain(n: int) -> Callable[[Any, Any, Any], tuple[int, list[float]]]:
    def build(exu: Any, mbs: Any, node: Any) -> tuple[int, list[float]]:
        import exudyn.utilities as eu

        before, end = mbs.CreateGround(), np.zeros(3)
        for k in range(n):
            c, s = np.cos(bend(k)), np.sin(bend(k))
            body = mbs.CreateRigidBody(
                inertia=eu.RigidBodyInertia(mass=1, inertiaTensor=np.diag([0.001, 0.004, 0.004])),
                nodeType=node,
                referencePosition=(end + 0.1 * np.array([c, s, 0])).tolist(),
                referenceRotationMatrix=np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
                gravity=[0, 0, -9.81],
            )
            mbs.CreateSphericalJoint(itemNumbers=[before, body], position=end.tolist(), useGlobalFrame=True, show=False)
            before, end = body, end + 0.2 * np.array([c, s, 0])
            if k == 3:
                found = body
        return found, [0.1, 0, 0]

    return build


CASES = (
    Case("heavy top", TOP, 0.1, (100, 200, 400, 800), "last", 1.0, their_top),
    Case("chain of 8 ball joints", chain_text(8), 0.5, (125, 250, 500, 1000), "link3.b", 1.6, their_chain(8)),
    Case("chain of 64 ball joints", chain_text(64), 0.5, (125, 250, 500), "link3.b", 12.8, their_chain(64)),
)


def ours(case: Case, steps: int) -> tuple[Array, float]:
    """The point at the end, and seconds, without those of a run of one step."""
    given = {"method": "hht-si2", "options": {"alpha": ALPHA}, "step": case.stop / steps}
    scene = mbdsl.parse(case.text)
    run = mbdsl.simulate(scene, stop=case.stop, interval=case.stop, **given)
    one = mbdsl.simulate(scene, stop=case.stop / steps, interval=case.stop / steps, **given)
    seconds = run.stats["seconds"]["integrate"] - one.stats["seconds"]["integrate"]
    return np.array([run[f"{case.point}.{i}"][-1] for i in "xyz"]), max(seconds, 1e-9)


class Exudyn:
    """A case in Exudyn with one kind of node."""

    def __init__(self, exu: Any, case: Case, node: Any) -> None:
        self.exu, self.case = exu, case
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.body, self.place = case.theirs(exu, self.mbs, node)
        self.mbs.Assemble()

    def run(self, way: str, steps: int, taken: int | None = None) -> tuple[Array, float]:
        sparse, modified = WAYS[way]
        given = self.exu.SimulationSettings()
        t = given.timeIntegration
        t.numberOfSteps, t.endTime = taken or steps, self.case.stop * (taken or steps) / steps
        t.generalizedAlpha.spectralRadius = 0.9
        t.newton.useModifiedNewton = modified
        t.verboseMode = 0
        given.linearSolverType = self.exu.LinearSolverType.EigenSparse if sparse else self.exu.LinearSolverType.EXUdense
        given.solution.file.write = False
        given.solution.sensors.writePeriod = self.case.stop
        given.show.statistics = given.show.computationTime = False
        given.parallel.numberOfThreads = 1
        begin = time.process_time()
        try:
            self.mbs.SolveDynamic(given)
        except self.exu.SolverError:
            return np.full(3, np.inf), np.inf
        seconds = time.process_time() - begin
        found = self.mbs.GetObjectOutputBody(self.body, self.exu.OutputVariableType.Position, self.place)
        return np.array(found, float), seconds

    def time(self, way: str, steps: int) -> tuple[Array, float]:
        """Without preparations and the first step."""
        found, whole = self.run(way, steps)
        return found, max(whole - self.run(way, steps, 1)[1], 1e-9) if whole < np.inf else np.inf


def compare(exu: Any, case: Case, repeats: int) -> list[str]:
    fine = 8 * case.steps[-1]
    coarse_end, fine_end = ours(case, fine // 2)[0], ours(case, fine)[0]
    true = fine_end + (fine_end - coarse_end) / 3
    kinds = exu.NodeType
    nodes = {"rotation vectors": kinds.RotationRotationVector, "Euler parameters": kinds.RotationEulerParameters}
    programs = {(name, way): Exudyn(exu, case, node) for name, node in nodes.items() for way in WAYS}

    def error(found: Array) -> float:
        return float(np.abs(found - true).max()) / case.size

    first = {key: p.time(key[1], case.steps[0]) for key, p in programs.items()}
    least = min(seconds for _, seconds in first.values())
    kept = {key: p for key, p in programs.items() if first[key][1] <= HOPELESS * least}
    best: dict[str, dict[int, tuple[float, float]]] = {"mbdsl": {}, **{" ".join(key): {} for key in kept}}
    for _ in range(repeats):
        for steps in case.steps:
            runs = {"mbdsl": ours(case, steps), **{" ".join(k): p.time(k[1], steps) for k, p in kept.items()}}
            for name, (found, seconds) in runs.items():
                before = best[name].get(steps, (0.0, np.inf))[1]
                best[name][steps] = error(found), min(before, seconds)
    lines = [f"{case.name}: microseconds a step, and error"]
    for name, rows in best.items():
        cells = [f"{1e6 * s / n:8.2f} {e:8.1e}" for n, (e, s) in rows.items()]
        lines.append(f"  {name:34} {'   '.join(cells)}")
    steps = case.steps[-1]
    theirs = min((n for n in best if n != "mbdsl"), key=lambda n: best[n][steps][1])
    lines.append(f"  equal step: {best['mbdsl'][steps][1] / best[theirs][steps][1]:.3f} of the time of {theirs}")
    ratios = [at_equal_error(best["mbdsl"], rows) for name, rows in best.items() if name != "mbdsl"]
    known = [max(r) for r in ratios if r]
    lines.append(f"  equal error: {max(known):.3f} of the time of the best" if known else "  equal error: void")
    return lines


def at_equal_error(one: dict[int, tuple[float, float]], other: dict[int, tuple[float, float]]) -> list[float]:
    """Ratios of times at the errors of ``one`` that ``other`` reaches."""
    e, s = (np.log([row[k] for row in other.values()])[::-1] for k in (0, 1))
    if not np.isfinite(e).all() or (np.diff(e) <= 0).any():
        return []
    found = []
    for error, seconds in one.values():
        if e[0] <= np.log(error) <= e[-1]:
            found.append(seconds / float(np.exp(np.interp(np.log(error), e, s))))
    if not found:  # mbdsl is more accurate with its largest step than Exudyn with its smallest one: by its order, 2
        error, seconds = one[min(one)]
        found.append(seconds / float(np.exp(s[0] + 0.5 * (e[0] - np.log(error)))))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", help="name of a case")
    parser.add_argument("--repeats", type=int, default=3)
    given = parser.parse_args()
    import exudyn

    for case in CASES:
        if given.only in (None, case.name):
            print("\n".join(compare(exudyn, case, given.repeats)), flush=True)


if __name__ == "__main__":
    main()
