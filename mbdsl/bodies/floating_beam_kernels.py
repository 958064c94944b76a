"""How frames on a beam in its floating frame of reference move, and the beam's own inertia and elastic forces.

Coordinates are R = (x, y), the origin of the floating frame, its angle phi, and k elastic coordinates q. In the frame's
axes a point of the axis is at u(q) = u0 + S q - 1/2 e_x q^T N q (the last term, the foreshortening by bending, with
geometric stiffening only), turned by v'(q), linear in q. With A = A(phi), J the turn by 90 degrees, w = phi':

    r = R + A u,   theta = phi + v',   B = [1, A J u, A u_j; 0, 1, v'_j],   u_j = S_j - e_x (N q)_j

Kinetic energy, with integrals over the mass that are constants of the discretisation (m, I0, S_bar, h1, g0, H, G and
N_bar; H holds the stiffening's share, complete to second order in q and q'):

    T = m/2 R'.R' + w R'.A J c + R'.A c' + P w^2/2 + w b.q' + 1/2 q'^T M_ff q'
    c = S_bar q - 1/2 e_x q^T N_bar q,   P = I0 + (2 h1 + H q).q,   b = g0 - G q

so that, with c_j = dc/dq_j and g the field of gravity,

    M = [[m, A J c, A c_j], [., P, b_j], [., ., M_ff]]
    Q_R   = m g - A (c'' + 2 w J c' - w^2 c),   c'' = -e_x q'^T N_bar q'
    Q_phi = g.A J c - 2 w (h1 + H q).q'
    Q_j   = g.A c_j + w^2 (h1 + H q)_j + 2 w (G q')_j - (K q + D q')_j

Source: A. A. Shabana, Dynamics of Multibody Systems, ch. 5; the foreshortening after T. R. Kane, R. R. Ryan, A. K.
Banerjee, Dynamics of a cantilever beam attached to a moving base, J. Guidance 10 (1987). Record of a body in I: see
``RECORD``; of a frame: number of its elastic coordinates, their list in I, offsets in F of its constants, of N (or -1),
of A u_j and of what that was at the start of the step, first slot.
"""

from math import cos, sin

from mbdsl.compilation.buffer_layout import (
    FP,
    FRAMES,
    GD,
    GP,
    INVERSE,
    KEEP,
    LEVER,
    MASS_ROW,
    MU_WRENCH,
    NEW_MASS,
    PAST_LEVER,
    PAST_WRENCH,
    SLOTS,
    T1,
    TANGENT_ROW,
    TIMES,
    WRENCH,
    Q,
    V,
)
from mbdsl.compilation.marks import kernel, rare
from mbdsl.numerics.banded import cholesky_solve

MASS = 2  #: the mass matrix depends on q
#: the model that fills the tables
MODEL = "mbdsl.bodies.floating_beam"

# -- record of a body: first coordinate, first frame, number of frames, k; offsets in F of m, I0, g, S_bar, h1, g0
FIRST, FRAME, N_FRAME, SIZE, CONSTANTS = 0, 1, 2, 3, 4
#: entries of H, G, N_bar (how many; i, j, slot in I; values in F), and of K, D
INERTIAL, INERTIAL_AT, INERTIAL_VALUES = 5, 6, 7
ELASTIC, ELASTIC_AT, ELASTIC_VALUES = 8, 9, 10
#: first slot of rows and columns of R and phi; offsets in F of c, c_j, ... at q, for M, at the start of the step
BORDER, NOW, HELD, PAST = 11, 12, 13, 14
#: list of frame records in I; bandwidth of M_ff and offset of its Cholesky factor, scratch (8 k) in F
OF_FRAMES, BAND, FACTOR, SCRATCH = 15, 16, 17, 18
RECORD = 19
FRAME_RECORD = 7
#: what stands from NOW on: cos phi, sin phi, c_x, c_y, P - I0, whether ``decompose`` was here; c_j (x, y), b, h1 + H q;
#: what that found
COS, SIN, C_X, C_Y, P_Q, KNOWN, LISTS = 0, 1, 2, 3, 4, 5, 6


