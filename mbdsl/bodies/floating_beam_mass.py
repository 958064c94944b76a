"""The mass matrix of a beam in a floating frame: the parts that its kernels share, and the solution with it."""

from math import cos, sin

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel
from mbdsl.numerics.banded import cholesky_solve

# -- record of a body: first coordinate, first frame, number of frames, k; offsets in numbers of m, I0, g, S_bar, h1, g0
FIRST, FRAME, N_FRAME, SIZE, CONSTANTS = 0, 1, 2, 3, 4
#: nonzero entries of H, G, N_bar: their number, offset in layout of (i, j, slot), of values in numbers; same for K, D
INERTIAL, INERTIAL_AT, INERTIAL_VALUES = 5, 6, 7
ELASTIC, ELASTIC_AT, ELASTIC_VALUES = 8, 9, 10
#: first slot of rows and columns of R and phi; offsets in numbers of the parts at q, for M, at the start of the step
BORDER, NOW, HELD, PAST = 11, 12, 13, 14
#: list of frame records in layout; bandwidth of M_ff; offsets in numbers of its Cholesky factor and scratch (8 k)
OF_FRAMES, BAND, FACTOR, SCRATCH = 15, 16, 17, 18
RECORD = 19
FRAME_RECORD = 7
#: the parts, from NOW on: cos phi, sin phi, c_x, c_y, P - I0, 1 if ``decompose`` has run; c_j (x, y), b, h1 + H q;
#: the results of ``decompose``
COS, SIN, C_X, C_Y, P_Q, KNOWN, LISTS = 0, 1, 2, 3, 4, 5, 6


@kernel
def parts(o, row, at, vectors, numbers, layout):
    """Write the parts that M and the forces consist of, at the coordinates vectors[row], to numbers from ``at`` on."""
    d, k, n = layout[o + FIRST], layout[o + SIZE], layout[o + CONSTANTS] + 4
    phi, q = vectors[row, d + 2], vectors[row, d + 3 :]
    c_x, c_y, P = 0.0, 0.0, 0.0
    cx, cy = numbers[at + LISTS :], numbers[at + LISTS + k :]
    b, Hq = numbers[at + LISTS + 2 * k :], numbers[at + LISTS + 3 * k :]
    for j in range(k):
        cx[j], cy[j], Hq[j], b[j] = numbers[n + j], numbers[n + k + j], numbers[n + 2 * k + j], numbers[n + 3 * k + j]
        c_x += numbers[n + j] * q[j]
        c_y += cy[j] * q[j]
        P += Hq[j] * q[j]
    entries, values = layout[o + INERTIAL_AT], layout[o + INERTIAL_VALUES]
    for e in range(layout[o + INERTIAL]):
        i, x, v = layout[entries + 3 * e], q[layout[entries + 3 * e + 1]], values + 3 * e
        Hq[i] += numbers[v] * x
        b[i] -= numbers[v + 1] * x
        cx[i] -= numbers[v + 2] * x
    for j in range(k):
        c_x += 0.5 * (cx[j] - numbers[n + j]) * q[j]
        P += Hq[j] * q[j]
    numbers[at + COS], numbers[at + SIN], numbers[at + C_X], numbers[at + C_Y], numbers[at + P_Q] = (
        cos(phi),
        sin(phi),
        c_x,
        c_y,
        P,
    )
    numbers[at + KNOWN] = 0.0


@kernel
def of_mass(o, layout):
    """The offset in numbers of the parts for M."""
    return layout[o + NOW] if layout[L.MASS_ROW] == L.POSITION else layout[o + HELD]


@kernel
def rates(o, y, x, numbers, layout):
    """Write H y, G y and N_bar y to numbers from x, x + k and x + 2 k on."""
    k, entries, values = layout[o + SIZE], layout[o + INERTIAL_AT], layout[o + INERTIAL_VALUES]
    for j in range(3 * k):
        numbers[x + j] = 0.0
    for a in range(layout[o + INERTIAL]):
        i, z, v = layout[entries + 3 * a], y[layout[entries + 3 * a + 1]], values + 3 * a
        numbers[x + i] += numbers[v] * z
        numbers[x + k + i] += numbers[v + 1] * z
        numbers[x + 2 * k + i] += numbers[v + 2] * z


