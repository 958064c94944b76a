"""Loops of the emitted `tangent`: the entries of the iteration matrix from the tables of joints, springs and laws."""

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import rare
from mbdsl.system.frame_block import Terms, frame_block


@rare
def coupling_matrix(cM, numbers, layout, matrix):
    """matrix += cM times the constant off-diagonal entries of M."""
    for k in range(layout[L.N_COUPLINGS]):
        slot, value = (
            layout[L.SLOTS] + layout[layout[L.COUPLINGS] + 3 * k + 2],
            cM * numbers[layout[L.COUPLING_VALUES] + k],
        )
        matrix[layout[slot]] += value
        matrix[layout[slot + 1]] += value


@rare
def begin_matrix(cM, cE, numbers, layout, matrix):
    """matrix = cM times the constant part of the diagonal of M, plus cE times the unit matrix."""
    for i in range(layout[L.SIZE]):
        matrix[i] = 0.0
    for i in range(layout[L.N_Q]):
        matrix[layout[layout[L.SLOTS] + layout[L.MASS_SLOTS] + i]] += cM * numbers[layout[L.MASS] + i] + cE


@rare
def pair_blocks(C, slot, pair, x, numbers, layout, matrix):
    """matrix += the blocks of two frames, whose ``Terms`` x have 6 x 6 matrices T and Td; returns the next slot."""
    for i in range(2):
        for j in range(2):
            at = C.HALF * i + C.POSE * j
            own = Terms(x.cT, x.T + at, x.cTd, x.Td + at)
            slot = frame_block(C, slot, pair[i], pair[j], own, numbers, layout, matrix)
    return slot


@rare
def constraint_tangents(C, factors, vectors, gradients, numbers, layout, matrix):
    """matrix += cK (Phi_q^T lam)_q + cU (Phi_q^T mu)_q; cC Phi_q^T to the right; cP Phi_q + cN (Phi_q v)_q below;
    diagonal cC if left out."""
    cK, cP, cN, cC, cU = factors.cK, factors.cP, factors.cN, factors.cC, factors.cU
    n, row, mu_row = layout[L.N_Q], layout[L.LAM_ROW], layout[L.MU_ROW]
    for r in range(layout[L.N_PHI]):
        o = layout[L.PAIRS] + L.PAIR * r
        slot = layout[L.SLOTS] + layout[o + L.SLOT]
        if layout[o + L.LEFT_OUT]:
            matrix[layout[slot]] += cC
            continue
        slot += 1
        if layout[o + L.SECOND_DERIVATIVE] >= 0 and cK == 0.0 and cU == 0.0:
            a, b = (
                layout[layout[L.FRAMES] + 2 * layout[o + L.FRAME_A]],
                layout[layout[L.FRAMES] + 2 * layout[o + L.FRAME_B]],
            )
            slot += (a + b) * (a + b)  # as pair_blocks
        elif layout[o + L.SECOND_DERIVATIVE] >= 0:
            pair, h = (layout[o + L.FRAME_A], layout[o + L.FRAME_B]), layout[o + L.SECOND_DERIVATIVE]
            factor = cK * vectors[row, n + r] + (cU * vectors[mu_row, n + r] if cU != 0.0 else 0.0)
            slot = pair_blocks(C, slot, pair, Terms(factor, h, 0.0, h), numbers, layout, matrix)
        for side in range(2):
            f = layout[o + L.FRAME_A + side]
            nb, kb = layout[layout[L.FRAMES] + 2 * f], layout[layout[L.FRAMES] + 2 * f + 1]
            for j in range(nb):
                value = 0.0
                for l in range(C.POSE):
                    value += gradients[r, C.POSE * side + l] * numbers[kb + l * nb + j]
                matrix[layout[slot + j]] += cC * value
                matrix[layout[slot + nb + j]] += cP * value
            if cN != 0.0:  # no iteration matrix requires it
                for j in range(nb):
                    rate = 0.0
                    for l in range(C.POSE):
                        k = kb + l * nb + j
                        rate += (
                            gradients[r, C.GRADIENT_RATE + C.POSE * side + l] * numbers[k]
                            + gradients[r, C.POSE * side + l] * numbers[k + C.POSE * nb]
                        )
                    matrix[layout[slot + nb + j]] += cN * rate
            slot += 2 * nb


