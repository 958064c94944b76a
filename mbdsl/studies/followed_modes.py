"""Modes of a sweep followed from point to point, so that their curves do not jump where frequencies cross.

Modes of neighbouring points belong together where the modal assurance criterion (MAC; Allemang, Brown, Proc. 1st Int.
Modal Analysis Conf. (1982) 110) of their shapes is large, |x^H y|^2/(x^H x y^H y). Shapes are weighted by the masses,
so that those of different modes are nearly orthogonal, and contain the velocities, which separate decays with one
shape. Where the criterion is not clear, or the order by frequency changes, points are added between: shapes of modes
that cross stay, and those of modes that veer from each other change within the gap.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mbdsl.analysis.eigenmodes import Mode, Modes
from mbdsl.kernels.arrays import Array, Complex, Integers
from mbdsl.studies.measures import MODES
from mbdsl.studies.store import Computed
from mbdsl.studies.sweep_values import Varied

CLEAR = 0.75  #: least assurance of modes that belong together
HALVINGS, MOST = 8, 200  #: largest number of halvings between two points, and of points added in a sweep
EQUAL = 1e-6  #: relative difference of eigenvalues whose shapes are combinations of each other
MASSLESS = 1e-6  #: weight of coordinates without mass, relative to the largest


@dataclass(frozen=True)
class Shapes:
    """Eigenvalues (K,) [1/s] and weighted shapes (K, n) of size one, of modes in the order in which they are followed.

    ``number`` (K,) are their places by frequency, from 0; -1 of a mode that is lost.
    """

    values: Complex
    shapes: Complex
    number: Integers


def with_modes(run: Computed, modes: Modes) -> Computed:
    """A run with modes: their weighted shapes are its q (real parts) and v (imaginary parts), eigenvalues are lam."""
    system, scale = modes.system, modes.system.tables.scale
    mass = system.M(modes.t, modes.q).diagonal()
    least = MASSLESS * float((mass / scale**2).max(initial=0.0)) or 1.0
    weight = np.sqrt(np.maximum(mass, least * scale**2))
    shapes = np.array([mode.shape * weight for mode in modes], complex).reshape(len(modes), system.n)
    values = np.array([mode.eigenvalue for mode in modes], complex)
    return replace(run, q=shapes.real, v=shapes.imag, lam=np.stack([values.real, values.imag], axis=1))


def shapes_of(run: Computed) -> Shapes | None:
    """The modes of a run by frequency; None if it has none."""
    if not run.done or run.lam.ndim != 2 or not len(run.lam):
        return None
    x = run.q + 1j * run.v
    size = np.linalg.norm(x, axis=1, keepdims=True)
    values = run.lam[:, 0] + 1j * run.lam[:, 1]
    return Shapes(values, np.asarray(x / np.where(size > 0.0, size, 1.0), complex), np.arange(len(values)))


def assurance(a: Shapes, b: Shapes) -> Array:
    """The criterion (K, L) of the modes of two points."""
    found = np.abs(a.shapes.conj() @ b.shapes.T) ** 2
    s, t = a.values[:, None], b.values[None]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.abs(s) / np.abs(t)
        same = np.abs(1.0 + s.conj() * t / np.abs(s * t)) ** 2 / ((1.0 + ratio) * (1.0 + 1.0 / ratio))
    return np.asarray(found * np.where((np.abs(s) > 0.0) & (np.abs(t) > 0.0), same, 1.0))


def aligned(a: Shapes, b: Shapes) -> Shapes:
    """The modes b, where those with equal eigenvalues are the combinations that are closest to modes of a."""
    shapes, left = b.shapes.copy(), set(range(len(b.values)))
    for k in range(len(b.values)):
        near = np.abs(b.values - b.values[k]) <= EQUAL * abs(b.values[k])
        cluster = [j for j in np.flatnonzero(near) if j in left]
        left -= set(cluster)
        if len(cluster) < 2:
            continue
        Q = np.linalg.qr(b.shapes[cluster].T)[0].T
        if len(Q) < len(cluster):
            continue
        parts = a.shapes @ Q.conj().T
        chosen = np.sort(np.argsort(-np.linalg.norm(parts, axis=1), kind="stable")[: len(cluster)])
        if len(chosen) < len(cluster):
            continue
        U, _, V = np.linalg.svd(parts[chosen])
        shapes[cluster] = U @ V @ Q
    return Shapes(b.values, shapes, b.number)


def assigned(a: Shapes, b: Shapes, asked: int) -> tuple[Shapes, bool, bool]:
    """The modes b in the order of a; whether this is clear for the first ``asked`` modes, and keeps their order."""
    from scipy.optimize import linear_sum_assignment

    b = aligned(a, b)
    if a.shapes.shape[1] != b.shapes.shape[1]:
        order, sure = np.arange(min(len(a.values), len(b.values))), np.zeros(len(a.values))
        rows = order
    else:
        sure_of = assurance(a, b)
        rows, order = linear_sum_assignment(-sure_of)
        sure = np.zeros(len(a.values))
        sure[rows] = sure_of[rows, order]
    K = len(a.values)
    values, number = np.full(K, np.nan + 0j), np.full(K, -1)
    shapes = a.shapes.copy() if a.shapes.shape[1] == b.shapes.shape[1] else np.zeros((K, b.shapes.shape[1]), complex)
    values[rows], number[rows], shapes[rows] = b.values[order], b.number[order], b.shapes[order]
    kept = [k for k in range(min(asked, K)) if a.number[k] >= 0]
    clear = all(sure[k] >= CLEAR for k in kept)
    # of two modes with equal frequencies, the order may change without a crossing
    before, after = np.abs(a.values), np.abs(values)
    crossing = any(
        (before[j] - before[k]) * (after[j] - after[k]) < 0.0 for j in kept for k in range(K) if number[k] >= 0
    )
    return Shapes(values, shapes, number), clear, not crossing


@dataclass
class Follower:
    """Follows modes between points, which are tuples of the values of the parameters.

    ``between(a, b)`` is the point in the middle and its run, or None.
    """

    asked: int
    between: Callable[[tuple, tuple], tuple[tuple, Computed] | None]
    added: int = 0

    def follow(self, at: tuple, a: Shapes, to: tuple, b: Shapes, halvings: int = HALVINGS) -> tuple[Shapes, bool]:
        """The modes b of the point ``to`` in the order of those of ``at``, and whether this order is certain."""
        found, clear, ordered = assigned(a, b, self.asked)
        if (clear and ordered) or not halvings or self.added >= MOST:
            return found, clear
        middle = self.between(at, to)
        shapes = shapes_of(middle[1]) if middle is not None else None
        if middle is None or shapes is None:
            return found, clear
        self.added += 1
        first, sure = self.follow(at, a, middle[0], shapes, halvings - 1)
        second, sure_too = self.follow(middle[0], first, to, b, halvings - 1)
        return second, sure and sure_too


def followed(
    follower: Follower,
    rows: Sequence[tuple[int, ...]],
    points: Sequence[tuple],
    runs: Sequence[Computed],
    paired: bool,
) -> tuple[list[Shapes | None], list[int]]:
    """The modes of each row in the order in which they are followed, and the rows where it is not certain.

    ``rows`` are the indices of the values of the parameters, ``points`` these values. A row follows its neighbour with
    the next lower value of the first parameter that is not at its first value; if that run has no modes, the row before
    it. Curves over the first parameter are thus followed each by itself; a way around a crossing, with other values of
    the others, may lead to another order.
    """
    places = {row: k for k, row in enumerate(rows)}
    found: list[Shapes | None] = []
    uncertain = []
    for k, row in enumerate(rows):
        b, before = shapes_of(runs[k]), row
        source: int | None = None
        while b is not None and any(before) and source is None:
            first = 0
            while not before[first]:
                first += 1
            lower = (before[first] - 1,)
            before = lower * len(before) if paired else (*before[:first], *lower, *before[first + 1 :])
            source = places[before] if found[places[before]] is not None else None
        if b is None or source is None:
            found.append(b)
            continue
        a = found[source]
        assert a is not None
        if not any(rows[source]):  # at the first point, modes with equal frequencies have no order yet
            a = aligned(b, a)
        shapes, sure = follower.follow(points[source], a, points[k], b)
        found.append(shapes)
        uncertain += [] if sure else [k]
    return found, uncertain


def values(measures: Sequence, shapes: Shapes | None, run: Computed) -> Mapping[str, float]:
    """The measures of a run, with those of modes in the order in which they are followed."""
    found = dict(run.stats.get("values", {}))
    for m in measures:
        if m.of == MODES and shapes is not None:
            k = int(m.signal) - 1
            lost = k >= len(shapes.number) or shapes.number[k] < 0
            mode = None if lost else Mode(complex(shapes.values[k]), shapes.shapes[k], {})
            found[str(m)] = math.nan if mode is None else float(getattr(mode, m.function))
    return found


def notes(
    ranges: Sequence[Varied],
    rows: Sequence[tuple[int, ...]],
    found: Sequence[Shapes | None],
    uncertain: Sequence[int],
    follower: Follower,
) -> list[str]:
    """Sentences: where the order by frequency is another one than at the first point, and where it is not certain."""

    def where(k: int) -> str:
        return ", ".join(p.said(j) for p, j in zip(ranges, rows[k], strict=True))

    lines = []
    for k, shapes in enumerate(found):
        moved = (
            []
            if shapes is None
            else [j for j in range(min(follower.asked, len(shapes.number))) if shapes.number[j] != j]
        )
        if not moved or shapes is None:
            continue
        j = moved[0]
        place = "not among the modes" if shapes.number[j] < 0 else f"mode {shapes.number[j] + 1} by frequency"
        lines.append(f"modes are followed by their shapes from {where(0)}: at {where(k)}, mode {j + 1} is {place}")
        break
    if uncertain:
        more = f" and {len(uncertain) - 1} more" if len(uncertain) > 1 else ""
        lines.append(
            f"which mode is which is not certain at {where(uncertain[0])}{more}: their shapes change too much from the "
            "point before; give more values"
        )
    return lines