@kernel
def parts(o, row, at, Y, F, I):
    """What M and the forces are made of at the coordinates in Y[row]."""
    d, k, n = I[o + FIRST], I[o + SIZE], I[o + CONSTANTS] + 4
    phi, q = Y[row, d + 2], Y[row, d + 3 :]
    c_x, c_y, P = 0.0, 0.0, 0.0
    cx, cy = F[at + LISTS :], F[at + LISTS + k :]
    b, Hq = F[at + LISTS + 2 * k :], F[at + LISTS + 3 * k :]
    for j in range(k):
        cx[j], cy[j], Hq[j], b[j] = F[n + j], F[n + k + j], F[n + 2 * k + j], F[n + 3 * k + j]
        c_x += F[n + j] * q[j]
        c_y += cy[j] * q[j]
        P += Hq[j] * q[j]
    entries, values = I[o + INERTIAL_AT], I[o + INERTIAL_VALUES]
    for e in range(I[o + INERTIAL]):
        i, x, v = I[entries + 3 * e], q[I[entries + 3 * e + 1]], values + 3 * e
        Hq[i] += F[v] * x
        b[i] -= F[v + 1] * x
        cx[i] -= F[v + 2] * x
    for j in range(k):
        c_x += 0.5 * (cx[j] - F[n + j]) * q[j]
        P += Hq[j] * q[j]
    F[at + COS], F[at + SIN], F[at + C_X], F[at + C_Y], F[at + P_Q] = cos(phi), sin(phi), c_x, c_y, P
    F[at + KNOWN] = 0.0


@kernel
def of_mass(o, I):
    """Where the parts that M is made of stand."""
    return I[o + NOW] if I[MASS_ROW] == Q else I[o + HELD]


@kernel
def move(block, Y, Z, F, I):
    """Pose, rate and lever of every frame, and A u_j; wrenches start at zero."""
    for e in range(I[block]):
        o = I[I[block + 1] + e]
        d, at = I[o + FIRST], I[o + NOW]
        parts(o, Q, at, Y, F, I)
        if I[MASS_ROW] != Q and I[NEW_MASS]:
            parts(o, I[MASS_ROW], I[o + HELD], Y, F, I)
        c, s, w = F[at + COS], F[at + SIN], Y[V, d + 2]
        q, v = Y[Q, d + 3 :], Y[V, d + 3 :]
        for f in range(I[o + N_FRAME]):
            r, row = I[o + OF_FRAMES] + FRAME_RECORD * f, I[o + FRAME] + f
            k, which, n, N, to = I[r], I[r + 1], I[r + 2], I[r + 3], I[r + 4]
            px, py, theta, turn = F[n], F[n + 1], F[n + 2], 0.0
            rx, ry = 0.0, 0.0
            n += 3
            for j in range(k):
                i = I[which + j]
                ux, uy = F[n + j], F[n + k + j]
                px += ux * q[i]
                py += uy * q[i]
                theta += F[n + 2 * k + j] * q[i]
                turn += F[n + 2 * k + j] * v[i]
                if N >= 0:
                    Nq = 0.0
                    for l in range(k):
                        Nq += F[N + k * j + l] * q[I[which + l]]
                    ux -= Nq
                    px -= 0.5 * Nq * q[i]
                ux, uy = c * ux - s * uy, s * ux + c * uy
                F[to + j], F[to + k + j] = ux, uy
                rx += ux * v[i]
                ry += uy * v[i]
            lx, ly = c * px - s * py, s * px + c * py
            Z[row, 0], Z[row, 1], Z[row, 2] = Y[Q, d] + lx, Y[Q, d + 1] + ly, Y[Q, d + 2] + theta
            Z[row, 3], Z[row, 4], Z[row, 5] = Y[V, d] - ly * w + rx, Y[V, d + 1] + lx * w + ry, w + turn
            Z[row, LEVER], Z[row, LEVER + 1] = lx, ly
            for j in range(3):
                Z[row, WRENCH + j], Z[row, MU_WRENCH + j] = 0.0, 0.0