@rare
def columns(C, factor, past, gradients, numbers, layout, matrix):
    """matrix += factor B^T G^T, to the right, with the G of constraints, or if ``past`` is 1 that of the start of the
    step."""
    G = C.PAST_GRADIENT * past
    for r in range(layout[L.N_PHI] if factor != 0.0 else 0):
        o = layout[L.PAIRS] + L.PAIR * r
        if layout[o + L.LEFT_OUT]:
            continue
        a, b = (
            layout[layout[L.FRAMES] + 2 * layout[o + L.FRAME_A]],
            layout[layout[L.FRAMES] + 2 * layout[o + L.FRAME_B]],
        )
        slot = layout[L.SLOTS] + layout[o + L.SLOT] + 1
        if layout[o + L.SECOND_DERIVATIVE] >= 0:
            slot += (a + b) * (a + b)  # as in constraint_tangents
        for side in range(2):
            f = layout[o + L.FRAME_A + side]
            nb, kb = layout[layout[L.FRAMES] + 2 * f], layout[layout[L.FRAMES] + 2 * f + 1]
            for j in range(nb):
                value = 0.0
                for l in range(C.POSE):
                    value += gradients[r, G + C.POSE * side + l] * numbers[kb + l * nb + j]
                matrix[layout[slot + j]] += factor * value
            slot += 2 * nb


@rare
def spring_tangents(C, cK, cD, gradients, numbers, layout, matrix):
    """matrix += the derivatives of -f: s H + G (k G + c w^T H) with respect to z, c G G with respect to w."""
    if cK == 0.0 and cD == 0.0:
        return
    scratch = numbers.size - C.TANGENT_SCRATCH
    for r in range(layout[L.N_PHI], layout[L.N_PHI] + layout[L.N_SPRINGS]):
        o = layout[L.PAIRS] + L.PAIR * r
        a, b, h, p = layout[o + L.FRAME_A], layout[o + L.FRAME_B], layout[o + L.SECOND_DERIVATIVE], layout[o + L.DETAIL]
        if numbers[p] == 0.0 and numbers[p + 1] == 0.0:
            continue
        for i in range(C.PAIR_POSE):
            for j in range(C.PAIR_POSE):
                damping = numbers[p + 1] * gradients[r, i] * gradients[r, j]
                stiffness = gradients[r, i] * (
                    numbers[p] * gradients[r, j] + numbers[p + 1] * gradients[r, C.GRADIENT_RATE + j]
                )
                if h >= 0:
                    stiffness += gradients[r, C.MAGNITUDE] * numbers[h + C.PAIR_POSE * i + j]
                numbers[scratch + C.PAIR_POSE * i + j] = cK * stiffness + cD * damping
                numbers[scratch + C.SQUARE + C.PAIR_POSE * i + j] = damping
        terms = Terms(1.0, scratch, cK, scratch + C.SQUARE)
        pair_blocks(C, layout[L.SLOTS] + layout[o + L.SLOT], (a, b), terms, numbers, layout, matrix)


