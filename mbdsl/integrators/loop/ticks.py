"""Ticks of clocks that set discrete variables: the jump of accelerations and forces is added to the history.

With the jump dQ of the forces,

    [[M, J^T], [J, 0]] [da; dlam] = [dQ; 0],   J = [Phi_q; Gam_v]

A method's history is linear in accelerations, multipliers and applied forces over masses: row r gets
c_a h^e_a da + c_f dQ/m in its coordinates and c_l dlam in its constraints, with the numbers that
:func:`mbdsl.integrators.tick_history.weights` appends to ``coefficients``, h the last step. Order 2 is kept over any
number of ticks. The record of the clocks is described in :mod:`mbdsl.system.clock_tables`.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.linear_solve import factor, solve
from mbdsl.integrators.loop.run_data import evaluate, inertia
from mbdsl.integrators.loop.tangent_matrices import tangent_matrix
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare
from mbdsl.system.clock_tables import ACTION, ACTIONS, CLOCK, CLOCKS, FIRST, PLACE, ROOM
from mbdsl.system.switches import signature

#: numbers of a row of history in ``coefficients``: row, c_a, e_a, c_f, c_l
WEIGHTS = 5
NEVER = 1e300
LARGEST = 2.0**53  #: ticks that set larger values are left to Python, which reports errors


@kernel
def full(run):
    """Whether the log of ticks has no room for another one."""
    o, numbers, layout = run.layout[L.TICKS], run.numbers, run.layout
    return o > 0 and numbers[layout[o + PLACE] + layout[o + CLOCKS]] >= layout[o + ROOM]


@rare
def next_tick(run):
    """The time of the next tick of any clock [s]."""
    o, numbers, layout, found = run.layout[L.TICKS], run.numbers, run.layout, NEVER
    for i in range(layout[o + CLOCKS]):
        a, b, c = layout[o + FIRST + CLOCK * i], layout[o + FIRST + CLOCK * i + 1], layout[o + FIRST + CLOCK * i + 2]
        found = min(found, (a + numbers[layout[o + PLACE] + i] * b) / c)
    return found


@rare
def due_at(t, run):
    """The sum of 2^i over the clocks i that tick at t."""
    o, numbers, layout, due, weight = run.layout[L.TICKS], run.numbers, run.layout, 0.0, 1.0
    for i in range(layout[o + CLOCKS]):
        a, b, c = layout[o + FIRST + CLOCK * i], layout[o + FIRST + CLOCK * i + 1], layout[o + FIRST + CLOCK * i + 2]
        if (a + numbers[layout[o + PLACE] + i] * b) / c <= t:
            due += weight
        weight *= 2.0
    return due


@rare
def ticks(due, clock):
    """Whether this clock is in the sum ``due``."""
    weight = 1.0
    for _ in range(clock):
        weight *= 2.0
    return due - 2.0 * weight * int(due / (2.0 * weight)) >= weight


@rare
def limited(t, run):
    """Whether all values that are set at t are numbers that whole numbers can represent; others may be errors."""
    numbers, layout, due = run.numbers, run.layout, due_at(t, run)
    o = layout[L.TICKS]
    first = o + FIRST + CLOCK * layout[o + CLOCKS]
    found = True
    for j in range(layout[o + ACTIONS]):
        p = first + ACTION * j
        if ticks(due, layout[p]):
            found = found and abs(numbers[layout[p + 1]]) <= LARGEST
    return found


@rare
def act(t, run):
    """Set the variables of the clocks that tick at t, write the log, and count the ticks; whether a value changes."""
    numbers, layout = run.numbers, run.layout
    o = layout[L.TICKS]
    place, clocks, actions, changed = layout[o + PLACE], layout[o + CLOCKS], layout[o + ACTIONS], False
    log, due = place + clocks + 1 + int(numbers[place + clocks]) * (2 + actions), due_at(t, run)
    for i in range(clocks):
        if ticks(due, i):
            numbers[place + i] += 1.0
    first = o + FIRST + CLOCK * clocks
    for j in range(actions):
        p = first + ACTION * j
        old = numbers[layout[p + 2]]
        if ticks(due, layout[p]):
            numbers[layout[p + 2]] = numbers[layout[p + 1]]
            changed = changed or numbers[layout[p + 2]] != old
            if layout[p + 3] >= 0:
                numbers[layout[p + 3]] = numbers[layout[p + 2]]
        numbers[log + 2 + j] = numbers[layout[p + 2]]
    numbers[log], numbers[log + 1] = t, due
    numbers[place + clocks] += 1.0
    return changed


@rare
def tick(run):
    """Do what clocks do at the end of a step, where it lies on a tick; False if that is left to Python."""
    reals, integers, vectors, layout = run.reals, run.integers, run.vectors, run.layout
    n, size, now = layout[L.N_Q], layout[L.N_ALL], reals[S.NOW]
    t = next_tick(run)
    if integers[S.CUT] > 0 or t > now + 4.0 * reals[S.LEAST_H] or reals[S.KNOWN] < now + 4.0 * reals[S.LEAST_H]:
        return False
    for i in range(n):
        vectors[L.POSITION, i], vectors[L.VELOCITY, i] = vectors[L.POSITION0, i], vectors[L.VELOCITY0, i]
    if integers[S.WATCHING] > 0:
        for i in range(n):
            vectors[L.POSITION, i] += 2.0 * reals[S.LEAST_H] * vectors[L.VELOCITY0, i]
        evaluate(t, run)
        if signature(run.numbers, layout) != integers[S.SIGNATURE]:  # an event at the same time
            return False
        for i in range(n):
            vectors[L.POSITION, i] = vectors[L.POSITION0, i]
    evaluate(t, run)
    for i in range(n):
        vectors[L.E_V, i] = vectors[L.FORCE, i]
    inertia(L.ACT, 0, 0, run)
    if not limited(t, run):
        return False
    changed, k = act(t, run), run.matrices.shape[0] - 1
    if changed:
        evaluate(t, run)
        for i in range(size):
            vectors[L.E_Q, i] = vectors[L.FORCE, i] - vectors[L.E_V, i] if i < n else 0.0
            vectors[L.E_X, i] = vectors[L.E_Q, i]
        tangent_matrix(k, t, run, M=1.0, Phi_q=1.0, Gam_v=1.0)
        integers[S.OTHERS] = 0
        if not factor(k, run):
            return False
        solve(k, L.E_Q, run)
        add(run)
        integers[S.SIGNATURE] = signature(run.numbers, layout)
    reals[S.NEXT_EVENT] = min(reals[S.KNOWN], next_tick(run) - reals[S.LEAST_H])
    integers[S.EVENTS] += 1
    return True


@rare
def add(run):
    """Add the jump in E_Q, [da; dlam], and in E_X, dQ, to the history."""
    reals, vectors, numbers, layout, c = run.reals, run.vectors, run.numbers, run.layout, run.coefficients
    n, size, mass = layout[L.N_Q], layout[L.N_ALL], layout[L.MASS]
    inertia(L.TIMES, L.E_Q, L.TEMPORARY, run)
    kind = layout[L.MASS_KIND] > 0
    for i in range(n):
        vectors[L.FORCE0, i] += numbers[mass + i] * vectors[L.E_Q, i] + (vectors[L.TEMPORARY, i] if kind else 0.0)
    rows = int(c[c.size - 1])
    for j in range(rows):
        p = c.size - 1 - WEIGHTS * (rows - j)
        row, ca, cf, cl = int(c[p]), c[p + 1] * reals[S.LAST_H] ** c[p + 2], c[p + 3], c[p + 4]
        for i in range(size):
            if i < n:
                m = numbers[mass + i]
                vectors[row, i] += ca * vectors[L.E_Q, i] + cf * vectors[L.E_X, i] / (m if m > 0.0 else 1.0)
            else:
                vectors[row, i] += cl * vectors[L.E_Q, i]