@kernel
def border(o, at, sign, row, target, vectors, numbers, layout):
    """vectors[target] += sign (M - its constant part) vectors[row], with the rows and columns of R and phi of M."""
    d, k = layout[o + FIRST], layout[o + SIZE]
    c, s, c_x, c_y = numbers[at + COS], numbers[at + SIN], numbers[at + C_X], numbers[at + C_Y]
    cx, cy, b = numbers[at + LISTS :], numbers[at + LISTS + k :], numbers[at + LISTS + 2 * k :]
    x, y, alpha = vectors[row, d], vectors[row, d + 1], vectors[row, d + 2]
    x, y = sign * (c * x + s * y), sign * (c * y - s * x)
    alpha *= sign
    fx, fy, tau = -c_y * alpha, c_x * alpha, c_x * y - c_y * x + numbers[at + P_Q] * alpha
    for j in range(k):
        a = sign * vectors[row, d + 3 + j]
        fx += cx[j] * a
        fy += cy[j] * a
        tau += b[j] * a
        vectors[target, d + 3 + j] += x * cx[j] + y * cy[j] + b[j] * alpha
    vectors[target, d] += c * fx - s * fy
    vectors[target, d + 1] += s * fx + c * fy
    vectors[target, d + 2] += tau


@kernel
def decompose(o, at, numbers, layout):
    """Write the data of ``solve`` to numbers: M_ff^{-1} M_fr (three columns), and the factors of the 3 x 3 Schur
    complement, in the axes of the floating frame. M is never formed, and M_ff was factorised with the tables."""
    k, n, x = layout[o + SIZE], layout[o + CONSTANTS], at + LISTS + 4 * layout[o + SIZE]
    c_x, c_y, lists = numbers[at + C_X], numbers[at + C_Y], at + LISTS
    for j in range(3 * k):
        numbers[x + j] = numbers[lists + j]  # c_j and b: the columns of M_fr
    for column in range(3):
        cholesky_solve(k, layout[o + BAND], numbers[layout[o + FACTOR] :], numbers[x + column * k :])
    s00, s01, s02 = numbers[n], 0.0, -c_y
    s11, s12, s22 = numbers[n], c_x, numbers[n + 1] + numbers[at + P_Q]
    for j in range(k):
        cx, cy, b = numbers[lists + j], numbers[lists + k + j], numbers[lists + 2 * k + j]
        y1, y2 = numbers[x + k + j], numbers[x + 2 * k + j]
        s00 -= cx * numbers[x + j]
        s01 -= cx * y1
        s02 -= cx * y2
        s11 -= cy * y1
        s12 -= cy * y2
        s22 -= b * y2
    x += 3 * k
    l10, l20 = s01 / s00, s02 / s00
    d1 = s11 - l10 * s01
    l21 = (s12 - l10 * s02) / d1
    numbers[x], numbers[x + 1], numbers[x + 2] = 1.0 / s00, 1.0 / d1, 1.0 / (s22 - l20 * s02 - l21 * (s12 - l10 * s02))
    numbers[x + 3], numbers[x + 4], numbers[x + 5] = l10, l20, l21
    numbers[at + KNOWN] = 1.0


@kernel
def solve(o, at, row, target, vectors, numbers, layout):
    """vectors[target] = M^{-1} vectors[row] with the results of ``decompose``; uses SCRATCH of numbers."""
    d, k, y = layout[o + FIRST], layout[o + SIZE], layout[o + SCRATCH]
    c, s, x = numbers[at + COS], numbers[at + SIN], at + LISTS + 4 * layout[o + SIZE]
    r0 = c * vectors[row, d] + s * vectors[row, d + 1]
    r1 = c * vectors[row, d + 1] - s * vectors[row, d]
    r2 = vectors[row, d + 2]
    for j in range(k):
        f = vectors[row, d + 3 + j]
        numbers[y + j] = f
        r0 -= numbers[x + j] * f
        r1 -= numbers[x + k + j] * f
        r2 -= numbers[x + 2 * k + j] * f
    cholesky_solve(k, layout[o + BAND], numbers[layout[o + FACTOR] :], numbers[y:])
    z = x + 3 * k
    r1 -= numbers[z + 3] * r0
    r2 -= numbers[z + 4] * r0 + numbers[z + 5] * r1
    alpha = r2 * numbers[z + 2]
    ay = r1 * numbers[z + 1] - numbers[z + 5] * alpha
    ax = r0 * numbers[z] - numbers[z + 3] * ay - numbers[z + 4] * alpha
    vectors[target, d], vectors[target, d + 1], vectors[target, d + 2] = c * ax - s * ay, s * ax + c * ay, alpha
    for j in range(k):
        vectors[target, d + 3 + j] = (
            numbers[y + j] - numbers[x + j] * ax - numbers[x + k + j] * ay - numbers[x + 2 * k + j] * alpha
        )
