"""Friction of joints that hold the same motion, which the equations of motion do not determine.

Of the rows that hold joints, those are left out that depend on others. All multipliers that give the same accelerations
are lam + Z y, with Z the null space of the transposed rows. Joints can stay at rest if |F_i| <= mu_s N_i for some y.
Shares in proportion to mu_s N are those of the least sum of |F_i|^2/(mu_s N_i), which are linear in lam. If they do not
satisfy this, a linear program looks for others (:mod:`mbdsl.numerics.friction_shares`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.sticking import Sticking
from mbdsl.numerics.friction_shares import FrictionLimits, largest_reserve
from mbdsl.numerics.saddle_point import dense
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.signals import values

Joints = Sequence[tuple[Sticking, list[int]]]  #: joints and the rows that hold them
DEPENDENT = 1e-9  #: part of a row of length one that others leave, and counts as zero
TINY = float(np.finfo(float).tiny)


class At(NamedTuple):
    """The state at an event, the rows that are left out, the numbers, and the joints at rest by their numbers."""

    t: float
    q: Array
    v: Array
    left_out: tuple[int, ...]
    numbers: dict[str, float]
    resting: list[int]


def put(system: System, numbers: Mapping[str, float], left_out: tuple[int, ...]) -> None:
    """Set rows and numbers of ``system``."""
    system.activate(left_out)
    for name in system.tables.inputs:
        if name in numbers:
            system.set_input(name, numbers[name])


def motion(system: System, at: At, left_out: tuple[int, ...]) -> tuple[Array, Array]:
    """Accelerations and multipliers with the numbers of ``at``."""
    put(system, at.numbers, left_out)
    return accelerations(system, at.t, at.q, at.v, left_out)


class RowsHeld(NamedTuple):
    """Rows that hold joints: all of them, those that are independent, and the null space Z (m + p, d)."""

    rows: list[int]
    kept: list[int]
    Z: Array


def independent(system: System, at: At, left_out: tuple[int, ...], rows: list[int]) -> RowsHeld:
    """Those of ``rows`` that are independent of all other rows that are not left out, and of those before them."""
    J = dense(system.velocity_jacobian(at.t, at.q, at.v)) / system.tables.scale
    size = np.maximum(np.linalg.norm(J, axis=1), TINY)
    J = J / size[:, None]
    others = np.setdiff1d(np.arange(len(J)), [*left_out, *rows])
    basis = np.linalg.qr(J[others].T)[0] if len(others) else np.zeros((J.shape[1], 0))
    kept: list[int] = []
    Z = np.zeros((len(J), 0))
    for row in rows:
        rest = J[row]
        for _ in range(2):  # twice is enough (Kahan)
            rest = rest - basis @ (basis.T @ rest)
        left = float(np.linalg.norm(rest))
        if left > DEPENDENT:
            kept.append(row)
            basis = np.column_stack([basis, rest / left])
        else:
            before, z = [*others, *kept], np.zeros(len(J))
            z[before], z[row] = -np.linalg.lstsq(J[before].T, J[row], rcond=None)[0], 1.0
            Z = np.column_stack([Z, z])
    return RowsHeld(rows, kept, Z / size[:, None])


def share(system: System, at: At, joints: Joints, held: RowsHeld, lam: Array) -> dict[str, float] | None:
    """The numbers by which each of the joints carries a part of the multipliers lam (m + p,); None if they cannot
    stay at rest."""
    place = {row: i for i, row in enumerate(held.rows)}
    own = [[place[row] for row in rows] for _, rows in joints]
    limits = FrictionLimits(own, np.array([x.mu_s for x, _ in joints]), *_normals(system, at, joints, held.Z, lam))
    most = np.maximum(limits.mu * limits.N, TINY)
    weight = np.empty((len(place), 1))
    for k, which in enumerate(own):
        weight[which] = np.sqrt(most.min() / most[k])
    Z, E = held.Z[held.rows], np.diag([float(row in held.kept) for row in held.rows])
    ways = np.linalg.lstsq(weight * Z, weight * E, rcond=None)[0]
    S, multipliers = E - Z @ ways, lam[held.rows]
    if limits.exceeded(S @ multipliers, -ways @ multipliers):
        y = largest_reserve(E @ multipliers, Z, limits)
        if y is None:
            return None
        change = (E - S) @ multipliers + Z @ y
        S = S + np.outer(change, multipliers) / max(float(multipliers @ multipliers), TINY)
    names = {row: name for x, rows in joints for row, name in zip(rows, x.rows, strict=True)}
    parts = [(x, k, row) for x, rows in joints for k, row in enumerate(rows) if x.among]
    return {x.share(k, names[r]): float(S[place[row], place[r]]) for x, k, row in parts for r in held.rows}


def _normals(system: System, at: At, joints: Joints, Z: Array, lam: Array) -> tuple[Array, Array]:
    """The normal forces N (k,) of joints, and their derivatives with respect to y (k, d)."""
    size = np.maximum(np.abs(Z).max(axis=0, initial=0.0), TINY)
    step = 1e-6 * max(float(np.abs(lam).max(initial=0.0)), TINY) / size
    many = np.vstack([lam, lam + (step * Z).T, lam - (step * Z).T])
    count, d = len(many), Z.shape[1]
    t, q, v = np.full(count, at.t), np.tile(at.q, (count, 1)), np.tile(at.v, (count, 1))
    inputs = {name: np.full(count, x) for name, x in at.numbers.items()}
    found = np.array(values(system, [x.normal for x, _ in joints], t, q, v, many, inputs))
    return found[:, 0], (found[:, 1 : 1 + d] - found[:, 1 + d :]) / (2 * step)
