"""Unilateral contacts with Coulomb friction at one time: which of them are open, stick or slip, and their reactions.

    w = b + G P;   0 <= w_N  perp  P_N >= 0;   |P_T| <= mu P_N, and P_T = -mu P_N w_T/|w_T| where w_T is not zero

w and P have one row for the normal of each contact, followed by none, one (plane) or two (space) for its tangents.
With velocities and impulses this is an impact (:mod:`mbdsl.numerics.impact`), with accelerations and forces a lasting
contact. G = W^T P W is Delassus's matrix. Up to ``FEW`` contacts in the plane, all modes are tried, those closest to
the present ones first. Else projected Gauss-Seidel (M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999) 235-257)
finds the modes, and Newton's method solves their equations.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from mbdsl.numerics.saddle_point import least_squares

Array = NDArray[np.float64]
Modes = tuple[int, ...]

#: FORWARD, BACKWARD: slips with w_T > 0, w_T < 0; in space all slip FORWARD. AT_LIMIT: other contacts hold it, and its
#: friction is the largest, as if it slipped FORWARD or BACKWARD
OPEN, STICK, FORWARD, BACKWARD, AT_LIMIT, AT_LIMIT_BACKWARD = range(6)
SENSE = {FORWARD: 1.0, BACKWARD: -1.0, AT_LIMIT: 1.0, AT_LIMIT_BACKWARD: -1.0}
FEW = 4  #: most contacts of which all modes are tried
SWEEPS, SETTLED = 5000, 1e-13  #: most sweeps of Gauss-Seidel, and their last relative change
UNBOUNDED = 1e9  #: size of P, relative to b, above which there is no solution
WRONG = 1e-9  #: relative error of a solution above which it is none
DEPENDENT = 1e-10  #: relative pivot below which a row depends on others
ROUNDING = 1e-12  #: the same, of forces that are rounding
LOOSE = 1e-5  #: the same, of many contacts in a step of a run, which the next step corrects
SWITCHES = 20  #: most sets of modes that are tried from a guess
NEWTON = 50  #: most iterations for the directions of slip in space


@dataclass(frozen=True)
class Contacts:
    """k contacts: Delassus's matrix G (r, r), number of rows (1, 2 or 3) and coefficient of friction of each.

    ``slips`` (k,), in the plane: the sign of the slip of those that slide already, so that they cannot stick; else 0.
    ``mu_s`` (k,): coefficients of those that stick; without it those of ``mu``.
    """

    G: Array
    sizes: tuple[int, ...]
    mu: Array
    slips: tuple[int, ...] = ()
    mu_s: Array | None = None

    @cached_property
    def first(self) -> list[int]:
        """The row of each contact's normal."""
        return [0, *np.cumsum(self.sizes).tolist()][:-1]

    def tangents(self, i: int) -> slice:
        return slice(self.first[i] + 1, self.first[i] + self.sizes[i])

    def slides(self, i: int) -> int:
        """The sign of the slip of contact i, if it slides already; else 0."""
        return self.slips[i] if self.slips else 0

    def limit(self, i: int, mode: int = STICK) -> float:
        """The coefficient of the largest friction of contact i in a mode."""
        return float(self.mu[i] if self.mu_s is None or mode in (FORWARD, BACKWARD) else self.mu_s[i])

    def rubs(self, i: int) -> bool:
        """Whether contact i has friction."""
        return self.sizes[i] > 1 and self.limit(i) > 0.0

    def choices(self, i: int) -> tuple[int, ...]:
        """The modes that contact i may have."""
        if not self.rubs(i):
            return OPEN, FORWARD
        if self.slides(i):
            return OPEN, FORWARD if self.slides(i) > 0 else BACKWARD
        if self.sizes[i] == 3:
            return OPEN, STICK, FORWARD
        at_limit = (AT_LIMIT, AT_LIMIT_BACKWARD) if len(self.sizes) > 1 and self.limit(i) > self.mu[i] else ()
        return (OPEN, STICK, FORWARD, BACKWARD, *at_limit)

    def only(self, which: Sequence[int]) -> Contacts:
        """Some of the contacts."""
        rows = [r for i in which for r in range(self.first[i], self.first[i] + self.sizes[i])]
        slips = tuple(self.slips[i] for i in which) if self.slips else ()
        mu_s = None if self.mu_s is None else self.mu_s[list(which)]
        sizes = tuple(self.sizes[i] for i in which)
        return Contacts(self.G[np.ix_(rows, rows)], sizes, self.mu[list(which)], slips, mu_s)

    def held(self, modes: Modes) -> list[int]:
        """The rows that are zero in these modes: normals of closed contacts, and tangents of those that stick."""
        own = zip(self.first, self.sizes, modes, strict=True)
        return [r for n, size, x in own if x != OPEN for r in range(n, n + (size if x == STICK else 1))]


