"""The planar ANCF cable: motion of frames on a beam in absolute nodal coordinates, and its elastic forces.

The coordinates of each node are the position r and the slope r' = dr/dx of the axis, where x is the undeformed length.
Between two nodes r = S e, with the four cubic Hermite polynomials S(x) and the element's eight coordinates e. Therefore
the mass matrix is constant, there are no velocity-dependent inertia forces, and a frame at x moves with

    r = S e,   theta = atan2(r'_y, r'_x),   B = [S; p^T S'],   p = J r'/|r'|^2,   J the rotation by 90 degrees
    (B v)_q = [0; (P S' v)^T S'],   P = d^2 theta/dr'^2 = [[-2 p_x p_y, p_x^2 - p_y^2], [., 2 p_x p_y]]
    d(B^T F)/dq = tau S'^T P S'

A slope vector does not contain the number of revolutions. The angle of end a is the value closest to its angle in the
last accepted state (``numbers[layout[TURN]]``, which evaluations only read); from there, revolutions are counted along
the axis, which bends by less than half a turn between two nodes. Thus angles depend on q and on the last accepted state
only, and not on rejected iterates. (Sections are assumed to be normal to the axis.)

Axial strain, material curvature, and their energy, with Kelvin-Voigt damping (retardation time T):

    eps = |r'| - 1,   K = r' x r''/|r'|^2 = theta',   U = 1/2 int EA eps^2 + EI K^2 dx
    N = EA (eps + T d eps/dt),   M = EI (K + T dK/dt),   Q = -int eps_e N + K_e M dx

With u = r'/|r'|^2: eps_r' = r'/|r'|, eps_r'r' = (1 - eps_r' eps_r'^T)/|r'|, K_r'' = p, K_r' = -J r''/|r'|^2 - 2 K u,
K_r''r' = J/|r'|^2 - 2 p u^T, K_r'r' = 2 (J r'' u^T + u (J r'')^T)/|r'|^2 + 8 K u u^T - 2 K/|r'|^2.

The points at which eps and K are evaluated are tables (:mod:`mbdsl.bodies.ancf_cable`). Source: J. Gerstmayr,
H. Irschik, On the correct representation of bending and axial deformation in the absolute nodal coordinate formulation
with an elastic line approach, J. Sound Vib. 318 (2008) 461-487. Record of a body in layout: see ``RECORD``. Record of a
frame: number of its shape functions (4, or 2 at a node), its first coordinate, offset in numbers of phi0, S, S', first
slot.
"""

from math import atan2, floor, pi, sqrt

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import PLANE as C
from mbdsl.kernels.marks import kernel, rare
from mbdsl.numerics.banded import cholesky_solve_pairs

MASS = 1  #: the mass matrix is constant, but not diagonal
#: the model that fills the tables
MODEL = "mbdsl.bodies.ancf_cable"

# -- record of a body: first coordinate, first frame, number of frames, number of elements --------------------------
FIRST, FRAME, N_FRAME, ELEMENTS = 0, 1, 2, 3
#: offsets of EA, EI, T in numbers; number of points, offset of weights and S' for eps; same for K, with S' and S''
MATERIAL, N_STRETCH, STRETCH, N_BEND, BEND = 4, 5, 6, 7, 8
#: first slot of the elements' 8 x 8 blocks, list of frame records, bandwidth of M; in numbers its factor, scratch (64)
BLOCKS, OF_FRAMES, BAND, FACTOR, SCRATCH = 9, 10, 11, 12, 13
#: offset in numbers of the angle of end a in the last accepted state
TURN = 14
RECORD = 15
FRAME_RECORD = 4
STRETCH_POINT, BEND_POINT = 5, 9


@kernel
def passed(ax, ay, bx, by):
    """1 where atan2 jumps by -2 pi on the shorter rotation from slope a to slope b, -1 for a jump by 2 pi, else 0."""
    if ay >= 0.0 > by and ax * by - ay * bx > 0.0:
        return 1.0
    if ay < 0.0 <= by and ax * by - ay * bx < 0.0:
        return -1.0
    return 0.0


@kernel
def angle(x, y):
    """atan2(y, x) with -0 taken as 0, as ``passed`` assumes."""
    return atan2(y + 0.0, x)