@kernel
def keep(block, F, I):
    """Where a step begins, what the last evaluation found is the past."""
    if I[KEEP]:
        for e in range(I[block]):
            o = I[I[block + 1] + e]
            for j in range(LISTS + 7 * I[o + SIZE] + 6):
                F[I[o + PAST] + j] = F[I[o + NOW] + j]
            if F[I[o + PAST] + KNOWN] == 0.0:
                decompose(o, I[o + PAST], F, I)
            for f in range(I[o + N_FRAME]):
                r = I[o + OF_FRAMES] + FRAME_RECORD * f
                for j in range(2 * I[r]):
                    F[I[r + 5] + j] = F[I[r + 4] + j]


@kernel
def gather(block, wrench, lever, columns, row, Y, Z, F, I):
    """Y[row] += B^T F for every frame's wrench F, with l and A u_j as they were where these say."""
    for e in range(I[block]):
        o = I[I[block + 1] + e]
        d = I[o + FIRST]
        for f in range(I[o + N_FRAME]):
            r, z = I[o + OF_FRAMES] + FRAME_RECORD * f, Z[I[o + FRAME] + f]
            fx, fy, tau = z[wrench], z[wrench + 1], z[wrench + 2]
            Y[row, d] += fx
            Y[row, d + 1] += fy
            Y[row, d + 2] += tau - z[lever + 1] * fx + z[lever] * fy
            k, turn, u = I[r], I[r + 2] + 3 + 2 * I[r], I[r + columns]
            for j in range(k):
                Y[row, d + 3 + I[I[r + 1] + j]] += F[u + j] * fx + F[u + k + j] * fy + F[turn + j] * tau


@kernel
def collect(block, Y, Z, F, I):
    """f += B^T F."""
    gather(block, WRENCH, LEVER, 4, FP, Y, Z, F, I)


@kernel
def collect_with_mu(block, Y, Z, F, I):
    """The same, and that of the wrenches of mu: in one go."""
    for e in range(I[block]):
        o = I[I[block + 1] + e]
        d = I[o + FIRST]
        for f in range(I[o + N_FRAME]):
            r, z = I[o + OF_FRAMES] + FRAME_RECORD * f, Z[I[o + FRAME] + f]
            lx, ly, fx, fy, tau = z[LEVER], z[LEVER + 1], z[WRENCH], z[WRENCH + 1], z[WRENCH + 2]
            gx, gy, mu = z[MU_WRENCH], z[MU_WRENCH + 1], z[MU_WRENCH + 2]
            Y[FP, d] += fx
            Y[FP, d + 1] += fy
            Y[FP, d + 2] += tau - ly * fx + lx * fy
            Y[GD, d] += gx
            Y[GD, d + 1] += gy
            Y[GD, d + 2] += mu - ly * gx + lx * gy
            k, turn, u = I[r], I[r + 2] + 3 + 2 * I[r], I[r + 4]
            for j in range(k):
                i, ux, uy = d + 3 + I[I[r + 1] + j], F[u + j], F[u + k + j]
                Y[FP, i] += ux * fx + uy * fy + F[turn + j] * tau
                Y[GD, i] += ux * gx + uy * gy + F[turn + j] * mu


@kernel
def collect_past(block, Y, Z, F, I):
    """The same for those of psi, at the pose of the start of the step."""
    gather(block, PAST_WRENCH, PAST_LEVER, 5, GP, Y, Z, F, I)


