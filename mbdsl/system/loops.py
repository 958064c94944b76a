"""The loops over rows of the gradient table: scalar coordinates g(z) of pairs of frames contribute to f, Phi and A.

Kinds differ only in the dependence of g, its gradient G and its second derivative H on two frames. Therefore the loops
``fill`` and ``curve`` are compiled once for each kind; the others are the same for all constraints, springs and laws:

    constraint   Phi = g - u(t),  wrench -= G^T lam (and += G^T mu)
    spring       s = k (g - g0) + c dg/dt,  wrench -= G^T s
    law          s from an expression, wrench += sign G^T s

Nonholonomic constraints have no kernels of their own: Gam and its derivatives are expressions over frames.
"""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import (
    COUPLING_VALUES,
    COUPLINGS,
    FORCE0,
    FP,
    FRAMES,
    GAMMAS,
    GD,
    GP,
    GRADIENT_RATE,
    GROUND_FRAMES,
    INVERSE,
    KEEP,
    LAM_ROW,
    LEVER,
    MAGNITUDE,
    MASS,
    MASS_SLOTS,
    MOVED,
    MOVING,
    MU_ROW,
    MU_WRENCH,
    N_COUPLINGS,
    N_FRAMES,
    N_GAM,
    N_LAWS,
    N_MOVING,
    N_PHI,
    N_Q,
    N_SPRINGS,
    PAIR,
    PAIRS,
    PAST_GRADIENT,
    PAST_LEVER,
    PAST_WRENCH,
    PSI_ROW,
    REGISTERS,
    SIZE,
    SLOTS,
    TIMES,
    VALUE,
    WRENCH,
)
from mbdsl.compilation.marks import kernel, rare, square


@kernel
def fill(block, rows, gradient, Z, C, F, I):
    """g and G of all components of a kind."""
    for e in range(I[block]):
        r = I[block + 1] + rows * e
        o = I[PAIRS] + PAIR * r
        gradient(Z, I[o], I[o + 1], F[I[block + 2] + I[block + 3] * e :], C[r:])


@kernel
def curve(block, rows, hessian, Z, C, F, I):
    """d^2g/dz^2 and w^T d^2g/dz^2 of all components of a kind with a varying gradient."""
    for e in range(I[block]):
        for k in range(rows):
            r = I[block + 1] + rows * e + k
            o = I[PAIRS] + PAIR * r
            a, b, h = I[o], I[o + 1], I[o + 3]
            if h < 0:
                continue
            H = square(F, h)
            for j in range(36):
                F[h + j] = 0.0
            unit = C[r, GRADIENT_RATE:]
            for j in range(rows):
                unit[j] = 0.0
            unit[k] = 1.0
            hessian(Z, a, b, F[I[block + 2] + I[block + 3] * e :], unit, H)
            for j in range(6):
                rate = 0.0
                for i in range(3):
                    rate += Z[a, 3 + i] * F[h + 6 * i + j] + Z[b, 3 + i] * F[h + 6 * (3 + i) + j]
                C[r, GRADIENT_RATE + j] = rate


@kernel
def start(Y, Z, F, I):
    """Initialise f with the constant generalised force, and the ground's wrenches with zero."""
    for i in range(I[N_Q]):
        Y[FP, i] = F[I[FORCE0] + i]
        Y[GD, i] = 0.0
    for f in range(I[GROUND_FRAMES]):
        for j in range(3):
            Z[f, WRENCH + j], Z[f, MU_WRENCH + j] = 0.0, 0.0


@kernel
def carry(Z, F, I):
    """Pose and rates of frames that drivers move as functions of time."""
    for k in range(I[N_MOVING]):
        o = I[MOVING] + MOVED * k
        for j in range(6):
            Z[I[o], j] = F[I[REGISTERS] + I[o + 1 + j]]


