"""Radau IIA with s stages: the coefficients and the rows of ``vectors``, which kernels read as constants.

    A c^k = c^{k+1}/(k + 1) for k = 0 ... s - 1 with the nodes c, where 2 c - 1 are the zeros of the difference of the
    Legendre polynomials of degrees s and s - 1
    there A back = the eigenvalues of A on the diagonal: the real one, and for each complex pair re, im; there back = 1

The embedded formula, of order s, has f_0 with the real eigenvalue as its weight; its difference to the formula of order
2 s - 1 is h (real f_0 + sum e1_i f_i).

Source: Hairer, Wanner, Solving Ordinary Differential Equations II (1996), sections IV.5 and IV.8; Stiff differential
equations solved by Radau methods, J. Comput. Appl. Math. 111 (1999) 93-111.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from mbdsl.integrators.methods import radau5_coefficients
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array

#: own rows of ``vectors``: two for intermediate results; G of the coordinates without mass, otherwise 0; q and v at the
#: start of the last step; velocities with psi' in the place of Omega, at the ends of this step and of the last one
ERROR, ERROR2, METRIC, QB, VB, RATES = range(L.ROWS, L.ROWS + 6)
FIRST = RATES + 2

Numbers = tuple[float, ...]
Table = tuple[Numbers, ...]


@dataclass(frozen=True, eq=False)
class Scheme:
    """Radau IIA with an odd number of stages s: a constant of the translation of kernels."""

    stages: int
    nodes: Numbers  #: (s,) c
    values: Numbers  #: (s,) the real eigenvalue of A, then re and im of each complex pair
    A: Table
    square: Table  #: A^2
    inverse: Table  #: A^{-1}
    there: Table  #: (s, s) eigenvectors of A: rows of real and imaginary parts
    back: Table  #: (s, s) columns that combine these to vectors of the stages
    e1: Numbers  #: (s,) of the embedded formula
    e2: Numbers  #: (s,) e1 A
    integrals: Table  #: (s, s) coefficients of x, x^2, ... in the integrals of the Lagrange polynomials, by rows
    fit: Table  #: (3, s) coefficients of 1, x, x^2 in the parabola that fits values at the stages best, by rows
    each: tuple[int, ...]  #: the numbers of the stages
    pairs: tuple[int, ...]  #: the places of complex pairs among the eigenvalues
    evaluated: tuple[int, ...]  #: the order in which stages are evaluated, the middle one last
    predicted: tuple[int, ...]  #: the order in which predictions are turned to rotation vectors
    # -- rows of the first stage in ``vectors``, followed by those of the others -------------------------------------
    STAGE: int  #: unknowns [a; lam; nu]
    STAGE2: int  #: unknowns [w; mu; 0]
    RESIDUAL: int  #: [R1; R3; R5]
    RESIDUAL2: int  #: [R2; R4; 0]
    CHANGE: int  #: corrections, in the eigenvectors and then of the stages
    DV: int  #: corrections of v
    PAST: int  #: [a; lam; nu] in the last step
    PAST2: int  #: [w; mu; 0] in the last step
    ROWS: int  #: the number of own rows


def scheme(stages: int) -> Scheme:
    """The coefficients and rows for a number of stages; with three, the coefficients are those of the closed form."""
    s, middle = stages, stages // 2
    found: dict[str, Any] = {name: _tuples(table) for name, table in tables(s).items()}
    if s == 3:
        found |= radau5_coefficients.tables()
    names = ("STAGE", "STAGE2", "RESIDUAL", "RESIDUAL2", "CHANGE", "DV", "PAST", "PAST2")
    rows: dict[str, Any] = {name: FIRST + k * s for k, name in enumerate(names)}
    evaluated = (0, 2, 1) if s == 3 else tuple((middle + k) % s for k in range(1, s + 1))
    return Scheme(
        stages=s,
        each=tuple(range(s)),
        pairs=tuple(range(1, s, 2)),
        evaluated=evaluated,
        predicted=evaluated if s == 3 else tuple(range(s)),
        ROWS=FIRST + len(names) * s - L.ROWS,
        **found,
        **rows,
    )


def _tuples(table: Array) -> Any:
    return tuple(map(_tuples, table)) if table.ndim else float(table)


def tables(stages: int) -> dict[str, Array]:
    """The coefficients by their names in :class:`Scheme`."""
    from numpy.polynomial import legendre

    s, one = stages, np.eye(stages)
    c = (1.0 + np.sort(legendre.legroots([0.0] * (s - 1) + [-1.0, 1.0]))) / 2.0
    c[-1] = 1.0
    lagrange, integrals, a = _of_nodes(c)
    values, vectors = np.linalg.eig(a)
    chosen = np.argsort(np.where(values.imag < 0.0, np.inf, values.imag))[: (s + 1) // 2]
    values, back = values[chosen], vectors[:, chosen]
    there = np.linalg.inv(vectors)[chosen]
    parts = [values[0].real, *np.ravel([(z.real, z.imag) for z in values[1:]])]
    rows = [there[0].real, *(part for x in there[1:] for part in (x.real, x.imag))]
    columns = [back[:, 0].real, *(part for x in back.T[1:] for part in (2.0 * x.real, -2.0 * x.imag))]
    e1 = -values[0].real * lagrange[:, 0]
    return {
        "nodes": c,
        "values": np.array(parts),
        "e1": e1,
        "e2": e1 @ a,
        "A": a,
        "square": a @ a,
        "inverse": np.linalg.solve(a, one),
        "there": np.array(rows),
        "back": np.array(columns).T,
        "integrals": integrals,
        "fit": np.linalg.pinv(np.vander(c, 3, increasing=True)),
    }


def _of_nodes(c: Array) -> tuple[Array, Array, Array]:
    """Coefficients of the Lagrange polynomials, by rows, and of their integrals; A.

    In rational arithmetic: the Vandermonde matrix of seven nodes magnifies rounding to 1e-12.
    """
    x, zero = [Fraction(value) for value in c.tolist()], Fraction(0)
    lagrange: list[list[Fraction]] = []
    for one in x:
        row = [Fraction(1)]
        for other in x:
            if other is not one:  # times (X - other)/(one - other)
                pairs = zip([zero, *row], [*row, zero], strict=True)
                row = [(low - other * high) / (one - other) for low, high in pairs]
        lagrange.append(row)
    integrals = [[value / (k + 1) for k, value in enumerate(row)] for row in lagrange]
    a = [[sum((value * at ** (k + 1) for k, value in enumerate(row)), zero) for row in integrals] for at in x]
    return np.array(lagrange, float), np.array(integrals, float), np.array(a, float)
