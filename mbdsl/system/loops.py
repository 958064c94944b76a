"""The loops over the rows of the gradient table. They add the contributions of scalar coordinates g(z) of frame pairs
to f, Phi and the iteration matrix.

Kinds differ only in the dependence of g, its gradient G and its second derivative H on two frames. Therefore the loops
``fill`` and ``curve`` are compiled once for each kind; the others are the same for all constraints, springs and laws:

    constraint   Phi = g - u(t),  wrench -= G^T lam (and += G^T mu)
    spring       s = k (g - g0) + c dg/dt,  wrench -= G^T s
    law          s from an expression, wrench += sign G^T s

Nonholonomic constraints have no kernels of their own: Gam and its derivatives are expressions over frames.
"""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import (
    BLOCK_SIZE,
    CARRIED,
    CONSTANT_FORCE,
    COUPLED,
    COUPLING,
    COUPLING_VALUES,
    COUPLINGS,
    DETAIL,
    FORCE,
    FORCE2,
    FRAME_A,
    FRAME_B,
    FRAMES,
    GAMMA,
    GAMMAS,
    GRADIENT_RATE,
    GROUND_FRAMES,
    HALF,
    INVERSE,
    KEEP,
    LAM_ROW,
    LEAF,
    LEAVES,
    LEFT_OUT,
    LEVER,
    LEVERS,
    MAGNITUDE,
    MASS,
    MASS_SLOTS,
    MOVED,
    MOVING,
    MU_ROW,
    MU_WRENCH,
    N_COUPLED,
    N_COUPLINGS,
    N_FRAMES,
    N_GAM,
    N_LAWS,
    N_MOVING,
    N_PHI,
    N_Q,
    N_SPRINGS,
    PAIR,
    PAIR_POSE,
    PAIRS,
    PAST_FORCE,
    PAST_GRADIENT,
    PAST_LEVER,
    PAST_WRENCH,
    POSE,
    PSI_ROW,
    RATE,
    REGISTERS,
    SECOND_DERIVATIVE,
    SIZE,
    SLOT,
    SLOTS,
    SQUARE,
    TANGENT_SCRATCH,
    TIMES,
    VALUE,
    WRENCH,
)
from mbdsl.compilation.marks import kernel, rare, square
from mbdsl.system.frame_block import frame_block


@kernel
def fill(block, rows, gradient, frames, gradients, numbers, layout):
    """Write g and G of all components of a kind to gradients. Reads frames, and parameters in numbers."""
    for e in range(layout[block]):
        r = layout[block + 1] + rows * e
        o = layout[PAIRS] + PAIR * r
        gradient(
            frames,
            layout[o + FRAME_A],
            layout[o + FRAME_B],
            numbers[layout[block + 2] + layout[block + 3] * e :],
            gradients[r:],
        )


@kernel
def curve(block, rows, hessian, frames, gradients, numbers, layout):
    """Write d^2g/dz^2 to numbers and w^T d^2g/dz^2 to gradients, for all components of a kind with varying gradient."""
    for e in range(layout[block]):
        for k in range(rows):
            r = layout[block + 1] + rows * e + k
            o = layout[PAIRS] + PAIR * r
            a, b, h = layout[o + FRAME_A], layout[o + FRAME_B], layout[o + SECOND_DERIVATIVE]
            if h < 0:
                continue
            H = square(numbers, h, PAIR_POSE)
            for j in range(SQUARE):
                numbers[h + j] = 0.0
            unit = gradients[r, GRADIENT_RATE:]
            for j in range(rows):
                unit[j] = 0.0
            unit[k] = 1.0
            hessian(frames, a, b, numbers[layout[block + 2] + layout[block + 3] * e :], unit, H)
            for j in range(PAIR_POSE):
                rate = 0.0
                for i in range(POSE):
                    rate += (
                        frames[a, RATE + i] * numbers[h + PAIR_POSE * i + j]
                        + frames[b, RATE + i] * numbers[h + PAIR_POSE * (POSE + i) + j]
                    )
                gradients[r, GRADIENT_RATE + j] = rate