@kernel
def constraints(Y, Z, C, F, I):
    """Phi, Phi_q v + Phi_t, and the constraint forces -Phi_q^T lam on the frames."""
    n, row = I[N_Q], I[LAM_ROW]
    for r in range(I[N_PHI]):
        o = I[PAIRS] + PAIR * r
        if I[o + 5]:
            Y[FP, n + r], Y[GD, n + r] = 0.0, 0.0
            continue
        a, b = I[o], I[o + 1]
        lam = Y[row, n + r]
        rate = 0.0
        for j in range(3):
            rate += C[r, j] * Z[a, 3 + j] + C[r, 3 + j] * Z[b, 3 + j]
            Z[a, 6 + j] -= C[r, j] * lam
            Z[b, 6 + j] -= C[r, 3 + j] * lam
        Y[FP, n + r] = C[r, VALUE]
        Y[GD, n + r] = rate


@kernel
def drive(Y, F, I):
    """Phi -= u(t) and Phi_q v + Phi_t -= u'(t) in the rows of drivers."""
    n = I[N_Q]
    for r in range(I[N_PHI]):
        o = I[PAIRS] + PAIR * r
        u = I[o + 4]
        if u >= 0 and not I[o + 5]:
            Y[FP, n + r] -= F[I[REGISTERS] + I[u]]
            Y[GD, n + r] -= F[I[REGISTERS] + I[u + 1]]


@kernel
def constraints_with_mu(Y, Z, C, F, I):
    """As ``constraints``, with Phi_q^T mu on the frames; one loop costs half as much as two."""
    n, row, mu_row = I[N_Q], I[LAM_ROW], I[MU_ROW]
    for r in range(I[N_PHI]):
        o = I[PAIRS] + PAIR * r
        if I[o + 5]:
            Y[FP, n + r], Y[GD, n + r] = 0.0, 0.0
            continue
        a, b = I[o], I[o + 1]
        lam, mu = Y[row, n + r], Y[mu_row, n + r]
        rate = 0.0
        for j in range(3):
            g, k = C[r, j], C[r, 3 + j]
            rate += g * Z[a, 3 + j] + k * Z[b, 3 + j]
            Z[a, WRENCH + j] -= g * lam
            Z[b, WRENCH + j] -= k * lam
            Z[a, MU_WRENCH + j] += g * mu
            Z[b, MU_WRENCH + j] += k * mu
        Y[FP, n + r] = C[r, VALUE]
        Y[GD, n + r] = rate


@kernel
def keep(Y, Z, C, I):
    """At the start of a step, store the state of the last evaluation; wrenches of psi start at zero."""
    if I[KEEP]:
        I[KEEP] = 0
        for r in range(I[N_PHI]):
            for j in range(6):
                C[r, PAST_GRADIENT + j] = C[r, j]
        for f in range(I[N_FRAMES]):
            for j in range(2):
                Z[f, PAST_LEVER + j] = Z[f, LEVER + j]
    for i in range(I[N_Q]):
        Y[GP, i] = 0.0
    for f in range(I[N_FRAMES]):
        for j in range(3):
            Z[f, PAST_WRENCH + j] = 0.0


@kernel
def remember(Y, Z, C, I):
    """Phi_q^T psi with the Phi_q of the start of the step, on the frames."""
    n, row = I[N_Q], I[PSI_ROW]
    for r in range(I[N_PHI]):
        o = I[PAIRS] + PAIR * r
        a, b = I[o], I[o + 1]
        if I[o + 5]:
            continue
        psi = Y[row, n + r]
        for j in range(3):
            Z[a, PAST_WRENCH + j] += C[r, PAST_GRADIENT + j] * psi
            Z[b, PAST_WRENCH + j] += C[r, PAST_GRADIENT + 3 + j] * psi


