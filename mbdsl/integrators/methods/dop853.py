"""DOP853: explicit Runge-Kutta of order 8 on the index-1 form, with projection and error-controlled steps.

The accelerations of a stage and the projection: :mod:`mbdsl.integrators.methods.dop853_stages`. The step has 12 stages;
the accelerations at its projected end are the first stage of the next step. The error is estimated by embedded formulas
of order 5 and 3, with differences e5 and e3 from the result:

    error = e5^2 / sqrt(e5^2 + 0.01 e3^2) = O(h^8)

The last stage and the end of the step belong to the same time; h |lambda|, with the largest eigenvalue lambda of the
equations, follows from their difference. Steps with h |lambda| > 6.1 are limited by stability, not by accuracy. Output
between steps: :mod:`mbdsl.integrators.methods.dop853_output`.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.5, II.6 and the code
DOP853; Solving Ordinary Differential Equations II (1996), section IV.2 (test for stiffness).
"""

from math import sqrt

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.linear_solve import SPARSE_LU, larger
from mbdsl.integrators.loop.step_times import end_of_step
from mbdsl.integrators.loop.switch_location import length_before_switch
from mbdsl.integrators.method import Method
from mbdsl.integrators.methods.dop853_coefficients import (
    ALL,
    NODE,
    OF_E3,
    OF_E5,
    SQUARE,
    STAGES,
    TABLE,
)
from mbdsl.integrators.methods.dop853_output import interpolate as interpolate
from mbdsl.integrators.methods.dop853_stages import (
    CHANGED,
    END,
    FRICTION,
    OTHERS,
    OWN_ROWS,
    READY,
    ROOT,
    SPEED,
    STAGE,
    STIFF_STEPS,
    finish,
    has_friction,
    is_changed,
    solve_stages,
)
from mbdsl.integrators.methods.multiplier_matrix import roots
from mbdsl.integrators.methods.multiplier_matrix import tables as tables
from mbdsl.integrators.methods.radau_step import before_switch, fitted, update_switches
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare

#: h |lambda| at the limit of stability; number of stiff steps after which the model counts as stiff; number of other
#: steps in succession after which the stiff ones are forgotten; number of further steps up to which a controlled run
#: continues nevertheless
LIMIT, STIFF_FROM, RESET, AFFORDABLE = 6.1, 15, 6, 10_000

METHOD = Method(
    "dop853",
    doc="explicit Runge-Kutta of order 8 by Dormand and Prince, for models that are not stiff",
    order=8,
    index=1,
    enforces=("Phi", "dPhi"),
    family="Dormand-Prince",
    source="Hairer, Norsett, Wanner (1993), section II.5",
    coefficients=lambda options: TABLE,
    memory=lambda c, start: (0.1, *(0.0,) * 6),
    begin=lambda c, start: {L.UNKNOWN0: [*start.a, *start.lam]},
    own_reactions=False,
    steps=("controlled", "fixed"),
    rows=OWN_ROWS,
    matrices=2,
    stable=LIMIT,
    longest=0.1,
    relative_step=8.0,
)

#: h |lambda| of steps that are limited by something else: the control of steps keeps those of a stiff model near LIMIT,
#: while near a singular pose accelerations change by any amount with the last digits of positions
SINGULAR_FROM = 100.0
#: allowed error estimate of a step, relative to the tolerance
SHARE = 0.1
#: least error and least motion of a step that count: their squares are not zero
LEAST = 1e-150
#: largest error that may be due to rounding, relative to what is allowed
NOISE = 100.0
#: factor of the step length for safety; smallest and largest ratio of successive step lengths
SAFE, SHRINK, GROW = 0.9, 0.333, 6.0

# -- lengths of steps --------------------------------------------------------------------------------------------------


@rare
def first_step(run):
    """A length within which the motion at the start changes little [s]."""
    vectors, layout, length = run.vectors, run.layout, run.reals[S.STOP] - run.reals[S.START]
    speed, force = 0.0, 0.0
    for i in range(layout[L.N_Q]):
        speed = max(speed, abs(vectors[L.VELOCITY0, i]) * vectors[L.SCALE, i])
        force = max(force, abs(vectors[L.UNKNOWN0, i]) * vectors[L.SCALE, i])
    rate = max(speed, force**0.5)
    # of runs with different tolerances the first steps differ, so that their difference shows the error behind an event
    longest = 0.01 * length * (1e4 * run.reals[S.TOL]) ** 0.125
    return min(longest, run.reals[S.TOL] ** 0.125 / rate) if rate > 0.0 else longest


