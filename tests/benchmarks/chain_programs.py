"""The pendulum chain in mbdsl, MuJoCo and Exudyn, each with all settings that are compared, and a reference.

The chain is that of models/chain.mbd: N uniform rods with a mass of 1 kg and a length of 1 m, one behind the other on
hinges, which start horizontally and at rest. Compared are the absolute angles of the rods at four times.

- Reference: the equations of Lagrange in the N angles, with the mass matrix written out, solved by SciPy's DOP853 at
  the tolerance ``TIGHT``. It has no code in common with the programs.
- MuJoCo: bodies with hinges and given inertias, without geometry; RK4, the only integrator of an order above 1, with
  all parts disabled that the chain does not need, and dense or sparse matrices. A run is one call of ``mj_step`` in C.
- Exudyn, explicit: ``ObjectKinematicTree``, which has the angles of the hinges as coordinates. Its explicit solvers
  cannot solve for joints between bodies.
- Exudyn, implicit: the same tree, and bodies with ``RevoluteJoint2D``.

Times are processor times of one thread. They begin with the first step in mbdsl and MuJoCo, and with the second in
Exudyn, because the time of a run of one step is subtracted.
"""

from __future__ import annotations

import importlib.util
import math
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import against_exudyn
import numpy as np
from against_exudyn import LEAST, WAYS, Case, Seen, Theirs
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import mbdsl
from mbdsl.errors import MbdslError
from mbdsl.integrators import available
from mbdsl.integrators.loop import loop_state as S
from mbdsl.mechanism import graph
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.plan import plan
from mbdsl.simulation.run_options import RunOptions
from mbdsl.simulation.tolerance_calibration import calibrated

Array = NDArray[np.float64]

MODEL = against_exudyn.MODELS / "chain.mbd"
MASS, LENGTH, GRAVITY = 1.0, 1.0, 9.81  #: those of the model
INERTIA = MASS * LENGTH**2 / 12.0  #: of a rod about its centre
THICKNESS = 1e-3  #: moment of inertia about the rod [kg m^2], which the planar motion does not depend on
STOP, POINTS = 1.0, against_exudyn.TIMES
TIGHT = 1e-13
FIRST, LEVELS = 8, 18  #: least number of steps, and how often it is doubled at most
TOLERANCES = [10.0 ** (-k / 2) for k in range(4, 23)]
EVERY_STEP = 1 << 40  #: more steps than a run has
TRIED = 64  #: number of steps with which Exudyn's options are compared
NEAR, MOST = 1.3, 3  #: options that take at most this times the least time are kept, and how many of them at most
PROGRAMS = ("mbdsl", "MuJoCo", "Exudyn explicit", "Exudyn implicit")


@dataclass(frozen=True)
class Series:
    """A program with one setting: its runs at ``sizes``, coarse to fine, which are numbers of steps or tolerances.

    ``run(size)`` returns the seconds, and the largest error of an angle, which is infinite if the run failed.
    """

    program: str
    name: str
    sizes: Sequence[float]
    run: Callable[[float], tuple[float, float]]
    order: int = 0


class Reference:
    """The angles of the rods (N,) [rad] at any times."""

    def __init__(self, n: int, tol: float = TIGHT) -> None:
        k = np.arange(1, n + 1)
        behind = n - np.maximum.outer(k, k) + 0.5  # rods that both joints carry, in masses of a rod
        inertia = MASS * LENGTH**2 * (behind - np.diag(np.full(n, 1.0 / 6.0)))
        weight = MASS * GRAVITY * LENGTH * (n - k + 0.5)

        def rates(t: float, y: Array) -> Array:
            phi, w = y[:n], y[n:]
            between = phi[:, None] - phi[None, :]
            forces = -(inertia * np.sin(between)) @ w**2 - weight * np.cos(phi)
            return np.concatenate([w, np.linalg.solve(inertia * np.cos(between), forces)])

        start = np.zeros(2 * n)
        self.n, self.tol = n, tol
        self._solution = solve_ivp(rates, (0.0, STOP), start, method="DOP853", rtol=tol, atol=tol, dense_output=True)
        self.times = np.linspace(0.0, STOP, POINTS + 1)[1:]
        self.angles = self.at(self.times)

    @cached_property
    def scene(self) -> tuple[Any, Any]:
        """The same chain in mbdsl, and its graph."""
        scene = mbdsl.load(MODEL, {"N": self.n})
        return scene, graph.build(scene)

    def at(self, times: Array) -> Array:
        """(times, N)."""
        return self._solution.sol(times)[: self.n].T

    def error(self, angles: Array, times: Array | None = None) -> float:
        """The largest error; infinite if values are missing."""
        true = self.angles if times is None else self.at(times)
        if angles.shape != true.shape:
            return math.inf
        error = float(np.abs(angles - true).max())
        return error if math.isfinite(error) else math.inf


