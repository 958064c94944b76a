"""Newton's iteration of a step: renewal of the matrix and acceptance of an iterate."""

from __future__ import annotations

from typing import NamedTuple

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.run_data import evaluate
from mbdsl.integrators.loop.step_control import allowed, bend_uneven, even
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare

MAX_ITERATIONS = 25
#: smallest part of a correction that a damped iteration applies
SHORTEST = 1.0 / 32.0
#: contraction above which the next step starts with a new matrix
SLOW = 0.05
#: contraction assumed of a first iteration, at least: if none was measured in the last OFTEN steps; otherwise
UNMEASURED, OFTEN, MEASURED = 0.05, 8, 1e-3
#: largest change of a position that is attributed to rounding in a singular pose
SINGULAR_NOISE = 1e-9
#: error allowed for the iteration, relative to that allowed for a controlled step
NOISE = 0.3
#: steps until a new matrix is tried again where corrections are as small as rounding
LONG = 100
#: change of a multiplier in a first iteration, relative to its value, up to which laws of multipliers are linear; a
#: multiplier below this part of the largest one is rounding
NEARLY_LINEAR, OF_ROUNDING = 0.1, 1e-9
#: largest size that loosens the bounds of kinematics: larger coordinates count turns or long travels
FAR = 16.0
#: distance from the axis of a spin at which its speed counts, relative to the mechanism's length
SPIN = 1e-2
EPS = 2.220446049250313e-16


@kernel
def residual_size(run):
    """Sum of the magnitudes of the residuals, in four independent partial sums; NaN if one of them is."""
    vectors, size = run.vectors, run.layout[L.N_ALL]
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    for k in range(1 + run.integers[S.STABILISED]):
        y, whole = vectors[L.RESIDUAL + k], size - size % 4
        for i in range(0, whole, 4):
            a, b, c, d = a + abs(y[i]), b + abs(y[i + 1]), c + abs(y[i + 2]), d + abs(y[i + 3])
        for i in range(whole, size):
            a += abs(y[i])
    return (a + b) + (c + d)


@rare
def constraint_size(run):
    """Largest residual among the constraints."""
    vectors = run.vectors
    value = 0.0
    for k in range(1 + run.integers[S.STABILISED]):
        for i in range(run.layout[L.N_Q], run.layout[L.N_ALL]):
            value = max(value, abs(vectors[L.RESIDUAL + k, i]))
    return value


@rare
def finite(run):
    """Whether all entries of the matrices are finite: a derivative may be infinite where the force is finite."""
    matrices = run.matrices
    for k in range(matrices.shape[0]):
        for i in range(matrices.shape[1]):
            if not abs(matrices[k, i]) < 1e300:
                return False
    return True


@rare
def keep_unknowns(run):
    """Store the unknowns in BEFORE (and BEFORE2)."""
    vectors = run.vectors
    for k in range(1 + run.integers[S.STABILISED]):
        for i in range(run.layout[L.N_ALL]):
            vectors[L.BEFORE + k, i] = vectors[L.UNKNOWN + k, i]


@rare
def take_back(part, run):
    """Reduce the last correction to a part of it."""
    vectors = run.vectors
    for k in range(1 + run.integers[S.STABILISED]):
        for i in range(run.layout[L.N_ALL]):
            vectors[L.UNKNOWN + k, i] = vectors[L.BEFORE + k, i] + part * (
                vectors[L.UNKNOWN + k, i] - vectors[L.BEFORE + k, i]
            )


class Limits(NamedTuple):
    """Bounds that a change of positions is compared with, in the mechanism's length."""

    size: float  #: of the mechanism
    floor: float  #: rounding, with a margin
    rounding: float  #: rounding, or a part of the allowed error if that is smaller
    estimate: float  #: the same for errors estimated from a contraction; in kinematics without turns and travels
    tolerance: float  #: from the discretisation error of the step
    velocity_tolerance: float  #: for the constraints on velocities


@kernel
def kinematic(run):
    """Whether there is no differential equation, and therefore no error that a tolerance can refer to."""
    return run.reals[S.RELATIVE_TOL] > 1.0


