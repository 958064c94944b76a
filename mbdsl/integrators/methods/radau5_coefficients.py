"""Coefficients of Radau IIA with three stages, and the eigenvectors that diagonalise them.

    A c^k = c^{k+1}/(k + 1) for k = 0, 1, 2 with c = NODES
    A R = s R and L A = s L with L R = 1, for the real and for a complex eigenvalue s

The embedded formula of order 3, in which f_0 has the real s as its weight, is that of Hairer and Wanner, Solving
Ordinary Differential Equations II, section IV.8.
"""

from __future__ import annotations

from math import sqrt

S6, E = sqrt(6.0), 81 ** (1 / 3)
NODES = ((4 - S6) / 10, (4 + S6) / 10, 1.0)
A = (
    ((88 - 7 * S6) / 360, (296 - 169 * S6) / 1800, (-2 + 3 * S6) / 225),
    ((296 + 169 * S6) / 1800, (88 + 7 * S6) / 360, (-2 - 3 * S6) / 225),
    ((16 - S6) / 36, (16 + S6) / 36, 1 / 9),
)


def product(a, b):
    return tuple(tuple(sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)) for i in range(3))


def cross(u, v):
    return tuple(u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3] for i in range(3))


def eigenvectors(s):
    """Left and right eigenvectors L and R of A for the eigenvalue s: cross products of two columns or rows of A - s."""
    a = [[A[i][j] - s * (i == j) for j in range(3)] for i in range(3)]
    R, L = cross(a[0], a[1]), cross([row[0] for row in a], [row[1] for row in a])
    size = sum(x * y for x, y in zip(L, R, strict=True))
    return tuple(x / size for x in L), R


#: eigenvalues of A: the real one, and real and imaginary part of a complex one
REAL = (6 + E - 9 ** (1 / 3)) / 30
RE, IM = (12 - E + 9 ** (1 / 3)) / 60, (E + 9 ** (1 / 3)) * sqrt(3.0) / 60
L_REAL, R_REAL = eigenvectors(REAL)
_L, _R = eigenvectors(complex(RE, IM))
L_RE, L_IM = tuple(x.real for x in _L), tuple(x.imag for x in _L)
R_RE, R_IM = tuple(x.real for x in _R), tuple(x.imag for x in _R)
#: A^2 and A^{-1}
SQUARE = product(A, A)
_M = tuple(cross(A[(i + 1) % 3], A[(i + 2) % 3]) for i in range(3))
_DET = sum(x * y for x, y in zip(A[0], _M[0], strict=True))
INVERSE = tuple(tuple(_M[j][i] / _DET for j in range(3)) for i in range(3))
#: error = h (REAL f_0 + sum E1_i f_i) of the embedded formula, and E2 = E1 A
_Z = tuple(REAL / 3 * x for x in (-13 - 7 * S6, -13 + 7 * S6, -1.0))
E1 = tuple(sum(_Z[k] * A[k][j] for k in range(3)) for j in range(3))
E2 = tuple(sum(E1[k] * A[k][j] for k in range(3)) for j in range(3))