def to_the_end(motion: MechanismRun) -> int:
    """All steps of a run; a status."""
    status = S.RUNNING
    while status == S.RUNNING and not motion.invalid():
        status = motion.advance(EVERY_STEP)
    return status


def numbers_of_steps() -> list[float]:
    return [FIRST * 2.0**k for k in range(LEVELS)]


def mbdsl_run(reference: Reference, method: str, step: float | None, tol: float | None) -> tuple[float, float]:
    """Seconds and error of a run; both are infinite if it is refused."""
    scene, mechanism = reference.scene
    try:
        return _measured(reference, scene, mechanism, method, step, tol)
    except MbdslError:
        return math.inf, math.inf


def _measured(
    reference: Reference, scene: Any, mechanism: Any, method: str, step: float | None, tol: float | None
) -> tuple[float, float]:
    motion = MechanismRun(
        scene, plan(scene, RunOptions(method=method, step=step, tol=tol, stop=STOP, times=reference.times)), mechanism
    )
    motion.prepare()
    motion.watch()
    begun = time.process_time()
    if tol is None:
        status, missed = to_the_end(motion), False
    else:
        status, found = calibrated(motion, tol, lambda: to_the_end(motion))
        missed = found.horizon is not None
    seconds = time.process_time() - begun
    if status != S.DONE or missed:
        return seconds, math.inf
    q = motion.output(False)[1][1:]
    first = motion.system.tables.coordinates
    return seconds, reference.error(q[:, [first[f"link[{k}]"] + 2 for k in range(1, reference.n + 1)]])


def chosen(reference: Reference, accuracy: float) -> tuple[str, float | None, float | None] | None:
    """Method, step and ``tol`` that ``--accuracy`` chooses; None if it does not reach the accuracy."""
    try:
        given = {"stop": STOP, "interval": STOP / POINTS, "budget": 1.0}
        found = mbdsl.simulate(reference.scene[0], accuracy=accuracy, **given).stats
    except MbdslError:
        return None
    return found["method"], None if found["tol"] is not None else found["h"], found["tol"]


def _fixed(reference: Reference, method: str, steps: float) -> tuple[float, float]:
    return mbdsl_run(reference, method, STOP / steps, None)


def mbdsl_series(reference: Reference, methods: Sequence[str] | None = None) -> Iterator[Series]:
    """Every method with fixed steps and with tolerances, methods of high order first."""
    compared = {name: m for name, m in available().items() if methods is None or name in methods}
    for name, method in sorted(compared.items(), key=lambda item: -item[1].order):
        if "fixed" in method.steps:
            yield Series("mbdsl", name, numbers_of_steps(), partial(_fixed, reference, name), method.order)
        if "controlled" in method.steps:
            yield Series("mbdsl", f"{name} --tol", TOLERANCES, partial(mbdsl_run, reference, name, None))


def mjcf(n: int, jacobian: str) -> str:
    """The chain as MuJoCo's XML; the hinges turn from x to z."""
    joint = '<joint type="hinge" axis="0 -1 0"/>'
    inertia = f'mass="{MASS}" diaginertia="{THICKNESS} {INERTIA!r} {INERTIA!r}"'
    rod = f'{joint}<inertial pos="{LENGTH / 2} 0 0" {inertia}/>'
    links = "".join(f'<body pos="{LENGTH if k else 0} 0 0">{rod}' for k in range(n)) + "</body>" * n
    option = f'<option integrator="RK4" gravity="0 0 {-GRAVITY}" jacobian="{jacobian}"/>'
    return f"<mujoco>{option}<worldbody>{links}</worldbody></mujoco>"


