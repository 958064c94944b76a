"""How frames on a planar rigid body move with its coordinates q = (x, y, phi) of the centre of mass.

For a frame at s (body axes), l = A(phi) s:

    r = (x, y) + l,  phi_f = phi + phi0
    B = dz/dq = [[1, 0, -l_y], [0, 1, l_x], [0, 0, 1]],   (B v)_q = [[0, 0, -l_x w], [0, 0, -l_y w], [0, 0, 0]]
    d(B^T F)/dq = -(l . F) in (phi, phi)

These functions are all that joints and forces know of a body. Integer table, per body: first coordinate,
first frame, number of frames, offset of the frames' (s_x, s_y, phi0), slot of (phi, phi) in the iteration matrix.
"""

from math import cos, sin

from mbdsl.compilation.buffer_layout import (
    FP,
    FRAMES,
    GD,
    GP,
    LEVER,
    MU_WRENCH,
    PAST_LEVER,
    PAST_WRENCH,
    SLOTS,
    WRENCH,
    Q,
    V,
)
from mbdsl.compilation.marks import kernel

MASS = 0  #: the mass matrix is diagonal and constant
MODEL = "mbdsl.bodies.rigid_body"


@kernel
def move(block, Y, Z, F, I):
    """Pose, rate and lever of every frame; wrenches start at zero."""
    for e in range(I[block]):
        o = I[block + 1] + 5 * e
        d, f0, k = I[o], I[o + 1], I[o + 3]
        x, y, phi = Y[Q, d], Y[Q, d + 1], Y[Q, d + 2]
        vx, vy, w = Y[V, d], Y[V, d + 1], Y[V, d + 2]
        c, s = cos(phi), sin(phi)
        for f in range(f0, f0 + I[o + 2]):
            sx, sy = F[k], F[k + 1]
            lx, ly = c * sx - s * sy, s * sx + c * sy
            Z[f, 0], Z[f, 1], Z[f, 2] = x + lx, y + ly, phi + F[k + 2]
            Z[f, 3], Z[f, 4], Z[f, 5] = vx - ly * w, vy + lx * w, w
            Z[f, 6], Z[f, 7], Z[f, 8] = 0.0, 0.0, 0.0
            Z[f, 9], Z[f, 10] = lx, ly
            Z[f, 11], Z[f, 12], Z[f, 13] = 0.0, 0.0, 0.0
            k += 3


@kernel
def gather(block, wrench, lever, row, Y, Z, I):
    """Y[row] += B^T F for every frame's wrench F in the columns from ``wrench`` on, l in those from ``lever`` on."""
    for e in range(I[block]):
        o = I[block + 1] + 5 * e
        d = I[o]
        for f in range(I[o + 1], I[o + 1] + I[o + 2]):
            fx, fy = Z[f, wrench], Z[f, wrench + 1]
            Y[row, d] += fx
            Y[row, d + 1] += fy
            Y[row, d + 2] += Z[f, wrench + 2] - Z[f, lever + 1] * fx + Z[f, lever] * fy


@kernel
def collect(block, Y, Z, I):
    """f += B^T F."""
    gather(block, WRENCH, LEVER, FP, Y, Z, I)


@kernel
def collect_with_mu(block, Y, Z, I):
    """The same, and that of the wrenches of the stabilising multipliers, Phi_q^T mu."""
    for e in range(I[block]):
        o = I[block + 1] + 5 * e
        d = I[o]
        x, y, phi, mu_x, mu_y, mu_phi = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for f in range(I[o + 1], I[o + 1] + I[o + 2]):
            lx, ly = Z[f, LEVER], Z[f, LEVER + 1]
            x += Z[f, WRENCH]
            y += Z[f, WRENCH + 1]
            phi += Z[f, WRENCH + 2] - ly * Z[f, WRENCH] + lx * Z[f, WRENCH + 1]
            mu_x += Z[f, MU_WRENCH]
            mu_y += Z[f, MU_WRENCH + 1]
            mu_phi += Z[f, MU_WRENCH + 2] - ly * Z[f, MU_WRENCH] + lx * Z[f, MU_WRENCH + 1]
        Y[FP, d] += x
        Y[FP, d + 1] += y
        Y[FP, d + 2] += phi
        Y[GD, d] = mu_x
        Y[GD, d + 1] = mu_y
        Y[GD, d + 2] = mu_phi


@kernel
def collect_past(block, Y, Z, I):
    """The same for those of psi, at the pose of the start of the step."""
    gather(block, PAST_WRENCH, PAST_LEVER, GP, Y, Z, I)


@kernel
def jacobians(block, Y, Z, F, I):
    """B, then (B v)_q, of every frame, 3 x 3 each, row by row; what is always zero has been zero from the start."""
    for e in range(I[block]):
        o = I[block + 1] + 5 * e
        w = Y[V, I[o] + 2]
        for f in range(I[o + 1], I[o + 1] + I[o + 2]):
            k = I[I[FRAMES] + 2 * f + 1]
            lx, ly = Z[f, 9], Z[f, 10]
            F[k], F[k + 4], F[k + 8] = 1.0, 1.0, 1.0
            F[k + 2], F[k + 5] = -ly, lx
            F[k + 11], F[k + 14] = -lx * w, -ly * w


@kernel
def stiffness(block, cK, Z, I, A):
    """A += cK * (-d(B^T F)/dq) at the accumulated wrenches."""
    for e in range(I[block]):
        o = I[block + 1] + 5 * e
        for f in range(I[o + 1], I[o + 1] + I[o + 2]):
            A[I[I[SLOTS] + I[o + 4]]] += cK * (Z[f, 9] * Z[f, 6] + Z[f, 10] * Z[f, 7])
