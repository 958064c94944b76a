"""The loops over holonomic constraints that are expressions over frames: g(z) - u(t) = 0, z of all frames in g.

Their rows are among those of the other joints, whose loops find no gradients there; what drivers prescribe, u(t), is
subtracted with theirs. Records: see :mod:`mbdsl.system.relations`.
"""

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare
from mbdsl.system.frame_block import Terms, frame_block


@kernel
def is_left_out(o, layout):
    """1 if the constraint of the record at ``o`` is redundant and left out."""
    return layout[layout[L.PAIRS] + L.PAIR * layout[o] + L.LEFT_OUT]


@rare
def values(C, with_mu, vectors, frames, numbers, layout):
    """vectors[FORCE] += g and vectors[FORCE2] += dg/dt; WRENCH in frames -= G^T lam, and, if ``with_mu`` is 1,
    MU_WRENCH += G^T mu."""
    n = layout[L.N_Q]
    for k in range(layout[L.N_RELATIONS]):
        o = layout[layout[L.RELATIONS] + k]
        if is_left_out(o, layout):
            continue
        row = n + layout[o]
        lam, rate, mu = vectors[layout[L.LAM_ROW], row], 0.0, 0.0
        if with_mu == 1:
            mu = vectors[layout[L.MU_ROW], row]
        for l in range(layout[o + 4]):
            at = o + L.RELATION + (1 + C.POSE) * l
            f = layout[at]
            for j in range(C.POSE):
                g = numbers[layout[L.REGISTERS] + layout[at + 1 + j]]
                rate += g * frames[f, C.RATE + j]
                frames[f, C.WRENCH + j] -= g * lam
                if with_mu == 1:
                    frames[f, C.MU_WRENCH + j] += g * mu
        vectors[L.FORCE, row] += numbers[layout[L.REGISTERS] + layout[o + 1]]
        vectors[L.FORCE2, row] += rate


@rare
def keep(C, numbers, layout):
    """At the start of a step, store G of the last evaluation."""
    if layout[L.KEEP]:
        for k in range(layout[L.N_RELATIONS]):
            o = layout[layout[L.RELATIONS] + k]
            for l in range(layout[o + 4]):
                for j in range(C.POSE):
                    register = layout[o + L.RELATION + (1 + C.POSE) * l + 1 + j]
                    numbers[layout[o + 3] + C.POSE * l + j] = numbers[layout[L.REGISTERS] + register]


@rare
def remember(C, vectors, frames, numbers, layout):
    """PAST_WRENCH in frames += G^T psi with the G of the start of the step."""
    for k in range(layout[L.N_RELATIONS]):
        o = layout[layout[L.RELATIONS] + k]
        if is_left_out(o, layout):
            continue
        psi = vectors[layout[L.PSI_ROW], layout[L.N_Q] + layout[o]]
        for l in range(layout[o + 4]):
            f = layout[o + L.RELATION + (1 + C.POSE) * l]
            for j in range(C.POSE):
                frames[f, C.PAST_WRENCH + j] += numbers[layout[o + 3] + C.POSE * l + j] * psi


@rare
def gradient(C, past, o, l, numbers, layout):
    """Write G of leaf ``l`` of the record at ``o`` to the scratch; that of the start of the step if ``past`` is 1."""
    scratch = numbers.size - C.TANGENT_SCRATCH
    for j in range(C.POSE):
        at = layout[o + 3] + C.POSE * l + j
        if past == 0:
            at = layout[L.REGISTERS] + layout[o + L.RELATION + (1 + C.POSE) * l + 1 + j]
        numbers[scratch + j] = numbers[at]


@rare
def tangents(C, factors, vectors, frames, numbers, layout, matrix):
    """matrix += as :func:`mbdsl.system.tangent_loops.constraint_tangents`."""
    cK, cP, cN, cC, cU = factors.cK, factors.cP, factors.cN, factors.cC, factors.cU
    n, scratch = layout[L.N_Q], numbers.size - C.TANGENT_SCRATCH
    for k in range(layout[L.N_RELATIONS]):
        o = layout[layout[L.RELATIONS] + k]
        if is_left_out(o, layout):
            continue
        slot, count = layout[L.SLOTS] + layout[o + 2], layout[o + 4]
        second = o + L.RELATION + (1 + C.POSE) * count
        for l in range(count):
            f = layout[o + L.RELATION + (1 + C.POSE) * l]
            gradient(C, 0, o, l, numbers, layout)
            for i in range(C.POSE):
                numbers[scratch + C.POSE + i] = 0.0
            if cN != 0.0:  # w^T H
                for r in range(count):
                    at, fr = second + C.BLOCK_SIZE * (r * count + l), layout[o + L.RELATION + (1 + C.POSE) * r]
                    for j in range(C.POSE):
                        for i in range(C.POSE):
                            h = numbers[layout[L.REGISTERS] + layout[at + C.POSE * j + i]]
                            numbers[scratch + C.POSE + i] += frames[fr, C.RATE + j] * h
            nb, kb = layout[layout[L.FRAMES] + 2 * f], layout[layout[L.FRAMES] + 2 * f + 1]
            for j in range(nb):
                value, rate = 0.0, 0.0
                for i in range(C.POSE):
                    b = kb + i * nb + j
                    value += numbers[scratch + i] * numbers[b]
                    rate += numbers[scratch + C.POSE + i] * numbers[b] + numbers[scratch + i] * numbers[b + C.POSE * nb]
                matrix[layout[slot + j]] += cC * value
                matrix[layout[slot + nb + j]] += cP * value
                if cN != 0.0:
                    matrix[layout[slot + nb + j]] += cN * rate
            slot += 2 * nb
        if cK == 0.0 and cU == 0.0:
            continue
        factor = cK * vectors[layout[L.LAM_ROW], n + layout[o]]
        if cU != 0.0:
            factor += cU * vectors[layout[L.MU_ROW], n + layout[o]]
        for r in range(count):
            for c in range(count):
                at = second + C.BLOCK_SIZE * (r * count + c)
                for i in range(C.POSE):
                    for j in range(C.POSE):
                        h = numbers[layout[L.REGISTERS] + layout[at + C.POSE * i + j]]
                        numbers[scratch + C.PAIR_POSE * i + j] = h
                fr, fc = layout[o + L.RELATION + (1 + C.POSE) * r], layout[o + L.RELATION + (1 + C.POSE) * c]
                slot = frame_block(C, slot, fr, fc, Terms(factor, scratch, 0.0, scratch), numbers, layout, matrix)


@rare
def columns(C, factor, past, numbers, layout, matrix):
    """matrix += as :func:`mbdsl.system.tangent_loops.columns`."""
    scratch = numbers.size - C.TANGENT_SCRATCH
    for k in range(layout[L.N_RELATIONS] if factor != 0.0 else 0):
        o = layout[layout[L.RELATIONS] + k]
        if is_left_out(o, layout):
            continue
        slot = layout[L.SLOTS] + layout[o + 2]
        for l in range(layout[o + 4]):
            f = layout[o + L.RELATION + (1 + C.POSE) * l]
            gradient(C, past, o, l, numbers, layout)
            nb, kb = layout[layout[L.FRAMES] + 2 * f], layout[layout[L.FRAMES] + 2 * f + 1]
            for j in range(nb):
                value = 0.0
                for i in range(C.POSE):
                    value += numbers[scratch + i] * numbers[kb + i * nb + j]
                matrix[layout[slot + j]] += factor * value
            slot += 2 * nb
