"""Drivers that move bodies into rigid contacts: the laws of the contacts have a solution only without these drivers.

A driver prescribes a motion, and a contact stops every motion that would close its gap.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.kind import JointKind
from mbdsl.errors import InitialisationError
from mbdsl.expressions.symbolic import Expr, expr, leaves, walk
from mbdsl.mechanism.contacts import is_contact
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.numerics.contact_modes import Contacts, solve
from mbdsl.numerics.saddle_point import dense, least_squares
from mbdsl.system.accelerations import accelerations
from mbdsl.system.system import System

Array = NDArray[np.float64]
Driver = Component
DEPENDS = 1e-10  #: relative pivot below which a row depends on others


def drivers_at_fault(
    system: System, t: float, q: Array, v: Array, closed: Sequence[int], left_out: Sequence[int]
) -> list[Component]:
    """The drivers without which the gaps (rows ``closed``) could be kept from closing at time t; [] if there are none.

    ``left_out``: the rows that do not constrain, among them those of all contacts.
    """
    try:
        return _found(system, t, q, v, closed, left_out)
    except (InitialisationError, np.linalg.LinAlgError):
        return []  # the motion without contacts is not known


def _found(
    system: System, t: float, q: Array, v: Array, closed: Sequence[int], left_out: Sequence[int]
) -> list[Component]:
    scene, tables, n, rows = system.scene, system.tables, system.n, list(closed)
    matrix = dense(system.tangent(t, q, v, cM=1.0, cP=1.0, cV=1.0))
    W = matrix[[n + row for row in rows], :n]
    still = np.zeros_like(v)

    def without(names: Sequence[str]) -> tuple[int, ...]:
        return tuple(sorted({*left_out, *(row for name in names for row in own[name])}))

    def speeds(names: Sequence[str], at_rest: bool = False) -> Array:
        """The rates of the gaps, which are those before the impact whatever drivers there are; with ``at_rest``, those
        with the driven frames at rest."""
        u = system.constraint_rates(t, q, v)[rows]
        return u - system.constraint_rates(t, q, still)[rows] if at_rest else u

    def begins(names: Sequence[str], at_rest: bool = False) -> Array:
        """The same for the second derivatives of the gaps, without some drivers."""
        a, _ = accelerations(system, t, q, v, without(names))
        b = W @ a - system.gamma_c(t, q, v)[rows]
        return b + system.gamma_c(t, q, still)[rows] if at_rest else b

    def delassus(left_out: Sequence[int]) -> Array:
        kept = np.setdiff1d(np.arange(system.unknowns), [n + row for row in left_out])
        right = np.zeros((len(kept), len(W)))
        right[:n] = W.T
        G = W @ least_squares(matrix[np.ix_(kept, kept)], right, DEPENDS)[:n]
        return 0.5 * (G + G.T)

    def solvable(names: Sequence[str], rates: Callable[..., Array], at_rest: bool = False) -> bool:
        """Whether gaps with these rates can be stopped without some drivers; friction does not matter."""
        G = delassus(without(names))
        G[np.abs(G) <= DEPENDS * np.abs(free).max()] = 0.0
        return solve(Contacts(G, (1,) * len(W), np.zeros(len(W))), rates(names, at_rest)) is not None

    own = {c.name: _rows(system, c) for c in scene.components.values() if _in_time(c)}
    free = delassus(range(system.m + system.p))
    rates = next((x for x in (speeds, begins) if not solvable((), x)), None)
    if rates is None:
        return []
    if own and solvable(list(own), rates):
        found = [name for name in own if solvable([name], rates)]
        return [scene.components[name] for name in found or own]
    if solvable((), rates, at_rest=True):
        gaps = [c.gap for c, its in zip(scene.contacts, tables.contact_rows, strict=True) if its[0] in closed]
        return _of_frames(scene, gaps)
    return []


def _in_time(c: Component) -> bool:
    """Whether the constraints of a joint depend on time."""
    if not isinstance(c.kind, JointKind) or is_contact(c):
        return False
    return c.moves_in_time or any(leaf.op == "time" for leaf in leaves(*c.velocity_constraints))


def _rows(system: System, c: Component) -> list[int]:
    """The rows of a joint that depend on time: the last one of positions, and those of velocities."""
    rows, first = [], system.tables.rows.get(c.name)
    if first is not None and isinstance(c.kind, JointKind):
        rows.append(first + c.kind.rows - 1)
    first = system.tables.velocity_rows.get(c.name, 0)
    return [*rows, *range(first, first + len(c.velocity_constraints))]


def _of_frames(scene: Scene, gaps: Sequence[Expr]) -> list[Component]:
    """The drivers that prescribe the motions of bodies from which the ``gaps`` are measured."""
    every = {f.driver.name: f.driver for f in scene.frames.values() if f.driver is not None}
    nodes = set(walk(*gaps))
    return [c for c in every.values() if _law(c) in nodes] or list(every.values())


def _law(c: Component) -> Expr:
    assert isinstance(c.kind, JointKind) and c.kind.driver is not None
    return expr(c.values[c.kind.driver])
