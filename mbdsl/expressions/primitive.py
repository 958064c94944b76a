"""The potential of a law of one coordinate: its integral, computed for arrays of arguments."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbdsl.expressions.array_operations import ARRAY_OPERATIONS, table_value
from mbdsl.expressions.symbolic import Expr, const, evaluate, leaves, rebuild, walk

Array = NDArray[np.float64]

VARIABLE = Expr("variable")  #: the coordinate, in the law of an integral
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
ACCURACY, DEPTH = 1e-12, 40  #: relative difference of an interval's integral from that of its halves; most halvings


def potential(law: Expr, coordinate: Expr, rate: Expr | None, start: float) -> Expr | None:
    """The integral of ``law`` over its ``coordinate`` from ``start`` on; None if it depends on anything else.

    A dependence on the ``rate`` of the coordinate is damping: the force at rest has the potential.
    """
    new: dict[Expr, Expr] = {}
    for n in walk(law):
        if n is coordinate:
            new[n] = VARIABLE
        elif n is rate:
            new[n] = const(0.0)
        else:
            new[n] = n if all(new[a] is a for a in n.args) else rebuild(n, [new[a] for a in n.args])
    inside = new[law]
    if any(leaf is not VARIABLE for leaf in leaves(inside)) or any(n.op == "angle" for n in walk(inside)):
        return None
    return Expr("integral", (coordinate,), (inside, start))


def integral(law: Expr, start: float, x: object) -> Array:
    """The integral of ``law`` (over ``VARIABLE``) from ``start`` to each of ``x`` (N,), or a number.

    Gauss-Legendre quadrature between neighbouring arguments, which are halved until both agree.
    """
    given = np.asarray(x, float)
    ends = np.unique(np.append(given.ravel(), start))
    ends = ends[np.isfinite(ends)]
    a, b, owner = ends[:-1], ends[1:], np.arange(len(ends) - 1)
    total, whole = np.zeros(len(owner)), _gauss(law, a, b)
    size = np.abs(whole).max(initial=0.0)
    for _ in range(DEPTH):
        middle = 0.5 * (a + b)
        left, right = _gauss(law, a, middle), _gauss(law, middle, b)
        good = ~(np.abs(left + right - whole) > ACCURACY * size)  # nan: the law has no value
        np.add.at(total, owner[good], (left + right)[good])
        if good.all():
            break
        bad = ~good
        a, b = np.concatenate([a[bad], middle[bad]]), np.concatenate([middle[bad], b[bad]])
        owner, whole = np.tile(owner[bad], 2), np.concatenate([left[bad], right[bad]])
    else:
        np.add.at(total, owner, whole)
    sums = np.concatenate([[0.0], np.cumsum(total)])
    sums -= sums[np.searchsorted(ends, start)]
    return np.where(np.isfinite(given), sums[np.searchsorted(ends, given).clip(0, len(ends) - 1)], np.nan)


def _gauss(law: Expr, a: Array, b: Array) -> Array:
    """The integrals over the intervals from a to b (n,)."""
    half = 0.5 * (b - a)
    points = 0.5 * (a + b)[:, None] + half[:, None] * NODES
    with np.errstate(all="ignore"):
        (found,) = evaluate([law], lambda _: points.ravel(), ARRAY_OPERATIONS, table_value)  # type: ignore[arg-type]
    return half * (np.broadcast_to(np.asarray(found, float), points.size).reshape(points.shape) @ WEIGHTS)