def solve(
    contacts: Contacts, b: Array, last: Modes | None = None, independent: bool = False, guess: Array | None = None
) -> tuple[Array, Modes] | None:
    """P (r,) and the mode of each contact; None if there is no solution.

    ``last``: the present modes, which are tried first; with the P (r,) of them as a ``guess``, also of many contacts.
    ``independent``: modes whose rows that are zero do not depend on each other are preferred, of few contacts in the
    plane: their reactions are unique. There are such modes wherever there is a solution, as a basis of a linear
    programme.
    """
    few, plane = len(contacts.sizes) <= FEW, max(contacts.sizes, default=1) < 3
    if few and plane:
        ordered = list(_in_order(contacts, last))
        unique = [x for x in ordered if independent_rows(contacts.G, contacts.held(x)).all()] if independent else []
        found = _tried(contacts, b, unique, None)
        return found if found is not None else _tried(contacts, b, ordered, None)
    if last is not None and guess is not None and (found := _switched(contacts, b, last, guess)) is not None:
        return found
    P = _gauss_seidel(contacts, b, guess)
    if P is None:
        return None
    modes = tuple(_mode(contacts, b, P, i) for i in range(len(contacts.sizes)))
    if (exact := _tried(contacts, b, [modes], P)) is not None:
        return exact
    if _error(contacts, b, P, modes) <= (WRONG if guess is None else LOOSE):
        return P, modes
    return _tried(contacts, b, _in_order(contacts, modes), P) if few else None


def _tried(contacts: Contacts, b: Array, all_modes: Iterable[Modes], P: Array | None) -> tuple[Array, Modes] | None:
    """The first of these modes whose solution, in space by iterations from ``P``, obeys the laws."""
    for modes in all_modes:
        found = _solution(contacts, b, modes, P)
        if found is not None and _error(contacts, b, found, modes) <= WRONG:
            return found, modes
    return None


def _switched(contacts: Contacts, b: Array, modes: Modes, P: Array) -> tuple[Array, Modes] | None:
    """The solution by modes each of which is switched as the solution of all of them violates its law, a method of
    active sets; None if it has not ended after ``SWITCHES`` solutions."""
    mass = np.where(contacts.G.diagonal() > 0.0, contacts.G.diagonal(), 1.0)
    for _ in range(SWITCHES):
        found = _solution(contacts, b, modes, P)
        if found is None:
            return None
        if _error(contacts, b, found, modes) <= WRONG:
            return found, modes
        P = found
        x = P - (b + contacts.G @ P) / mass
        modes = tuple(_projected_mode(contacts, x, i) for i in range(len(modes)))
    return None


def _projected_mode(contacts: Contacts, x: Array, i: int) -> int:
    """The mode of contact i whose law holds at the projection of impulses ``x`` (r,)."""
    n, T = contacts.first[i], contacts.tangents(i)
    if x[n] <= 0.0:
        return OPEN
    if not contacts.rubs(i) or contacts.slides(i):
        return contacts.choices(i)[-1]
    if np.linalg.norm(x[T]) <= contacts.mu[i] * x[n]:
        return STICK
    return BACKWARD if contacts.sizes[i] == 2 and x[T][0] > 0.0 else FORWARD


def _in_order(contacts: Contacts, last: Modes | None) -> Iterator[Modes]:
    """All modes, those with the fewest changes from ``last`` first."""
    choices = [contacts.choices(i) for i in range(len(contacts.sizes))]
    if last is None:  # closed contacts stick, those that slide go on
        last = tuple(STICK if STICK in x else x[-1] for x in choices)
    for changed in range(len(choices) + 1):
        for which in combinations(range(len(choices)), changed):
            others = [[x for x in choices[i] if x != last[i]] if i in which else [last[i]] for i in range(len(choices))]
            if all(last[i] in choices[i] for i in range(len(choices)) if i not in which):
                yield from product(*others)


