"""mbdsl against Exudyn: the same models on one machine, warm, alternately in one process, one thread.

    python tests/benchmarks/against_exudyn.py [--only NAME] [--repeats 5] [--steps N]

Exudyn runs its generalised-alpha solver with its default settings, in the build without range checks where the
processor allows it, with every combination of dense or sparse matrices and full or modified Newton; the fastest counts.
Of mbdsl, hht-i3 and hht-si2 run with their default settings except alpha, which is chosen for the same damping of high
frequencies as with Exudyn's default spectral radius. Times are of the step loops from the second step on: of Exudyn,
the time of a run of one step is subtracted, to leave out its preparations; of mbdsl, only these steps are timed.
Processor time is measured, which a busy machine disturbs less.

Every program runs with a step, its half, its quarter and so on. At equal step, times are compared as they are. At equal
error, time is interpolated over error, both as logarithms, and compared at three errors that all programs reach; the
largest ratio counts. The error is that of the coordinates at four times, relative to the size of the mechanism, against
hht-si2 at steps much smaller, extrapolated. Exudyn with tolerances much tighter, extrapolated as well, has to arrive at
the same, or the row is void. Nothing is asserted: times belong to a machine and an hour.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # idle BLAS threads spin, which counts as processor time

import numpy as np
from numpy.typing import NDArray

import mbdsl
from mbdsl.expressions.symbolic import Expr
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.mechanism import graph
from mbdsl.system import build

Array = NDArray[np.float64]

MODELS = Path(__file__).parents[2] / "models"
METHODS = ("hht-i3", "hht-si2")
ALPHA = -1 / 19  #: (1 + alpha)/(1 - alpha) = 0.9, the spectral radius at infinity that is Exudyn's default
#: options of Exudyn's solver: sparse or dense matrices, full or modified Newton
WAYS = {
    "dense": (False, False),
    "dense, modified": (False, True),
    "sparse": (True, False),
    "sparse, modified": (True, True),
}
DENSE_LIMIT = 512  #: number of bodies above which dense matrices are not tried: a factorisation takes minutes
#: an option that is slower than the best by this factor at the largest step is not run at smaller steps, if the
#: difference is more than JUDGED
HOPELESS = 2.5
JUDGED = 0.01  #: [s]
LEAST = 1e-9  #: least difference of two times [s]: noise can make the difference negative
FIRST_STARTS = 4  #: runs of one step before the first one is subtracted
TIMES = 4  #: times at which errors are measured, spaced evenly over the run
AGREE = 0.2  #: largest difference of the two extrapolated solutions, relative to the smallest error that is compared
#: factors on Exudyn's tolerances for the extrapolated solution: the first that its Newton iteration reaches is used
TIGHTER = (1e-3, 1e-2, 1e-1, 1.0)
NOTICEABLE = 0.1  #: a note is printed if the tolerance of the iteration contributes more than this part of the error


@dataclass(frozen=True)
class Case:
    name: str
    stop: float
    steps: int  #: with the largest step; divisible by TIMES
    target: float  #: target ratio of times at equal error
    model: str = ""  #: model, if its name differs
    n: int | None = None  #: loops or links
    halvings: int = 3

    @property
    def path(self) -> Path:
        return MODELS / f"{self.model or self.name}.mbd"

    @property
    def parameters(self) -> dict[str, str | float]:
        return {} if self.n is None else {"N": self.n}


CASES = (
    Case("pendulum", 10.0, 4000, 0.10),
    Case("slider_crank", 2.0, 1000, 0.10),
    Case("seven_body", 0.03, 1000, 0.12),
    Case("four_bar_2", 2.0, 1000, 0.12, "four_bar", 2),  # through two singular poses
    Case("four_bar_40", 0.5, 100, 0.15, "four_bar", 40),
    Case("chain_8", 2.0, 1000, 0.15, "chain", 8),
    Case("chain_64", 0.2, 100, 0.15, "chain", 64),
    Case("chain_512", 0.04, 20, 0.20, "chain", 512),
    Case("chain_4096", 0.04, 20, 0.20, "chain", 4096, 2),
)


@dataclass
class Seen:
    """One run: seconds from the second step on, coordinates at the times of comparison, and counts per step."""

    seconds: float
    states: Array  #: (TIMES, n)
    iterations: float
    matrices: float
    whole: bool = True  #: all steps had the requested size


class Ours:
    """The model in mbdsl."""

    def __init__(self, case: Case, stop: float) -> None:
        self.stop = stop
        self.scene = mbdsl.load(case.path, case.parameters)
        mechanism = graph.build(self.scene)
        self.system = build(self.scene, mechanism)
        self.start = initial_state(self.system, mechanism, 0.0)

    def run(self, method: str, steps: int) -> Seen:
        times = np.linspace(0.0, self.stop, TIMES + 1)[1:]
        run = MethodRun(self.system, method, self.stop / steps, 0.0, self.stop, times, {"alpha": ALPHA})
        s = self.start
        run.begin(s.q, s.v, s.a, s.lam, s.redundant)
        run.advance(1)
        begun = time.process_time()
        status = run.advance()
        seconds = time.process_time() - begun
        n, J = self.system.n, run.integers
        whole = status == S.DONE
        return Seen(seconds, run.out[:, :n], J[S.ITERATIONS] / steps, J[S.MATRICES] / steps, whole)


class Theirs:
    """The same model and start in Exudyn, whose displacements count from the start. Coordinates are stored at
    ``points`` times."""

    def __init__(self, exu: Any, ours: Ours, points: int = TIMES) -> None:
        from exudyn import itemInterface as item

        self.exu, self.item, self.stop, self.n, self.points = exu, item, ours.stop, ours.system.n, points
        self.solver = exu.DynamicSolverType.GeneralizedAlpha
        self.starts: dict[tuple, list[float]] = {}  #: seconds of runs of one step, by solver, option and tolerance
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.scene = ours.scene
        self.objects: dict[str, int] = {}
        self.markers: dict[tuple, int] = {}
        self.offsets: dict[str, tuple[float, float]] = {}  #: from the centre of mass to the compared point
        self.places: list[tuple[slice, tuple[float, float] | None]] = []
        self.gravity = np.zeros(2)
        for c in self.scene.components.values():
            if c.kind.name == "PointOnLine":  # Exudyn's constraint on a coordinate replaces a line
                tip = self.scene.frames[c.ports["frame_b"]]
                self.offsets[tip.body] = tip.x, tip.y
        for c in self.scene.components.values():
            if c.kind.name == "Ground":
                self.objects[c.name] = self.mbs.AddObject(item.ObjectGround())
                self.gravity = np.array(c.values["n"]) * c.values["g"]
        self.nodes = {c.name: self._body(c, ours) for c in self.scene.bodies()}
        for c in self.scene.components.values():
            if "frame_b" in c.ports:
                self._between(c.kind.name, c.values, c.ports["frame_a"], c.ports["frame_b"])
        self.sensors = [self.mbs.AddSensor(self._sensor(node)) for node in self.nodes.values()]
        self.mbs.Assemble()
        self.reference = np.array(self.mbs.systemData.GetODE2Coordinates(exu.ConfigurationType.Reference))

    def _sensor(self, node: int) -> Any:
        coordinates = self.exu.OutputVariableType.Coordinates
        return self.item.SensorNode(
            nodeNumber=node, outputVariableType=coordinates, storeInternal=True, writeToFile=False
        )

    def _body(self, c: Any, ours: Ours) -> int:
        item, mbs, values = self.item, self.mbs, c.values
        first = ours.system.tables.coordinates[c.name]
        own = slice(first, first + len(c.kind.coordinates))
        q, v, m = ours.start.q[own].copy(), ours.start.v[own].copy(), values["m"]
        if c.kind.name == "PointMass":
            node = mbs.AddNode(item.NodePoint2D(referenceCoordinates=q, initialVelocities=v))
            body = item.MassPoint2D(mass=m, nodeNumber=node)
            self.places.append((own, None))
        elif c.kind.name in ("Body", "Rod"):
            x, y = self.offsets.setdefault(c.name, (0.0, 0.0))
            self.places.append((own, (-x, -y)))
            q, v = displaced(q, v, x, y)
            node = mbs.AddNode(item.NodeRigidBody2D(referenceCoordinates=q, initialVelocities=v))
            inertia = values["I"] + m * (x * x + y * y)  # about the node
            body = item.RigidBody2D(mass=m, inertia=inertia, centerOfMass=[-x, -y], nodeNumber=node)
        else:
            raise ValueError(f"{c.kind.name} has no counterpart here")
        self.objects[c.name] = mbs.AddObject(body)
        if self.gravity.any():
            weight = mbs.AddMarker(item.MarkerBodyMass(bodyNumber=self.objects[c.name]))
            mbs.AddLoad(item.Gravity(markerNumber=weight, loadVector=[*self.gravity, 0.0]))
        return node

    def _between(self, kind: str, values: Mapping[str, Any], a: str, b: str) -> None:
        item, mbs = self.item, self.mbs
        if kind == "Revolute":
            mbs.AddObject(item.RevoluteJoint2D(markerNumbers=[self._marker(a), self._marker(b)]))
        elif kind == "Distance":
            ends = [self._marker(a), self._marker(b)]
            mbs.AddObject(item.DistanceConstraint(markerNumbers=ends, distance=values["length"]))
        elif kind == "PointOnLine":
            line = self.scene.frames[a]
            assert line.body not in self.nodes and line.y == line.phi == 0.0  # the x axis
            ground = mbs.AddNode(item.NodePointGround())
            still = mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=ground, coordinate=1))
            node = self.nodes[self.scene.frames[b].body]
            height = mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=1))
            mbs.AddObject(item.CoordinateConstraint(markerNumbers=[still, height]))
        elif kind == "SpringDamper":
            mbs.AddObject(
                item.SpringDamper(
                    markerNumbers=[self._marker(a), self._marker(b)],
                    referenceLength=values["s0"],
                    stiffness=values["k"],
                    damping=values["c"],
                )
            )
        elif kind == "Torque":
            assert self.scene.frames[a].body not in self.nodes and isinstance(values["tau"], Expr)
            on = self._marker(b, self.item.MarkerBodyRigid)
            mbs.AddLoad(item.Torque(markerNumber=on, loadVector=[0.0, 0.0, values["tau"].value]))
        else:
            raise ValueError(f"{kind} has no counterpart here")

    def _marker(self, name: str, kind: Any = None) -> int:
        """The marker at a frame."""
        kind = kind or self.item.MarkerBodyPosition
        if (name, kind) not in self.markers:
            frame = self.scene.frames[name]
            x, y = self.offsets.get(frame.body, (0.0, 0.0))
            place = [frame.x - x, frame.y - y, 0.0]
            marker = kind(bodyNumber=self.objects[frame.body], localPosition=place)
            self.markers[name, kind] = self.mbs.AddMarker(marker)
        return self.markers[name, kind]

    def start(self) -> tuple[Array, Array]:
        """Initial q and v of the centres of mass, in the convention of mbdsl."""
        initial = self.exu.ConfigurationType.Initial
        q = self.reference + self.mbs.systemData.GetODE2Coordinates(initial)
        return self._centres(q, np.array(self.mbs.systemData.GetODE2Coordinates_t(initial)))

    def _centres(self, q: Array, v: Array) -> tuple[Array, Array]:
        found, rates = q.copy(), v.copy()
        for own, offset in self.places:
            if offset is not None:
                found[own], rates[own] = displaced(q[own], v[own], *offset)
        return found, rates

    def run(self, way: str, steps: int, tighter: float = 1.0) -> Seen:
        start = self._start(way, steps, tighter)
        total, done = self._once(way, steps, steps, tighter)
        data = [self.mbs.GetSensorStoredData(sensor) for sensor in self.sensors]
        moved = np.hstack([x[1:, 1:] for x in data])  # without the start, and the column of times
        it = self.mbs.sys["dynamicSolver"].it
        done = done and it.currentStepIndex == steps + 1 and len(moved) == self.points
        states = np.full((self.points, self.n), np.nan)
        if done:
            states[:] = [self._centres(self.reference + q, np.zeros(self.n))[0] for q in moved]
        return Seen(max(total - start, LEAST), states, it.newtonStepsCount / steps, it.newtonJacobiCount / steps, done)

    def _start(self, way: str, steps: int, tighter: float = 1.0) -> float:
        """The least seconds of a run of one step so far: a larger value would make the difference too small."""
        known = self.starts.setdefault((str(self.solver), way, tighter), [])
        for _ in range(1 if known else FIRST_STARTS):
            known.append(self._once(way, steps, 1, tighter)[0])
        return min(known)

    def _set(self, t: Any) -> None:
        """Further settings of the time integration."""

    def _once(self, way: str, steps: int, taken: int, tighter: float) -> tuple[float, bool]:
        """The first ``steps`` steps: seconds, and whether the run succeeded."""
        sparse, modified = WAYS[way]
        s, kinds = self.exu.SimulationSettings(), self.exu.LinearSolverType
        t = s.timeIntegration
        t.numberOfSteps, t.endTime = taken, self.stop * taken / steps
        t.newton.useModifiedNewton = modified
        t.newton.relativeTolerance *= tighter
        t.newton.absoluteTolerance *= tighter
        self._set(t)
        s.solutionSettings.writeSolutionToFile = False
        s.solutionSettings.sensorsWritePeriod = self.stop / self.points
        s.linearSolver.solverType = kinds.EigenSparse if sparse else kinds.EXUdense
        s.parallel.numberOfThreads = 1
        begun = time.process_time()
        try:
            done = bool(self.mbs.SolveDynamic(s, solverType=self.solver))
        except self.exu.SolverError:
            done = False
        return time.process_time() - begun, done


def displaced(q: Array, v: Array, x: float, y: float) -> tuple[Array, Array]:
    """Position and velocity of the point (x, y) of a rigid body."""
    c, s = np.cos(q[2]), np.sin(q[2])
    dx, dy = c * x - s * y, s * x + c * y
    return q + np.array([dx, dy, 0.0]), v + v[2] * np.array([-dy, dx, 0.0])


@dataclass
class Curve:
    """Measurements of one program at all its steps, largest step first."""

    seconds: list[list[float]] = field(default_factory=list)  #: of each round
    errors: list[float] = field(default_factory=list)
    seen: list[Seen] = field(default_factory=list)

    def at(self, error: float, seconds: Array) -> float:
        """Seconds at an error within its range, by interpolation."""
        order = np.argsort(self.errors)
        return float(np.exp(np.interp(np.log(error), np.log(self.errors)[order], np.log(seconds)[order])))


@dataclass
class Comparison:
    """The comparison of one model: a curve for each program, and the reasons why it is invalid."""

    case: Case
    sizes: list[int]  #: numbers of steps
    stop: float
    curves: dict[str, Curve] = field(default_factory=dict)
    void: str = ""
    gap: float = 0.0
    notes: list[str] = field(default_factory=list)

    @property
    def ways(self) -> list[str]:
        return [name for name in self.curves if name in WAYS]

    def rounds(self) -> list[dict[str, Array]]:
        """The seconds of every program over its steps, in each round."""
        count = len(next(iter(self.curves.values())).seconds)
        return [{name: np.array(curve.seconds[k]) for name, curve in self.curves.items()} for k in range(count)]

    def smallest(self) -> dict[str, Array]:
        """The same, of the fastest runs of all rounds."""
        return {name: np.array(curve.seconds).min(axis=0) for name, curve in self.curves.items()}

    def at_step(self, method: str, k: int) -> tuple[float, float]:
        """Ratio of times at equal step: of the minima, and the median over rounds."""

        def ratio(seconds: dict[str, Array]) -> float:
            return float(seconds[method][k] / min(seconds[way][k] for way in self.ways))

        return ratio(self.smallest()), float(np.median([ratio(r) for r in self.rounds()]))

    def errors(self) -> Array:
        """Three errors that every program reaches; none if there are no such errors."""
        low = max(min(curve.errors) for curve in self.curves.values())
        high = min(max(curve.errors) for curve in self.curves.values())
        return np.geomspace(high, low, 3) if high > low > 0.0 else np.array([])

    def at_error(self, method: str, error: float) -> tuple[float, float]:
        """The same at equal error."""

        def ratio(seconds: dict[str, Array]) -> float:
            of = {name: self.curves[name].at(error, seconds[name]) for name in [method, *self.ways]}
            return of[method] / min(of[way] for way in self.ways)

        return ratio(self.smallest()), float(np.median([ratio(r) for r in self.rounds()]))

    def headline(self) -> tuple[float, float]:
        """Ratio at the worst of the errors, with our fastest method there: of the minima, and the median over
        rounds."""
        best = [min((self.at_error(m, e) for m in METHODS), key=lambda r: r[1]) for e in self.errors()]
        return max(r[0] for r in best), max(r[1] for r in best)


def compare(exu: Any, case: Case, repeats: int, steps: int | None = None) -> Comparison:
    """Run both programs alternately on one model; ``steps`` limits the number of the largest steps."""
    first = steps or case.steps
    first += -first % TIMES
    found = Comparison(case, [first * 2**k for k in range(case.halvings + 1)], case.stop * first / case.steps)
    ours = Ours(case, found.stop)
    theirs = Theirs(exu, ours)
    scale = ours.system.tables.scale

    def distance(a: Array, b: Array) -> float:
        return float((np.abs(a - b) * scale).max())

    q, v = theirs.start()
    start = ours.start
    if max(distance(q, start.q), found.stop * distance(v, start.v)) > 1e-13:
        found.void = "other start"
        return found
    coarse, fine = (ours.run("hht-si2", k * found.sizes[-1]).states for k in (2, 4))
    true = (4 * fine - coarse) / 3

    # The solution of Exudyn's method without the error due to its tolerances.
    for tighter in TIGHTER:
        sharp = [theirs.run("sparse", n, tighter) for n in found.sizes[-2:]]
        if all(seen.whole for seen in sharp):
            break
    found.gap = distance((4 * sharp[1].states - sharp[0].states) / 3, true)
    dense = case.n is None or case.n < DENSE_LIMIT
    tried = [way for way, (sparse, _) in WAYS.items() if sparse or dense]
    if not dense:
        found.notes.append("dense matrices are not tried: hopeless at this size")
    once = {way: theirs.run(way, first).seconds for way in tried}
    kept = [way for way in tried if once[way] <= HOPELESS * min(once.values()) + JUDGED]
    found.curves = {name: Curve() for name in (*METHODS, *kept)}
    for name, curve in found.curves.items():
        program = theirs if name in WAYS else ours
        curve.seen = [program.run(name, n) for n in found.sizes]
        curve.errors = [distance(seen.states, true) for seen in curve.seen]
        if not all(seen.whole for seen in curve.seen):
            found.void = f"{name} did not come through with steps of this size"
            return found
    for way in kept:
        least = found.curves[way].errors[-1]
        if (by := distance(found.curves[way].seen[-1].states, sharp[1].states)) > NOTICEABLE * least:
            found.notes.append(f"Exudyn {way}: its tolerance makes {by:.0e} of the error {least:.0e} at the last step")
    least = min(found.curves[way].errors[-1] for way in kept)
    if not found.void and not found.gap <= AGREE * least:
        found.void = f"Exudyn tends elsewhere: {found.gap:.0e} away, at an error of {least:.0e}"

    for curve in found.curves.values():
        curve.seconds = [[0.0] * len(found.sizes) for _ in range(repeats)]
    for r in range(repeats):
        for k, n in enumerate(found.sizes):
            for name, curve in found.curves.items():
                curve.seconds[r][k] = (theirs if name in WAYS else ours).run(name, n).seconds
    return found


def rows(c: Comparison) -> list[str]:
    """The tables of one model."""
    lines = [f"{c.case.name}, {c.stop:g} s"]
    if not c.curves or not next(iter(c.curves.values())).seconds:
        return [*lines, f"  VOID: {c.void}"]
    smallest = c.smallest()
    for k, n in enumerate(c.sizes):
        for name, curve in c.curves.items():
            us = 1e6 / (n - 1) * np.array([smallest[name][k], np.median([r[k] for r in curve.seconds])])
            seen = curve.seen[k]
            text = f"{us[0]:10.2f} {us[1]:10.2f} {curve.errors[k]:9.1e} {seen.iterations:6.2f} {seen.matrices:6.2f}"
            who, ratio = f"Exudyn {name}", ""
            if name in METHODS:
                low, middle = c.at_step(name, k)
                who, ratio = f"mbdsl {name}", f"   {low:5.3f} {middle:6.3f}"
            lines.append(f"  {n:7d} {who:23} {text}{ratio}")
    for e in c.errors():
        ratios = [(name, *c.at_error(name, e)) for name in METHODS]
        ratio_text = ", ".join(f"{name} {low:.3f} {middle:.3f}" for name, low, middle in ratios)
        lines.append(f"  at an error of {e:.1e}: {ratio_text}")
    lines.append(f"  extrapolated, the programs differ by {c.gap:.0e}")
    lines += [f"  {note}" for note in c.notes]
    return lines


def worst(c: Comparison) -> tuple[tuple[float, float], tuple[float, float]]:
    """The largest ratios at equal step and at equal error: of the minima, and the median over rounds."""
    step = [min((c.at_step(m, k) for m in METHODS), key=lambda r: r[1]) for k in range(len(c.sizes))]
    return (max(r[0] for r in step), max(r[1] for r in step)), c.headline()


def verdict(c: Comparison) -> str:
    """The line of one model in the summary."""
    if c.void:
        return f"{c.case.name:14} VOID: {c.void}"
    if not len(c.errors()):
        return f"{c.case.name:14} VOID: no error that all of them reach"
    at_step, at_error = worst(c)
    met = "met" if at_error[1] <= c.case.target else "MISSED"
    return (
        f"{c.case.name:14} {at_step[0]:8.3f} {at_step[1]:8.3f}   {at_error[0]:8.3f} {at_error[1]:8.3f}"
        f"   {c.case.target:6.2f} {met}"
    )


def load() -> Any:
    """Exudyn, in the build without range checks if this processor has one."""
    sys.exudynFast = True  # type: ignore[attr-defined]
    import exudyn

    return exudyn


def table(steps: int | None = None, repeats: int = 5, only: str | None = None, cases: tuple[Case, ...] = CASES) -> str:
    """The whole comparison as text; ``steps`` shortens it."""
    exu = load()
    fast = "without" if "exudyn.exudynCPPfast" in sys.modules else "with"
    head = f"  {'steps':>7} {'program':23} {'us/step':>10} {'':10} {'error':>9} {'iter.':>6} {'matr.':>6}   ratio\n"
    head += f"  {'':7} {'':23} {'min':>10} {'median':>10} {'':9} {'a step':>6} {'a step':>6}   {'min':>5} median"
    lines = [f"mbdsl {mbdsl.__version__}, Exudyn {version('exudyn')} {fast} range checks", head]
    found = []
    for case in cases:
        if only is None or only in (case.name, case.model):
            found.append(compare(exu, case, repeats, steps))
            lines += rows(found[-1])
    lines += [
        "",
        "Time over Exudyn's, at the worst step and the worst error, with the better of our methods there",
        f"{'':14} {'equal step':17}   {'equal error':17}   target",
        f"{'':14} {'min':>8} {'median':>8}   {'min':>8} {'median':>8}   (median)",
        *map(verdict, found),
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", metavar="NAME", help="one model: a name of the summary, or of a file")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--steps", type=int, default=None, help="fewer steps, for a quick look")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", DeprecationWarning)  # Exudyn renames its items from time to time
    print(table(arguments.steps, arguments.repeats, arguments.only))
