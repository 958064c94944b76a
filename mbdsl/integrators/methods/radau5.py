"""RADAU5: Radau IIA with three stages on the stabilised index-2 equations, order 5, with error-controlled steps.

The equations and how they are solved: :mod:`mbdsl.integrators.methods.radau5_stages`. The end of a step is its third
stage, where both levels of constraints hold. Lengths of steps follow from an embedded formula of order 3, and a digital
filter.

Source: Hairer, Wanner, Solving Ordinary Differential Equations II (1996), section IV.8, on the equations of Gear,
Gupta, Leimkuhler, J. Comput. Appl. Math. 12 & 13 (1985) 77-90; controller: Soederlind, ACM Trans. Math. Softw. 29
(2003) 1-26. The splitting is ours.
"""

from mbdsl.compilation.buffer_layout import (
    FORCE,
    FORCE0,
    N_ALL,
    N_PHI,
    N_Q,
    NEW_MASS,
    POSITION,
    POSITION0,
    SCALE,
    SOLVER,
    UNKNOWN0,
    VELOCITY,
    VELOCITY0,
)
from mbdsl.compilation.marks import kernel, rare
from mbdsl.integrators.loop.linear_solve import SPARSE_LU
from mbdsl.integrators.loop.loop_state import (
    CUT,
    DIVERGED,
    DONE,
    EVENT,
    EVERY,
    FACTORISATIONS,
    FRESH,
    HISTORY,
    ITERATIONS,
    LAST_H,
    LAST_STEP,
    LEAST_H,
    LOOK,
    MATRICES,
    MOST_H,
    NEXT_EVENT,
    NODES,
    NOT_FINITE,
    NOTES,
    NOW,
    OUTPUT,
    REJECTED,
    RUNNING,
    SIGNATURE,
    SINGULAR,
    START,
    STEP,
    STEP_END,
    STEP_SIZE,
    STOP,
    TOL,
    TOO_SMALL,
    UNCUT,
    UNSEEN,
    WATCHING,
    ZONES,
)
from mbdsl.integrators.loop.newton import EPS, SINGULAR_NOISE, finite
from mbdsl.integrators.loop.run_data import evaluate
from mbdsl.integrators.loop.switch_location import SHORT_OF, until_switch
from mbdsl.integrators.loop.turn_counting import count_turns
from mbdsl.integrators.loop.zone_landing import note, until_zone
from mbdsl.integrators.method import Method
from mbdsl.integrators.methods.radau5_stages import (
    MATRICES as MATRIX_COUNT,
)
from mbdsl.integrators.methods.radau5_stages import (
    NODES as STAGES,
)
from mbdsl.integrators.methods.radau5_stages import (
    OWN_ROWS,
    PAST,
    PAST2,
    QB,
    RESIDUAL,
    STAGE,
    STAGE2,
    VB,
    correct,
    estimate,
    matrices,
    motion,
    predict,
    residual,
    set_metric,
)
from mbdsl.system.switches import signature

# -- memory: the last step, and its error; the one of the matrices; the contraction last seen; the largest scaled speed
# so far
LAST, ERROR, OF_MATRICES, CONTRACTION, SPEED = range(5)

METHOD = Method(
    "radau5",
    doc="Radau IIA of order 5, stabilised: positions and velocities on their constraints",
    order=5,
    index=2,
    enforces=("Phi", "dPhi"),
    family="Radau IIA",
    source="Hairer, Wanner (1996)",
    memory=lambda c, start: (0.0,) * 5,
    begin=lambda c, start: {UNKNOWN0: [*start.a, *start.lam]},
    sets=2,
    matrices=MATRIX_COUNT,
    own_reactions=False,
    steps=("controlled", "fixed"),
    rows=OWN_ROWS,
)

MAX_ITERATIONS = 25
#: contraction assumed of a first iteration, at least, where it has not been seen for so many steps
ASSUMED, OFTEN = 0.05, 4
#: contraction above which matrices are made anew
SLOW = 0.02
#: the tolerance of the embedded formula, of order 3, is this times the power 4/5 of that of the result
STRICT = 0.1
#: what Newton's iteration may leave, relative to the tolerance over the whole time
LEFT = 0.2
#: where that is rounding: what it may leave relative to what a step may err
STALLED = 1e-3
#: the largest error that may be rounding, relative to what is allowed
NOISE = 100.0
#: the error, relative to what is allowed, up to which a corner of a force is passed
UNNOTICED = 0.05
#: the error that is aimed at; how much shorter, or longer, the next step may be
AIM, SHRINK, GROW = 0.5, 0.15, 6.0


