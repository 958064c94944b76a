"""Coefficients of Radau IIA with s stages, as the kernels read them: one vector, and the places of its tables.

    A c^k = c^{k+1}/(k + 1) for k = 0 ... s - 1 with the nodes c, where 2 c - 1 are the zeros of the difference of the
    Legendre polynomials of degrees s and s - 1
    THERE A BACK = the eigenvalues of A on the diagonal: the real one, and for each complex pair re, im; THERE BACK = 1

The embedded formula, of order s, has f_0 with the real eigenvalue as its weight; its difference to the formula of order
2 s - 1 is h (real f_0 + sum E1_i f_i).

Source: Hairer, Wanner, Solving Ordinary Differential Equations II (1996), sections IV.5 and IV.8; Stiff differential
equations solved by Radau methods, J. Comput. Appl. Math. 111 (1999) 93-111.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cache

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from mbdsl.integrators.methods.radau_newton import EXPONENT, FACTOR, MEASURED, POWER

#: largest number of stages, and the distance of rows in tables
MOST = 7
#: the tolerance of the embedded formula, relative to that of the result
LOOSER = 5.0
#: nodes c; the real eigenvalue of A, re and im of each complex pair; E1, and E2 = E1 A
NODES, EIGENVALUES, E1, E2 = range(5, 5 + 4 * MOST, MOST)
#: A, A^2, A^{-1}; eigenvectors of A: rows of real and imaginary parts, columns that combine these to vectors of the
#: stages; coefficients of x, x^2, ... in the integrals from 0 to x of the Lagrange polynomials of the nodes, by rows
A, SQUARE, INVERSE, THERE, BACK, INTEGRALS = range(5 + 4 * MOST, 5 + 4 * MOST + 6 * MOST**2, MOST**2)
#: coefficients of 1, x, x^2 in the parabola that fits values at the stages best, by rows
FIT = INTEGRALS + MOST**2
SIZE = FIT + 3 * MOST

Array = NDArray[np.float64]


@cache
def tables(stages: int) -> dict[int, Array]:
    """The tables by their places: vectors (s,) and matrices (s, s)."""
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
        NODES: c,
        EIGENVALUES: np.array(parts),
        E1: e1,
        E2: e1 @ a,
        A: a,
        SQUARE: a @ a,
        INVERSE: np.linalg.solve(a, one),
        THERE: np.array(rows),
        BACK: np.array(columns).T,
        INTEGRALS: integrals,
        FIT: np.linalg.pinv(np.vander(c, 3, increasing=True)),
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


def coefficients(stages: int) -> tuple[float, ...]:
    """The vector that the kernels read."""
    found = np.zeros(SIZE)
    found[FACTOR], found[POWER], found[EXPONENT] = LOOSER, 1.0, 1.0 / (stages + 1)
    found[MEASURED] = 1e4  # the eigenvectors magnify rounding; KNOWN is 0
    for place, table in tables(stages).items():
        for k, row in enumerate(np.atleast_2d(table)):
            found[place + MOST * k : place + MOST * k + stages] = row
    return tuple(found)
