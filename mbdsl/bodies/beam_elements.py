"""Finite elements of a straight beam: cubic (Hermite) for deflection, quadratic (Lagrange) for axial displacement."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mbdsl.kernels.arrays import Array

Reference = Literal["pinned-pinned", "clamped-free", "mean-axis"]

GAUSS = 4  #: points per element; exact to degree 7, while v v and x^2 v' v' have degree 6
DUST = 1e-14  #: integrals of modes that are smaller than this part of their upper bound are set to zero
#: reference conditions -> axial and bending coordinates held at zero; negative indices count from the far end
HELD: dict[Reference, tuple[tuple[int, ...], tuple[int, ...]]] = {
    "pinned-pinned": ((0,), (0, -2)),
    "clamped-free": ((0,), (0, 1)),
    "mean-axis": ((), ()),
}


def element(x: Array, L: float, n: int) -> tuple[NDArray[np.intp], Array]:
    """Indices of the elements that contain x, and local coordinates from 0 to 1, exact at nodes and mid nodes."""
    y = x * (n / L)
    half = np.round(2 * y) / 2
    y = np.where(np.abs(y - half) < 1e-12 * n, half, y)
    e = np.clip(y.astype(np.intp), 0, n - 1)
    return e, y - e


def spread(parts: list[Array], e: NDArray[np.intp], size: int) -> Array:
    """Table (points, size) of shape functions: the values ``parts`` within element e, in the columns from 2 e on."""
    table = np.zeros((len(e), size))
    table[np.arange(len(e))[:, None], 2 * e[:, None] + np.arange(len(parts))] = np.array(parts).T
    return table


def quadratic(x: Array, L: float, n: int) -> tuple[Array, Array]:
    """s and s' at x for each axial coordinate: (points, 2 n + 1) each."""
    e, r = element(x, L, n)
    s = [(1 - r) * (1 - 2 * r), 4 * r * (1 - r), r * (2 * r - 1)]
    ds = [(4 * r - 3) * (n / L), (4 - 8 * r) * (n / L), (4 * r - 1) * (n / L)]
    return spread(s, e, 2 * n + 1), spread(ds, e, 2 * n + 1)


def cubic(x: Array, L: float, n: int) -> tuple[Array, Array, Array]:
    """v, v' and v'' at x for each bending coordinate: (points, 2 n + 2) each."""
    e, r = element(x, L, n)
    h, size = L / n, 2 * n + 2
    v = [(1 - r) ** 2 * (1 + 2 * r), h * r * (1 - r) ** 2, r**2 * (3 - 2 * r), -h * r**2 * (1 - r)]
    d = 6 * r * (1 - r)
    dv = [-d / h, (1 - r) * (1 - 3 * r), d / h, r * (3 * r - 2)]
    c = (6 - 12 * r) / h**2
    ddv = [-c, (6 * r - 4) / h, c, (6 * r - 2) / h]
    return spread(v, e, size), spread(dv, e, size), spread(ddv, e, size)


def gauss(L: float, n: int) -> tuple[Array, Array]:
    """Points and weights (4 n,) of the quadrature over all elements."""
    points, weights = np.polynomial.legendre.leggauss(GAUSS)
    h = L / n
    return (h * (np.arange(n)[:, None] + (1 + points) / 2)).ravel(), np.tile(h * weights / 2, n)


def gram(f: Array, w: Array | float = 1.0) -> Array:
    """Sum of w f^T f over the points, w >= 0; exactly symmetric."""
    f = np.sqrt(w)[..., None] * f
    return f.T @ f


def without_dust(A: Array, size: float) -> Array:
    return np.where(np.abs(A) < DUST * size, 0.0, A)


def free(n: int, reference: Reference) -> tuple[Array, Array, tuple[str, ...]]:
    """Shapes (axial, bending) and names of the element coordinates that the reference conditions leave free, node by
    node along the beam."""
    size = 4 * n + 3
    bends = np.isin(np.arange(size) % 4, (1, 2))
    axial, bending = np.flatnonzero(~bends), np.flatnonzero(bends)
    held = [*axial[list(HELD[reference][0])], *bending[list(HELD[reference][1])]]
    A, B = (np.delete(np.eye(size)[part], held, axis=1) for part in (axial, bending))
    names = [name for i in range(n + 1) for name in (f"u{i}", f"v{i}", f"t{i}", f"u{i + 1}m")][:size]
    return A, B, tuple(name for i, name in enumerate(names) if i not in held)