@rare
def law_tangents(C, factors, gradients, numbers, layout, matrix):
    """matrix += the derivatives of -f: s H - sign G ds/dz for every frame, - sign G ds/dlam for every multiplier of s.

    (The s of s H already has the sign.)
    """
    cK, cD, cL = factors.cK, factors.cD, factors.cL
    if cK == 0.0 and cD == 0.0 and cL == 0.0:
        return
    scratch = numbers.size - C.TANGENT_SCRATCH
    first = layout[L.N_PHI] + layout[L.N_SPRINGS]
    for r in range(first, first + layout[L.N_LAWS]):
        o = layout[L.PAIRS] + L.PAIR * r
        a, b, h, leaf = (
            layout[o + L.FRAME_A],
            layout[o + L.FRAME_B],
            layout[o + L.SECOND_DERIVATIVE],
            layout[o + L.DETAIL],
        )
        slot = layout[L.SLOTS] + layout[o + L.SLOT]
        if h >= 0:
            terms = Terms(cK * gradients[r, C.MAGNITUDE], h, 0.0, h)
            slot = pair_blocks(C, slot, (a, b), terms, numbers, layout, matrix)
        sign = layout[leaf + 1]
        for k in range(layout[leaf + 2]):
            at = leaf + L.LEAVES + C.LEAF * k
            for i in range(C.PAIR_POSE):
                for j in range(C.POSE):
                    dz = -sign * gradients[r, i] * numbers[layout[L.REGISTERS] + layout[at + 1 + j]]
                    dw = -sign * gradients[r, i] * numbers[layout[L.REGISTERS] + layout[at + 1 + C.POSE + j]]
                    numbers[scratch + C.PAIR_POSE * i + j] = cK * dz + cD * dw
                    numbers[scratch + C.SQUARE + C.PAIR_POSE * i + j] = dw
            of_a = Terms(1.0, scratch, cK, scratch + C.SQUARE)
            of_b = Terms(1.0, scratch + C.HALF, cK, scratch + C.SQUARE + C.HALF)
            slot = frame_block(C, slot, a, layout[at], of_a, numbers, layout, matrix)
            slot = frame_block(C, slot, b, layout[at], of_b, numbers, layout, matrix)
        at = leaf + L.LEAVES + C.LEAF * layout[leaf + 2]
        for k in range(layout[at]):
            change = -cL * sign * numbers[layout[L.REGISTERS] + layout[at + 1 + k]]
            for side in range(2):
                f = (a, b)[side]
                nb, kb = layout[layout[L.FRAMES] + 2 * f], layout[layout[L.FRAMES] + 2 * f + 1]
                for j in range(nb):
                    value = 0.0
                    for l in range(C.POSE):
                        value += gradients[r, C.POSE * side + l] * numbers[kb + l * nb + j]
                    matrix[layout[slot + j]] += change * value
                slot += nb


@rare
def gamma_tangents(C, factors, vectors, numbers, layout, matrix):
    """matrix += cK (Gam_v^T nu)_q + cD (Gam_v^T nu)_v; cC Gam_v^T to the right; cV Gam_v + cW Gam_q below.

    A constraint that is left out, or inactive (cV = 0 = cW), has cC on the diagonal.
    """
    cK, cD, cV, cW, cC = factors.cK, factors.cD, factors.cV, factors.cW, factors.cC
    scratch = numbers.size - C.TANGENT_SCRATCH
    first = layout[L.N_Q] + layout[L.N_PHI]
    for k in range(layout[L.N_GAM]):
        o = layout[layout[L.GAMMAS] + k]
        slot, count, nu = layout[L.SLOTS] + layout[o + 2], layout[o + 4], vectors[layout[L.LAM_ROW], first + k]
        if layout[o + 3] or (cV == 0.0 and cW == 0.0):
            matrix[layout[slot]] += cC
        if layout[o + 3]:
            continue
        slot += 1
        for l in range(count):
            at = o + L.GAMMA + C.LEAF * l
            f = layout[at]
            nb, kb = layout[layout[L.FRAMES] + 2 * f], layout[layout[L.FRAMES] + 2 * f + 1]
            for j in range(nb):
                value, rate = 0.0, 0.0
                for i in range(C.POSE):
                    w, z, b = (
                        numbers[layout[L.REGISTERS] + layout[at + 1 + i]],
                        numbers[layout[L.REGISTERS] + layout[at + 1 + C.POSE + i]],
                        kb + i * nb + j,
                    )
                    value += w * numbers[b]
                    rate += z * numbers[b] + w * numbers[b + C.POSE * nb]
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
        second = o + L.GAMMA + C.LEAF * count
        for r in range(count):
            for c in range(count):
                at = second + 2 * C.BLOCK_SIZE * (r * count + c)
                for i in range(C.POSE):
                    for j in range(C.POSE):
                        dz = nu * numbers[layout[L.REGISTERS] + layout[at + C.POSE * i + j]]
                        dw = nu * numbers[layout[L.REGISTERS] + layout[at + C.BLOCK_SIZE + C.POSE * i + j]]
                        numbers[scratch + C.PAIR_POSE * i + j] = cK * dz + cD * dw
                        numbers[scratch + C.SQUARE + C.PAIR_POSE * i + j] = dw
                fr, fc = layout[o + L.GAMMA + C.LEAF * r], layout[o + L.GAMMA + C.LEAF * c]
                terms = Terms(1.0, scratch, cK, scratch + C.SQUARE)
                slot = frame_block(C, slot, fr, fc, terms, numbers, layout, matrix)