@kernel
def move(block, vectors, frames, numbers, layout):
    """Write pose, rate and p (in the columns LEVER) of every frame, and zero wrenches, to frames.

    Reads the rows POSITION and VELOCITY of vectors.
    """
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d = layout[o + FIRST]
        first = floor(
            (numbers[layout[o + TURN]] - angle(vectors[L.POSITION, d + 2], vectors[L.POSITION, d + 3])) / (2.0 * pi)
            + 0.5
        )
        for f in range(layout[o + N_FRAME]):
            r, z = layout[o + OF_FRAMES] + FRAME_RECORD * f, frames[layout[o + FRAME] + f]
            k, n = layout[r], layout[r + 2]
            q, v = (
                vectors[L.POSITION, layout[o + FIRST] + layout[r + 1] :],
                vectors[L.VELOCITY, layout[o + FIRST] + layout[r + 1] :],
            )
            x, y, vx, vy, ax, ay, ux, uy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for j in range(k):
                s, t = numbers[n + 1 + j], numbers[n + 1 + k + j]
                x += s * q[2 * j]
                y += s * q[2 * j + 1]
                vx += s * v[2 * j]
                vy += s * v[2 * j + 1]
                ax += t * q[2 * j]
                ay += t * q[2 * j + 1]
                ux += t * v[2 * j]
                uy += t * v[2 * j + 1]
            square = ax * ax + ay * ay
            px, py = -ay / square, ax / square
            turns, last = first, d + layout[r + 1] // 4 * 4 + 2
            for i in range(d + 2, last, 4):
                turns += passed(
                    vectors[L.POSITION, i],
                    vectors[L.POSITION, i + 1],
                    vectors[L.POSITION, i + 4],
                    vectors[L.POSITION, i + 5],
                )
            turns += passed(vectors[L.POSITION, last], vectors[L.POSITION, last + 1], ax, ay)
            z[0], z[1], z[2] = x, y, angle(ax, ay) + 2.0 * pi * turns + numbers[n]
            z[3], z[4], z[5] = vx, vy, px * ux + py * uy
            z[C.LEVER], z[C.LEVER + 1] = px, py
            for j in range(3):
                z[C.WRENCH + j], z[C.MU_WRENCH + j] = 0.0, 0.0


@kernel
def gather(block, wrench, lever, row, vectors, frames, numbers, layout):
    """vectors[row] += B^T F of every frame, with F and p in the columns of frames from ``wrench`` and ``lever`` on."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        for f in range(layout[o + N_FRAME]):
            r, z = layout[o + OF_FRAMES] + FRAME_RECORD * f, frames[layout[o + FRAME] + f]
            k, n, to = layout[r], layout[r + 2], vectors[row, layout[o + FIRST] + layout[r + 1] :]
            tx, ty = z[lever] * z[wrench + 2], z[lever + 1] * z[wrench + 2]
            for j in range(k):
                s, t = numbers[n + 1 + j], numbers[n + 1 + k + j]
                to[2 * j] += s * z[wrench] + t * tx
                to[2 * j + 1] += s * z[wrench + 1] + t * ty


@kernel
def curvature(ax, ay, bx, by):
    """K, K_r', K_r'' and 1/|r'|^2 for r' = a, r'' = b."""
    d = 1.0 / (ax * ax + ay * ay)
    K = (ax * by - ay * bx) * d
    return K, (by - 2.0 * K * ax) * d, (-bx - 2.0 * K * ay) * d, -ay * d, ax * d, d


@kernel
def summed(c, k, q):
    """x and y of a field at a point: coordinates q times the shape functions, or their derivatives, in c from k on."""
    x, y = 0.0, 0.0
    for j in range(4):
        x += c[k + j] * q[2 * j]
        y += c[k + j] * q[2 * j + 1]
    return x, y