@kernel
def start(vectors, frames, numbers, layout):
    """Write the constant generalised force to vectors[FORCE], 0 to vectors[FORCE2] and to the ground's wrenches."""
    for i in range(layout[N_Q]):
        vectors[FORCE, i] = numbers[layout[CONSTANT_FORCE] + i]
        vectors[FORCE2, i] = 0.0
    for f in range(layout[GROUND_FRAMES]):
        for j in range(POSE):
            frames[f, WRENCH + j], frames[f, MU_WRENCH + j] = 0.0, 0.0


@kernel
def carry(frames, numbers, layout):
    """Write pose and rates of the frames that drivers move from the registers, in numbers, to frames."""
    for k in range(layout[N_MOVING]):
        o = layout[MOVING] + MOVED * k
        for j in range(CARRIED):
            frames[layout[o], j] = numbers[layout[REGISTERS] + layout[o + 1 + j]]


@kernel
def couple(numbers, layout):
    """Write the functions of couplings and their derivatives from the registers to the parameters of components."""
    for k in range(layout[N_COUPLED]):
        o = layout[COUPLED] + COUPLING * k
        numbers[layout[o]] = numbers[layout[REGISTERS] + layout[o + 1]]


@kernel
def constraints(vectors, frames, gradients, numbers, layout):
    """Write Phi to vectors[FORCE] and Phi_q v + Phi_t to vectors[FORCE2]; WRENCH in frames -= Phi_q^T lam."""
    n, row = layout[N_Q], layout[LAM_ROW]
    for r in range(layout[N_PHI]):
        o = layout[PAIRS] + PAIR * r
        if layout[o + LEFT_OUT]:
            vectors[FORCE, n + r], vectors[FORCE2, n + r] = 0.0, 0.0
            continue
        a, b = layout[o + FRAME_A], layout[o + FRAME_B]
        lam = vectors[row, n + r]
        rate = 0.0
        for j in range(POSE):
            rate += gradients[r, j] * frames[a, RATE + j] + gradients[r, POSE + j] * frames[b, RATE + j]
            frames[a, WRENCH + j] -= gradients[r, j] * lam
            frames[b, WRENCH + j] -= gradients[r, POSE + j] * lam
        vectors[FORCE, n + r] = gradients[r, VALUE]
        vectors[FORCE2, n + r] = rate


@kernel
def drive(vectors, numbers, layout):
    """vectors[FORCE] -= u(t) and vectors[FORCE2] -= u'(t), that is Phi and Phi_q v + Phi_t, in the rows of drivers."""
    n = layout[N_Q]
    for r in range(layout[N_PHI]):
        o = layout[PAIRS] + PAIR * r
        u = layout[o + DETAIL]
        if u >= 0 and not layout[o + LEFT_OUT]:
            vectors[FORCE, n + r] -= numbers[layout[REGISTERS] + layout[u]]
            vectors[FORCE2, n + r] -= numbers[layout[REGISTERS] + layout[u + 1]]


@kernel
def constraints_with_mu(vectors, frames, gradients, numbers, layout):
    """As ``constraints``; also MU_WRENCH in frames += Phi_q^T mu. One loop costs half as much as two."""
    n, row, mu_row = layout[N_Q], layout[LAM_ROW], layout[MU_ROW]
    for r in range(layout[N_PHI]):
        o = layout[PAIRS] + PAIR * r
        if layout[o + LEFT_OUT]:
            vectors[FORCE, n + r], vectors[FORCE2, n + r] = 0.0, 0.0
            continue
        a, b = layout[o + FRAME_A], layout[o + FRAME_B]
        lam, mu = vectors[row, n + r], vectors[mu_row, n + r]
        rate = 0.0
        for j in range(POSE):
            g, k = gradients[r, j], gradients[r, POSE + j]
            rate += g * frames[a, RATE + j] + k * frames[b, RATE + j]
            frames[a, WRENCH + j] -= g * lam
            frames[b, WRENCH + j] -= k * lam
            frames[a, MU_WRENCH + j] += g * mu
            frames[b, MU_WRENCH + j] += k * mu
        vectors[FORCE, n + r] = gradients[r, VALUE]
        vectors[FORCE2, n + r] = rate