@kernel
def newton(t, h, size, unit, tolerance, stalled, run):
    """Solve the stages; a status."""
    memory, integers, layout = run.memory, run.integers, run.layout
    # What every step leaves undone adds up: not much more than half of the last digit is good enough.
    floor = 0.5 * EPS * size
    # The first change has nothing to be compared with.
    contraction, former = min(max(memory[CONTRACTION], ASSUMED if integers[UNSEEN] >= OFTEN else 1e-3), 0.9), 0.0
    integers[UNSEEN] += 1
    fresh = False
    for k in range(MAX_ITERATIONS):
        # the middle one last: matrices are made there
        for stage in (0, 2, 1):
            motion(stage, h, run)
            layout[NEW_MASS] = 1
            evaluate(t + STAGES[stage] * h, run)
            residual(stage, run)
        integers[ITERATIONS] += 1
        if integers[FRESH] == 0:
            integers[MATRICES] += 1
            integers[FACTORISATIONS] += 1
            still = max(1e3 * floor, stalled) / unit
            if not matrices(t + STAGES[1] * h, h, still, run):
                return SINGULAR if finite(run) else NOT_FINITE
            integers[FRESH], memory[OF_MATRICES], fresh = 1, h, True
        held = k > 4 and constraint_size(run) <= 1e3 * floor
        change = correct(h, unit, run)
        if not change < 1e100:
            return NOT_FINITE
        if k > 0:
            contraction = change / former if former > 0.0 else 0.0
            if former > 100.0 * floor:
                memory[CONTRACTION], integers[UNSEEN] = contraction, 0
        left = change * contraction / (1.0 - contraction) if contraction < 0.9 else change
        if (
            left <= tolerance
            or change <= floor
            or (k > 2 and contraction > 0.3 and change <= max(1e3 * floor, stalled))
        ):
            return RUNNING
        if held and contraction > 0.3 and change <= SINGULAR_NOISE * size:
            return RUNNING  # close to a singular pose, where rounding is magnified; the constraints hold
        if k > 0 and contraction > 0.3 and former > 100.0 * floor and (not fresh or k % 3 == 0):
            integers[FRESH] = 0
        if k > 2 and contraction > 0.9 and tolerance > 0.0 and change > SINGULAR_NOISE * size:
            return DIVERGED  # with a shorter step it will be better
        former = change
    return DIVERGED


@rare
def constraint_size(run):
    """Largest violation of the constraints on positions, in all stages."""
    vectors, layout = run.vectors, run.layout
    value = 0.0
    for k in range(3):
        for i in range(layout[N_Q], layout[N_Q] + layout[N_PHI]):
            value = max(value, abs(vectors[RESIDUAL + k, i]))
    return value


@kernel
def sizes(length, run):
    """The size of the mechanism and its motion; memory[SPEED] follows the largest scaled velocity, and is not less than
    that which makes this way in the time that there is."""
    memory, vectors, layout = run.memory, run.vectors, run.layout
    size, speed = 1.0, 0.0
    for i in range(layout[N_Q]):
        size = max(size, abs(vectors[POSITION0, i]) * vectors[SCALE, i])
        speed = max(speed, abs(vectors[VELOCITY0, i]) * vectors[SCALE, i])
    memory[SPEED] = max(memory[SPEED], speed, 1.0 / length)
    return size


@rare
def first_step(length, strict, run):
    """A step in which the motion that is known at the start changes little."""
    vectors, layout = run.vectors, run.layout
    speed, force = 0.0, 0.0
    for i in range(layout[N_Q]):
        speed = max(speed, abs(vectors[VELOCITY0, i]) * vectors[SCALE, i])
        force = max(force, abs(vectors[UNKNOWN0, i]) * vectors[SCALE, i])
    rate = max(speed, force**0.5)
    return min(0.01 * length, strict**0.25 / rate) if rate > 0.0 else 0.01 * length


@kernel
def next_step(h, error, run):
    """The digital filter H211b of Soederlind, which does not answer to what changes from one step to the next; where
    the error is far from what is aimed at, what that alone says."""
    memory = run.memory
    now = AIM / max(error, 1e-8)
    ratio = now**0.25
    if memory[ERROR] > 0.0 and ratio < 2.0:
        ratio = (now * AIM / max(memory[ERROR], 1e-8)) ** (1.0 / 16.0) * (h / memory[LAST]) ** -0.25
    return h * min(max(ratio, SHRINK), GROW)


