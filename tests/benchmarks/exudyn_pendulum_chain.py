"""mbdsl against Exudyn: the same models, steps and machine, warm, alternately in one process, one thread.

    python tests/benchmarks/exudyn_pendulum_chain.py [--repeats 7]

Two models: the point-mass pendulum (models/pendulum.mbd, 1e5 steps of 1e-4 s) and the chain of eight links
(models/chain.mbd, 5000 steps of 1e-3 s). Exudyn runs its generalised-alpha solver with every combination of dense or
sparse matrices and full or modified Newton; the fastest counts. Times are of the step loops: of Exudyn, a run of one
step is subtracted, of mbdsl, building and compiling are left out. A row is void unless both end at the same place, to
the methods' own error as halving mbdsl's step shows it. Nothing is asserted: times belong to a machine and an hour.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from statistics import median

import numpy as np

import mbdsl
from mbdsl import graph
from mbdsl.integrators import driver
from mbdsl.integrators.run import Integration
from mbdsl.layout import Q0
from mbdsl.system import build
from mbdsl.system.initial import initial_state

MODELS = Path(__file__).parents[2] / "models"
METHODS = ("hht-i3", "hht-si2")
#: how many times the methods' error end states may differ: Exudyn's method has another error constant
AGREE = 20.0


@dataclass(frozen=True)
class Case:
    name: str
    h: float
    steps: int
    exudyn: Callable  #: exudyn -> (container, system), and the reference coordinates that its results count from


def exudyn_pendulum(exu):
    from exudyn import itemInterface as item

    container = exu.SystemContainer()
    mbs = container.AddSystem()
    node = mbs.AddNode(item.NodePoint2D(referenceCoordinates=[-1, 0]))
    mbs.AddObject(item.MassPoint2D(physicsMass=1, nodeNumber=node))
    ground = mbs.AddObject(item.ObjectGround())
    origin = mbs.AddMarker(item.MarkerBodyPosition(bodyNumber=ground, localPosition=[0, 0, 0]))
    mass = mbs.AddMarker(item.MarkerNodePosition(nodeNumber=node))
    mbs.AddObject(item.DistanceConstraint(markerNumbers=[origin, mass], distance=1))
    mbs.AddLoad(item.Force(markerNumber=mass, loadVector=[0, -9.81, 0]))
    mbs.Assemble()
    return container, mbs, np.array([-1.0, 0.0])


def exudyn_chain(exu, n=8):
    from exudyn import itemInterface as item

    container = exu.SystemContainer()
    mbs = container.AddSystem()
    ground = mbs.AddObject(item.ObjectGround())
    end = mbs.AddMarker(item.MarkerBodyPosition(bodyNumber=ground, localPosition=[0, 0, 0]))
    reference = []
    for i in range(n):
        place = [i + 0.5, 0.0, 0.0]
        reference += place
        node = mbs.AddNode(item.NodeRigidBody2D(referenceCoordinates=place))
        body = mbs.AddObject(item.RigidBody2D(physicsMass=1, physicsInertia=1 / 12, nodeNumber=node))
        a = mbs.AddMarker(item.MarkerBodyPosition(bodyNumber=body, localPosition=[-0.5, 0, 0]))
        b = mbs.AddMarker(item.MarkerBodyPosition(bodyNumber=body, localPosition=[0.5, 0, 0]))
        mbs.AddObject(item.RevoluteJoint2D(markerNumbers=[end, a]))
        weight = mbs.AddMarker(item.MarkerBodyMass(bodyNumber=body))
        mbs.AddLoad(item.Gravity(markerNumber=weight, loadVector=[0, -9.81, 0]))
        end = b
    mbs.Assemble()
    return container, mbs, np.array(reference)


CASES = (Case("pendulum", 1e-4, 100_000, exudyn_pendulum), Case("chain", 1e-3, 5_000, exudyn_chain))


def settings(exu, h: float, steps: int, sparse: bool, modified: bool):
    s = exu.SimulationSettings()
    s.timeIntegration.numberOfSteps, s.timeIntegration.endTime = steps, steps * h
    s.timeIntegration.verboseMode = 0
    s.timeIntegration.newton.useModifiedNewton = modified
    s.solutionSettings.writeSolutionToFile = False
    s.solutionSettings.sensorsWritePeriod = steps * h
    s.linearSolverType = exu.LinearSolverType.EigenSparse if sparse else exu.LinearSolverType.EXUdense
    s.parallel.numberOfThreads = 1
    return s


def run_exudyn(exu, case: Case, steps: int, sparse: bool, modified: bool) -> tuple[float, np.ndarray]:
    """Seconds of the step loop, and the coordinates at the end."""

    def once(n: int) -> tuple[float, np.ndarray]:
        _container, mbs, reference = case.exudyn(exu)
        options = settings(exu, case.h, n, sparse, modified)
        begun = time.perf_counter()
        mbs.SolveDynamic(options)
        return time.perf_counter() - begun, reference + np.array(mbs.systemData.GetODE2Coordinates())

    start, _ = once(1)
    total, end = once(steps)
    return total - start, end


def run_mbdsl(case: Case, method: str, h: float, steps: int) -> tuple[float, np.ndarray]:
    """The same of mbdsl; no output but the end."""
    scene = mbdsl.load(MODELS / f"{case.name}.mbd")
    mechanism = graph.build(scene)
    system = build(scene, mechanism)
    stop = steps * h
    run = Integration(system, method, h, 0.0, stop, np.array([stop]))
    s = initial_state(system, mechanism, 0.0)
    run.begin(s.q, s.v, s.a, s.lam)
    begun = time.perf_counter()
    status = run.advance()
    seconds = time.perf_counter() - begun
    assert status == driver.DONE
    return seconds, run.Y[Q0, : system.n].copy()


def compare(exu, case: Case, steps: int, repeats: int) -> list[str]:
    """Rows of the table for one model."""
    ways = [(sparse, modified) for sparse in (False, True) for modified in (False, True)]
    for method in METHODS:  # compiles
        run_mbdsl(case, method, case.h, 1)
    theirs: dict[tuple[bool, bool], list[float]] = {way: [] for way in ways}
    ours: dict[str, list[float]] = {method: [] for method in METHODS}
    ends: dict[object, np.ndarray] = {}
    for _ in range(repeats):
        for way in ways:
            seconds, ends[way] = run_exudyn(exu, case, steps, *way)
            theirs[way].append(seconds / steps * 1e6)
            for method in METHODS:
                seconds, ends[method] = run_mbdsl(case, method, case.h, steps)
                ours[method].append(seconds / steps * 1e6)
    best = min(ways, key=lambda way: median(theirs[way]))
    rows = []
    for way in ways:
        name = f"Exudyn {'sparse' if way[0] else 'dense'}, {'modified' if way[1] else 'full'} Newton"
        mark = " *" if way == best else ""
        rows.append(f"{case.name:10} {name:31} {min(theirs[way]):8.2f} {median(theirs[way]):8.2f}{mark}")
    for method in METHODS:
        _, finer = run_mbdsl(case, method, case.h / 2, 2 * steps)
        error = np.abs(ends[method] - finer).max() * 4 / 3
        gap = np.abs(ends[method] - ends[best]).max()
        verdict = "" if gap <= AGREE * error + 1e-12 else "  VOID: other end state"
        a, b = min(ours[method]) / min(theirs[best]), median(ours[method]) / median(theirs[best])
        rows.append(
            f"{case.name:10} {'mbdsl ' + method:31} {min(ours[method]):8.2f} {median(ours[method]):8.2f}"
            f"   1/{1 / a:<5.1f} 1/{1 / b:<5.1f} {gap:9.1e} {error:9.1e}{verdict}"
        )
    return rows


def table(steps: int | None = None, repeats: int = 5) -> str:
    """The whole comparison as text; ``steps`` shortens it."""
    import exudyn as exu

    head = f"{'model':10} {'program':31} {'us/step':>8} {'':>8}   {'ratio':7} {'':7} {'end states':>9} {'error of'}\n"
    head += f"{'':10} {'':31} {'min':>8} {'median':>8}   {'min':7} {'median':7} {'differ by':>9} {'mbdsl':>9}"
    rows = [row for case in CASES for row in compare(exu, case, steps or case.steps, repeats)]
    note = f"mbdsl {mbdsl.__version__}, Exudyn {version('exudyn')}; * is what ratios are to"
    return "\n".join([head, *rows, note])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--steps", type=int, default=None, help="fewer steps, for a quick look")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", DeprecationWarning)  # Exudyn renames its items from time to time
    print(table(arguments.steps, arguments.repeats))