@kernel
def keep(vectors, frames, gradients, layout):
    """At the start of a step, store G and levers of the last evaluation (PAST_GRADIENT, PAST_LEVER). At every
    evaluation, set vectors[PAST_FORCE] and PAST_WRENCH in frames to zero."""
    if layout[KEEP]:
        layout[KEEP] = 0
        for r in range(layout[N_PHI]):
            for j in range(PAIR_POSE):
                gradients[r, PAST_GRADIENT + j] = gradients[r, j]
        for f in range(layout[N_FRAMES]):
            for j in range(LEVERS):
                frames[f, PAST_LEVER + j] = frames[f, LEVER + j]
    for i in range(layout[N_Q]):
        vectors[PAST_FORCE, i] = 0.0
    for f in range(layout[N_FRAMES]):
        for j in range(POSE):
            frames[f, PAST_WRENCH + j] = 0.0


@kernel
def remember(vectors, frames, gradients, layout):
    """PAST_WRENCH in frames += Phi_q^T psi with the Phi_q of the start of the step."""
    n, row = layout[N_Q], layout[PSI_ROW]
    for r in range(layout[N_PHI]):
        o = layout[PAIRS] + PAIR * r
        a, b = layout[o + FRAME_A], layout[o + FRAME_B]
        if layout[o + LEFT_OUT]:
            continue
        psi = vectors[row, n + r]
        for j in range(POSE):
            frames[a, PAST_WRENCH + j] += gradients[r, PAST_GRADIENT + j] * psi
            frames[b, PAST_WRENCH + j] += gradients[r, PAST_GRADIENT + POSE + j] * psi


@kernel
def gammas(vectors, frames, numbers, layout):
    """Write Gam to vectors[FORCE]; WRENCH in frames -= Gam_v^T nu. Records: see :mod:`mbdsl.system.nonholonomic`."""
    first = layout[N_Q] + layout[N_PHI]
    for k in range(layout[N_GAM]):
        o = layout[layout[GAMMAS] + k]
        vectors[FORCE, first + k], vectors[FORCE2, first + k] = numbers[layout[REGISTERS] + layout[o]], 0.0
        if layout[o + 3]:
            vectors[FORCE, first + k] = 0.0
            continue
        nu = vectors[layout[LAM_ROW], first + k]
        for l in range(layout[o + 4]):
            at = o + GAMMA + LEAF * l
            for j in range(POSE):
                frames[layout[at], WRENCH + j] -= numbers[layout[REGISTERS] + layout[at + 1 + j]] * nu


@kernel
def springs(frames, gradients, numbers, layout):
    """Linear springs and dampers: s = k (g - g0) + c dg/dt to gradients; WRENCH in frames -= G^T s.

    Rows with k = c = 0 are left out: their g need not exist, as the tilt of a bushing after half a turn.
    """
    for r in range(layout[N_PHI], layout[N_PHI] + layout[N_SPRINGS]):
        o = layout[PAIRS] + PAIR * r
        a, b, p = layout[o + FRAME_A], layout[o + FRAME_B], layout[o + DETAIL]
        if numbers[p] == 0.0 and numbers[p + 1] == 0.0:
            gradients[r, MAGNITUDE] = 0.0
            continue
        rate = 0.0
        for j in range(POSE):
            rate += gradients[r, j] * frames[a, RATE + j] + gradients[r, POSE + j] * frames[b, RATE + j]
        s = numbers[p] * (gradients[r, VALUE] - numbers[p + 2]) + numbers[p + 1] * rate
        gradients[r, MAGNITUDE] = s
        for j in range(POSE):
            frames[a, WRENCH + j] -= gradients[r, j] * s
            frames[b, WRENCH + j] -= gradients[r, POSE + j] * s


@kernel
def laws(frames, gradients, numbers, layout):
    """Forces by expression: WRENCH in frames += sign G^T s. The leaf list starts with the register of s and sign."""
    first = layout[N_PHI] + layout[N_SPRINGS]
    for r in range(first, first + layout[N_LAWS]):
        o = layout[PAIRS] + PAIR * r
        a, b = layout[o + FRAME_A], layout[o + FRAME_B]
        s = layout[layout[o + DETAIL] + 1] * numbers[layout[REGISTERS] + layout[layout[o + DETAIL]]]
        gradients[r, MAGNITUDE] = -s
        for j in range(POSE):
            frames[a, WRENCH + j] += gradients[r, j] * s
            frames[b, WRENCH + j] += gradients[r, POSE + j] * s