def mujoco_series(reference: Reference) -> Iterator[Series]:
    """RK4, with dense and with sparse matrices."""
    import mujoco

    mujoco.set_mju_user_warning(lambda text: None)  # too long steps are unstable: no messages, and no file for them
    unused = sum(bit.value for bit in mujoco.mjtDisableBit.__members__.values() if _is_unused(bit.name))
    for jacobian in ("dense", "sparse"):
        model = mujoco.MjModel.from_xml_string(mjcf(reference.n, jacobian))
        model.opt.disableflags = unused
        known: dict[float, float] = {}

        def run(n: float, model: Any = model, known: dict[float, float] = known) -> tuple[float, float]:
            model.opt.timestep, steps = STOP / n, int(n)
            data = mujoco.MjData(model)
            begun = time.process_time()
            mujoco.mj_step(model, data, nstep=steps)
            seconds = time.process_time() - begun
            if n not in known:
                mujoco.mj_resetData(model, data)
                angles = []
                for _ in range(POINTS):
                    mujoco.mj_step(model, data, nstep=steps // POINTS)
                    angles.append(np.cumsum(data.qpos))
                known[n] = reference.error(np.array(angles))
            return seconds, known[n]

        yield Series("MuJoCo", f"RK4, {jacobian}", numbers_of_steps(), run, 4)


def _is_unused(flag: str) -> bool:
    return flag.startswith("mjDSBL_") and flag != "mjDSBL_GRAVITY"


class Tree(Theirs):
    """The chain in Exudyn, with the angles of the hinges as coordinates."""

    def __init__(self, exu: Any, reference: Reference) -> None:
        from exudyn import itemInterface as item

        n = reference.n
        self.exu, self.item, self.stop, self.n, self.points = exu, item, STOP, n, POINTS
        self.reference_solution, self.tol, self.starts = reference, 0.0, {}
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        zeros = [0.0] * n
        node = item.NodeGenericODE2(
            referenceCoordinates=zeros,
            initialCoordinates=zeros,
            initialCoordinates_t=zeros,
            numberOfODE2Coordinates=n,
        )
        self.nodes = {"tree": self.mbs.AddNode(node)}
        same = exu.Matrix3DList([np.eye(3)] * n)
        centres = exu.Vector3DList([[LENGTH / 2, 0.0, 0.0]] * n)
        self.mbs.AddObject(
            item.ObjectKinematicTree(
                nodeNumber=self.nodes["tree"],
                jointTypes=[exu.JointType.RevoluteZ] * n,
                linkParents=list(range(-1, n - 1)),
                jointTransformations=same,
                jointOffsets=exu.Vector3DList([[LENGTH if k else 0.0, 0.0, 0.0] for k in range(n)]),
                linkInertiasCOM=exu.Matrix3DList([np.diag([THICKNESS, INERTIA, INERTIA])] * n),
                linkCOMs=centres,
                linkMasses=[MASS] * n,
                baseOffset=[0.0, 0.0, 0.0],
                gravity=[0.0, -GRAVITY, 0.0],
            )
        )
        self.sensors = [self.mbs.AddSensor(self._sensor(self.nodes["tree"]))]
        self.mbs.Assemble()
        self.reference, self.places = np.zeros(n), []

    def angles(self, states: Array) -> Array:
        return np.cumsum(states, axis=1)

    def _set(self, t: Any) -> None:
        """The tolerance of DOPRI5, if it has one; explicit solvers otherwise take fixed steps."""
        t.automaticStepSize = self.tol > 0.0
        if self.tol > 0.0:
            t.relativeTolerance = t.absoluteTolerance = self.tol

    def controlled(self, way: str, tol: float) -> tuple[float, float]:
        """Seconds and error of a run with a tolerance, whose steps do not end at the times of comparison."""
        self.tol = tol
        start = self._start(way, 1 << 20)
        total, done = self._once(way, POINTS, POINTS, 1.0)
        self.tol = 0.0
        if not done:
            return total, math.inf
        data = self.mbs.GetSensorStoredData(self.sensors[0])[1:]
        return max(total - start, LEAST), self.reference_solution.error(self.angles(data[:, 1:]), data[:, 0])


class Bodies(Theirs):
    """The chain in Exudyn as in ``against_exudyn.py``."""

    def angles(self, states: Array) -> Array:
        return states[:, 2::3]


def exudyn_series(reference: Reference) -> Iterator[Series]:
    """Explicit solvers on the tree; implicit solvers on the tree and on bodies; the options that are fast."""
    exu = against_exudyn.load()
    tree = Tree(exu, reference)
    case = Case("chain", STOP, FIRST, 1.0, n=reference.n)
    bodies = Bodies(exu, against_exudyn.Ours(case, STOP))
    programs = {"tree": tree, "joints": bodies}

    def seen(where: str, solver: str, way: str, steps: float, tighter: float = 1.0) -> Seen:
        program = programs[where]
        program.solver = getattr(exu.DynamicSolverType, solver)
        return program.run(way, int(steps), tighter)

    def run(where: str, *how: Any) -> Callable[[float], tuple[float, float]]:
        def at(steps: float) -> tuple[float, float]:
            found = seen(where, *how[:2], steps, *how[2:])
            error = reference.error(programs[where].angles(found.states)) if found.whole else math.inf
            return found.seconds, error

        return at

    def near(choices: Sequence[tuple[str, str, str]]) -> list[tuple[str, str, str]]:
        """The fastest choices of formulation, solver and options at equal steps, the fastest first."""
        taken = {choice: min(seen(*choice, TRIED).seconds for _ in range(2)) for choice in choices}
        least = min(taken.values())
        return sorted((c for c in choices if taken[c] <= NEAR * least), key=taken.__getitem__)[:MOST]

    matrices = [way for way, (_, modified) in WAYS.items() if not modified]  # explicit solvers have no Newton iteration
    for solver, order in (("RK67", 6), ("RK44", 4)):
        for choice in near([("tree", solver, way) for way in matrices]):
            yield Series("Exudyn explicit", ", ".join(choice[1:]), numbers_of_steps(), run(*choice), order)
    way = near([("tree", "RK44", way) for way in matrices])[0][2]

    def controlled(tol: float) -> tuple[float, float]:
        tree.solver = exu.DynamicSolverType.DOPRI5
        return tree.controlled(way, tol)

    yield Series("Exudyn explicit", f"DOPRI5, {way}", TOLERANCES, controlled)
    solvers = ("GeneralizedAlpha", "TrapezoidalIndex2")
    for k, choice in enumerate(near([(w, solver, way) for w in programs for solver in solvers for way in WAYS])):
        where, solver, way = choice
        for tighter in (1.0, 1e-2) if k == 0 else (1.0,):
            name = f"{solver}, {where}, {way}" + (f", tolerances x {tighter:g}" if tighter != 1.0 else "")
            yield Series("Exudyn implicit", name, numbers_of_steps(), run(*choice, tighter), 2)


def missing() -> dict[str, str]:
    """Package -> the command that installs it, for the packages that are not installed."""
    absent = [name for name in ("mujoco", "exudyn") if importlib.util.find_spec(name) is None]
    return dict.fromkeys(absent, "pip install 'mbdsl[bench]'")


def all_series(reference: Reference, methods: Sequence[str] | None = None) -> Iterator[Series]:
    """Of all installed programs."""
    absent = missing()
    yield from mbdsl_series(reference, methods)
    if "mujoco" not in absent:
        yield from mujoco_series(reference)
    if "exudyn" not in absent:
        warnings.simplefilter("ignore", DeprecationWarning)  # Exudyn renames its items from time to time
        yield from exudyn_series(reference)