@kernel
def trial_length(run):
    """The length to try [s]."""
    memory, reals, vectors = run.memory, run.reals, run.vectors
    first, speed = run.integers[S.HISTORY] == 1, 0.0
    for i in range(run.layout[L.N_Q]):
        speed = max(speed, abs(vectors[L.VELOCITY0, i]) * vectors[L.SCALE, i])
    memory[SPEED] = max(memory[SPEED], speed, 1.0 / (reals[S.STOP] - reals[S.START]) if reals[S.TOL] > 0.0 else 0.0)
    if first:
        memory[FRICTION] = 1.0 if has_friction(run) else 0.0
        roots(ROOT, run)
    if reals[S.TOL] == 0.0:
        return reals[S.STEP_SIZE]
    if first:
        reals[S.STEP_SIZE] = min(reals[S.STEP_SIZE], first_step(run))
    return min(reals[S.STEP_SIZE], reals[S.MOST_H])


@kernel
def estimate(h, run):
    """The error of the step just tried: the largest of scaled q, and of scaled v relative to the speed."""
    vectors, c, speed, five, three = run.vectors, run.coefficients, run.memory[SPEED], 0.0, 0.0
    for i in range(run.layout[L.N_Q]):
        v5, q5, v3, q3 = 0.0, 0.0, 0.0, 0.0
        for j in range(STAGES):
            a = vectors[STAGE + j, i]
            v5 += c[ALL * OF_E5 + j] * a
            q5 += c[ALL * (SQUARE + OF_E5) + j] * a
            v3 += c[ALL * OF_E3 + j] * a
            q3 += c[ALL * (SQUARE + OF_E3) + j] * a
        scale = h * vectors[L.SCALE, i]
        five = larger(scale * abs(v5) / speed, larger(scale * h * abs(q5), five))
        three = larger(scale * abs(v3) / speed, larger(scale * h * abs(q3), three))
    return five * five / sqrt(five * five + 0.01 * three * three) if five > LEAST else five


@rare
def overlooked(h, run):
    """The error of a step, across a switch, due to accelerations that its sum does not contain.

    Four stages have no weight. If only they meet a contact and repel it, the sum is that of a free flight through the
    contact, and the estimate is zero. What their accelerations, and those at the end of the step, exceed the others by
    counts with the mean weight of a stage.
    """
    vectors, c, speed, found, sum_of = run.vectors, run.coefficients, run.memory[SPEED], 0.0, ALL * STAGES
    for i in range(run.layout[L.N_Q]):
        inside, outside = 0.0, abs(vectors[STAGE + STAGES, i])
        for j in range(STAGES):
            a = abs(vectors[STAGE + j, i])
            if c[sum_of + j] != 0.0:
                inside = max(inside, a)
            else:
                outside = max(outside, a)
        v = h / STAGES * vectors[L.SCALE, i] * max(0.0, outside - inside)
        found = larger(v / speed, larger(h * v, found))
    return found


@kernel
def next_length(error, h, times, formulas, run):
    """Set the length of the next step."""
    reals = run.reals
    if reals[S.TOL] > 0.0:
        ratio = SAFE * max(error, 1e-12) ** -0.125
        reals[S.STEP_SIZE], reals[S.LAST_H] = h * min(max(ratio, SHRINK), GROW), h


# -- stiffness ---------------------------------------------------------------------------------------------------------


@kernel
def is_stiff(h, run):
    """Whether the steps are limited by stability, and many more of them are needed to the end."""
    memory, vectors, c, reals = run.memory, run.vectors, run.coefficients, run.reals
    speed, moved, changed = memory[SPEED], 0.0, 0.0
    b, a = ALL * STAGES, ALL * (STAGES - 1)
    for i in range(run.layout[L.N_Q]):
        v, q = 0.0, 0.0
        for j in range(STAGES):
            x = vectors[STAGE + j, i]
            v += (c[b + j] - c[a + j]) * x
            q += (c[ALL * SQUARE + b + j] - c[ALL * SQUARE + a + j]) * x
        v, q = h * v * vectors[L.SCALE, i], h * h * q * vectors[L.SCALE, i] * speed
        rate = (vectors[STAGE + STAGES, i] - vectors[STAGE + STAGES - 1, i]) * vectors[L.SCALE, i]
        moved += v * v + q * q
        changed += rate * rate + v * v * speed * speed
    reals[S.RADIUS] = h * sqrt(changed / moved) if moved > LEAST * LEAST else 0.0
    if LIMIT < reals[S.RADIUS] < SINGULAR_FROM:
        memory[STIFF_STEPS], memory[OTHERS] = memory[STIFF_STEPS] + 1.0, 0.0
    else:
        memory[OTHERS] += 1.0
        if memory[OTHERS] >= RESET:
            memory[STIFF_STEPS] = 0.0
    affordable = reals[S.TOL] > 0.0 and reals[S.STOP] - reals[S.STEP_END] <= AFFORDABLE * h
    return memory[STIFF_STEPS] >= STIFF_FROM and not affordable