# -- tangents ------------------------------------------------------------------------------------------------


@kernel
def inertia(task, row, target, vectors, numbers, layout):
    """Tasks of the mass matrix: TIMES for the constant off-diagonal entries, INVERSE for bodies with a diagonal one."""
    if task == TIMES:
        for i in range(layout[N_Q]):
            vectors[target, i] = 0.0
        for k in range(layout[N_COUPLINGS]):
            o, value = layout[COUPLINGS] + 3 * k, numbers[layout[COUPLING_VALUES] + k]
            vectors[target, layout[o]] += value * vectors[row, layout[o + 1]]
            vectors[target, layout[o + 1]] += value * vectors[row, layout[o]]
    elif task == INVERSE:
        for i in range(layout[N_Q]):
            vectors[target, i] = vectors[row, i] / numbers[layout[MASS] + i]


@rare
def coupling_matrix(cM, numbers, layout, matrix):
    """matrix += cM times the constant off-diagonal entries of M."""
    for k in range(layout[N_COUPLINGS]):
        slot, value = layout[SLOTS] + layout[layout[COUPLINGS] + 3 * k + 2], cM * numbers[layout[COUPLING_VALUES] + k]
        matrix[layout[slot]] += value
        matrix[layout[slot + 1]] += value


@rare
def begin_matrix(cM, cE, numbers, layout, matrix):
    """matrix = cM times the constant part of the diagonal of M, plus cE times the unit matrix."""
    for i in range(layout[SIZE]):
        matrix[i] = 0.0
    for i in range(layout[N_Q]):
        matrix[layout[layout[SLOTS] + layout[MASS_SLOTS] + i]] += cM * numbers[layout[MASS] + i] + cE


@rare
def pair_blocks(slot, a, b, cT, T, cTd, Td, numbers, layout, matrix):
    """matrix += four such blocks, of 6 x 6 matrices T and Td over the frames (a, b); returns the next slot."""
    for i in range(2):
        for j in range(2):
            at = HALF * i + POSE * j
            fr, fc = (a, b)[i], (a, b)[j]
            slot = frame_block(slot, fr, fc, cT, T + at, cTd, Td + at, numbers, layout, matrix)
    return slot


@rare
def constraint_tangents(cK, cP, cN, cC, cU, vectors, gradients, numbers, layout, matrix):
    """matrix += cK (Phi_q^T lam)_q + cU (Phi_q^T mu)_q; cC Phi_q^T to the right; cP Phi_q + cN (Phi_q v)_q below;
    diagonal cC if left out."""
    n, row, mu_row = layout[N_Q], layout[LAM_ROW], layout[MU_ROW]
    for r in range(layout[N_PHI]):
        o = layout[PAIRS] + PAIR * r
        slot = layout[SLOTS] + layout[o + SLOT]
        if layout[o + LEFT_OUT]:
            matrix[layout[slot]] += cC
            continue
        slot += 1
        if layout[o + SECOND_DERIVATIVE] >= 0 and cK == 0.0 and cU == 0.0:
            a, b = layout[layout[FRAMES] + 2 * layout[o + FRAME_A]], layout[layout[FRAMES] + 2 * layout[o + FRAME_B]]
            slot += (a + b) * (a + b)  # as pair_blocks
        elif layout[o + SECOND_DERIVATIVE] >= 0:
            slot = pair_blocks(
                slot,
                layout[o + FRAME_A],
                layout[o + FRAME_B],
                cK * vectors[row, n + r] + (cU * vectors[mu_row, n + r] if cU != 0.0 else 0.0),
                layout[o + SECOND_DERIVATIVE],
                0.0,
                layout[o + SECOND_DERIVATIVE],
                numbers,
                layout,
                matrix,
            )
        for side in range(2):
            f = layout[o + FRAME_A + side]
            nb, kb = layout[layout[FRAMES] + 2 * f], layout[layout[FRAMES] + 2 * f + 1]
            for j in range(nb):
                value = 0.0
                for l in range(POSE):
                    value += gradients[r, POSE * side + l] * numbers[kb + l * nb + j]
                matrix[layout[slot + j]] += cC * value
                matrix[layout[slot + nb + j]] += cP * value
            if cN != 0.0:  # no iteration matrix requires it
                for j in range(nb):
                    rate = 0.0
                    for l in range(POSE):
                        k = kb + l * nb + j
                        rate += (
                            gradients[r, GRADIENT_RATE + POSE * side + l] * numbers[k]
                            + gradients[r, POSE * side + l] * numbers[k + POSE * nb]
                        )
                    matrix[layout[slot + nb + j]] += cN * rate
            slot += 2 * nb


