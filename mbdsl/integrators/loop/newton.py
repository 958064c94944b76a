"""Newton's iteration of a step: when the matrix is renewed, and when an iterate is accepted."""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import (
    BEFORE,
    N_ALL,
    N_GAM,
    N_Q,
    NEW_MASS,
    POSITION0,
    RESIDUAL,
    SCALE,
    UNKNOWN,
    UNKNOWN0,
    VELOCITY0,
)
from mbdsl.compilation.marks import kernel, rare
from mbdsl.integrators.loop.loop_state import (
    CONTRACTION,
    CONTROLLED,
    DIVERGED,
    FACTORISATIONS,
    FRESH,
    HISTORY,
    ITERATIONS,
    LOOSEST,
    MATRICES,
    NOT_FINITE,
    RELATIVE_TOL,
    ROUNDING,
    RUNNING,
    SINGULAR,
    SPEED,
    STABILISED,
    UNIT,
    UNSEEN,
    VELOCITY_TOL,
)
from mbdsl.integrators.loop.run_data import evaluate
from mbdsl.integrators.loop.step_control import allowed, bend_uneven, even, other_matrices

MAX_ITERATIONS = 25
#: smallest part of a correction that is taken where whole ones do not get anywhere
SHORTEST = 1.0 / 32.0
#: contraction above which the next step starts with a new matrix
SLOW = 0.05
#: contraction assumed of a first iteration, at least, where it has not been seen for so many steps; and else
UNMEASURED, OFTEN, MEASURED = 0.05, 8, 1e-3
#: largest noise in a position that is put down to a singular pose
SINGULAR_NOISE = 1e-9
#: part of what a controlled step may err that its iteration may
NOISE = 0.3
#: steps before a new matrix is tried again against corrections of the size of rounding
LONG = 100
EPS = 2.220446049250313e-16


@kernel
def residual_size(unknowns, size, run):
    """Sum of the residuals' magnitudes, in four lanes that do not wait for one another; not a number if one is none."""
    vectors = run.vectors
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    for k in range(unknowns):
        y, whole = vectors[RESIDUAL + k], size - size % 4
        for i in range(0, whole, 4):
            a, b, c, d = a + abs(y[i]), b + abs(y[i + 1]), c + abs(y[i + 2]), d + abs(y[i + 3])
        for i in range(whole, size):
            a += abs(y[i])
    return (a + b) + (c + d)


@rare
def constraint_size(unknowns, n, size, run):
    """Largest residual among the constraints."""
    vectors = run.vectors
    value = 0.0
    for k in range(unknowns):
        for i in range(n, size):
            value = max(value, abs(vectors[RESIDUAL + k, i]))
    return value


@rare
def finite(run):
    """Whether a matrix holds numbers only: a derivative may be infinite where the force itself is not."""
    matrices = run.matrices
    for k in range(matrices.shape[0]):
        for i in range(matrices.shape[1]):
            if not abs(matrices[k, i]) < 1e300:
                return False
    return True


@rare
def keep_unknowns(unknowns, size, run):
    vectors = run.vectors
    for k in range(unknowns):
        for i in range(size):
            vectors[BEFORE + k, i] = vectors[UNKNOWN + k, i]


@rare
def take_back(part, unknowns, size, run):
    """Leave only a part of the last correction."""
    vectors = run.vectors
    for k in range(unknowns):
        for i in range(size):
            vectors[UNKNOWN + k, i] = vectors[BEFORE + k, i] + part * (vectors[UNKNOWN + k, i] - vectors[BEFORE + k, i])


