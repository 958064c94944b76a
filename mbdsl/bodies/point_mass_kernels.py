"""How the one frame of a point mass moves with q = (x, y): B = [[1, 0], [0, 1], [0, 0]], constant."""

from mbdsl.compilation.buffer_layout import FP, FRAMES, GD, GP, MU_WRENCH, PAST_WRENCH, WRENCH, Q, V
from mbdsl.compilation.marks import kernel

MASS = 0  #: the mass matrix is diagonal and constant
MODEL = "mbdsl.bodies.rigid_body"


@kernel
def move(block, Y, Z, F, I):
    for e in range(I[block]):
        o = I[block + 1] + 5 * e
        d, f0, k = I[o], I[o + 1], I[o + 3]
        for f in range(f0, f0 + I[o + 2]):
            for j in range(14):
                Z[f, j] = 0.0
            Z[f, 0], Z[f, 1], Z[f, 2] = Y[Q, d], Y[Q, d + 1], F[k + 2]
            Z[f, 3], Z[f, 4] = Y[V, d], Y[V, d + 1]
            k += 3


@kernel
def gather(block, wrench, row, Y, Z, I):
    for e in range(I[block]):
        o = I[block + 1] + 5 * e
        for f in range(I[o + 1], I[o + 1] + I[o + 2]):
            Y[row, I[o]] += Z[f, wrench]
            Y[row, I[o] + 1] += Z[f, wrench + 1]


@kernel
def collect(block, Y, Z, I):
    gather(block, WRENCH, FP, Y, Z, I)


@kernel
def collect_with_mu(block, Y, Z, I):
    collect(block, Y, Z, I)
    gather(block, MU_WRENCH, GD, Y, Z, I)


@kernel
def collect_past(block, Y, Z, I):
    gather(block, PAST_WRENCH, GP, Y, Z, I)


@kernel
def jacobians(block, Y, Z, F, I):
    for e in range(I[block]):
        o = I[block + 1] + 5 * e
        for f in range(I[o + 1], I[o + 1] + I[o + 2]):
            k = I[I[FRAMES] + 2 * f + 1]
            for j in range(12):
                F[k + j] = 0.0
            F[k], F[k + 3] = 1.0, 1.0
