"""What a run with steps of fixed size shows of itself: energy from nowhere, and contacts that it has stepped over.

Neither is an error that the run could have seen on its way. Both are looked for behind it, at the outputs, and only
where they can be: energy where nothing brings any, contacts where laws have conditions.
"""

from __future__ import annotations

from itertools import pairwise
from math import pi

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.kind import ForceKind, JointKind
from mbdsl.errors import MbdslError
from mbdsl.integrators import state
from mbdsl.integrators.run import Integration
from mbdsl.lang.expressions import Expr, leaves
from mbdsl.motion import KINEMATIC, Motion, Moving
from mbdsl.scene import Component, Scene
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.blocks import by_law, law_expressions
from mbdsl.system.signals import values
from mbdsl.trajectory import Trajectory

Array = NDArray[np.float64]

#: growth of energy, as a part of the largest kinetic energy, that no method has at a step of use
GROWTH = 0.05
#: a change of velocity between two outputs, as a part of the largest velocity, that a contact may have made
KICK = 0.25
#: contacts with fewer steps are not resolved; step times frequency where the error is a thousandth
FEW, RESOLVED = 10, 0.1
#: places that are looked at again, steps at each, and coordinates for which a frequency is asked for
PLACES, STEPS, LARGEST = 8, 5000, 300
#: the coordinate that a law pushes along
ALONG = {"fx": "x", "fy": "y", "tau": "phi"}


def doubts(motion: Motion, trajectory: Trajectory, states: list[tuple[Array, Array]]) -> list[str]:
    """What is to be said of a run with fixed steps; ``states`` are q and v (N, n) of each part at its outputs."""
    if motion.plan.tol is not None or len(trajectory.t) < 3:
        return []
    found = [growth(trajectory)]
    for p, (q, v) in zip(motion.parts, states, strict=True):
        if isinstance(p.integration, Integration) and p.method != KINEMATIC and p.system.tables.switches:
            found.append(_kicked(motion, p, trajectory.t, q, v))
    return [text for text in found if text]


# -- energy ------------------------------------------------------------------------------------------------------


def growth(trajectory: Trajectory) -> str | None:
    """That energy grows, where nothing brings any; None where it does not, or something may.

    Forces by expression count where they follow from the coordinate that they push along, as then they have a
    potential. It is not known, and so energies are compared at outputs where all of these forces are zero.
    """
    scene = trajectory.scene
    if not passive(scene):
        return None
    laws = [e for c in _by_law(scene) for e in law_expressions(c)]
    t, free = trajectory.t, np.ones(len(trajectory.t), bool)
    if laws:
        free = ~np.any(values(trajectory.system, laws, t, trajectory.q, trajectory.v), axis=0)
    E, T = trajectory["energy.total"], trajectory["energy.kinetic"]
    if free.sum() < 2 or not (np.isfinite(E).all() and np.isfinite(T).all()):
        return None
    E, t = E[free], t[free]
    grown = E - np.minimum.accumulate(E)
    k = int(np.argmax(grown))
    if not grown[k] > GROWTH * T.max():
        return None
    least = int(np.argmin(E[: k + 1]))
    return (
        f"energy grows by {grown[k]:.3g} J between t = {t[least]:.6g} and {t[k]:.6g} s, where nothing brings any: "
        f"the step, {trajectory.stats['h']:g} s, is too long; take a shorter one, or a tolerance in place of it"
    )


def passive(scene: Scene) -> bool:
    """Whether nothing in a scene can bring energy, as far as that can be seen."""
    if scene.inputs or any(frame.motion for frame in scene.frames.values()):
        return False
    for c in scene.components.values():
        kind = c.kind
        if isinstance(kind, JointKind) and (kind.driver or any(c.values[p.name] for p in kind.parameters if p.law)):
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
    """Whether a law depends on nothing but the coordinate that it pushes along."""
    law = c.values[name]
    if not isinstance(law, Expr):
        return not law
    if law.op == "const":
        return law.value == 0.0
    own = {c.signals[key] for key in (f"{c.name}.s", f"{c.name}.phi") if key in c.signals}
    if not _leaves_without(law, own):
        return True
    found, along = leaves(law), ALONG.get(name)
    if len(found) != 1 or found[0].op != "coordinate":
        return False
    frame, key = found[0].value  # type: ignore[misc]
    if key == "phi":
        return key == along and scene.frames[frame].body in {scene.frames[f].body for f in c.ports.values()}
    return key == along and frame in c.ports.values()


def _leaves_without(root: Expr, stop: set[Expr]) -> bool:
    """Whether ``root`` depends on something else than the expressions in ``stop``."""
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


def _kicked(motion: Motion, p: Moving, t: Array, q: Array, v: Array) -> str | None:
    """A law that acts for a few steps only, and turns the motion over: found by making these steps again."""
    scale, h, plan = p.system.tables.scale, motion.plan.h, motion.plan
    speed = np.abs(v / scale).max(initial=0.0)
    kicks = np.abs(np.diff(v, axis=0) / scale).max(axis=1, initial=0.0)
    order = [int(i) for i in np.argsort(-kicks)[:PLACES] if kicks[i] > KICK * speed]
    numbers = p.system.tables.F.copy()
    try:
        for i in sorted(order):
            first, last = max(0, i - 1), min(len(t) - 1, i + 2)
            steps = round((t[last] - t[first]) / h)
            if not 1 < steps <= STEPS:
                continue
            a, lam = accelerations(p.system, t[first], q[first], v[first], p.initial.redundant)
            stop = t[first] + steps * h
            due = t[first] + h * np.arange(1.0, steps + 1)
            due[-1] = stop
            again = Integration(p.system, p.method, h, t[first], stop, due, plan.options)
            again.begin(q[first], v[first], a, lam, p.initial.redundant)
            if again.advance() != state.DONE:
                continue
            if (told := _short(p.system, due, again.out, h)) is not None:
                return told
    except MbdslError:  # what a place does not allow is no doubt of the run
        return None
    finally:
        p.system.tables.F[:] = numbers
    return None


def _short(system: System, t: Array, out: Array, h: float) -> str | None:
    """The law that acts for the fewest steps, if these are few, between steps at which it does not act."""
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
                f"{what}; its {w / (2 * pi):.3g} Hz are not resolved (h omega = {h * w:.2g}): "
                f"take a step of {RESOLVED / w:.1g} s, or a tolerance in place of it"
            )
    return None


def _frequency(system: System, t: float, q: Array, v: Array, lam: Array) -> float:
    """The largest frequency [rad/s] of small motions about a state, within the constraints; 0 where none is known."""
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