@kernel
def newton(damped, t, h, formulas, run):
    """Solve the step for UNKNOWN (and UNKNOWN2); a status. ``damped``: with parts of corrections and new matrices.

    An iterate is accepted when the error that the contraction leaves is below what the step itself gets wrong by
    discretisation, or at rounding; in position units, and with a residual that has not grown.
    """
    reals, integers, vectors, layout = run.reals, run.integers, run.vectors, run.layout
    n, unknowns = layout[N_Q], 1 + integers[STABILISED]
    size, speed, bend = 1.0, 0.0, 0.0
    for i in range(n):
        size = max(size, abs(vectors[POSITION0, i]) * vectors[SCALE, i])
        speed = max(speed, abs(vectors[VELOCITY0, i]) * vectors[SCALE, i])
        # at the start, where nothing is known of how a changes, a thousandth of a itself
        d = (
            vectors[UNKNOWN0, i] - 2.0 * vectors[UNKNOWN0 + 1, i] + vectors[UNKNOWN0 + 2, i]
            if integers[HISTORY] > 2
            else 1e-3 * vectors[UNKNOWN0, i]
        )
        bend = max(bend, abs(d) * vectors[SCALE, i])
    if integers[HISTORY] > 2 and not even(run):
        bend = bend_uneven(h, n, run)
    floor, rounding = 16.0 * EPS * size, EPS * size
    # errors of velocities are seen in accelerations, where rounding of positions is 1/h^2 times it
    if integers[CONTROLLED]:
        rounding = min(rounding, NOISE * allowed(h, run) * reals[SPEED] * h)
    # The local error is about h^2/12 times the second difference of a; constraints on velocities are to be kept, too.
    tolerance = min(reals[RELATIVE_TOL] * h * h * bend, reals[LOOSEST] * size)
    velocity_tolerance = reals[LOOSEST] * size
    if integers[STABILISED] or layout[N_GAM] > 0:
        velocity_tolerance = max(reals[VELOCITY_TOL] * h * speed, 4.0 * EPS * size)
    fresh = integers[FRESH] == 0
    # The first change has nothing to be compared with; an old matrix may have become worse than it was when last seen.
    contraction = max(reals[CONTRACTION], MEASURED)
    if integers[UNSEEN] >= OFTEN:
        contraction = max(contraction, UNMEASURED)
    contraction = min(contraction, 0.9)
    integers[UNSEEN] += 1
    integers[ROUNDING] = max(0, integers[ROUNDING] - 1)
    former, former_residual, worn, renewed, part = 0.0, 0.0, False, False, 1.0
    layout[NEW_MASS] = 1
    for k in range(4 * MAX_ITERATIONS if damped else MAX_ITERATIONS):
        formulas.motion(h, run)
        evaluate(t, run)
        layout[NEW_MASS] = 0
        formulas.residual(h, run)
        integers[ITERATIONS] += 1
        remaining = residual_size(unknowns, layout[N_ALL], run)
        if not remaining < 1e300:
            return NOT_FINITE
        renewed = k > 0 and integers[FRESH] == 0
        if integers[FRESH] == 0:
            integers[MATRICES] += 1
            integers[FACTORISATIONS] += 1
            if not formulas.matrix(t, h, run):
                if k > 1 and former <= 1e3 * floor and finite(run) and not integers[CONTROLLED]:
                    return RUNNING  # the pose is singular, and what the former matrix left is rounding
                return SINGULAR if finite(run) else NOT_FINITE
            integers[FRESH] = 1
            if integers[CONTROLLED]:
                other_matrices(t, h, run)
        if damped:
            keep_unknowns(unknowns, layout[N_ALL], run)
        change = formulas.correct(k, h, run)
        if not change < 1e300:
            return NOT_FINITE
        if damped:
            # Friction that turns round within less than a step makes whole corrections jump to and fro.
            part = max(0.5 * part, SHORTEST) if k > 0 and change > 0.7 * former else min(1.4 * part, 1.0)
            integers[FRESH] = 0
            if part < 1.0:
                take_back(part, unknowns, layout[N_ALL], run)
                former, former_residual = change, remaining
                continue
        if k > 0:
            contraction = change / former if former > 0.0 else 0.0
            if renewed and change > 100.0 * floor:  # corrections by two matrices say nothing of each other
                contraction = max(contraction, UNMEASURED)
            if former > 100.0 * floor:  # below that it measures rounding
                reals[CONTRACTION] = contraction
                integers[UNSEEN] = 0
                worn = contraction > SLOW
        grown = k > 0 and remaining > 10.0 * former_residual and change > 100.0 * floor
        # What every step leaves undone adds up over many small ones: rounding is an excuse from the second change on.
        left = change * contraction / (1.0 - contraction) if contraction < 0.9 else change
        done = left <= tolerance or change <= rounding or (k > 0 and left <= rounding)
        # That v stays on the constraints is a promise, for which no contraction is good enough that was only assumed.
        if max(left, UNMEASURED * change if k == 0 else 0.0) > velocity_tolerance:
            done = False
        if k > 2 and contraction > 0.5 and change <= 1e3 * floor:
            done = True  # rounding keeps it from getting better
        last_digit = k > 0 and contraction > 0.1 and change <= EPS * size
        if last_digit and not renewed and (fresh or integers[ROUNDING] > 0):
            done = True  # the same: no new matrix would help
        held = k > 6 and reals[UNIT] * constraint_size(unknowns, n, layout[N_ALL], run) <= 1e2 * floor
        if held and change <= SINGULAR_NOISE * size:
            done = True  # close to a singular pose, where rounding is magnified; the constraints hold
        if done and not grown:
            if worn:
                integers[FRESH] = 0  # the next step starts with a new matrix
            return RUNNING
        if k > 0 and contraction > 0.3 and not fresh:
            integers[FRESH] = 0  # an old matrix that contracts badly is renewed at once
            fresh = True
            if last_digit:
                integers[ROUNDING] = LONG
        elif k > 2 and (contraction > 0.3 or (contraction > 0.1 and k % 3 == 0)):
            integers[FRESH] = 0  # far from the solution: plain Newton, or nearly
        former, former_residual = change, remaining
    return DIVERGED