@kernel
def forces(block, vectors, numbers, layout):
    """vectors[FORCE] += elastic and damping forces. Reads the rows POSITION and VELOCITY."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        m = layout[o + MATERIAL]
        EA, EI, T = numbers[m], numbers[m + 1], numbers[m + 2]
        for i in range(layout[o + ELEMENTS]):
            d = layout[o + FIRST] + 4 * i
            q, v, f = vectors[L.POSITION, d : d + 8], vectors[L.VELOCITY, d : d + 8], vectors[L.FORCE, d : d + 8]
            for g in range(layout[o + N_STRETCH]):
                c = numbers[layout[o + STRETCH] + STRETCH_POINT * g :]
                (ax, ay), (ux, uy) = summed(c, 1, q), summed(c, 1, v)
                n = sqrt(ax * ax + ay * ay)
                N = -c[0] * EA * (n - 1.0 + T * (ax * ux + ay * uy) / n) / n
                for j in range(4):
                    f[2 * j] += c[1 + j] * N * ax
                    f[2 * j + 1] += c[1 + j] * N * ay
            for g in range(layout[o + N_BEND]):
                c = numbers[layout[o + BEND] + BEND_POINT * g :]
                (ax, ay), (ux, uy) = summed(c, 1, q), summed(c, 1, v)
                (bx, by), (wx, wy) = summed(c, 5, q), summed(c, 5, v)
                K, kx, ky, px, py, _ = curvature(ax, ay, bx, by)
                M = -c[0] * EI * (K + T * (kx * ux + ky * uy + px * wx + py * wy))
                for j in range(4):
                    f[2 * j] += M * (c[1 + j] * kx + c[5 + j] * px)
                    f[2 * j + 1] += M * (c[1 + j] * ky + c[5 + j] * py)


@kernel
def inertia(block, task, row, target, vectors, numbers, layout):
    """Tasks of the mass matrix, see :mod:`mbdsl.kernels.buffer_layout`: here INVERSE, which writes vectors[target].
    :mod:`mbdsl.system.loops` multiplies with the constant entries of M."""
    if task == L.INVERSE:
        for e in range(layout[block]):
            o = layout[block + 1] + RECORD * e
            d, k = layout[o + FIRST], 2 * (layout[o + ELEMENTS] + 1)
            for j in range(d, d + 2 * k):
                vectors[target, j] = vectors[row, j]
            # x and y are not coupled in M, and have the same mass matrix
            cholesky_solve_pairs(k, layout[o + BAND], numbers[layout[o + FACTOR] :], vectors[target, d:])


# -- tangents --------------------------------------------------------------------------------------------------------


@kernel
def jacobians(block, vectors, frames, numbers, layout):
    """Write B, then (B v)_q, of every frame, 3 x 2 k each, to numbers. Entries that are always zero keep their initial
    value, zero."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        for f in range(layout[o + N_FRAME]):
            r, row = layout[o + OF_FRAMES] + FRAME_RECORD * f, layout[o + FRAME] + f
            k, n, v = layout[r], layout[r + 2], vectors[L.VELOCITY, layout[o + FIRST] + layout[r + 1] :]
            B, px, py = layout[layout[L.FRAMES] + 2 * row + 1], frames[row, C.LEVER], frames[row, C.LEVER + 1]
            ux, uy = 0.0, 0.0
            for j in range(k):
                ux += numbers[n + 1 + k + j] * v[2 * j]
                uy += numbers[n + 1 + k + j] * v[2 * j + 1]
            P_xx, P_xy = -2.0 * px * py, px * px - py * py
            wx, wy = P_xx * ux + P_xy * uy, P_xy * ux - P_xx * uy
            for j in range(k):
                s, t, x = numbers[n + 1 + j], numbers[n + 1 + k + j], B + 2 * j
                numbers[x], numbers[x + 2 * k + 1] = s, s
                numbers[x + 4 * k], numbers[x + 4 * k + 1] = t * px, t * py
                numbers[x + 10 * k], numbers[x + 10 * k + 1] = t * wx, t * wy


@kernel
def stiffness(block, cK, frames, numbers, layout, matrix):
    """matrix += cK * (-d(B^T F)/dq) with the accumulated wrenches F, from frames."""
    if cK == 0.0:  # forces may be infinite at rest, as P/w, where M is also asked for
        return
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        for f in range(layout[o + N_FRAME]):
            r, z = layout[o + OF_FRAMES] + FRAME_RECORD * f, frames[layout[o + FRAME] + f]
            k, t, slot = layout[r], layout[r + 2] + 1 + layout[r], layout[L.SLOTS] + layout[r + 3]
            px, py, tau = z[C.LEVER], z[C.LEVER + 1], -cK * z[C.WRENCH + 2]
            P_xx, P_xy = -2.0 * px * py * tau, (px * px - py * py) * tau
            for i in range(k):
                for j in range(k):
                    s, at = numbers[t + i] * numbers[t + j], slot + 4 * k * i + 2 * j
                    matrix[layout[at]] += s * P_xx
                    matrix[layout[at + 1]] += s * P_xy
                    matrix[layout[at + 2 * k]] += s * P_xy
                    matrix[layout[at + 2 * k + 1]] -= s * P_xx


@rare
def tangents(block, factors, vectors, numbers, layout, matrix):
    """matrix += -cK Q_q - cD Q_v with the elastic and damping forces Q; M is constant. Uses SCRATCH of numbers."""
    cK, cD = factors.cK, factors.cD
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        H = numbers[layout[o + SCRATCH] : layout[o + SCRATCH] + 64]
        for i in range(layout[o + ELEMENTS]):
            d = layout[o + FIRST] + 4 * i
            for j in range(64):
                H[j] = 0.0
            of_stretch(o, cK, cD, vectors[L.POSITION, d : d + 8], vectors[L.VELOCITY, d : d + 8], H, numbers, layout)
            of_bending(o, cK, cD, vectors[L.POSITION, d : d + 8], vectors[L.VELOCITY, d : d + 8], H, numbers, layout)
            slot = layout[L.SLOTS] + layout[o + BLOCKS] + 64 * i
            for j in range(64):
                matrix[layout[slot + j]] += H[j]