@kernel
def forces(block, Y, F, I):
    """f += velocity-dependent inertia forces, gravity beyond its constant part, elastic and damping forces."""
    for e in range(I[block]):
        o = I[I[block + 1] + e]
        d, k, at, n, x = I[o + FIRST], I[o + SIZE], I[o + NOW], I[o + CONSTANTS], I[o + SCRATCH]
        c, s, c_x, c_y = F[at + COS], F[at + SIN], F[at + C_X], F[at + C_Y]
        q, v, w, f = Y[Q, d + 3 :], Y[V, d + 3 :], Y[V, d + 2], Y[FP]
        cx, cy, Hq = F[at + LISTS :], F[at + LISTS + k :], F[at + LISTS + 3 * k :]
        gx, gy = c * F[n + 2] + s * F[n + 3], c * F[n + 3] - s * F[n + 2]
        rates(o, v, x, F, I)
        dx, dy, ddx, dP = 0.0, 0.0, 0.0, 0.0
        for j in range(k):
            dx += cx[j] * v[j]
            dy += cy[j] * v[j]
            ddx -= F[x + 2 * k + j] * v[j]
            dP += 2.0 * Hq[j] * v[j]
            f[d + 3 + j] += gx * cx[j] + gy * cy[j] + w * (w * Hq[j] + 2.0 * F[x + k + j])
        fx, fy = ddx - 2.0 * w * dy - w * w * c_x, 2.0 * w * dx - w * w * c_y
        f[d] -= c * fx - s * fy
        f[d + 1] -= s * fx + c * fy
        f[d + 2] += gy * c_x - gx * c_y - dP * w
        entries, values = I[o + ELASTIC_AT], I[o + ELASTIC_VALUES]
        for a in range(I[o + ELASTIC]):
            i, j = I[entries + 3 * a], I[entries + 3 * a + 1]
            f[d + 3 + i] -= F[values + 2 * a] * q[j] + F[values + 2 * a + 1] * v[j]


@kernel
def rates(o, y, x, F, I):
    """H y, G y and N_bar y, to F[x], F[x + k], F[x + 2 k]."""
    k, entries, values = I[o + SIZE], I[o + INERTIAL_AT], I[o + INERTIAL_VALUES]
    for j in range(3 * k):
        F[x + j] = 0.0
    for a in range(I[o + INERTIAL]):
        i, z, v = I[entries + 3 * a], y[I[entries + 3 * a + 1]], values + 3 * a
        F[x + i] += F[v] * z
        F[x + k + i] += F[v + 1] * z
        F[x + 2 * k + i] += F[v + 2] * z


# -- the mass matrix -------------------------------------------------------------------------------------------------


@kernel
def border(o, at, sign, row, target, Y, F, I):
    """Y[target] += sign (M - its constant part) Y[row]: what M has in the rows and columns of R and phi."""
    d, k = I[o + FIRST], I[o + SIZE]
    c, s, c_x, c_y = F[at + COS], F[at + SIN], F[at + C_X], F[at + C_Y]
    cx, cy, b = F[at + LISTS :], F[at + LISTS + k :], F[at + LISTS + 2 * k :]
    x, y, alpha = Y[row, d], Y[row, d + 1], Y[row, d + 2]
    x, y = sign * (c * x + s * y), sign * (c * y - s * x)
    alpha *= sign
    fx, fy, tau = -c_y * alpha, c_x * alpha, c_x * y - c_y * x + F[at + P_Q] * alpha
    for j in range(k):
        a = sign * Y[row, d + 3 + j]
        fx += cx[j] * a
        fy += cy[j] * a
        tau += b[j] * a
        Y[target, d + 3 + j] += x * cx[j] + y * cy[j] + b[j] * alpha
    Y[target, d] += c * fx - s * fy
    Y[target, d + 1] += s * fx + c * fy
    Y[target, d + 2] += tau