@rare
def record(t0, h, times, out, run):
    """Output times passed by this step: q and v by the polynomial of degree 5 that both have at three ends of steps (in
    the first step: with the accelerations at both ends), multipliers linearly."""
    memory, integers, vectors, layout = run.memory, run.integers, run.vectors, run.layout
    n, r = layout[N_Q], memory[LAST] / h
    while integers[OUTPUT] < times.size and times[integers[OUTPUT]] <= t0 + h + 1e-9 * h:
        k = integers[OUTPUT]
        x = min((times[k] - t0) / h, 1.0)
        if x > 1.0 - 1e-9:
            x = 1.0
        for i in range(n):
            q0, v0, q1, v1 = (
                vectors[POSITION0, i],
                h * vectors[VELOCITY0, i],
                vectors[POSITION, i],
                h * vectors[VELOCITY, i],
            )
            c2, c3 = 3.0 * (q1 - q0) - 2.0 * v0 - v1, 2.0 * (q0 - q1) + v0 + v1
            if integers[HISTORY] > 1:
                g, dg = (r * (1.0 + r)) ** 2, -2.0 * r * (1.0 + r) * (1.0 + 2.0 * r)
                off = vectors[QB, i] - (q0 - r * (v0 - r * (c2 - r * c3)))
                slope = h * vectors[VB, i] - (v0 - r * (2.0 * c2 - r * 3.0 * c3))
                b1 = (slope - dg * off / g) / g
                b0 = off / g + b1 * r
            else:
                b0 = h * h / 2.0 * vectors[UNKNOWN0, i] - c2
                b1 = h * h / 2.0 * vectors[STAGE + 2, i] - c2 - 3.0 * c3 - b0
            g, dg, b = (x * (1.0 - x)) ** 2, 2.0 * x * (1.0 - x) * (1.0 - 2.0 * x), b0 + b1 * x
            out[k, i] = q0 + x * (v0 + x * (c2 + x * c3)) + g * b
            out[k, n + i] = (v0 + x * (2.0 * c2 + x * 3.0 * c3) + dg * b + g * b1) / h
            if x == 1.0:
                out[k, i], out[k, n + i] = q1, vectors[VELOCITY, i]
        for i in range(n, layout[N_ALL]):
            out[k, n + i] = vectors[UNKNOWN0, i] + x * (vectors[STAGE + 2, i] - vectors[UNKNOWN0, i])
        integers[OUTPUT] += 1


@kernel
def shift(run):
    """The step becomes history."""
    vectors, layout = run.vectors, run.layout
    for i in range(layout[N_Q]):
        vectors[QB, i], vectors[VB, i], vectors[POSITION0, i], vectors[VELOCITY0, i] = (
            vectors[POSITION0, i],
            vectors[VELOCITY0, i],
            vectors[POSITION, i],
            vectors[VELOCITY, i],
        )
    for i in range(layout[N_ALL]):
        vectors[UNKNOWN0 + 1, i] = vectors[STAGE + 1, i]
        vectors[UNKNOWN0, i] = vectors[STAGE + 2, i]
        for k in range(3):
            vectors[PAST + k, i], vectors[PAST2 + k, i] = vectors[STAGE + k, i], vectors[STAGE2 + k, i]


@rare
def before_switch(status, error, h, run):
    """The part of the step just tried after which a switch changes that makes a difference; 1 if none does."""
    reals = run.reals
    if status == RUNNING:
        evaluate(reals[STEP_END], run)
    return until_switch(status, status == RUNNING and error <= UNNOTICED, h, run)


@rare
def see(t, run):
    """Switches and forces at the end of a step that is accepted."""
    integers, vectors, numbers, layout = run.integers, run.vectors, run.numbers, run.layout
    evaluate(t, run)
    integers[SIGNATURE] = signature(numbers, layout)
    for i in range(layout[N_Q]):
        vectors[FORCE0, i] = vectors[FORCE, i]