@kernel
def of_stretch(o, cK, cD, q, v, H, numbers, layout):
    """H (8 x 8) += the part of -cK Q_q - cD Q_v of one element that is due to its axial strain."""
    EA, T = numbers[layout[o + MATERIAL]], numbers[layout[o + MATERIAL] + 2]
    for g in range(layout[o + N_STRETCH]):
        c = numbers[layout[o + STRETCH] + STRETCH_POINT * g :]
        (ax, ay), (ux, uy) = summed(c, 1, q), summed(c, 1, v)
        n = sqrt(ax * ax + ay * ay)
        ax, ay = ax / n, ay / n
        rate = ax * ux + ay * uy
        k, N = c[0] * EA, c[0] * EA * cK * (n - 1.0 + T * rate) / n
        # eps_e (cK (eps + T d eps/dt) + cD T eps_v)_e^T + cK N eps_ee
        tx = k * ((cK + cD * T) * ax + cK * T * (ux - ax * rate) / n)
        ty = k * ((cK + cD * T) * ay + cK * T * (uy - ay * rate) / n)
        xx, xy = ax * tx + N * ay * ay, ax * ty - N * ax * ay
        yx, yy = ay * tx - N * ax * ay, ay * ty + N * ax * ax
        for i in range(4):
            for j in range(4):
                s, at = c[1 + i] * c[1 + j], 16 * i + 2 * j
                H[at] += s * xx
                H[at + 1] += s * xy
                H[at + 8] += s * yx
                H[at + 9] += s * yy


@kernel
def of_bending(o, cK, cD, q, v, H, numbers, layout):
    """H (8 x 8) += the part of -cK Q_q - cD Q_v of one element that is due to its curvature."""
    EI, T = numbers[layout[o + MATERIAL] + 1], numbers[layout[o + MATERIAL] + 2]
    for g in range(layout[o + N_BEND]):
        c = numbers[layout[o + BEND] + BEND_POINT * g :]
        (ax, ay), (ux, uy) = summed(c, 1, q), summed(c, 1, v)
        (bx, by), (wx, wy) = summed(c, 5, q), summed(c, 5, v)
        K, kx, ky, px, py, d = curvature(ax, ay, bx, by)
        k = c[0] * EI
        # K_r'r' = [[aa, ab], [ab, ac]], K_r''r' = [[m, ba], [bb, -m]]
        hx, hy, fx, fy = -by * d * d, bx * d * d, ax * d, ay * d
        aa = 4.0 * hx * ax + 8.0 * K * fx * fx - 2.0 * K * d
        ab = 2.0 * (hx * ay + hy * ax) + 8.0 * K * fx * fy
        ac = 4.0 * hy * ay + 8.0 * K * fy * fy - 2.0 * K * d
        m, ba, bb = -2.0 * px * fx, -d - 2.0 * px * fy, d - 2.0 * py * fx
        M = cK * k * (K + T * (kx * ux + ky * uy + px * wx + py * wy))
        # (cK (K + T dK/dt) + cD T K_v)_(r', r'')
        own, rate = k * (cK + cD * T), k * cK * T
        sx = own * kx + rate * (aa * ux + ab * uy + m * wx + bb * wy)
        sy = own * ky + rate * (ab * ux + ac * uy + ba * wx - m * wy)
        tx = own * px + rate * (m * ux + ba * uy)
        ty = own * py + rate * (bb * ux - m * uy)
        aa, ab, ac, m, ba, bb = M * aa, M * ab, M * ac, M * m, M * ba, M * bb
        for j in range(4):
            s, t = c[1 + j], c[5 + j]
            lx, ly = s * sx + t * tx, s * sy + t * ty
            # columns x and y: the factors of the rows' S', then of their S''
            axx, axy = kx * lx + s * aa + t * m, kx * ly + s * ab + t * bb
            ayx, ayy = ky * lx + s * ab + t * ba, ky * ly + s * ac - t * m
            bxx, bxy = px * lx + s * m, px * ly + s * ba
            byx, byy = py * lx + s * bb, py * ly - s * m
            for i in range(4):
                s, t, at = c[1 + i], c[5 + i], 16 * i + 2 * j
                H[at] += s * axx + t * bxx
                H[at + 1] += s * axy + t * bxy
                H[at + 8] += s * ayx + t * byx
                H[at + 9] += s * ayy + t * byy
