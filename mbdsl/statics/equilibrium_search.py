"""The search for a static equilibrium from given positions: overdamped motion, left at saddle points, and stability."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from mbdsl.compilation import code_cache
from mbdsl.errors import EquilibriumError
from mbdsl.initial.dependent_rows import redundant_rows
from mbdsl.initial.redundancy import of_attitudes
from mbdsl.mechanism import graph as mechanism_graph
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import few
from mbdsl.numerics.saddle_point import Array, dense
from mbdsl.statics import states_at_rest
from mbdsl.statics.pseudo_transient import MotionSearch, movers
from mbdsl.storage.compilation_notice import announce_compilation
from mbdsl.system import System, build
from mbdsl.system.bending import REMEDY, SMALL, first_bend

PUSHES = 20  #: greatest number of saddle points to leave


class Found(NamedTuple):
    """An equilibrium, with the fields of :class:`mbdsl.analysis.equilibria.Equilibrium`."""

    q: Array
    lam: Array
    iterations: int
    stability: str
    stiffness: float | None
    redundant: list[str]
    notes: list[str]
    left_out: tuple[int, ...]
    v: Array  #: zero, except for states


def prepared(scene: Scene, announce: Callable[[str], None] | None) -> tuple[System, mechanism_graph.MechanismGraph]:
    """The System of a model as written, with its code loaded or compiled, and its graph."""
    mechanism = mechanism_graph.build(scene)
    system = build(scene, mechanism)
    # code that a simulation has compiled is used if it is in the cache
    sets = 2 if code_cache.is_compiled(system.module_name(2)) else 1
    announce_compilation(announce, lambda: system.uncompiled(sets))
    system.kernels(sets)
    return system, mechanism


def searched(system: System, t: float, q: Array) -> Found:
    """The equilibrium of ``system`` at time ``t`` that overdamped motion reaches from ``q``."""
    if not system.tables.states:
        return _searched(system, t, q)
    other, start = states_at_rest.prepared(system, t, q)
    found = _searched(other, t, start)
    q, v = states_at_rest.split(system, found.q)
    return found._replace(q=q, v=v)


def _searched(system: System, t: float, q: Array) -> Found:
    notes: list[str] = []
    search = MotionSearch(system, t, q)
    pushes = 0
    while True:
        search.descend()
        stiffness, zero, directions = search.stability()
        if stiffness is None or stiffness >= -zero or pushes == PUSHES:
            break
        search.push(directions[:, 0], stiffness)
        pushes += 1
        if pushes == 1 and search.iterations == 0:
            notes.append("the start is an unstable equilibrium; the search begins at a displaced position")
    if pushes == PUSHES:
        notes.append(f"the search left {PUSHES} saddle points and ends at another one")
    if stiffness is None:
        stability = "held"
    elif stiffness < -zero:
        stability = "unstable"
    elif stiffness <= zero:
        stability = "indifferent"
        names = movers(system, np.abs(directions).max(axis=1))
        notes.append(f"indifferent: nothing resists a motion of {few(names)}, which stays where it starts")
    else:
        stability = "stable"
    if not search.symmetric:
        notes.append("some forces have no potential: only the eigenvalues (mbdsl eigen) decide about stability")
    if system.scene.events.typed:
        notes.append("discrete variables have their values at the start; when-equations do not act")
    q, lam, left_out = search.q, search.lam, redundant_rows(system, t, search.q, np.zeros(system.n))
    if left_out:
        lam = _without(system, t, q, lam, left_out)
    if (bend := first_bend(system, q[None])) is not None:
        span = system.scene.components[bend.name].span
        raise EquilibriumError(f"{bend.name} bends by {bend.angle:.2g} rad: {SMALL}", span, hint=REMEDY)
    names = [system.constraint_names()[k] for k in left_out if k not in system.tables.switchable]
    idle = of_attitudes(system, t, search.q, np.zeros(system.n), left_out)
    if named := [x for x in names if x not in idle]:
        notes.append(
            f"redundant: {few(named)} {'follows' if len(named) == 1 else 'follow'} from the other constraints; "
            "how the reactions share the load there is not determined"
        )
    if joints := system.scene.sticking:
        notes.append(f"friction of {few([x.name for x in joints], 4)} is left out: it can hold other poses as well")
    return Found(q, lam, search.iterations, stability, stiffness, names, notes, left_out, np.zeros(system.n))


def _without(system: System, t: float, q: Array, lam: Array, left_out: tuple[int, ...]) -> Array:
    """The multipliers of the same constraint force with zeros in the rows left out, of which there are few."""
    J = dense(system.velocity_jacobian(t, q, np.zeros(system.n)))
    kept = np.delete(np.arange(len(lam)), left_out)
    J = J / system.tables.scale
    found = np.zeros(len(lam))
    found[kept] = lam[kept] + np.linalg.lstsq(J[kept].T, J[list(left_out)].T @ lam[list(left_out)], rcond=1e-12)[0]
    return found