@kernel
def advance(steps, times, out, run):
    """At most ``steps`` steps, not counting rejected ones; a status. Everything needed to go on is in the buffers."""
    memory, reals, integers, layout = run.memory, run.reals, run.integers, run.layout
    tol, length = reals[TOL], reals[STOP] - reals[START]
    strict = STRICT * tol**0.8
    if integers[HISTORY] == 1:
        set_metric(run)
        if tol > 0.0:
            memory[CONTRACTION], memory[ERROR] = 1.0, 0.0
            reals[STEP_SIZE] = min(reals[STEP_SIZE], first_step(length, strict, run))
    for _ in range(steps):
        if (tol > 0.0 and reals[NOW] >= reals[STOP]) or (tol == 0.0 and integers[STEP] >= integers[LAST_STEP]):
            return DONE
        t0, h, end, tried, refused, error, former = (
            reals[START] + integers[STEP] * reals[STEP_SIZE],
            reals[STEP_SIZE],
            reals[STOP],
            0,
            0,
            0.0,
            0.0,
        )
        if tol > 0.0:
            t0, h, end = reals[NOW], min(reals[STEP_SIZE], reals[MOST_H]), min(reals[STOP], reals[NEXT_EVENT])
            if integers[ZONES] > 0:
                h = until_zone(h, run)
                if h == 0.0:
                    return LOOK
        while True:
            t = t0 + h
            if tol > 0.0 and end - t < h:  # it is hit exactly, with no short step before it
                left = end - t0
                h = left if left <= 1.01 * h else min(h, 0.5 * left)
                t = t0 + h if h < left else end
            elif tol == 0.0 and integers[STEP] == integers[LAST_STEP] - 1:
                t = reals[STOP]
            size = sizes(length, run)
            if memory[OF_MATRICES] != h:
                integers[FRESH] = 0
            tolerance, unit, stalled = (
                LEFT * tol * h / length,
                1.0 / memory[SPEED] if tol > 0.0 else h,
                STALLED * strict,
            )
            behind = integers[HISTORY] - 1 if tried == 0 else 1 - tried
            predict(h / memory[LAST] if integers[HISTORY] > 1 else 1.0, behind, run)
            early = max(0.0, t - reals[NEXT_EVENT]) if tol == 0.0 else 0.0  # units in the last place
            reals[STEP_END] = t - early
            status = newton(t0 - early, h, size, unit, tolerance, stalled, run)
            if status == SINGULAR and layout[SOLVER] == SPARSE_LU:
                return status  # once more with a search for pivots
            if tol == 0.0:
                if status == RUNNING:
                    break
                integers[FRESH], tried = 0, tried + 1
                if tried > 2:
                    return status
                continue
            if status == RUNNING:
                motion(2, h, run)
                error = estimate(h, memory[SPEED], run) / strict
            if integers[WATCHING]:
                part = before_switch(status, error, h, run)
                if part < 1.0:
                    if integers[CUT] == 0:
                        reals[UNCUT] = h
                    h *= part * (1.0 - min(0.5, SHORT_OF * 10.0 ** integers[CUT]))
                    if not h >= reals[LEAST_H]:
                        return EVENT
                    integers[CUT], integers[REJECTED] = integers[CUT] + 1, integers[REJECTED] + 1
                    continue
            if status == RUNNING:
                # A step that is shorter and errs no less errs by rounding.
                if error <= 1.0 or (refused > 1 and former <= error < NOISE):
                    break
                refused, former = refused + 1, error
                h *= max(SHRINK, (AIM / error) ** 0.25) if error < 1e300 else 0.1
            else:
                h *= 0.4 if status == DIVERGED else 0.25
                integers[FRESH], tried = 0, tried + 1 if tried < 1 else 1
            integers[REJECTED], integers[CUT] = integers[REJECTED] + 1, 0
            if h < reals[LEAST_H]:
                return status if status != RUNNING else TOO_SMALL
        motion(2, h, run)
        if integers[WATCHING]:
            see(t, run)
        if integers[EVERY]:
            times[integers[OUTPUT]] = t
        if integers[OUTPUT] < times.size and times[integers[OUTPUT]] <= t0 + h + 1e-9 * h:
            record(t0, h, times, out, run)
        shift(run)
        count_turns(run)
        if integers[NOTES] > 0:
            note(run)
        if tol > 0.0:
            reals[STEP_SIZE], reals[LAST_H] = next_step(h, error, run), h
            reals[NODES], reals[NODES + 1] = t, t0 + STAGES[1] * h
            if 0.95 <= reals[STEP_SIZE] / h <= 1.15 and memory[CONTRACTION] < SLOW:
                reals[STEP_SIZE] = h  # and the matrices are good for another one
            memory[ERROR] = error
        memory[LAST] = h
        if memory[CONTRACTION] > SLOW:
            integers[FRESH] = 0
        integers[HISTORY], integers[STEP], reals[NOW] = 2, integers[STEP] + 1, t
        if tol > 0.0 and (integers[CUT] > 0 or reals[NOW] >= reals[NEXT_EVENT]):
            return EVENT
        if tol == 0.0 and t > reals[NEXT_EVENT]:
            return EVENT
    if tol > 0.0:
        return DONE if reals[NOW] >= reals[STOP] else RUNNING
    return DONE if integers[STEP] >= integers[LAST_STEP] else RUNNING