@kernel
def travel_speed(run):
    """The largest scaled velocity of bodies in space, without their spins, or a small part of the largest spin if it is
    larger: a top moves its joint far more slowly than it turns."""
    vectors, layout, speed, spin, k = run.vectors, run.layout, 0.0, 0.0, 0
    for i in range(layout[L.N_Q]):
        own = abs(vectors[L.VELOCITY0, i]) * vectors[L.SCALE, i]
        d = layout[layout[L.ROTATIONS] + 2 * k] if k < layout[L.N_ROTATIONS] else i + 1
        if i < d:
            speed = max(speed, own)
        else:
            spin = max(spin, own)
            k = k + 1 if i == d + 2 else k
    return max(speed, SPIN * spin)


@kernel
def limits(h, run):
    """The bounds of a step of length h."""
    reals, integers, vectors, layout = run.reals, run.integers, run.vectors, run.layout
    n, size, speed, bend = layout[L.N_Q], 1.0, 0.0, 0.0
    for i in range(n):
        size = max(size, abs(vectors[L.POSITION0, i]) * vectors[L.SCALE, i])
        speed = max(speed, abs(vectors[L.VELOCITY0, i]) * vectors[L.SCALE, i])
        # at the start, where changes of a are not known, a thousandth of a itself
        d = (
            vectors[L.UNKNOWN0, i] - 2.0 * vectors[L.UNKNOWN0 + 1, i] + vectors[L.UNKNOWN0 + 2, i]
            if integers[S.HISTORY] > 2
            else 1e-3 * vectors[L.UNKNOWN0, i]
        )
        bend = max(bend, abs(d) * vectors[L.SCALE, i])
    if integers[S.HISTORY] > 2 and not even(run):
        bend = bend_uneven(h, n, run)
    rounding = EPS * size
    # The estimate reads accelerations, in which rounding of positions is magnified by 1/h^2.
    if integers[S.CONTROLLED] and reals[S.GRID] == 0.0:
        rounding = min(rounding, NOISE * allowed(h, run) * reals[S.SPEED] * h)
    # The local error is about h^2/12 times the second difference of a; constraints on velocities must be kept, too.
    near = min(size, FAR) if kinematic(run) else size
    tolerance = min(reals[S.RELATIVE_TOL] * h * h * bend, reals[S.LOOSEST] * near)
    velocity_tolerance = reals[S.LOOSEST] * size
    if integers[S.STABILISED] or layout[L.N_GAM] > 0:
        if layout[L.N_ROTATIONS] > 0:
            speed = travel_speed(run)
        velocity_tolerance = max(reals[S.VELOCITY_TOL] * h * speed, 4.0 * EPS * size)
    return Limits(size, 16.0 * EPS * size, rounding, min(rounding, EPS * near), tolerance, velocity_tolerance)


@kernel
def assumed_contraction(run):
    """Of the first iteration, whose change has no former one to be compared with; an old matrix may have got worse."""
    reals, integers = run.reals, run.integers
    contraction = max(reals[S.CONTRACTION], MEASURED)
    if integers[S.UNSEEN] >= OFTEN:
        contraction = max(contraction, UNMEASURED)
    integers[S.UNSEEN] += 1
    return min(contraction, 0.9)


@kernel
def evaluate_residual(t, h, formulas, run):
    """The residuals at the present iterate; their sum."""
    formulas.motion(h, run)
    evaluate(t, run)
    run.layout[L.NEW_MASS] = 0
    formulas.residual(h, run)
    run.integers[S.ITERATIONS] += 1
    return residual_size(run)


@kernel
def renew_matrix(t, h, formulas, run):
    """Whether the iteration matrix at the present iterate could be factorised."""
    integers = run.integers
    integers[S.MATRICES] += 1
    integers[S.FACTORISATIONS] += 1
    if not formulas.matrix(t, h, run):
        return False
    integers[S.FRESH] = 1
    return True


@kernel
def reactions_change(run):
    """Whether a correction of multipliers is so large that friction may have changed otherwise than linearly.

    The change of positions shows only what is linear: the derivative of friction by a load that was zero is zero.
    """
    correction, unknown, n, size = (
        run.vectors[L.CORRECTION],
        run.vectors[L.UNKNOWN],
        run.layout[L.N_Q],
        run.layout[L.N_ALL],
    )
    largest, excess = 0.0, 0.0
    for i in range(n, size):
        largest = max(largest, abs(unknown[i]))
    for i in range(n, size):
        excess = max(excess, abs(correction[i]) - max(NEARLY_LINEAR * abs(unknown[i]), OF_ROUNDING * largest))
    return excess > 0.0