def _solution(contacts: Contacts, b: Array, modes: Modes, P: Array | None = None) -> Array | None:
    """P of these modes; in space by Newton's method from ``P``. Where rows depend on each other, that nearest to ``P``,
    which is zero unless it is given."""
    G, r = contacts.G, len(b)
    P = np.zeros(r) if P is None else P
    scale = np.sqrt(np.where(G.diagonal() > 0.0, G.diagonal(), 1.0))
    curved = any(mode > STICK and size == 3 for mode, size in zip(modes, contacts.sizes, strict=True))
    for _ in range(NEWTON if curved else 1):
        J, right = _equations(contacts, b, modes, P)
        if not (np.isfinite(J).all() and np.isfinite(right).all()):
            return None
        x = P + least_squares(J / scale, right - J @ P, 1e-12) / scale
        change, P = np.abs(scale * (x - P)).max(initial=0.0), x
        if change <= 1e-15 * np.abs(scale * P).max(initial=0.0):
            break
    return P


def _equations(contacts: Contacts, b: Array, modes: Modes, P: Array) -> tuple[Array, Array]:
    """J (r, r) and c (r,) of the equations J P = c of these modes, linearised about ``P``."""
    G, r = contacts.G, len(b)
    J, c = np.zeros((r, r)), np.zeros(r)
    w = b + G @ P
    for i, mode in enumerate(modes):
        n, T, mu = contacts.first[i], contacts.tangents(i), contacts.mu[i]
        own = slice(n, T.stop)
        if mode == OPEN:
            J[own, own] = np.eye(contacts.sizes[i])
            continue
        rows = own if mode == STICK else slice(n, n + 1)
        J[rows], c[rows] = G[rows], -b[rows]
        if mode == STICK or contacts.sizes[i] == 1:
            continue
        J[T, T] = np.eye(contacts.sizes[i] - 1)
        if not contacts.rubs(i):
            continue
        if contacts.sizes[i] == 2:
            J[T, n] = SENSE[mode] * contacts.limit(i, mode)
            continue
        speed = np.hypot(*w[T])
        along = w[T] / speed if speed > 0.0 else np.zeros(2)
        across = (np.eye(2) - np.outer(along, along)) / (speed or 1.0) * mu * P[n]
        J[T, n] = mu * along
        J[T] += across @ G[T]
        c[T] = across @ (G[T] @ P)
    others = sorted(set(range(r)) - set(contacts.held(modes)))  # rows of impulses, with the unit of the others
    mass = np.where(G.diagonal() > 0.0, G.diagonal(), 1.0)[others]
    J[others], c[others] = mass[:, None] * J[others], mass * c[others]
    return J, c


def _mode(contacts: Contacts, b: Array, P: Array, i: int) -> int:
    """The mode of contact i at an approximate solution."""
    n, T = contacts.first[i], contacts.tangents(i)
    if contacts.G[n, n] * P[n] <= SETTLED * np.abs(b).max(initial=0.0):
        return OPEN
    if not contacts.rubs(i) or contacts.slides(i):
        return contacts.choices(i)[-1]
    if np.linalg.norm(P[T]) < contacts.limit(i) * P[n] * (1.0 - 1e-9):
        return STICK
    return BACKWARD if contacts.sizes[i] == 2 and P[T][0] > 0.0 else FORWARD


def _error(contacts: Contacts, b: Array, P: Array, modes: Modes) -> float:
    """The largest violation of the laws, relative to b; rows of impulses by the diagonal of G."""
    w = b + contacts.G @ P
    mass = np.where(contacts.G.diagonal() > 0.0, contacts.G.diagonal(), 1.0)
    wrong, size = 0.0, float(np.abs(b).max(initial=0.0)) or 1.0
    for i, mode in enumerate(modes):
        n, T, mu = contacts.first[i], contacts.tangents(i), contacts.limit(i, mode)
        wrong = max(wrong, -w[n], -mass[n] * P[n], abs(w[n]) if mode != OPEN else abs(mass[n] * P[n]))
        if not contacts.rubs(i):
            continue
        most = mu * max(0.0, P[n])
        excess = float(np.linalg.norm(P[T])) - most
        if mass[T].max() * excess > ROUNDING * size:
            wrong = max(wrong, size * excess / most if most else np.inf)
        if mode in (STICK, AT_LIMIT, AT_LIMIT_BACKWARD):
            wrong = max(wrong, float(np.abs(w[T]).max()))
        elif mode != OPEN and not contacts.slides(i):  # friction is opposite to the slip: P_T . w_T = -mu P_N |w_T|
            speed = float(np.linalg.norm(w[T]))
            force = mu * max(P[n], 0.0)
            wrong = max(wrong, speed + float(P[T] @ w[T]) / force if force > 0.0 else 0.0)
            if contacts.sizes[i] == 2 and w[n + 1] * (1.0 if mode == FORWARD else -1.0) < 0.0:
                wrong = max(wrong, speed)
            if speed <= WRONG * size and mu < contacts.limit(i):
                return np.inf  # it does not slide
    return wrong / size


