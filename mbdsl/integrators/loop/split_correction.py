"""How Newton's corrections are solved for: in one system, or in two that follow each other."""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import (
    CORRECTION,
    CORRECTION2,
    DIAGONAL,
    MASS,
    MASS_SLOTS,
    N_ALL,
    N_GAM,
    N_LAWS,
    N_Q,
    RESIDUAL,
    SCALE,
    SLOTS,
    TEMPORARY2,
    UNKNOWN,
)
from mbdsl.compilation.marks import kernel, rare
from mbdsl.integrators.loop.linear_solve import clear, compress, has_entries, larger, multiply, solve, solve_both

#: how large the effect of the second system's solution on the first's may be, relative to that, to be taken into
#: account an iteration late: in the first two iterations of a step, and afterwards
EARLY, LATE = 0.3, 0.02


@kernel
def correct_one(run):
    """Solve for the corrections of UNKNOWN with matrix 0, and apply them; the largest scaled one of an acceleration."""
    vectors, layout = run.vectors, run.layout
    residual, correction, unknown, scale = vectors[RESIDUAL], vectors[CORRECTION], vectors[UNKNOWN], vectors[SCALE]
    for i in range(layout[N_ALL]):
        correction[i] = -residual[i]
    solve(0, CORRECTION, run)
    for i in range(layout[N_ALL]):
        unknown[i] += correction[i]
    change = 0.0
    for i in range(layout[N_Q]):
        change = larger(abs(correction[i]) * scale[i], change)
    return change


@kernel
def solve_two(k, run):
    """Solve the second system and the first, in iteration k = 0, 1, ... of a step: with the matrices A0, A1 and A2,

        CORRECTION2 <- A1^{-1} CORRECTION2,   CORRECTION <- A0^{-1} (CORRECTION + A2 CORRECTION2)

    Both are solved side by side, which takes little longer than one. What A2 adds comes afterwards, and only where it
    matters: CORRECTION2 is the smaller, for smooth motion by a power of h, and then an iteration later is soon enough.
    """
    solve_both(run)
    if has_entries(2, run):
        add_coupling(k, run)


@rare
def add_coupling(k, run):
    vectors, layout = run.vectors, run.layout
    for i in range(layout[N_ALL]):
        vectors[TEMPORARY2, i] = 0.0
    multiply(2, CORRECTION2, TEMPORARY2, run)
    change, added = 0.0, 0.0
    for i in range(layout[N_Q]):
        change = max(change, abs(vectors[CORRECTION, i]) * vectors[SCALE, i])
        added = max(added, abs(vectors[TEMPORARY2, i]) * vectors[DIAGONAL, i])
    if added > (EARLY if k < 2 else LATE) * change:
        solve(0, TEMPORARY2, run)
        for i in range(layout[N_ALL]):
            vectors[CORRECTION, i] += vectors[TEMPORARY2, i]


@rare
def stiff(limit, mass, k, run):
    """Whether forces make up more than this share of the diagonal of matrix k (not factorised yet), the other part
    being ``mass`` times M."""
    numbers, layout, matrices = run.numbers, run.layout, run.matrices
    for i in range(layout[N_Q]):
        a = matrices[k, layout[layout[SLOTS] + layout[MASS_SLOTS] + i]]
        if abs(a - mass * numbers[layout[MASS] + i]) > limit * abs(a):
            return True
    return False


@kernel
def couples(mass, run):
    """Whether A2 may matter: forces are stiff beside ``mass`` times M in A0, or depend on coordinates in ways that no
    diagonal shows."""
    layout = run.layout
    return layout[N_LAWS] + layout[N_GAM] > 0 or stiff(LATE, mass, 0, run)


@rare
def couple(run):
    """Prepare A2 for ``multiply``; compared with A0, which is not factorised yet, it may be as good as zero."""
    vectors, layout, matrices, pivots = run.vectors, run.layout, run.matrices, run.pivots
    ratio = 0.0
    clear(2, run)
    for i in range(layout[N_Q]):
        slot = layout[layout[SLOTS] + layout[MASS_SLOTS] + i]
        d = abs(matrices[0, slot])
        vectors[DIAGONAL, i] = vectors[SCALE, i] / d if d > 0.0 else 0.0
        ratio = max(ratio, abs(matrices[2, slot]) / max(d, 1e-300))
    if ratio <= LATE and layout[N_LAWS] + layout[N_GAM] == 0:
        return
    compress(2, run)
    ratio = 0.0
    for k in range(pivots[2, pivots.shape[1] - 1]):
        r, c = pivots[2, 2 * k], pivots[2, 2 * k + 1]
        if r < layout[N_Q]:
            ratio = max(ratio, abs(matrices[2, k]) * vectors[DIAGONAL, r] / vectors[SCALE, c])
    if ratio <= LATE:
        clear(2, run)
