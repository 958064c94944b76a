"""The step of Radau IIA: the lengths of steps, and their repetition.

The end of a step is its last stage, where both levels of constraints hold. The length of steps is controlled by an
embedded formula and a digital filter. The equations: :mod:`mbdsl.integrators.methods.radau_stages`; ``R``, the
coefficients and rows of a method: :class:`mbdsl.integrators.methods.radau_coefficients.Scheme`. They are the
``formulas`` of the loop.

Source: Hairer, Wanner, Solving Ordinary Differential Equations II (1996), section IV.8; controller: Soederlind, ACM
Trans. Math. Softw. 29 (2003) 1-26.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.linear_solve import SPARSE_LU
from mbdsl.integrators.loop.run_data import evaluate
from mbdsl.integrators.loop.step_times import end_in_reach, end_of_step, representable
from mbdsl.integrators.loop.switch_location import length_before_switch, until_switch
from mbdsl.integrators.method import Method
from mbdsl.integrators.methods.radau_coefficients import QB
from mbdsl.integrators.methods.radau_matrices import COMPLEX
from mbdsl.integrators.methods.radau_newton import (
    CONTRACTION,
    ERROR,
    EXPONENT,
    KNOWN,
    LAST,
    PARABOLIC,
    SPEED,
    solve_step,
    strict,
)
from mbdsl.integrators.methods.radau_stages import estimate, finish, set_metric
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare
from mbdsl.system.switches import signature


def method(R, factor, power, exponent, measured, known):
    """The declaration of the method with the scheme ``R``, and its coefficients from FACTOR to KNOWN."""
    order = 2 * R.stages - 1
    return Method(
        f"radau{order}",
        doc=f"Radau IIA of order {order}, stabilised: positions and velocities on their constraints",
        order=order,
        index=2,
        enforces=("Phi", "dPhi"),
        family="Radau IIA",
        source="Hairer, Wanner (1996)" if R.stages == 3 else "Hairer, Wanner (1999)",
        coefficients=lambda options: (factor, power, exponent, measured, known),
        memory=lambda c, start: (0.0,) * 5,
        begin=lambda c, start: {L.UNKNOWN0: [*start.a, *start.lam]},
        sets=2,
        matrices=COMPLEX + R.stages - 1,
        own_reactions=False,
        steps=("controlled", "fixed"),
        rows=R.ROWS,
        past_positions=QB,
        second_rates=True,
    )


#: the tolerance of the embedded formula with more than three stages, relative to that of the result; a contraction is
#: measured there where changes are above so many times the smallest ones, as the eigenvectors magnify rounding
LOOSER, NOISY = 5.0, 1e4
#: contraction above which the next step starts with new matrices
SLOW = 0.02
#: contraction up to which steps become longer in space: the c with the least iterations for a time, 1/(c log(1/c))
CHEAPEST = 0.37
#: largest error that may be due to rounding, relative to what is allowed
NOISE = 100.0
#: error, relative to what is allowed, up to which a step may pass a corner of a force
UNNOTICED = 0.05
#: error aimed at, relative to what is allowed; smallest and largest ratio of successive step lengths
AIM, SHRINK, GROW = 0.5, 0.15, 6.0


# -- lengths of steps --------------------------------------------------------------------------------------------------


@rare
def first_step(run):
    """A length within which the motion at the start changes little [s]."""
    reals, vectors, layout, length = run.reals, run.vectors, run.layout, run.reals[S.STOP] - run.reals[S.START]
    speed, force, jerk = 1.0 / length, 0.0, 0.0
    for i in range(layout[L.N_Q]):
        speed = max(speed, abs(vectors[L.VELOCITY0, i]) * vectors[L.SCALE, i])
        force = max(force, abs(vectors[L.UNKNOWN0, i]) * vectors[L.SCALE, i])
        jerk = max(jerk, abs(vectors[L.UNKNOWN0, i] - vectors[L.UNKNOWN0 + 1, i]) * vectors[L.SCALE, i])
    rate = max(speed, force**0.5)
    if run.coefficients[EXPONENT] < 0.25:
        # at the start of a contact the force is zero; steps of high order would pass it in two steps, whose lengths
        # other conditions determine, so that runs with different tolerances would have the same error
        rate = max(rate, (jerk / (reals[S.NODES] - reals[S.NODES + 1]) / speed) ** 0.5)
    # of runs with different tolerances the first steps differ, so that their difference shows the error behind an event
    longest = 0.01 * length * (1e4 * run.reals[S.TOL]) ** run.coefficients[EXPONENT]
    return min(longest, strict(run) ** run.coefficients[EXPONENT] / rate)


@kernel
def trial_length(run):
    """The length to try [s]."""
    memory, reals = run.memory, run.reals
    first = run.integers[S.HISTORY] == 1
    if first:
        set_metric(run)
    if reals[S.TOL] == 0.0:
        return reals[S.STEP_SIZE]
    if first:
        memory[CONTRACTION], memory[ERROR] = 1.0, 0.0
        reals[S.STEP_SIZE] = min(reals[S.STEP_SIZE], first_step(run))
    return min(reals[S.STEP_SIZE], reals[S.MOST_H])


@kernel
def fitted(t0, h, run):
    """The length, at most about h, with which the end is reached without a short last step [s]."""
    end = end_in_reach(run)
    if end - (t0 + h) < h:
        left = end - t0
        if left <= 1.01 * h:
            return left
        h = min(h, 0.5 * left)
    return representable(h, run)


@kernel
def filtered_length(h, error, run):
    """The next length by Soederlind's digital filter H211b, which smooths variations of the error; without the filter
    where the error is far from the aim."""
    memory, power = run.memory, run.coefficients[EXPONENT]
    now = AIM / max(error, 1e-8)
    ratio = now**power
    if memory[ERROR] > 0.0 and ratio < 2.0:
        ratio = (now * AIM / max(memory[ERROR], 1e-8)) ** (0.25 * power) * (h / memory[LAST]) ** -0.25
    return h * min(max(ratio, SHRINK), GROW)


@kernel
def next_length(error, h, times, formulas, run):
    """Set the length of the next step; decide whether it starts with new matrices."""
    memory, reals = run.memory, run.reals
    if reals[S.TOL] > 0.0:
        new = filtered_length(h, error, run)
        if run.layout[L.N_ROTATIONS] > 0 and run.integers[S.UNSEEN] == 0:
            # the contraction is about proportional to h: a spinning body needs a new matrix in every step
            new = min(new, h * max(1.0, CHEAPEST / memory[CONTRACTION]))
        keep = 0.95 <= new / h <= 1.15 and memory[CONTRACTION] < SLOW  # the matrices can be kept for another step
        reals[S.STEP_SIZE], reals[S.LAST_H], memory[ERROR] = h if keep else new, h, error
    memory[LAST] = h
    if memory[CONTRACTION] > SLOW and run.integers[S.UNSEEN] <= run.coefficients[KNOWN]:
        run.integers[S.FRESH] = 0


# -- the step ----------------------------------------------------------------------------------------------------------


@rare
def before_switch(status, error, h, run):
    """The part of the step just tried after which a switch changes that makes a difference; 1 if none does."""
    reals = run.reals
    if status == S.RUNNING:
        evaluate(reals[S.STEP_END], run)
    return until_switch(status, status == S.RUNNING and error <= UNNOTICED, h, run)


@rare
def update_switches(run):
    """Switches and forces at the end of an accepted step."""
    integers, vectors, numbers, layout = run.integers, run.vectors, run.numbers, run.layout
    evaluate(run.reals[S.STEP_END], run)
    integers[S.SIGNATURE] = signature(numbers, layout)
    for i in range(layout[L.N_Q]):
        vectors[L.FORCE0, i] = vectors[L.FORCE, i]


@kernel
def take_fixed(R, t0, h, run):
    """Try a step of fixed length up to three times; a status."""
    reals, integers = run.reals, run.integers
    end = reals[S.STOP] if integers[S.STEP] == integers[S.LAST_STEP] - 1 else t0 + h
    early = max(0.0, end - reals[S.NEXT_EVENT])  # some units in the last place
    reals[S.STEP_END] = end - early
    status = S.DIVERGED
    for attempt in range(3):
        status = solve_step(R, attempt, t0 - early, h, run)
        if status == S.RUNNING or (status == S.SINGULAR and run.layout[L.SOLVER] == SPARSE_LU):
            break
        integers[S.FRESH] = 0
    return status


@kernel
def take_controlled(R, t0, h, run):
    """Try shorter and shorter steps until one is accepted; status, length and error."""
    memory, reals, integers = run.memory, run.reals, run.integers
    attempt, refused, error, former, allowed = 0, 0, 0.0, 0.0, strict(run)
    while True:
        h = fitted(t0, h, run)
        end_of_step(t0, h, run)
        status = solve_step(R, attempt, t0, h, run)
        if status == S.SINGULAR and run.layout[L.SOLVER] == SPARSE_LU:
            return status, h, error  # the run continues with the dense solver
        if status == S.RUNNING:
            finish(R, h, run)
            error = estimate(R, h, memory[SPEED], run) / allowed
        if integers[S.WATCHING]:
            part = before_switch(status, error, h, run)
            if part < 1.0:
                h = length_before_switch(part, h, run)
                if h == 0.0:
                    return S.EVENT, h, error
                continue
        if status == S.RUNNING:
            # If a shorter step has no smaller error, the error is due to rounding.
            if error <= 1.0 or (refused > 1 and former <= error < NOISE):
                return S.RUNNING, h, error
            refused, former = refused + 1, error
            h *= max(SHRINK, (AIM / error) ** run.coefficients[EXPONENT]) if error < 1e300 else 0.1
        else:
            if attempt != 1:  # each length is tried from constant accelerations and with soft constraints
                h *= 0.4 if status == S.DIVERGED else 0.25
            integers[S.FRESH], attempt = 0, PARABOLIC if attempt == 1 else 1
        integers[S.REJECTED], integers[S.CUT] = integers[S.REJECTED] + 1, 0
        if h < reals[S.LEAST_H]:
            return status if status != S.RUNNING else S.TOO_SMALL, h, error


@kernel
def take(t0, h, formulas, run):
    """Take a step of about length h from t0; status, length and error relative to what is allowed."""
    status, error = S.RUNNING, 0.0
    if run.reals[S.TOL] > 0.0:
        status, h, error = take_controlled(formulas, t0, h, run)
    else:
        status = take_fixed(formulas, t0, h, run)
    if status == S.RUNNING:
        finish(formulas, h, run)
        if run.integers[S.WATCHING]:
            update_switches(run)
    return status, h, error
