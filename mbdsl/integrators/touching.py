"""The contacts of a run whose gaps are closed at one time: their rows, and the problem of their forces.

With J the rows of all other constraints and W those of the contacts, one of the gap of each and those of its slips,
Delassus's matrix is G = W X, where

    [[M, J^T], [J, 0]] [X; .] = [W^T; 0]
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.numerics import contact_modes
from mbdsl.numerics.contact_modes import Contacts
from mbdsl.numerics.saddle_point import least_squares

Array = NDArray[np.float64]
DEPENDS = 1e-10  #: relative pivot below which a row depends on others
ROUGHLY = 1e-9  #: change of forces from one round of an event to the next, relative to them, that is rounding


class Touching(NamedTuple):
    """The contacts (numbers) whose gaps are closed, their rows W (r, n), X (n, r), and the problem with G (r, r)."""

    which: NDArray[np.int64]
    W: Array
    X: Array
    laws: Contacts

    @property
    def normals(self) -> list[int]:
        return self.laws.first

    def only(self, at: NDArray[np.int64]) -> Touching:
        """Some of the contacts."""
        rows = [r for i in at for r in range(self.normals[i], self.normals[i] + self.laws.sizes[i])]
        return Touching(self.which[at], self.W[rows], self.X[:, rows], self.laws.only(at.tolist()))

    def supported(self, b: Array, rest: NDArray[np.bool_]) -> Array:
        """The accelerations of gaps (k,) with the contacts at ``rest`` closed, where ``b`` are those with all open: a
        ball bounces on a table that its floor carries."""
        at = np.flatnonzero(rest)
        if not len(at) or len(at) == len(rest):
            return b
        G = self.laws.G[np.ix_(self.normals, self.normals)]
        found = contact_modes.solve(Contacts(G[np.ix_(at, at)], (1,) * len(at), np.zeros(len(at))), b[at])
        return b if found is None else b + G[:, at] @ found[0]

    def carried(self, u: Array, rest: NDArray[np.bool_]) -> Array:
        """The rates of gaps (k,) once those at ``rest`` are held, where ``u`` are those before."""
        at, G = np.flatnonzero(rest), self.laws.G[np.ix_(self.normals, self.normals)]
        return u - G[:, at] @ least_squares(G[np.ix_(at, at)], u[at], DEPENDS) if len(at) else u


def alike(x: Array, y: Array) -> bool:
    """Whether two arrays differ by rounding alone."""
    return x.shape == y.shape and bool(np.abs(x - y).max(initial=0.0) <= ROUGHLY * np.abs(y).max(initial=0.0))


def senses(own: Touching, u: Array, edge: float) -> tuple[int, ...]:
    """Of each contact the sign of its slip, 1 if this has two directions; 0 of those at rest."""
    found = []
    for i, size in enumerate(own.laws.sizes):
        slip = u[own.laws.tangents(i)]
        moves = size > 1 and np.linalg.norm(slip) > edge
        found.append(0 if not moves else 1 if size == 3 else int(np.sign(slip[0])))
    return tuple(found)


def reduced(own: Touching, u: Array, slips: tuple[int, ...]) -> tuple[Contacts, Array]:
    """The problem in which contacts in space that slide have friction along their slip alone, and the matrix
    (rows, r) of its rows."""
    laws, rows, sizes = own.laws, [], []
    every = np.eye(len(u))
    for i, (n, size) in enumerate(zip(laws.first, laws.sizes, strict=True)):
        rows.append(every[n : n + 1])
        T = laws.tangents(i)
        along = size == 3 and slips[i]
        rows.append((u[T] / np.linalg.norm(u[T])) @ every[T] if along else every[T])
        sizes.append(2 if along else size)
    turn = np.vstack(rows) if rows else np.zeros((0, 0))
    return Contacts(turn @ laws.G @ turn.T, tuple(sizes), laws.mu, slips, laws.mu_s), turn
