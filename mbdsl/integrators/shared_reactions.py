"""Laws and conditions that read reactions which rigid contacts at rest share, so that they are not unique.

F has a row with the generalised force of each constraint and each closed contact, which contains the friction of those
that slide. With F^T Z = 0, the reactions lam + Z y have the same generalised forces for all y. What reads lam is not
unique if it changes with y.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import Span
from mbdsl.expressions.symbolic import Expr, leaves, walk
from mbdsl.integrators.touching import Touching
from mbdsl.mechanism.contacts import FRICTION, MODE, OPEN, number
from mbdsl.numerics.contact_modes import STICK, Contacts, Modes
from mbdsl.numerics.friction_shares import exerted
from mbdsl.numerics.saddle_point import dense
from mbdsl.system import System
from mbdsl.system.signals import values

Array = NDArray[np.float64]
ZERO = 1e-9  #: singular value, relative to the largest, and part of a unit vector, that count as zero
CHANGE = 1e-6  #: change of what is read, relative to its size, that counts


class Reader(NamedTuple):
    """A law or a condition with reactions: expressions in it, what it is in a message, and its place."""

    roots: tuple[Expr, ...]
    name: str
    span: Span | None


class Shared(NamedTuple):
    """Reader of reactions that are not unique from time t [s] on, and the joints and contacts that share the load."""

    t: float
    reader: Reader
    among: tuple[str, ...]


def readers(system: System) -> list[Reader]:
    """What reads reactions in a scene: laws, friction of joints, conditions and values of when-equations."""
    scene = system.scene
    found = []
    for c in scene.components.values():
        if c.kind.name != FRICTION:
            laws = [x for p in c.kind.parameters if p.law and isinstance(x := c.values[p.name], Expr)]
            found.append(Reader((*laws, *c.velocity_constraints), f"the law of {c.kind.name} `{c.name}`", c.span))
            if c.friction is not None and c.name not in {x.name for x in scene.contacts}:
                found.append(Reader((c.friction,), f"friction of {c.kind.name} `{c.name}`", c.span))
    for b in scene.events.branches:
        given = [x for a in b.actions for x in (a.value,) if x is not None]
        found.append(Reader((*b.conditions, *given), "the `when`", b.span))
    found = [x._replace(roots=tuple(y for root in x.roots for y in _compared(root))) for x in found]
    return [x for x in found if any(leaf.op == "multiplier" for leaf in leaves(*x.roots))]


def _compared(root: Expr) -> list[Expr]:
    """An expression that varies where ``root`` does, which may be a condition."""
    compared = [n.args[0] - n.args[1] for n in walk(root) if n.op in ("lt", "le", "eq", "ne")]
    return compared or [root]


class SharedReactions:
    """What reads reactions of rigid contacts in a run; ``found``: the readers of those that are not unique."""

    def __init__(self, system: System) -> None:
        self.system, self.found = system, list[Shared]()
        self.inputs: Mapping[str, float] = {}  #: the present values of the model's inputs
        self.readers = readers(system) if system.scene.contacts else []

    def look(
        self,
        state: tuple[float, Array, Array],
        own: tuple[Touching, Contacts, Array, Modes],
        others: Sequence[int],
        numbers: Mapping[str, float],
    ) -> None:
        """Note the readers of reactions that are not unique in a state t, q, v.

        ``own``: the contacts at rest, their problem, the matrix of its rows, and the modes. ``others``: the rows that
        do not constrain, among them those of all contacts. ``numbers``: discrete variables, with modes.
        """
        known = {id(x.reader) for x in self.found}
        asked = [x for x in self.readers if id(x) not in known]
        if not asked:
            return
        system, (touching, laws, turn, modes) = self.system, own
        held, rows = [], []
        for i, (k, n) in enumerate(zip(touching.which.tolist(), laws.first, strict=True)):
            if numbers[number(system.scene.contacts[k].name, MODE)] != OPEN:
                some = range(laws.sizes[i] if modes[i] == STICK else 1)
                held += [n + j for j in some]
                rows += [system.tables.contact_rows[k][j] for j in some]
        joints = np.setdiff1d(np.arange(system.m + system.p), np.array(others, int))
        if rows:
            t, q, v = state
            J = dense(system.velocity_jacobian(t, q, v))[joints]
            F = exerted(laws, modes, held).T @ turn @ touching.W
            self._note(state, [*joints.tolist(), *rows], np.vstack([J, F]), numbers, asked)

    def _note(
        self,
        state: tuple[float, Array, Array],
        rows: list[int],
        F: Array,
        numbers: Mapping[str, float],
        asked: Sequence[Reader],
    ) -> None:
        """Note those of ``asked`` that change with y; F (k, n): the forces of the ``rows``."""
        system, (t, q, v) = self.system, state
        F = F / system.tables.scale
        size = np.linalg.norm(F, axis=1)
        size = np.where(size > 0.0, size, 1.0)
        s = np.linalg.svd(F / size[:, None], compute_uv=False)
        rank = int((s > ZERO * s.max(initial=0.0)).sum())
        if rank == len(F):
            return  # all are unique, as at most events
        Z = np.linalg.svd(F / size[:, None])[0][:, rank:] / size[:, None]
        lam = np.ones((1 + Z.shape[1], system.m + system.p))
        lam[1:, rows] += (Z / np.abs(Z).max(axis=0)).T
        count = len(lam)
        inputs = {name: np.full(count, x) for name, x in (*self.inputs.items(), *numbers.items())}
        states = np.full(count, t), np.tile(q, (count, 1)), np.tile(v, (count, 1))
        for reader in asked:
            read = np.nan_to_num(np.array(values(system, reader.roots, *states, lam, inputs)))
            varies = np.abs(read[:, 1:] - read[:, :1]).max(axis=0) > CHANGE * np.abs(read).max()
            if varies.any():
                part, names = np.abs(Z[:, varies]).max(axis=1), system.constraint_names()
                among = (names[rows[i]].rsplit(".", 1)[0] for i in np.flatnonzero(part > ZERO * part.max()))
                self.found.append(Shared(t, reader, tuple(dict.fromkeys(among))))
