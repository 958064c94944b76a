"""The loops over holonomic constraints that are expressions over frames: g(z) - u(t) = 0, z of all frames in g.

Their rows are among those of the other joints, whose loops find no gradients there; what drivers prescribe, u(t), is
subtracted with theirs. Records: see :mod:`mbdsl.system.relations`.
"""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import (
    BLOCK_SIZE,
    FORCE,
    FORCE2,
    FRAMES,
    KEEP,
    LAM_ROW,
    LEFT_OUT,
    MU_ROW,
    MU_WRENCH,
    N_Q,
    N_RELATIONS,
    PAIR,
    PAIR_POSE,
    PAIRS,
    PAST_WRENCH,
    POSE,
    PSI_ROW,
    RATE,
    REGISTERS,
    RELATION,
    RELATIONS,
    SLOTS,
    TANGENT_SCRATCH,
    WRENCH,
)
from mbdsl.compilation.marks import kernel, rare
from mbdsl.system.frame_block import frame_block


@kernel
def is_left_out(o, layout):
    """1 if the constraint of the record at ``o`` is redundant and left out."""
    return layout[layout[PAIRS] + PAIR * layout[o] + LEFT_OUT]


@rare
def values(with_mu, vectors, frames, numbers, layout):
    """vectors[FORCE] += g and vectors[FORCE2] += dg/dt; WRENCH in frames -= G^T lam, and, if ``with_mu`` is 1,
    MU_WRENCH += G^T mu."""
    n = layout[N_Q]
    for k in range(layout[N_RELATIONS]):
        o = layout[layout[RELATIONS] + k]
        if is_left_out(o, layout):
            continue
        row = n + layout[o]
        lam, rate, mu = vectors[layout[LAM_ROW], row], 0.0, 0.0
        if with_mu == 1:
            mu = vectors[layout[MU_ROW], row]
        for l in range(layout[o + 4]):
            at = o + RELATION + (1 + POSE) * l
            f = layout[at]
            for j in range(POSE):
                g = numbers[layout[REGISTERS] + layout[at + 1 + j]]
                rate += g * frames[f, RATE + j]
                frames[f, WRENCH + j] -= g * lam
                if with_mu == 1:
                    frames[f, MU_WRENCH + j] += g * mu
        vectors[FORCE, row] += numbers[layout[REGISTERS] + layout[o + 1]]
        vectors[FORCE2, row] += rate


@rare
def keep(numbers, layout):
    """At the start of a step, store G of the last evaluation."""
    if layout[KEEP]:
        for k in range(layout[N_RELATIONS]):
            o = layout[layout[RELATIONS] + k]
            for l in range(layout[o + 4]):
                for j in range(POSE):
                    register = layout[o + RELATION + (1 + POSE) * l + 1 + j]
                    numbers[layout[o + 3] + POSE * l + j] = numbers[layout[REGISTERS] + register]


@rare
def remember(vectors, frames, numbers, layout):
    """PAST_WRENCH in frames += G^T psi with the G of the start of the step."""
    for k in range(layout[N_RELATIONS]):
        o = layout[layout[RELATIONS] + k]
        if is_left_out(o, layout):
            continue
        psi = vectors[layout[PSI_ROW], layout[N_Q] + layout[o]]
        for l in range(layout[o + 4]):
            f = layout[o + RELATION + (1 + POSE) * l]
            for j in range(POSE):
                frames[f, PAST_WRENCH + j] += numbers[layout[o + 3] + POSE * l + j] * psi


@rare
def gradient(past, o, l, numbers, layout):
    """Write G of leaf ``l`` of the record at ``o`` to the scratch; that of the start of the step if ``past`` is 1."""
    scratch = numbers.size - TANGENT_SCRATCH
    for j in range(POSE):
        at = layout[o + 3] + POSE * l + j
        if past == 0:
            at = layout[REGISTERS] + layout[o + RELATION + (1 + POSE) * l + 1 + j]
        numbers[scratch + j] = numbers[at]


@rare
def tangents(cK, cP, cN, cC, cU, vectors, frames, numbers, layout, matrix):
    """matrix += as :func:`mbdsl.system.loops.constraint_tangents`."""
    n, scratch = layout[N_Q], numbers.size - TANGENT_SCRATCH
    for k in range(layout[N_RELATIONS]):
        o = layout[layout[RELATIONS] + k]
        if is_left_out(o, layout):
            continue
        slot, count = layout[SLOTS] + layout[o + 2], layout[o + 4]
        second = o + RELATION + (1 + POSE) * count
        for l in range(count):
            f = layout[o + RELATION + (1 + POSE) * l]
            gradient(0, o, l, numbers, layout)
            for i in range(POSE):
                numbers[scratch + POSE + i] = 0.0
            if cN != 0.0:  # w^T H
                for r in range(count):
                    at, fr = second + BLOCK_SIZE * (r * count + l), layout[o + RELATION + (1 + POSE) * r]
                    for j in range(POSE):
                        for i in range(POSE):
                            h = numbers[layout[REGISTERS] + layout[at + POSE * j + i]]
                            numbers[scratch + POSE + i] += frames[fr, RATE + j] * h
            nb, kb = layout[layout[FRAMES] + 2 * f], layout[layout[FRAMES] + 2 * f + 1]
            for j in range(nb):
                value, rate = 0.0, 0.0
                for i in range(POSE):
                    b = kb + i * nb + j
                    value += numbers[scratch + i] * numbers[b]
                    rate += numbers[scratch + POSE + i] * numbers[b] + numbers[scratch + i] * numbers[b + POSE * nb]
                matrix[layout[slot + j]] += cC * value
                matrix[layout[slot + nb + j]] += cP * value
                if cN != 0.0:
                    matrix[layout[slot + nb + j]] += cN * rate
            slot += 2 * nb
        if cK == 0.0 and cU == 0.0:
            continue
        factor = cK * vectors[layout[LAM_ROW], n + layout[o]]
        if cU != 0.0:
            factor += cU * vectors[layout[MU_ROW], n + layout[o]]
        for r in range(count):
            for c in range(count):
                at = second + BLOCK_SIZE * (r * count + c)
                for i in range(POSE):
                    for j in range(POSE):
                        h = numbers[layout[REGISTERS] + layout[at + POSE * i + j]]
                        numbers[scratch + PAIR_POSE * i + j] = h
                fr, fc = layout[o + RELATION + (1 + POSE) * r], layout[o + RELATION + (1 + POSE) * c]
                slot = frame_block(slot, fr, fc, factor, scratch, 0.0, scratch, numbers, layout, matrix)


@rare
def columns(factor, past, numbers, layout, matrix):
    """matrix += as :func:`mbdsl.system.loops.columns`."""
    scratch = numbers.size - TANGENT_SCRATCH
    for k in range(layout[N_RELATIONS] if factor != 0.0 else 0):
        o = layout[layout[RELATIONS] + k]
        if is_left_out(o, layout):
            continue
        slot = layout[SLOTS] + layout[o + 2]
        for l in range(layout[o + 4]):
            f = layout[o + RELATION + (1 + POSE) * l]
            gradient(past, o, l, numbers, layout)
            nb, kb = layout[layout[FRAMES] + 2 * f], layout[layout[FRAMES] + 2 * f + 1]
            for j in range(nb):
                value = 0.0
                for i in range(POSE):
                    value += numbers[scratch + i] * numbers[kb + i * nb + j]
                matrix[layout[slot + j]] += factor * value
            slot += 2 * nb