@kernel
def gammas(Y, Z, F, I):
    """Gam, and the constraint forces -Gam_v^T nu on the frames. Records: see :mod:`mbdsl.system.nonholonomic`."""
    first = I[N_Q] + I[N_PHI]
    for k in range(I[N_GAM]):
        o = I[I[GAMMAS] + k]
        Y[FP, first + k], Y[GD, first + k] = F[I[REGISTERS] + I[o]], 0.0
        if I[o + 3]:
            Y[FP, first + k] = 0.0
            continue
        nu = Y[I[LAM_ROW], first + k]
        for l in range(I[o + 4]):
            at = o + 5 + 7 * l
            for j in range(3):
                Z[I[at], WRENCH + j] -= F[I[REGISTERS] + I[at + 1 + j]] * nu


@kernel
def springs(Z, C, F, I):
    """Linear springs and dampers: wrench -= G^T (k (g - g0) + c dg/dt)."""
    for r in range(I[N_PHI], I[N_PHI] + I[N_SPRINGS]):
        o = I[PAIRS] + PAIR * r
        a, b, p = I[o], I[o + 1], I[o + 4]
        rate = 0.0
        for j in range(3):
            rate += C[r, j] * Z[a, 3 + j] + C[r, 3 + j] * Z[b, 3 + j]
        s = F[p] * (C[r, VALUE] - F[p + 2]) + F[p + 1] * rate
        C[r, MAGNITUDE] = s
        for j in range(3):
            Z[a, 6 + j] -= C[r, j] * s
            Z[b, 6 + j] -= C[r, 3 + j] * s


@kernel
def laws(Z, C, F, I):
    """Forces by expression: wrench += sign G^T s. The leaf list starts with the register of s, and the sign."""
    first = I[N_PHI] + I[N_SPRINGS]
    for r in range(first, first + I[N_LAWS]):
        o = I[PAIRS] + PAIR * r
        a, b = I[o], I[o + 1]
        s = I[I[o + 4] + 1] * F[I[REGISTERS] + I[I[o + 4]]]
        C[r, MAGNITUDE] = -s
        for j in range(3):
            Z[a, 6 + j] += C[r, j] * s
            Z[b, 6 + j] += C[r, 3 + j] * s


# -- tangents ------------------------------------------------------------------------------------------------


@kernel
def inertia(task, row, target, Y, F, I):
    """Tasks of the constant part of the mass matrix; INVERSE for bodies with a diagonal one."""
    if task == TIMES:
        for i in range(I[N_Q]):
            Y[target, i] = 0.0
        for k in range(I[N_COUPLINGS]):
            o, value = I[COUPLINGS] + 3 * k, F[I[COUPLING_VALUES] + k]
            Y[target, I[o]] += value * Y[row, I[o + 1]]
            Y[target, I[o + 1]] += value * Y[row, I[o]]
    elif task == INVERSE:
        for i in range(I[N_Q]):
            Y[target, i] = Y[row, i] / F[I[MASS] + i]


@rare
def coupling_matrix(cM, F, I, A):
    """A += cM times the constant off-diagonal entries of M."""
    for k in range(I[N_COUPLINGS]):
        slot, value = I[SLOTS] + I[I[COUPLINGS] + 3 * k + 2], cM * F[I[COUPLING_VALUES] + k]
        A[I[slot]] += value
        A[I[slot + 1]] += value


@rare
def begin_matrix(cM, F, I, A):
    """A = cM times the constant part of M's diagonal."""
    for i in range(I[SIZE]):
        A[i] = 0.0
    for i in range(I[N_Q]):
        A[I[I[SLOTS] + I[MASS_SLOTS] + i]] += cM * F[I[MASS] + i]