@rare
def columns(factor, past, gradients, numbers, layout, matrix):
    """matrix += factor B^T G^T, to the right, with the G of constraints, or if ``past`` is 1 that of the start of the
    step."""
    G = PAST_GRADIENT * past
    for r in range(layout[N_PHI] if factor != 0.0 else 0):
        o = layout[PAIRS] + PAIR * r
        if layout[o + LEFT_OUT]:
            continue
        a, b = layout[layout[FRAMES] + 2 * layout[o + FRAME_A]], layout[layout[FRAMES] + 2 * layout[o + FRAME_B]]
        slot = layout[SLOTS] + layout[o + SLOT] + 1
        if layout[o + SECOND_DERIVATIVE] >= 0:
            slot += (a + b) * (a + b)  # as in constraint_tangents
        for side in range(2):
            f = layout[o + FRAME_A + side]
            nb, kb = layout[layout[FRAMES] + 2 * f], layout[layout[FRAMES] + 2 * f + 1]
            for j in range(nb):
                value = 0.0
                for l in range(POSE):
                    value += gradients[r, G + POSE * side + l] * numbers[kb + l * nb + j]
                matrix[layout[slot + j]] += factor * value
            slot += 2 * nb


@rare
def spring_tangents(cK, cD, gradients, numbers, layout, matrix):
    """matrix += the derivatives of -f: s H + G (k G + c w^T H) with respect to z, c G G with respect to w."""
    if cK == 0.0 and cD == 0.0:
        return
    scratch = numbers.size - TANGENT_SCRATCH
    for r in range(layout[N_PHI], layout[N_PHI] + layout[N_SPRINGS]):
        o = layout[PAIRS] + PAIR * r
        a, b, h, p = layout[o + FRAME_A], layout[o + FRAME_B], layout[o + SECOND_DERIVATIVE], layout[o + DETAIL]
        if numbers[p] == 0.0 and numbers[p + 1] == 0.0:
            continue
        for i in range(PAIR_POSE):
            for j in range(PAIR_POSE):
                damping = numbers[p + 1] * gradients[r, i] * gradients[r, j]
                stiffness = gradients[r, i] * (
                    numbers[p] * gradients[r, j] + numbers[p + 1] * gradients[r, GRADIENT_RATE + j]
                )
                if h >= 0:
                    stiffness += gradients[r, MAGNITUDE] * numbers[h + PAIR_POSE * i + j]
                numbers[scratch + PAIR_POSE * i + j] = cK * stiffness + cD * damping
                numbers[scratch + SQUARE + PAIR_POSE * i + j] = damping
        pair_blocks(layout[SLOTS] + layout[o + SLOT], a, b, 1.0, scratch, cK, scratch + SQUARE, numbers, layout, matrix)