@rare
def is_unstable(h, run):
    """Whether a step of fixed length, which has failed, is unstable; from the change of a along the first stage."""
    vectors, reals, moved, changed = run.vectors, run.reals, 0.0, 0.0
    for i in range(run.layout[L.N_Q]):
        a, b = vectors[STAGE, i] * vectors[L.SCALE, i], vectors[STAGE + 1, i] * vectors[L.SCALE, i]
        moved = max(moved, run.coefficients[NODE + 1] * abs(a))
        changed = max(changed, abs(b - a))
    found = changed / moved if moved > 0.0 else 0.0  # nan if the first stage has failed, too
    if found > reals[S.RADIUS]:
        reals[S.RADIUS] = found
    return reals[S.RADIUS] > LIMIT


# -- the step ----------------------------------------------------------------------------------------------------------


@kernel
def begin_step(run):
    """The accelerations at the start of the step are those of the first stage."""
    vectors = run.vectors
    for i in range(run.layout[L.N_ALL]):
        vectors[STAGE, i], vectors[L.UNKNOWN, i] = vectors[L.UNKNOWN0, i], vectors[L.UNKNOWN0, i]
    run.memory[READY] = 0.0


@kernel
def take_fixed(t0, h, run):
    """Take a step of fixed length; a status."""
    reals, integers = run.reals, run.integers
    end = reals[S.STOP] if integers[S.STEP] == integers[S.LAST_STEP] - 1 else t0 + h
    early = max(0.0, end - reals[S.NEXT_EVENT])  # some units in the last place
    reals[S.STEP_END] = end - early
    begin_step(run)
    status = solve_stages(t0 - early, h, run)
    if status == S.RUNNING:
        status = finish(reals[S.STEP_END], h, run)
    failed = status != S.RUNNING and status != S.SINGULAR
    return S.STIFF if failed and is_unstable(h, run) else status


@kernel
def take_controlled(t0, h, run):
    """Try shorter and shorter steps until one is accepted; status, length and error."""
    reals, integers = run.reals, run.integers
    refused, error, former, allowed = 0, 0.0, 0.0, SHARE * reals[S.TOL]
    while True:
        h = fitted(t0, h, run)
        end_of_step(t0, h, run)
        begin_step(run)
        status, error = solve_stages(t0, h, run), 0.0
        if status == S.RUNNING:
            error = estimate(h, run) / allowed
            if not error < 1e300:
                status = S.NOT_FINITE
        # If a shorter step has no smaller error, the error is due to rounding.
        accepted = status == S.RUNNING and (error <= 1.0 or (refused > 1 and former <= error < NOISE))
        if accepted:
            status = finish(reals[S.STEP_END], h, run)
            if status == S.RUNNING and integers[S.WATCHING] and (run.memory[CHANGED] > 0.0 or is_changed(run)):
                missed = overlooked(h, run) / allowed
                error, accepted = larger(error, missed), missed <= 1.0
        if status == S.SINGULAR and run.layout[L.SOLVER] == SPARSE_LU:
            return status, h, error  # the run continues with the dense solver
        if integers[S.WATCHING]:
            part = before_switch(status, error, h, run)
            if part < 1.0:
                h = length_before_switch(part, h, run)
                if h == 0.0:
                    return S.EVENT, h, error
                continue
        if status == S.RUNNING:
            if accepted:
                return S.RUNNING, h, error
            refused, former = refused + 1, error
            h *= max(SHRINK, SAFE * error**-0.125)
        else:
            h *= 0.25
        integers[S.REJECTED], integers[S.CUT] = integers[S.REJECTED] + 1, 0
        if h < reals[S.LEAST_H]:
            return status if status != S.RUNNING else S.TOO_SMALL, h, error


@kernel
def take(t0, h, formulas, run):
    """Take a step of about length h from t0; status, length and error relative to what is allowed."""
    status, error = S.RUNNING, 0.0
    if run.reals[S.TOL] > 0.0:
        status, h, error = take_controlled(t0, h, run)
    else:
        status = take_fixed(t0, h, run)
    if status == S.RUNNING:
        if run.integers[S.WATCHING]:
            update_switches(run)
        if is_stiff(h, run):
            return S.STIFF, h, error
    return status, h, error


@kernel
def store(h, run):
    """Store the step as the last one."""
    reals, vectors, layout = run.reals, run.vectors, run.layout
    for i in range(layout[L.N_Q]):
        vectors[L.POSITION0, i], vectors[L.VELOCITY0, i] = vectors[L.POSITION, i], vectors[L.VELOCITY, i]
    for i in range(layout[L.N_ALL]):
        vectors[L.UNKNOWN0 + 1, i], vectors[L.UNKNOWN0, i] = vectors[L.UNKNOWN0, i], vectors[END, i]
    if reals[S.TOL] > 0.0:
        reals[S.NODES], reals[S.NODES + 1] = reals[S.STEP_END], reals[S.NOW]