@rare
def frame_block(slot, fr, fc, cT, T, cTd, Td, F, I, A):
    """A[slots] += B_r^T (cT T B_c + cTd Td (B v)_q,c), T and Td 3 x 3 blocks in F, with row stride 6."""
    nr, kr = I[I[FRAMES] + 2 * fr], I[I[FRAMES] + 2 * fr + 1]
    nc, kc = I[I[FRAMES] + 2 * fc], I[I[FRAMES] + 2 * fc + 1]
    for j in range(nc):
        t0, t1, t2 = 0.0, 0.0, 0.0
        for l in range(3):
            bl, dl = cT * F[kc + l * nc + j], cTd * F[kc + (3 + l) * nc + j]
            t0 += F[T + l] * bl + F[Td + l] * dl
            t1 += F[T + 6 + l] * bl + F[Td + 6 + l] * dl
            t2 += F[T + 12 + l] * bl + F[Td + 12 + l] * dl
        for i in range(nr):
            A[I[slot + i * nc + j]] += F[kr + i] * t0 + F[kr + nr + i] * t1 + F[kr + 2 * nr + i] * t2
    return slot + nr * nc


@rare
def pair_blocks(slot, a, b, cT, T, cTd, Td, F, I, A):
    """The four blocks of 6 x 6 matrices T and Td in F over the frames (a, b); returns the slot behind them."""
    for i in range(2):
        for j in range(2):
            at = 18 * i + 3 * j
            fr, fc = (a, b)[i], (a, b)[j]
            slot = frame_block(slot, fr, fc, cT, T + at, cTd, Td + at, F, I, A)
    return slot


@rare
def constraint_tangents(cK, cP, cN, Y, C, F, I, A):
    """cK (Phi_q^T lam)_q; Phi_q^T to the right; cP Phi_q + cN (Phi_q v)_q below; 1 on the diagonal if left out."""
    n, row = I[N_Q], I[LAM_ROW]
    for r in range(I[N_PHI]):
        o = I[PAIRS] + PAIR * r
        slot = I[SLOTS] + I[o + 2]
        if I[o + 5]:
            A[I[slot]] += 1.0
            continue
        slot += 1
        if I[o + 3] >= 0:
            slot = pair_blocks(slot, I[o], I[o + 1], cK * Y[row, n + r], I[o + 3], 0.0, I[o + 3], F, I, A)
        for side in range(2):
            f = I[o + side]
            nb, kb = I[I[FRAMES] + 2 * f], I[I[FRAMES] + 2 * f + 1]
            for j in range(nb):
                value = 0.0
                for l in range(3):
                    value += C[r, 3 * side + l] * F[kb + l * nb + j]
                A[I[slot + j]] += value
                A[I[slot + nb + j]] += cP * value
            if cN != 0.0:  # no method requires it
                for j in range(nb):
                    rate = 0.0
                    for l in range(3):
                        k = kb + l * nb + j
                        rate += C[r, GRADIENT_RATE + 3 * side + l] * F[k] + C[r, 3 * side + l] * F[k + 3 * nb]
                    A[I[slot + nb + j]] += cN * rate
            slot += 2 * nb


@rare
def spring_tangents(scratch, cK, cD, C, F, I, A):
    """-df on frames: s H + G (k G + c w^T H) with respect to z, c G G with respect to w."""
    for r in range(I[N_PHI], I[N_PHI] + I[N_SPRINGS]):
        o = I[PAIRS] + PAIR * r
        a, b, h, p = I[o], I[o + 1], I[o + 3], I[o + 4]
        for i in range(6):
            for j in range(6):
                damping = F[p + 1] * C[r, i] * C[r, j]
                stiffness = C[r, i] * (F[p] * C[r, j] + F[p + 1] * C[r, GRADIENT_RATE + j])
                if h >= 0:
                    stiffness += C[r, MAGNITUDE] * F[h + 6 * i + j]
                F[scratch + 6 * i + j] = cK * stiffness + cD * damping
                F[scratch + 36 + 6 * i + j] = damping
        pair_blocks(I[SLOTS] + I[o + 2], a, b, 1.0, scratch, cK, scratch + 36, F, I, A)