@kernel
def converged(k, change, contraction, stalled, limit, run):
    """Whether the change of iteration k leaves an error below the limits. ``stalled``: by rounding."""
    # Errors left in many small steps add up: a change at rounding level is accepted from the second one on.
    left = change * contraction / (1.0 - contraction) if contraction < 0.9 else change
    done = left <= limit.tolerance or change <= limit.rounding or (k > 0 and left <= limit.estimate)
    # v has to stay on the constraints: an assumed contraction is not relied upon.
    if max(left, UNMEASURED * change if k == 0 else 0.0) > limit.velocity_tolerance:
        done = False
    if stalled or (k > 2 and contraction > 0.5 and change <= 1e3 * limit.floor):
        done = True  # rounding prevents further progress
    progress = kinematic(run) and contraction <= 0.3
    if k > 6 and not progress and change <= SINGULAR_NOISE * limit.size:
        violation = constraint_size(run)
        # close to a singular pose, which magnifies rounding; the constraints hold
        done = done or run.reals[S.UNIT] * violation <= 1e2 * limit.floor
    return done


@kernel
def newton(damped, t, h, formulas, run):
    """Solve the step for UNKNOWN (and UNKNOWN2); a status. ``damped``: with parts of corrections and new matrices.

    An iterate is accepted if the error that the contraction leaves is below the discretisation error of the step, or at
    rounding, in position units; and if the residual has not grown.
    """
    reals, integers = run.reals, run.integers
    limit, contraction = limits(h, run), assumed_contraction(run)
    integers[S.ROUNDING] = max(0, integers[S.ROUNDING] - 1)
    fresh, former, former_residual, worn, part = integers[S.FRESH] == 0, 0.0, 0.0, False, 1.0
    run.layout[L.NEW_MASS] = 1
    for k in range(4 * MAX_ITERATIONS if damped else MAX_ITERATIONS):
        remaining = evaluate_residual(t, h, formulas, run)
        if not remaining < 1e300:
            return S.NOT_FINITE
        renewed = k > 0 and integers[S.FRESH] == 0
        if integers[S.FRESH] == 0 and not renew_matrix(t, h, formulas, run):
            if k > 1 and former <= 1e3 * limit.floor and finite(run) and not integers[S.CONTROLLED]:
                return S.RUNNING  # the pose is singular, and the former matrix has left an error at rounding level
            return S.SINGULAR if finite(run) else S.NOT_FINITE
        if damped:
            keep_unknowns(run)
        change = formulas.correct(k, h, run)
        if not change < 1e300:
            return S.NOT_FINITE
        if damped:
            # Friction that reverses within less than a step makes full corrections alternate.
            part = max(0.5 * part, SHORTEST) if k > 0 and change > 0.7 * former else min(1.4 * part, 1.0)
            integers[S.FRESH] = 0
            if part < 1.0:
                take_back(part, run)
                former, former_residual = change, remaining
                continue
        if k > 0:
            contraction = change / former if former > 0.0 else 0.0
            if renewed and change > 100.0 * limit.floor:  # changes by two matrices are not comparable
                contraction = max(contraction, UNMEASURED)
            if former > 100.0 * limit.floor:  # below that it measures rounding
                reals[S.CONTRACTION], integers[S.UNSEEN], worn = contraction, 0, contraction > SLOW
        grown = k > 0 and remaining > 10.0 * former_residual and change > 100.0 * limit.floor
        last_digit = k > 0 and contraction > 0.1 and change <= EPS * limit.size
        stalled = last_digit and not renewed and (fresh or integers[S.ROUNDING] > 0)  # no new matrix would help
        unseen = k == 0 and run.layout[L.OF_MULTIPLIERS] > 0 and reactions_change(run)
        if converged(k, change, contraction, stalled, limit, run) and not grown and not unseen:
            if worn:
                integers[S.FRESH] = 0  # the next step starts with a new matrix
            return S.RUNNING
        if k > 0 and contraction > 0.3 and not fresh:
            integers[S.FRESH], fresh = 0, True  # an old matrix that contracts badly is renewed at once
            if last_digit:
                integers[S.ROUNDING] = LONG
        elif k > 2 and (contraction > 0.3 or (contraction > 0.1 and k % 3 == 0)):
            integers[S.FRESH] = 0  # far from the solution: plain Newton, or nearly
        former, former_residual = change, remaining
    return S.DIVERGED
