"""Warnings about runs with fixed steps: peaks of laws within a step, growing energy, contacts that are not resolved.

Fixed steps have no error estimate. Four symptoms are checked. During the run, all steps are searched for peaks of
laws between their ends (:mod:`mbdsl.integrators.missed_peaks`). After the run, its outputs are checked for growing
energy in models without a source of energy, for unresolved contacts in models whose laws have conditions, and in space
for bodies that make half a turn in a step.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from math import inf, pi
from typing import Any

import numpy as np

from mbdsl.elements.kind import ForceKind, JointKind
from mbdsl.errors import MbdslError
from mbdsl.expressions.symbolic import Expr, leaves, walk
from mbdsl.integrators import backend
from mbdsl.integrators.backends import External
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.missed_peaks import MissedPeak
from mbdsl.integrators.peak_zones import LONGEST
from mbdsl.integrators.run import MethodRun
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.contacts import FRICTION, is_contact
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.simulation.examined_run import ExaminedRun
from mbdsl.simulation.large_rotations import LargeRotations
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.part_run import KINEMATIC, PartRun
from mbdsl.simulation.run_symptoms import EnergyGrowth, Kicks, Symptom
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.peaks_along_motion import GIVEN_UP
from mbdsl.system.peaks_in_fixed_steps import InFixedSteps
from mbdsl.system.signals import values
from mbdsl.system.structure import by_law, law_expressions

OF_STREAMS = True  #: rows that a stream has taken were examined while it took them

#: growth of energy, relative to the largest kinetic energy, that no method shows at a reasonable step
GROWTH = 0.05
#: growth of energy, relative to the largest energy, that is rounding
ROUNDING = 1e-12
#: motion in a step, relative to the mechanism's size, that is rounding of positions
AT_REST = 1e-13
#: contacts with fewer steps are not resolved; step times angular frequency at which the error is about 1e-3
FEW, RESOLVED = 10, 0.1
#: most steps that are computed again at a place, most coordinates for which frequencies are computed
STEPS, LARGEST = 5000, 300
#: the coordinate along which a law acts
ALONG = {"fx": "x", "fy": "y", "tau": "phi"}


class Watch:
    """The search for symptoms of too long steps in the outputs of a run; they are added block by block."""

    def __init__(self, motion: MechanismRun) -> None:
        self._motion, self._rows = motion, 0
        scene, h = motion.system.scene, motion.plan.h
        self._energy: EnergyGrowth | None = None
        self._kicks: dict[int, Kicks] = {}  #: by the number of the part
        self._turns: dict[int, LargeRotations] = {}
        if motion.plan.tol is not None:
            return
        if passive(scene):
            self._energy = EnergyGrowth([e for c in _by_law(scene) for e in law_expressions(c)])
        for k, p in enumerate(motion.parts):
            if isinstance(p.integration, MethodRun) and p.method != KINEMATIC:
                if scene.spatial:
                    self._turns[k] = LargeRotations(p.system, h)
                if p.system.tables.switches:
                    self._kicks[k] = Kicks(p.system.tables.scale)

    def add(self, trajectory: Trajectory, states: list[tuple[Array, Array]]) -> None:
        """Add the outputs that follow; ``states`` are q and v (N, n) of each part."""
        self._rows += len(trajectory.t)
        if self._energy is not None:
            self._energy.add(trajectory)
        for k, kicks in self._kicks.items():
            kicks.add(trajectory.t, *states[k])
        for k, turns in self._turns.items():
            turns.add(trajectory.t, states[k][1])

    def doubts(self) -> list[str]:
        """Warnings about a run with fixed steps, or by a backend that does not search its steps for peaks of laws."""
        motion = self._motion
        peak = _first_peak(motion) if motion.plan.tol is None else None
        found = [_not_searched(motion), _given_up(motion)]
        found += [turns.warning() for turns in self._turns.values()]
        if self._rows >= 3:
            found.append(None if self._energy is None else _growth(self._energy, motion))
            found += [_kicked(motion, motion.parts[k], kicks) for k, kicks in self._kicks.items()]
        if peak is not None:
            law = _law_within([motion.system.scene, *(p.system.scene for p in motion.parts)], peak.root)
            if law is None or not any(text and text.startswith(f"{law.kind.name} {law.name} ") for text in found):
                found.insert(0, _unseen(peak, law))
        return [text for text in found if text]

    @property
    def _symptoms(self) -> list[Symptom]:
        return [*([self._energy] if self._energy is not None else []), *self._kicks.values(), *self._turns.values()]

    def state(self) -> dict[str, Any]:
        """The state for a checkpoint."""
        return {"rows": self._rows, "symptoms": [x.state() for x in self._symptoms]}

    def restore(self, known: dict[str, Any]) -> None:
        """Continue from a state."""
        self._rows = int(known["rows"])
        for symptom, kept in zip(self._symptoms, known["symptoms"], strict=True):
            symptom.restore(kept)


def warnings(run: ExaminedRun) -> list[str]:
    """Warnings about a completed run with fixed steps, or by a backend that does not search its steps."""
    if not run.done:
        return []
    if run.stream is not None:
        return run.stream.watched(run.motion).doubts()
    watch = Watch(run.motion)
    watch.add(run.trajectory, run.states)
    return watch.doubts()


# -- between the ends of a step -----------------------------------------------------------------------------------


def _not_searched(motion: MechanismRun) -> str | None:
    """A warning about a backend that may pass over peaks of laws; None if it searches or no law can have one."""
    plan = motion.plan
    own = backend(plan.method)
    if own is None or own.METHOD.searches or not motion.parts:
        return None
    h = plan.h if plan.tol is None else LONGEST * (plan.stop - plan.start)
    for p in motion.parts:
        looks = InFixedSteps(p.system, h)
        if not isinstance(p.integration, External):
            continue
        own = {x for c in p.system.scene.contacts for x in (c.condition, *c.slips)}
        for root in looks.roots:
            law = _law_within([motion.system.scene, p.system.scene], root)
            if root in own or (law is not None and (is_contact(law) or law.kind.name == FRICTION)):
                continue  # the method solves them
            where, what = _words(law)
            return (
                f"{where}{plan.method} does not search its steps for peaks of laws: a peak of {what} between the ends "
                "of a step may be missed; compare with a method that searches, such as hht-si2 with a tolerance"
            )
    return None


def _given_up(motion: MechanismRun) -> str | None:
    """A warning about laws whose search for peaks has taken too many operations."""
    ends = [[float(p.integration.searched[GIVEN_UP]), *p.system.zones_end] for p in motion.parts]
    since = min((t for end in ends for t in end), default=inf)
    if since == inf:
        return None
    remedy = "a smaller tolerance shortens the steps" if motion.plan.tol is not None else "try smaller steps"
    return (
        f"the search for peaks of laws between the ends of steps was given up at t = {since:.6g} s, because it takes "
        f"too many operations for these laws: from then on, a peak within a step may be missed; {remedy}"
    )


def _first_peak(motion: MechanismRun) -> MissedPeak | None:
    """The first peak of a law that steps have passed over."""
    watched = [p.integration.overlooked for p in motion.parts if isinstance(p.integration, MethodRun)]
    peaks = [peak for x in watched if x is not None and (peak := x.peak()) is not None]
    return min(peaks, key=lambda peak: peak.start, default=None)


#: what the warning about a peak that steps have passed over says, besides its place
UNSEEN = "that the ends of the step do not show"


def _unseen(peak: MissedPeak, law: Component | None) -> str:
    """The warning about a peak that steps have passed over."""
    where, what = _words(law)
    size = 10.0 ** np.floor(np.log10(peak.h))
    return (
        f"{where}{what} has a peak near t = {peak.time:.6g} s, within the step from {peak.start:.6g} to "
        f"{peak.end:.6g} s, {UNSEEN}: a short pulse is lost there, a corner changes "
        "little, and fixed steps do not estimate which; "
        f"try a tolerance instead, or a step of {np.floor(peak.h / size * (1.0 + 1e-9)) * size:.1g} s"
    )


def unseen_peak(stats: Mapping[str, Any]) -> str:
    """Why a finished run with these ``stats`` may miss a pulse; "" if its steps pass over none that is known."""
    return "its steps pass over a peak of a law" if any(UNSEEN in x for x in stats.get("warnings", ())) else ""


def _law_within(scenes: list[Scene], root: Expr) -> Component | None:
    """The component of one of ``scenes`` whose law or friction is the expression ``root``, or contained in it.

    It is contained if the motion of a driver has been replaced by a function of time. The part of a scene that is
    integrated has expressions of its own if bodies are welded to each other.
    """
    parts = set(walk(root))
    for c in (c for scene in scenes for c in scene.components.values()):
        laws = [c.values[p.name] for p in c.kind.parameters if p.law]
        if c.friction is not None or (isinstance(c.kind, ForceKind) and by_law(c)):
            laws += law_expressions(c)
        if any(law in parts and law.args for law in laws if isinstance(law, Expr)):
            return c
    return None


def _words(law: Component | None) -> tuple[str, str]:
    """Its place and its name: "arm.mbd:3:5: ", "the friction of Revolute pin"."""
    if law is None:
        return "", "a law"
    what = "friction" if law.friction is not None else "law"
    return "" if law.span is None else f"{law.span}: ", f"the {what} of {law.kind.name} {law.name}"


# -- energy ------------------------------------------------------------------------------------------------------


def _growth(found: EnergyGrowth, motion: MechanismRun) -> str | None:
    """A warning if energy grows without a source; None if it does not grow, or if the model is at rest."""
    h = motion.plan.h
    if found.count < 2 or not found.finite or found.speed * h <= AT_REST * min(1.0, motion.system.tables.size):
        return None
    if not found.grown > max(GROWTH * found.kinetic, ROUNDING * found.size):
        return None
    return (
        f"energy grows by {found.grown:.3g} J between t = {found.since:.6g} and {found.until:.6g} s, but the model has "
        f"no source of energy: the step of {h:g} s is too long; try a shorter step, or a tolerance instead"
    )


def passive(scene: Scene) -> bool:
    """Whether a scene certainly has no source of energy."""
    if scene.inputs or any(frame.motion for frame in scene.frames.values()):
        return False
    for c in scene.components.values():
        kind = c.kind
        if (
            isinstance(kind, JointKind)
            and not kind.relations
            and any(c.values[p.name] for p in kind.parameters if p.law)
        ):
            return False
        if c.moves_in_time:
            return False
        if isinstance(kind, ForceKind):
            if by_law(c):
                if not all(_has_potential(scene, c, name) for name in kind.laws):
                    return False
            elif any(x < 0.0 for spring in kind.springs(c.values) for x in spring[:2]):  # type: ignore[misc]
                return False
    return True


def _by_law(scene: Scene) -> list[Component]:
    return [c for c in scene.components.values() if isinstance(c.kind, ForceKind) and by_law(c)]


def _has_potential(scene: Scene, c: Component, name: str) -> bool:
    """Whether a law depends only on the coordinate along which it acts."""
    law = c.values[name]
    if not isinstance(law, Expr):
        return not law
    if law.op == "const":
        return law.value == 0.0
    own = {e for key in ("s", "phi") if (e := scene.signal_of(c, key)) is not None}
    if not _leaves_without(law, own):
        return True
    found, along = leaves(law), ALONG.get(name)
    if len(found) != 1 or found[0].op != "coordinate":
        return False
    frame, key = found[0].value
    if key == "phi":
        return key == along and scene.frames[frame].body in {scene.frames[f].body for f in c.ports.values()}
    return key == along and frame in c.ports.values()


def _leaves_without(root: Expr, stop: set[Expr]) -> bool:
    """Whether ``root`` depends on anything other than the expressions in ``stop``."""
    seen: set[Expr] = set()
    waiting = [root]
    while waiting:
        node = waiting.pop()
        if node in seen or node in stop:
            continue
        seen.add(node)
        if not node.args and leaves(node):
            return True
        waiting += node.args
    return False


# -- contacts ----------------------------------------------------------------------------------------------------


def _kicked(motion: MechanismRun, p: PartRun, kicks: Kicks) -> str | None:
    """A warning if a law acts for a few steps only and changes velocities much; these steps are repeated."""
    h, plan = motion.plan.h, motion.plan
    numbers = p.system.tables.numbers.copy()
    try:
        for kick in kicks.largest():
            first = kick.first
            steps = round((kick.last - first) / h)
            if not 1 < steps <= STEPS:
                continue
            a, lam = accelerations(p.system, first, kick.q, kick.v, p.initial.redundant)
            stop = first + steps * h
            due = first + h * np.arange(1.0, steps + 1)
            due[-1] = stop
            again = MethodRun(p.system, p.method, h, first, stop, due, plan.options)
            again.begin(kick.q, kick.v, a, lam, p.initial.redundant)
            if again.advance() != S.DONE:
                continue
            if (warning := _short(p.system, due, again.out, h)) is not None:
                return warning
    except MbdslError:  # steps that cannot be repeated give no information about the run
        return None
    finally:
        p.system.tables.numbers[:] = numbers
    return None


def _short(system: System, t: Array, out: Array, h: float) -> str | None:
    """A warning about a law that acts for so few steps that they do not resolve it; None if there is none."""
    n = system.n
    q, v, lam = out[:, :n], out[:, n : 2 * n], out[:, 2 * n :]
    for c in _by_law(system.scene):
        acting = np.any(values(system, law_expressions(c), t, q, v, lam), axis=0)
        edges = np.flatnonzero(np.diff(acting.astype(int)))
        for begin, end in pairwise(edges):
            if acting[begin] or end - begin >= FEW:
                continue
            w = max(_frequency(system, float(t[k]), q[k], v[k], lam[k]) for k in range(begin + 1, end + 1))
            w = max(w, pi / (h * (end - begin + 1)))
            if h * w <= RESOLVED:
                continue
            steps = "1 step" if end - begin == 1 else f"{end - begin} steps"
            what = f"{c.kind.name} {c.name} acts for {steps} at t = {t[begin + 1]:.6g} s"
            return (
                f"{what}; the step does not resolve its {w / (2 * pi):.3g} Hz (h omega = {h * w:.2g}): "
                f"try a step of {RESOLVED / w:.1g} s, or a tolerance instead"
            )
    return None


def _frequency(system: System, t: float, q: Array, v: Array, lam: Array) -> float:
    """The largest angular frequency [rad/s] of small motions about a state, within the constraints; 0 if unknown."""
    if system.n > LARGEST:
        return 0.0
    from scipy.linalg import eigh, null_space

    K, M, G = (
        x.toarray() if hasattr(x, "toarray") else np.asarray(x)
        for x in (system.stiffness(t, q, v, lam), system.M(t, q), system.Phi_q(t, q))
    )
    Z = null_space(G) if len(G) else np.eye(system.n)
    m, k = Z.T @ M @ Z, Z.T @ (K + K.T) @ Z / 2.0
    if not Z.shape[1] or np.linalg.eigvalsh(m)[0] <= 0.0:
        return 0.0
    return float(np.sqrt(max(0.0, np.abs(eigh(k, m, eigvals_only=True)).max())))