@rare
def law_tangents(cK, cD, cL, gradients, numbers, layout, matrix):
    """matrix += the derivatives of -f: s H - sign G ds/dz for every frame, - sign G ds/dlam for every multiplier of s.

    (The s of s H already has the sign.)
    """
    if cK == 0.0 and cD == 0.0 and cL == 0.0:
        return
    scratch = numbers.size - TANGENT_SCRATCH
    first = layout[N_PHI] + layout[N_SPRINGS]
    for r in range(first, first + layout[N_LAWS]):
        o = layout[PAIRS] + PAIR * r
        a, b, h, leaf = layout[o + FRAME_A], layout[o + FRAME_B], layout[o + SECOND_DERIVATIVE], layout[o + DETAIL]
        slot = layout[SLOTS] + layout[o + SLOT]
        if h >= 0:
            slot = pair_blocks(slot, a, b, cK * gradients[r, MAGNITUDE], h, 0.0, h, numbers, layout, matrix)
        sign = layout[leaf + 1]
        for k in range(layout[leaf + 2]):
            at = leaf + LEAVES + LEAF * k
            for i in range(PAIR_POSE):
                for j in range(POSE):
                    dz = -sign * gradients[r, i] * numbers[layout[REGISTERS] + layout[at + 1 + j]]
                    dw = -sign * gradients[r, i] * numbers[layout[REGISTERS] + layout[at + 1 + POSE + j]]
                    numbers[scratch + PAIR_POSE * i + j] = cK * dz + cD * dw
                    numbers[scratch + SQUARE + PAIR_POSE * i + j] = dw
            slot = frame_block(slot, a, layout[at], 1.0, scratch, cK, scratch + SQUARE, numbers, layout, matrix)
            slot = frame_block(
                slot, b, layout[at], 1.0, scratch + HALF, cK, scratch + SQUARE + HALF, numbers, layout, matrix
            )
        at = leaf + LEAVES + LEAF * layout[leaf + 2]
        for k in range(layout[at]):
            change = -cL * sign * numbers[layout[REGISTERS] + layout[at + 1 + k]]
            for side in range(2):
                f = (a, b)[side]
                nb, kb = layout[layout[FRAMES] + 2 * f], layout[layout[FRAMES] + 2 * f + 1]
                for j in range(nb):
                    value = 0.0
                    for l in range(POSE):
                        value += gradients[r, POSE * side + l] * numbers[kb + l * nb + j]
                    matrix[layout[slot + j]] += change * value
                slot += nb


@rare
def gamma_tangents(cK, cD, cV, cW, cC, vectors, numbers, layout, matrix):
    """matrix += cK (Gam_v^T nu)_q + cD (Gam_v^T nu)_v; cC Gam_v^T to the right; cV Gam_v + cW Gam_q below.

    A constraint that is left out, or inactive (cV = 0 = cW), has cC on the diagonal.
    """
    scratch = numbers.size - TANGENT_SCRATCH
    first = layout[N_Q] + layout[N_PHI]
    for k in range(layout[N_GAM]):
        o = layout[layout[GAMMAS] + k]
        slot, count, nu = layout[SLOTS] + layout[o + 2], layout[o + 4], vectors[layout[LAM_ROW], first + k]
        if layout[o + 3] or (cV == 0.0 and cW == 0.0):
            matrix[layout[slot]] += cC
        if layout[o + 3]:
            continue
        slot += 1
        for l in range(count):
            at = o + GAMMA + LEAF * l
            f = layout[at]
            nb, kb = layout[layout[FRAMES] + 2 * f], layout[layout[FRAMES] + 2 * f + 1]
            for j in range(nb):
                value, rate = 0.0, 0.0
                for i in range(POSE):
                    w, z, b = (
                        numbers[layout[REGISTERS] + layout[at + 1 + i]],
                        numbers[layout[REGISTERS] + layout[at + 1 + POSE + i]],
                        kb + i * nb + j,
                    )
                    value += w * numbers[b]
                    rate += z * numbers[b] + w * numbers[b + POSE * nb]
                # entries that are not asked for may be infinite at rest
                if cC != 0.0:
                    matrix[layout[slot + j]] += cC * value
                if cV != 0.0:
                    matrix[layout[slot + nb + j]] += cV * value
                if cW != 0.0:
                    matrix[layout[slot + nb + j]] += cW * rate
            slot += 2 * nb
        if cK == 0.0 and cD == 0.0:
            continue
        second = o + GAMMA + LEAF * count
        for r in range(count):
            for c in range(count):
                at = second + 2 * BLOCK_SIZE * (r * count + c)
                for i in range(POSE):
                    for j in range(POSE):
                        dz = nu * numbers[layout[REGISTERS] + layout[at + POSE * i + j]]
                        dw = nu * numbers[layout[REGISTERS] + layout[at + BLOCK_SIZE + POSE * i + j]]
                        numbers[scratch + PAIR_POSE * i + j] = cK * dz + cD * dw
                        numbers[scratch + SQUARE + PAIR_POSE * i + j] = dw
                fr, fc = layout[o + GAMMA + LEAF * r], layout[o + GAMMA + LEAF * c]
                slot = frame_block(slot, fr, fc, 1.0, scratch, cK, scratch + SQUARE, numbers, layout, matrix)
