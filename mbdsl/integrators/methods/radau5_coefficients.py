"""Coefficients of Radau IIA with three stages, and the eigenvectors that diagonalise them.

    A c^k = c^{k+1}/(k + 1) for k = 0, 1, 2 with c = NODES
    A R = s R and L A = s L with L R = 1, for the real and for a complex eigenvalue s

The embedded formula of order 3, in which f_0 has the real s as its weight, is that of Hairer and Wanner, Solving
Ordinary Differential Equations II, section IV.8.
"""

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


def tables():
    """The coefficients by their names in :class:`mbdsl.integrators.methods.radau_coefficients.Scheme`."""
    real = (6 + E - 9 ** (1 / 3)) / 30
    re, im = (12 - E + 9 ** (1 / 3)) / 60, (E + 9 ** (1 / 3)) * sqrt(3.0) / 60
    (L_real, R_real), (L, R) = eigenvectors(real), eigenvectors(complex(re, im))
    minors = tuple(cross(A[(i + 1) % 3], A[(i + 2) % 3]) for i in range(3))
    determinant = sum(x * y for x, y in zip(A[0], minors[0], strict=True))
    z = tuple(real / 3 * x for x in (-13 - 7 * S6, -13 + 7 * S6, -1.0))
    e1 = tuple(sum(z[k] * A[k][j] for k in range(3)) for j in range(3))
    return {
        "nodes": NODES,
        "values": (real, re, im),
        "e1": e1,
        "e2": tuple(sum(e1[k] * A[k][j] for k in range(3)) for j in range(3)),
        "A": A,
        "square": product(A, A),
        "inverse": tuple(tuple(minors[j][i] / determinant for j in range(3)) for i in range(3)),
        "there": (L_real, tuple(x.real for x in L), tuple(x.imag for x in L)),
        "back": tuple((x, 2.0 * y.real, -2.0 * y.imag) for x, y in zip(R_real, R, strict=True)),
    }
