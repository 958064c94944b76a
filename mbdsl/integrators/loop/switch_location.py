"""Location of switch changes within a step; the step is then repeated so that it ends shortly before the change.

An implicit step sees only the force at its end. A step across a switch therefore has the error of a switch that changes
at the start of the step, and its end shows little more than that the switch has changed. The time of the change is
located on the motion extrapolated from the start of the step, with the acceleration there and its rate. The step is
repeated up to shortly before that time, and :mod:`mbdsl.integrators.events` restarts the run behind the switch.

A step is not repeated if forces have a corner and no jump, and its error is accepted: a corner does not affect methods
of order 2. If forces jump, a step across the switch may have no solution. Therefore switches are also located in steps
for which Newton's iteration has failed.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.run_data import evaluate
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import rare
from mbdsl.system.switches import signature

#: distance between the end of the repeated step and the switch, relative to that from the start of the step; ten times
#: as much at each further attempt
SHORT_OF = 1e-4
#: tolerance of the located time, relative to its distance from the start of the step
CLOSE = 1e-6
#: relative change of a force below which it has a corner and no jump
JUMP = 1e-4
#: a rejected step ends at a corner if at least this part of the step lies before it
WORTH = 0.01
#: largest remaining time to a switch, relative to the last step, at which it is an event
LEFT = 1e-3
#: the part of a zone after which steps of ordinary methods end, and what is added to that of others for the part of the
#: way to a switch
MIDDLE, EARLIER = 0.5, 0.25
#: the part of a step that is tried if it has no solution, and friction sticks
NEARER = 0.9
#: values of WATCHING: BEHIND if switches read reactions: the last correction of a step may change them more than a
#: little, and switches are evaluated after it; REACTIONS if, besides, steps across an event may have no solution or
#: reactions that lag; TURNING if, besides, joints stick that slide in several directions
BEHIND, REACTIONS, TURNING = 2, 3, 4
#: motion on which switches are located: extrapolated from the start of the step, or interpolated to its computed end
ON, BETWEEN = 0, 1


@rare
def look(motion, x, h, run):
    """The signature of the switches after the part x of the step, on the ``motion`` ON or BETWEEN.

    Reads the computed end of the step from BEFORE and BEFORE2; writes POSITION, VELOCITY, the multipliers that laws
    read, and the results of ``evaluate``.
    """
    reals, vectors, numbers, layout = run.reals, run.vectors, run.numbers, run.layout
    n, row, a, d = (
        layout[L.N_Q],
        layout[L.LAW_ROW],
        L.UNKNOWN0 + L.PAST * (layout[L.ACCELERATION] - L.UNKNOWN),
        reals[S.NODES] - reals[S.NODES + 1],
    )
    s = x * h
    for i in range(n):
        q0, v0, q1, v1 = (
            vectors[L.POSITION0, i],
            h * vectors[L.VELOCITY0, i],
            vectors[L.BEFORE, i],
            h * vectors[L.BEFORE2, i],
        )
        c2, c3 = 3.0 * (q1 - q0) - 2.0 * v0 - v1, 2.0 * (q0 - q1) + v0 + v1
        if motion == ON:
            jerk = (vectors[a, i] - vectors[a + 1, i]) / d
            c2, c3 = h * h / 2.0 * (vectors[a, i] + (reals[S.NOW] - reals[S.NODES]) * jerk), h * h * h / 6.0 * jerk
        vectors[L.POSITION, i] = q0 + x * (v0 + x * (c2 + x * c3))
        vectors[L.VELOCITY, i] = (v0 + x * (2.0 * c2 + x * 3.0 * c3)) / h
    for i in range(n, layout[L.N_ALL]):
        lam = vectors[L.UNKNOWN0 + L.PAST * (row - L.UNKNOWN) if row <= L.UNKNOWN2 else L.KEPT2, i]
        vectors[row, i] = lam if motion == ON else lam + x * (vectors[L.BEFORE, i] - lam)
    evaluate(reals[S.NOW] + s, run)
    return signature(numbers, layout)


@rare
def jumps(motion, low, high, h, run):
    """Whether a force jumps between the close parts ``low`` and ``high`` of the step.

    The change is relative to the largest force there and at the ends of the step, in rows FORCE0 and E_V. Overwrites
    E_Q, and the rows that ``look`` writes.
    """
    vectors, layout = run.vectors, run.layout
    n = layout[L.N_Q]
    look(motion, low, h, run)
    for i in range(n):
        vectors[L.E_Q, i] = vectors[L.FORCE, i]
    look(motion, high, h, run)
    found = False
    for i in range(n):
        size = max(
            max(abs(vectors[L.FORCE, i]), abs(vectors[L.E_Q, i])),
            max(abs(vectors[L.FORCE0, i]), abs(vectors[L.E_V, i])),
        )
        found = found or not abs(vectors[L.FORCE, i] - vectors[L.E_Q, i]) <= JUMP * size
    return found


@rare
def evaluate_behind(t, run):
    """Evaluate the end of a step at time t after its last correction; keep its forces if no switch has changed.

    Overwrites E_V and TEMPORARY2.
    """
    vectors, size = run.vectors, run.layout[L.N_ALL]
    for i in range(size):
        vectors[L.E_V, i], vectors[L.TEMPORARY2, i] = vectors[L.FORCE, i], vectors[L.FORCE2, i]
    evaluate(t, run)
    if signature(run.numbers, run.layout) == run.integers[S.SIGNATURE]:
        for i in range(size):
            vectors[L.FORCE, i], vectors[L.FORCE2, i] = vectors[L.E_V, i], vectors[L.TEMPORARY2, i]


@rare
def until_switch(status, accepted, h, run):
    """The part of the step just tried after which a switch changes; 1 if the step is not to be cut short.

    Reads the registers of the last evaluation of the step. If the result is 1, the rows with the end of an ``accepted``
    step are the same as before; other rows (BEFORE, BEFORE2, E_Q, E_V, TEMPORARY2) are overwritten.
    """
    reals, integers, vectors, numbers, layout = run.reals, run.integers, run.vectors, run.numbers, run.layout
    n, size, row, old, found = (
        layout[L.N_Q],
        layout[L.N_ALL],
        layout[L.LAW_ROW],
        integers[S.SIGNATURE],
        status == S.RUNNING,
    )
    if found and signature(numbers, layout) == old:
        return 1.0
    for i in range(size):
        vectors[L.BEFORE, i], vectors[L.BEFORE2, i] = (
            vectors[L.POSITION, i] if i < n else vectors[row, i],
            vectors[L.VELOCITY, i],
        )
        vectors[L.E_V, i], vectors[L.TEMPORARY2, i] = vectors[L.FORCE, i], vectors[L.FORCE2, i]
    motion = ON
    if look(ON, 1.0, h, run) == old:
        if not found:  # sliding may end within the step, beyond which there is no solution
            return NEARER if integers[S.WATCHING] == REACTIONS else 1.0
        motion = BETWEEN
    low, high = 0.0, 1.0
    while high - low > CLOSE * high and high * h > reals[S.LEAST_H]:
        middle = 0.5 * (low + high)
        if look(motion, middle, h, run) == old:
            low = middle
        else:
            high = middle
    corner = integers[S.CORNERS] > 0 and not jumps(motion, low, high, h, run)
    if not corner or (not accepted and low > WORTH):
        return low
    if not accepted:
        return 1.0
    integers[S.SIGNATURE] = look(BETWEEN, 1.0, h, run)
    for i in range(size):
        if i < n:
            vectors[L.POSITION, i], vectors[L.VELOCITY, i] = vectors[L.BEFORE, i], vectors[L.BEFORE2, i]
        else:
            vectors[row, i] = vectors[L.BEFORE, i]
        vectors[L.FORCE, i], vectors[L.FORCE2, i] = vectors[L.E_V, i], vectors[L.TEMPORARY2, i]
    return 1.0


@rare
def length_before_switch(part, h, run):
    """The length of the next attempt, which ends shortly before the switch after ``part`` of h; 0 if it is too short.

    The first attempt leaves SHORT_OF of the way, each further one ten times as much. With methods of high order, the
    first such step after a restart ends earlier, at a part of the way that depends on the tolerance: the motion alone
    would determine the steps in a contact, and runs with different tolerances would have the same error.
    """
    reals, integers = run.reals, run.integers
    if integers[S.CUT] == 0:
        reals[S.UNCUT] = h
    new = part * (1.0 - min(0.5, SHORT_OF * 10.0 ** integers[S.CUT])) * h
    if integers[S.AIMED] == 0 and reals[S.WITHIN] != MIDDLE:
        new *= reals[S.WITHIN] + EARLIER
    integers[S.AIMED] = 1
    if not new >= max(reals[S.LEAST_H], reals[S.SLIVER] * reals[S.GRID]):
        return 0.0
    integers[S.REJECTED] += 1
    integers[S.CUT] += 1
    return new


@rare
def near_switch(h, run):
    """Whether a switch changes at the end of a step of length h, which is the last one of the history, or soon after.

    The switch that the step was cut short for is located by extrapolation from the start of the step.
    """
    reals, vectors, layout = run.reals, run.vectors, run.layout
    n, size, row, old = layout[L.N_Q], layout[L.N_ALL], layout[L.LAW_ROW], run.integers[S.SIGNATURE]
    for i in range(size):
        vectors[L.BEFORE, i], vectors[L.BEFORE2, i] = (
            vectors[L.POSITION, i] if i < n else vectors[row, i],
            vectors[L.VELOCITY, i],
        )
        vectors[L.E_V, i], vectors[L.TEMPORARY2, i] = vectors[L.FORCE, i], vectors[L.FORCE2, i]
    near = look(ON, 0.0, h, run) != old or look(ON, LEFT, h, run) != old
    for i in range(size):
        if i < n:
            vectors[L.POSITION, i], vectors[L.VELOCITY, i] = vectors[L.BEFORE, i], vectors[L.BEFORE2, i]
        else:
            vectors[row, i] = vectors[L.BEFORE, i]
    evaluate(reals[S.NOW], run)
    for i in range(size):
        vectors[L.FORCE, i], vectors[L.FORCE2, i] = vectors[L.E_V, i], vectors[L.TEMPORARY2, i]
    return near