def independent_rows(G: Array, rows: Sequence[int]) -> NDArray[np.bool_]:
    """Whether each of the ``rows`` is independent of those before it, by the pivots of Cholesky's method."""
    A, found = G[np.ix_(rows, rows)], np.zeros(len(rows), bool)
    size = A.diagonal().copy()
    for k in range(len(A)):
        found[k] = A[k, k] > DEPENDENT * size[k]
        if found[k]:
            A[k + 1 :, k + 1 :] -= np.outer(A[k + 1 :, k], A[k, k + 1 :]) / A[k, k]
    return found


def _gauss_seidel(contacts: Contacts, b: Array, guess: Array | None = None) -> Array | None:
    """P by projected Gauss-Seidel, from ``guess``: the normals onto P_N >= 0, the tangents onto the disc
    |P_T| <= mu P_N; None if P grows without bound."""
    G, P = contacts.G, np.zeros(len(b)) if guess is None else guess.copy()
    normal = [G[n, n] for n in contacts.first]
    tangent = [np.linalg.eigvalsh(G[T, T]).max(initial=0.0) for T in map(contacts.tangents, range(len(normal)))]
    mass = np.where(G.diagonal() > 0.0, G.diagonal(), 1.0)
    most = UNBOUNDED * float(np.abs(b).max(initial=0.0))
    for _ in range(SWEEPS):
        before = P.copy()
        for i, n in enumerate(contacts.first):
            if normal[i] > 0.0:
                P[n] = max(0.0, P[n] - (b[n] + G[n] @ P) / normal[i])
            T = contacts.tangents(i)
            if contacts.slides(i):
                P[T] = -contacts.slides(i) * contacts.mu[i] * P[n]
            elif contacts.rubs(i) and tangent[i] > 0.0:
                x = P[T] - (b[T] + G[T] @ P) / tangent[i]
                long, radius = float(np.linalg.norm(x)), contacts.limit(i) * P[n]
                P[T] = x if long <= radius else x * (radius / long)
        size = np.abs(mass * P).max(initial=0.0)
        if size > most:
            return None
        if np.abs(mass * (P - before)).max(initial=0.0) <= SETTLED * size:
            break
    return P


# -- Painleve's paradox ------------------------------------------------------------------------------------------------


def painleve(contacts: Contacts) -> tuple[int, float] | None:
    """A sliding contact whose friction is too large for a unique reaction, and the least such mu of it.

    With A_ij = G_NiNj - s_j mu_j G_NiTj of the contacts that slide, all principal minors have to be positive; the
    least mu is that of a common factor of all mu. They are positive if A + A^T is positive definite, which needs no
    search of the many combinations.

    Returns
    -------
    contact, mu : int, float
        None if the reactions are unique.
    """
    sliding = [i for i in range(len(contacts.sizes)) if contacts.slides(i) and contacts.rubs(i)]
    sizes = np.linalg.eigvalsh((A := _of_normals(contacts, sliding, 1.0)) + A.T)
    if sizes.min(initial=np.inf) > SETTLED * sizes.max(initial=0.0):
        return None
    for count in range(1, min(len(sliding), 2 * FEW) + 1):
        for which in combinations(sliding, count):
            if not independent_rows(contacts.G, [contacts.first[i] for i in which]).all():
                continue  # the minor is zero, whatever the friction is
            if _least_minor(contacts, which, 1.0) <= 0.0:
                low, high = 0.0, 1.0
                while high - low > 1e-12:
                    middle = 0.5 * (low + high)
                    low, high = (low, middle) if _least_minor(contacts, which, middle) <= 0.0 else (middle, high)
                return which[-1], high * float(contacts.mu[which[-1]])
    return None


def _least_minor(contacts: Contacts, which: Sequence[int], factor: float) -> float:
    """det A of these contacts with ``factor`` times their mu."""
    return float(np.linalg.det(_of_normals(contacts, which, factor)))


def _of_normals(contacts: Contacts, which: Sequence[int], factor: float) -> Array:
    """A (k, k) of these k contacts with ``factor`` times their mu."""
    N = np.array([contacts.first[i] for i in which], int)
    rub = factor * contacts.mu[list(which)] * np.array([contacts.slips[i] for i in which])
    return contacts.G[np.ix_(N, N)] - contacts.G[np.ix_(N, N + 1)] * rub