@kernel
def inertia(block, task, row, target, Y, F, I):
    """Tasks of the mass matrix, see :mod:`mbdsl.compilation.buffer_layout`."""
    for e in range(I[block]):
        o = I[I[block + 1] + e]
        if task == TIMES:
            border(o, of_mass(o, I), 1.0, row, target, Y, F, I)
        elif task == INVERSE:
            decompose(o, of_mass(o, I), F, I)
            solve(o, of_mass(o, I), row, target, Y, F, I)


@kernel
def carry_over(block, Y, F, I):
    """GP <- M M_n^{-1} GP with M_n at the start of the step."""
    for e in range(I[block]):
        o = I[I[block + 1] + e]
        solve(o, I[o + PAST], GP, T1, Y, F, I)
        border(o, I[o + NOW], 1.0, T1, GP, Y, F, I)
        border(o, I[o + PAST], -1.0, T1, GP, Y, F, I)


@kernel
def decompose(o, at, F, I):
    """What M^{-1} takes at these coordinates: M_ff^{-1} M_fr (three columns), and the factors of the 3 x 3 Schur
    complement, in the floating frame's axes. M is never formed, and M_ff was factorised beforehand."""
    k, n, x = I[o + SIZE], I[o + CONSTANTS], at + LISTS + 4 * I[o + SIZE]
    c_x, c_y, lists = F[at + C_X], F[at + C_Y], at + LISTS
    for j in range(3 * k):
        F[x + j] = F[lists + j]  # c_j and b: the columns of M_fr
    for column in range(3):
        cholesky_solve(k, I[o + BAND], F[I[o + FACTOR] :], F[x + column * k :])
    s00, s01, s02 = F[n], 0.0, -c_y
    s11, s12, s22 = F[n], c_x, F[n + 1] + F[at + P_Q]
    for j in range(k):
        cx, cy, b = F[lists + j], F[lists + k + j], F[lists + 2 * k + j]
        y1, y2 = F[x + k + j], F[x + 2 * k + j]
        s00 -= cx * F[x + j]
        s01 -= cx * y1
        s02 -= cx * y2
        s11 -= cy * y1
        s12 -= cy * y2
        s22 -= b * y2
    x += 3 * k
    l10, l20 = s01 / s00, s02 / s00
    d1 = s11 - l10 * s01
    l21 = (s12 - l10 * s02) / d1
    F[x], F[x + 1], F[x + 2] = 1.0 / s00, 1.0 / d1, 1.0 / (s22 - l20 * s02 - l21 * (s12 - l10 * s02))
    F[x + 3], F[x + 4], F[x + 5] = l10, l20, l21
    F[at + KNOWN] = 1.0


@kernel
def solve(o, at, row, target, Y, F, I):
    """Y[target] <- M^{-1} Y[row], after ``decompose``."""
    d, k, y = I[o + FIRST], I[o + SIZE], I[o + SCRATCH]
    c, s, x = F[at + COS], F[at + SIN], at + LISTS + 4 * I[o + SIZE]
    r0 = c * Y[row, d] + s * Y[row, d + 1]
    r1 = c * Y[row, d + 1] - s * Y[row, d]
    r2 = Y[row, d + 2]
    for j in range(k):
        f = Y[row, d + 3 + j]
        F[y + j] = f
        r0 -= F[x + j] * f
        r1 -= F[x + k + j] * f
        r2 -= F[x + 2 * k + j] * f
    cholesky_solve(k, I[o + BAND], F[I[o + FACTOR] :], F[y:])
    z = x + 3 * k
    r1 -= F[z + 3] * r0
    r2 -= F[z + 4] * r0 + F[z + 5] * r1
    alpha = r2 * F[z + 2]
    ay = r1 * F[z + 1] - F[z + 5] * alpha
    ax = r0 * F[z] - F[z + 3] * ay - F[z + 4] * alpha
    Y[target, d], Y[target, d + 1], Y[target, d + 2] = c * ax - s * ay, s * ax + c * ay, alpha
    for j in range(k):
        Y[target, d + 3 + j] = F[y + j] - F[x + j] * ax - F[x + k + j] * ay - F[x + 2 * k + j] * alpha