@rare
def law_tangents(scratch, cK, cD, cL, C, F, I, A):
    """-df = s H - sign G ds/dz over every frame, and - sign G ds/dlam over every multiplier that s depends on.

    (The s of H already holds the sign.)
    """
    first = I[N_PHI] + I[N_SPRINGS]
    for r in range(first, first + I[N_LAWS]):
        o = I[PAIRS] + PAIR * r
        a, b, h, leaf = I[o], I[o + 1], I[o + 3], I[o + 4]
        slot = I[SLOTS] + I[o + 2]
        if h >= 0:
            slot = pair_blocks(slot, a, b, cK * C[r, MAGNITUDE], h, 0.0, h, F, I, A)
        sign = I[leaf + 1]
        for k in range(I[leaf + 2]):
            at = leaf + 3 + 7 * k
            for i in range(6):
                for j in range(3):
                    dz = -sign * C[r, i] * F[I[REGISTERS] + I[at + 1 + j]]
                    dw = -sign * C[r, i] * F[I[REGISTERS] + I[at + 4 + j]]
                    F[scratch + 6 * i + j] = cK * dz + cD * dw
                    F[scratch + 36 + 6 * i + j] = dw
            slot = frame_block(slot, a, I[at], 1.0, scratch, cK, scratch + 36, F, I, A)
            slot = frame_block(slot, b, I[at], 1.0, scratch + 18, cK, scratch + 54, F, I, A)
        at = leaf + 3 + 7 * I[leaf + 2]
        for k in range(I[at]):
            change = -cL * sign * F[I[REGISTERS] + I[at + 1 + k]]
            for side in range(2):
                f = (a, b)[side]
                nb, kb = I[I[FRAMES] + 2 * f], I[I[FRAMES] + 2 * f + 1]
                for j in range(nb):
                    value = 0.0
                    for l in range(3):
                        value += C[r, 3 * side + l] * F[kb + l * nb + j]
                    A[I[slot + j]] += change * value
                slot += nb


@rare
def gamma_tangents(scratch, cK, cD, cV, cW, Y, F, I, A):
    """cK (Gam_v^T nu)_q + cD (Gam_v^T nu)_v; Gam_v^T to the right; cV Gam_v + cW Gam_q below.

    A constraint that is left out, or out of play (cV = 0 = cW), has 1 on the diagonal.
    """
    first = I[N_Q] + I[N_PHI]
    for k in range(I[N_GAM]):
        o = I[I[GAMMAS] + k]
        slot, count, nu = I[SLOTS] + I[o + 2], I[o + 4], Y[I[LAM_ROW], first + k]
        if I[o + 3] or (cV == 0.0 and cW == 0.0):
            A[I[slot]] += 1.0
        if I[o + 3]:
            continue
        slot += 1
        for l in range(count):
            at = o + 5 + 7 * l
            f = I[at]
            nb, kb = I[I[FRAMES] + 2 * f], I[I[FRAMES] + 2 * f + 1]
            for j in range(nb):
                value, rate = 0.0, 0.0
                for i in range(3):
                    w, z, b = F[I[REGISTERS] + I[at + 1 + i]], F[I[REGISTERS] + I[at + 4 + i]], kb + i * nb + j
                    value += w * F[b]
                    rate += z * F[b] + w * F[b + 3 * nb]
                A[I[slot + j]] += value
                A[I[slot + nb + j]] += cV * value + cW * rate
            slot += 2 * nb
        second = o + 5 + 7 * count
        for r in range(count):
            for c in range(count):
                at = second + 18 * (r * count + c)
                for i in range(3):
                    for j in range(3):
                        dz = nu * F[I[REGISTERS] + I[at + 3 * i + j]]
                        dw = nu * F[I[REGISTERS] + I[at + 9 + 3 * i + j]]
                        F[scratch + 6 * i + j] = cK * dz + cD * dw
                        F[scratch + 36 + 6 * i + j] = dw
                fr, fc = I[o + 5 + 7 * r], I[o + 5 + 7 * c]
                slot = frame_block(slot, fr, fc, 1.0, scratch, cK, scratch + 36, F, I, A)
