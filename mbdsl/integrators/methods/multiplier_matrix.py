"""Multipliers of rigid bodies on pins: elimination of the accelerations before the factorisation.

With J = Phi_q, the masses M constant and diagonal, and C = J M^{-1/2}, the solution of

    [[M, J^T], [J, 0]] [a; lam] = [f; g]

is   C C^T lam = C M^{-1/2} f - g,   a = M^{-1/2} (M^{-1/2} f - C^T lam).

The matrix C C^T of the multipliers has the pattern of the joints that share a body: it takes half of the time of the
whole matrix, whose assembly takes longer than its factorisation. This holds for models of rigid bodies and point masses
whose constraints are linear in the poses of frames and do not depend on time: then the tangent of the scene is not
needed, and gamma consists of the centripetal accelerations of the frames.

Tables, at the offset in the last entry of ``layout``: a header, in which N_ALL and SPARSE have the meaning that
:mod:`mbdsl.integrators.loop.symmetric_lu` expects; for each constraint the first coordinate and the number of
coordinates of both frames' bodies (ROW); the products of which C C^T consists, as (place in the matrix, places of both
factors in C) (PRODUCT). C is stored in matrix 1, six entries a constraint.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbdsl.integrators.loop.linear_solve import SPARSE_LU
from mbdsl.integrators.loop.sparse_lu import analyse
from mbdsl.integrators.loop.symmetric_lu import symmetric_factor, symmetric_solve
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import PLANE
from mbdsl.kernels.marks import kernel, rare
from mbdsl.system import System

ROWS_AT, PRODUCTS_AT, N_PRODUCTS, HEADER = L.SPARSE + 1, L.SPARSE + 2, L.SPARSE + 3, L.SPARSE + 4
ROW, PRODUCT = 4, 3
#: most constraints of a body: their part of C C^T is full
MOST = 24
#: motions of bodies with C as above
MOTIONS = {"mbdsl.bodies.rigid_body_kernels", "mbdsl.bodies.point_mass_kernels"}


def _applies(system: System) -> bool:
    layout, tables = system.tables.layout, system.tables
    if not system.m or system.p or system.of_multipliers or layout[L.N_MOVING] or layout[L.MASS_KIND] != 0:
        return False
    if layout[L.N_RELATIONS]:
        return False
    if any(b.role == "body" and b.module.__name__ not in MOTIONS for b in tables.blocks):
        return False
    pairs = layout[layout[L.PAIRS] : layout[L.PAIRS] + L.PAIR * system.m].reshape(-1, L.PAIR)
    return bool((pairs[:, [L.SECOND_DERIVATIVE, L.DETAIL]] < 0).all() and (system.mass() > 0.0).all())


def tables(system: System, offset: int) -> NDArray[np.int64]:
    """The tables, which begin at ``offset`` in layout; only a zero if the model does not fulfil the conditions."""
    if not _applies(system):
        return np.zeros(1, np.int64)
    n, m, layout = system.n, system.m, system.tables.layout
    bodies = [system.scene.frames[name].body for name in system.tables.frames]
    coordinates = system.tables.coordinates
    place = [(coordinates[b], system.tables.models[b].n) if b in coordinates else (0, 0) for b in bodies]
    pairs = layout[layout[L.PAIRS] : layout[L.PAIRS] + L.PAIR * m].reshape(-1, L.PAIR)
    rows = np.array([place[f] for pair in pairs for f in pair[[L.FRAME_A, L.FRAME_A + 1]]], np.int64).reshape(-1, ROW)
    at: dict[int, list[tuple[int, int]]] = {}  # first coordinate of a body -> its constraints, and their places in C
    for r, row in enumerate(rows.tolist()):
        for side in range(2):
            if row[2 * side + 1]:
                at.setdefault(row[2 * side], []).append((r, PLANE.PAIR_POSE * r + PLANE.POSE * side))
    if max(map(len, at.values())) > MOST:
        return np.zeros(1, np.int64)
    found = [(r, s, i, j) for own in at.values() for k, (r, i) in enumerate(own) for s, j in own[: k + 1]]
    products = np.array(found, np.int64).reshape(-1, 4)
    r, s = products[:, 0], products[:, 1]
    order = np.array([k - n for k in system.elimination_order() if k >= n], np.int64)
    if _is_tree(rows):
        order = _from_the_ends(order.tolist(), r.tolist(), s.tolist())
    rank = np.empty(m, np.int64)
    rank[order] = np.arange(m)
    lower, upper = np.where(rank[r] > rank[s], r, s), np.where(rank[r] > rank[s], s, r)
    twice = products[(r == s) & (products[:, 2] != products[:, 3])]  # a constraint between two frames of one body
    pattern = analyse(m, lower, upper, order)
    products = np.column_stack([pattern.slots, products[:, 2:]])
    if len(twice):
        own = np.column_stack([twice[:, 0], twice[:, 3], twice[:, 2]])  # D has the numbering of the constraints
        products = np.concatenate([products, own])
    header = np.zeros(HEADER, np.int64)
    header[[L.N_ALL, L.SPARSE]] = m, HEADER
    header[ROWS_AT] = HEADER + len(pattern.table)
    header[PRODUCTS_AT] = header[ROWS_AT] + rows.size
    header[N_PRODUCTS] = len(products)
    return np.concatenate([header, pattern.table, rows.ravel(), products.ravel(), [offset]], dtype=np.int64)


def _is_tree(rows: NDArray[np.int64]) -> bool:
    """Whether joints form no loop of bodies; rows of the same two bodies belong to one joint."""
    joints = {(int(a) if na else -1, int(b) if nb else -1) for a, na, b, nb in rows}
    root: dict[int, int] = {}

    def of(body: int) -> int:
        while body in root:
            root[body], body = root.get(root[body], root[body]), root[body]
        return body

    for a, b in joints:
        first, second = of(a), of(b)
        if first == second:
            return False
        root[second] = first
    return True


def _from_the_ends(order: list[int], rows: list[int], columns: list[int]) -> NDArray[np.int64]:
    """An order of elimination (new -> old) of the matrix of a tree with these entries: from all ends at once.

    A constraint whose neighbours are neighbours of each other causes no fill. All of these come first, then those that
    now fulfil this, and so on: successive pivots are independent of each other, and the processor overlaps them.
    """
    near: dict[int, set[int]] = {r: set() for r in order}
    for r, s in zip(rows, columns, strict=True):
        if r != s:
            near[r].add(s)
            near[s].add(r)
    found: list[int] = []
    candidates = set(order)
    while candidates:
        layer = [r for r in sorted(candidates) if all(near[r] - {s} <= near[s] for s in near[r])]
        candidates = set()
        for r in layer:
            others = near.pop(r)
            candidates.discard(r)
            candidates |= others
            for s in others:
                near[s].discard(r)
        found += layer
    return np.array(found, np.int64)


@kernel
def applies(run):
    """Whether the multipliers are solved for in this way."""
    layout = run.layout
    return layout[L.SOLVER] == SPARSE_LU and layout[layout.size - 1] > 0


@rare
def roots(row, run):
    """vectors[row] <- diagonal of M^{-1/2}."""
    for i in range(run.layout[L.N_Q]):
        run.vectors[row, i] = run.numbers[run.layout[L.MASS] + i] ** -0.5


@rare
def assemble(root, run):
    """Matrix 1 <- C, matrix 0 <- C C^T at the state last evaluated; CORRECTION <- [Q; gamma]. ``root``: the row of
    M^{-1/2}."""
    vectors, layout, frames, gradients = run.vectors, run.layout, run.frames, run.gradients
    S, C, w = run.matrices[0], run.matrices[1], run.vectors[root]
    n, m, tables = layout[L.N_Q], layout[L.N_PHI], layout[layout[layout.size - 1] :]
    row, right, pair = tables[tables[ROWS_AT] :], vectors[L.CORRECTION], layout[layout[L.PAIRS] :]
    for i in range(n):
        right[i] = vectors[L.FORCE, i]
    for i in range(m + tables[tables[L.SPARSE] + 2 * m]):
        S[i] = 0.0
    for r in range(m):
        gamma, o = 0.0, L.PAIR * r
        if pair[o + L.LEFT_OUT]:
            for k in range(PLANE.PAIR_POSE * r, PLANE.PAIR_POSE * r + PLANE.PAIR_POSE):
                C[k] = 0.0
            S[r] = 1.0
        else:
            for side in range(2):
                k, d, nb = PLANE.POSE * side, row[ROW * r + 2 * side], row[ROW * r + 2 * side + 1]
                f, x, y, at = pair[o + L.FRAME_A + side], gradients[r, k], gradients[r, k + 1], PLANE.PAIR_POSE * r + k
                C[at], C[at + 1], C[at + 2] = 0.0, 0.0, 0.0
                if nb > 0:
                    C[at], C[at + 1] = w[d] * x, w[d + 1] * y
                if nb > 2:
                    lx, ly, omega = frames[f, PLANE.LEVER], frames[f, PLANE.LEVER + 1], frames[f, PLANE.RATE + 2]
                    C[at + 2] = w[d + 2] * (gradients[r, k + 2] - ly * x + lx * y)
                    gamma += omega * omega * (lx * x + ly * y)
        right[n + r] = gamma
    products = tables[tables[PRODUCTS_AT] :]
    for e in range(tables[N_PRODUCTS]):
        i, j, at = products[PRODUCT * e + 1], products[PRODUCT * e + 2], products[PRODUCT * e]
        S[at] += C[i] * C[j] + C[i + 1] * C[j + 1] + C[i + 2] * C[j + 2]


@kernel
def factorise(run):
    """Factorise C C^T; False if a pivot is lost."""
    layout = run.layout
    return symmetric_factor(run.matrices[0], layout[layout[layout.size - 1] :])


@rare
def solve_multipliers(y, root, run):
    """y <- [a; lam] of y = [f; g], with the factors of C C^T."""
    layout, C, w = run.layout, run.matrices[1], run.vectors[root]
    n, m, tables = layout[L.N_Q], layout[L.N_PHI], layout[layout[layout.size - 1] :]
    row, lam = tables[tables[ROWS_AT] :], y[n:]
    for i in range(n):
        y[i] *= w[i]
    for r in range(m):
        x = -lam[r]
        for side in range(2):
            d, nb, at = row[ROW * r + 2 * side], row[ROW * r + 2 * side + 1], PLANE.PAIR_POSE * r + PLANE.POSE * side
            if nb > 0:
                x += C[at] * y[d] + C[at + 1] * y[d + 1]
            if nb > 2:
                x += C[at + 2] * y[d + 2]
        lam[r] = x
    symmetric_solve(run.matrices[0], tables, lam)
    for r in range(m):
        for side in range(2):
            d, nb, at = row[ROW * r + 2 * side], row[ROW * r + 2 * side + 1], PLANE.PAIR_POSE * r + PLANE.POSE * side
            if nb > 0:
                y[d] -= C[at] * lam[r]
                y[d + 1] -= C[at + 1] * lam[r]
            if nb > 2:
                y[d + 2] -= C[at + 2] * lam[r]
    for i in range(n):
        y[i] *= w[i]