# -- tangents --------------------------------------------------------------------------------------------------------


@kernel
def jacobians(block, Y, Z, F, I):
    """B, then (B v)_q, of every frame, 3 x (3 + k) each; what is always zero has been zero from the start."""
    for e in range(I[block]):
        o = I[I[block + 1] + e]
        d, at = I[o + FIRST], I[o + NOW]
        c, s, w, v = F[at + COS], F[at + SIN], Y[V, d + 2], Y[V, d + 3 :]
        for f in range(I[o + N_FRAME]):
            r, row = I[o + OF_FRAMES] + FRAME_RECORD * f, I[o + FRAME] + f
            k, which, turn, N, u = I[r], I[r + 1], I[r + 2] + 3 + 2 * I[r], I[r + 3], I[r + 4]
            nb, B = 3 + k, I[I[FRAMES] + 2 * row + 1]
            lx, ly, rx, ry = Z[row, LEVER], Z[row, LEVER + 1], 0.0, 0.0
            rate = B + 3 * nb
            for j in range(k):
                ux, uy = F[u + j], F[u + k + j]
                F[B + 3 + j], F[B + nb + 3 + j], F[B + 2 * nb + 3 + j] = ux, uy, F[turn + j]
                rx += ux * v[I[which + j]]
                ry += uy * v[I[which + j]]
                Nv = 0.0
                if N >= 0:
                    for l in range(k):
                        Nv += F[N + k * j + l] * v[I[which + l]]
                F[rate + 3 + j], F[rate + nb + 3 + j] = -uy * w - c * Nv, ux * w - s * Nv
            F[B], F[B + nb + 1], F[B + 2 * nb + 2] = 1.0, 1.0, 1.0
            F[B + 2], F[B + nb + 2] = -ly, lx
            F[rate + 2], F[rate + nb + 2] = -lx * w - ry, -ly * w + rx


@kernel
def stiffness(block, cK, Z, F, I, A):
    """A += cK * (-d(B^T F)/dq) at the accumulated wrenches."""
    for e in range(I[block]):
        o = I[I[block + 1] + e]
        c, s = F[I[o + NOW] + COS], F[I[o + NOW] + SIN]
        for f in range(I[o + N_FRAME]):
            r, z = I[o + OF_FRAMES] + FRAME_RECORD * f, Z[I[o + FRAME] + f]
            k, N, u, slot = I[r], I[r + 3], I[r + 4], I[SLOTS] + I[r + 6]
            fx, fy = cK * z[WRENCH], cK * z[WRENCH + 1]
            A[I[slot]] += z[LEVER] * fx + z[LEVER + 1] * fy
            for j in range(k):
                value = F[u + k + j] * fx - F[u + j] * fy
                A[I[slot + 1 + 2 * j]] += value
                A[I[slot + 2 + 2 * j]] += value
            if N >= 0:
                slot += 1 + 2 * k
                for j in range(k * k):
                    A[I[slot + j]] += F[N + j] * (c * fx + s * fy)


@rare
def tangents(block, cM, cK, cD, cA, Y, F, I, A):
    """A += cM M (but for its constant part) + cA (M a)_q - cK Q_q - cD Q_v, with a in the row that M is to be
    differentiated with, and Q as ``forces`` says."""
    for e in range(I[block]):
        o = I[I[block + 1] + e]
        d, k, at, n, x = I[o + FIRST], I[o + SIZE], I[o + NOW], I[o + CONSTANTS], I[o + SCRATCH]
        c, s, c_x, c_y = F[at + COS], F[at + SIN], F[at + C_X], F[at + C_Y]
        cx, cy, Hq = F[at + LISTS :], F[at + LISTS + k :], F[at + LISTS + 3 * k :]
        v, w, a = Y[V, d + 3 :], Y[V, d + 2], Y[I[TANGENT_ROW], d:]
        ax, ay, alpha = c * a[0] + s * a[1], c * a[1] - s * a[0], cA * a[2]
        gx, gy = c * F[n + 2] + s * F[n + 3], c * F[n + 3] - s * F[n + 2]
        ex, ey = cA * ax - cK * gx, cA * ay - cK * gy
        rates(o, v, x, F, I)
        rates(o, a[3:], x + 3 * k, F, I)
        Hv, Gv, Nv = F[x:], F[x + k :], F[x + 2 * k :]
        Ga, Na = F[x + 4 * k :], F[x + 5 * k :]
        m = of_mass(o, I)
        mc, ms, mx, my = F[m + COS], F[m + SIN], F[m + C_X], F[m + C_Y]
        mcx, mcy, mb = F[m + LISTS :], F[m + LISTS + k :], F[m + LISTS + 2 * k :]
        dx, dy, ddx, dP, qx, qy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(k):
            dx += cx[j] * v[j]
            dy += cy[j] * v[j]
            ddx -= Nv[j] * v[j]
            dP += 2.0 * Hq[j] * v[j]
            qx += cx[j] * a[3 + j]
            qy += cy[j] * a[3 + j]
        # (R, phi), from what stands in the floating frame's axes and is turned with it
        tx = -c_y * alpha + cA * qx + cK * (ddx - 2.0 * w * dy - w * w * c_x)
        ty = c_x * alpha + cA * qy + cK * (2.0 * w * dx - w * w * c_y)
        tx, ty = -ty - 2.0 * cD * (dy + w * c_x), tx + 2.0 * cD * (dx - w * c_y)
        slot = I[SLOTS] + I[o + BORDER]
        Mx, My = -cM * (ms * mx + mc * my), cM * (mc * mx - ms * my)
        A[I[slot]] += c * tx - s * ty + Mx
        A[I[slot + 1]] += s * tx + c * ty + My
        A[I[slot + 2]] += Mx
        A[I[slot + 3]] += My
        A[I[slot + 4]] += cM * F[m + P_Q] - ex * c_x - ey * c_y + cD * dP
        slot += 5
        for j in range(k):
            tx = -cy[j] * alpha - cA * Na[j] - cK * w * w * cx[j] - 2.0 * cD * (Nv[j] + w * cy[j])
            ty = cx[j] * alpha - cK * w * (2.0 * Nv[j] + w * cy[j]) + 2.0 * cD * w * cx[j]
            Mx, My = cM * (mc * mcx[j] - ms * mcy[j]), cM * (ms * mcx[j] + mc * mcy[j])
            turned = ey * cx[j] - ex * cy[j]
            A[I[slot]] += c * tx - s * ty + Mx
            A[I[slot + 1]] += s * tx + c * ty + My
            A[I[slot + 2]] += Mx
            A[I[slot + 3]] += My
            A[I[slot + 4]] += (
                turned + 2.0 * alpha * Hq[j] + cA * Ga[j] + 2.0 * w * (cK * Hv[j] + cD * Hq[j]) + cM * mb[j]
            )
            A[I[slot + 5]] += turned - 2.0 * cD * (w * Hq[j] + Gv[j]) + cM * mb[j]
            slot += 6
        entries, values = I[o + INERTIAL_AT], I[o + INERTIAL_VALUES]
        for b in range(I[o + INERTIAL]):
            H, G, N = F[values + 3 * b], F[values + 3 * b + 1], F[values + 3 * b + 2]
            A[I[I[SLOTS] + I[entries + 3 * b + 2]]] -= ex * N + (alpha + 2.0 * cD * w) * G + cK * w * w * H
        entries, values = I[o + ELASTIC_AT], I[o + ELASTIC_VALUES]
        for b in range(I[o + ELASTIC]):
            A[I[I[SLOTS] + I[entries + 3 * b + 2]]] += cK * F[values + 2 * b] + cD * F[values + 2 * b + 1]
