"""The step loop of all compiled methods: zones, output, history, turns, records for later searches, counters, events.

A method supplies its step as the five kernels of :class:`mbdsl.integrators.loop.run_data.Step`:

    trial_length(run)                            the length to try [s]
    take(t0, h, formulas, run)                   status, length and error of a step from t0; RETRY: try a shorter one
    interpolate(k, x, h, out, run)               q and v at the part x of the step, into row k of ``out``
    store(h, run)                                the step becomes history
    next_length(error, h, times, formulas, run)  sets the length of the next step

Most methods have one system of equations per step and share the step of :mod:`mbdsl.integrators.loop.multistep`, which
is made of their ``formulas``. ``run`` is a :class:`mbdsl.integrators.loop.run_data.RunData`.
The loop is compiled once per method and allocates nothing.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.rotation_chart import leave_chart, move_charts
from mbdsl.integrators.loop.step_times import at_stop, finished, passed, start_of_step
from mbdsl.integrators.loop.switch_location import near_switch
from mbdsl.integrators.loop.ticks import full, tick
from mbdsl.integrators.loop.turn_counting import count_turns
from mbdsl.integrators.loop.zone_landing import note, until_zone
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare

#: most successive steps that end before a switch without an event; after these, events look for a standstill
MOST_PASSED = 20


@rare
def record(t0, h, times, out, step, run):
    """Output at the times passed by this step: q and v by the method's interpolation, multipliers linearly."""
    integers, vectors, layout = run.integers, run.vectors, run.layout
    n, size = layout[L.N_Q], layout[L.N_ALL]
    end = passed(t0, h, run)
    while integers[S.OUTPUT] < times.size and times[integers[S.OUTPUT]] <= end:
        k = integers[S.OUTPUT]
        x = (times[k] - t0) / h
        if x > 1.0 - 1e-9:
            x = 1.0
            for i in range(n):
                out[k, i], out[k, n + i] = vectors[L.POSITION, i], vectors[L.VELOCITY, i]
        else:
            step.interpolate(k, x, h, out, run)
        for i in range(n, size):
            out[k, n + i] = vectors[L.UNKNOWN0, i] + x * (vectors[L.UNKNOWN, i] - vectors[L.UNKNOWN0, i])
        leave_chart(out[k], run)
        integers[S.OUTPUT] += 1


@kernel
def advance(step, formulas, steps, times, out, run):
    """Take at most ``steps`` steps, each RETRY counted; a status. All that is needed to continue is in the buffers.

    RUNNING is also returned if there is no room to record the end of a further step.
    """
    reals, integers = run.reals, run.integers
    for _ in range(steps):
        if finished(run):
            return S.DONE
        if integers[S.NOTES] > 0 and integers[S.NOTED] >= integers[S.NOTES]:
            return S.RUNNING
        if full(run):
            return S.FULL
        if integers[S.MARGIN] > 0 and times.size - integers[S.OUTPUT] < integers[S.MARGIN]:
            return S.FULL
        h = step.trial_length(run)
        if integers[S.ZONES] > 0:
            h = until_zone(h, run)
            if h == 0.0:
                return S.LOOK
        t0 = start_of_step(run)
        status, h, error = step.take(t0, h, formulas, run)
        if status == S.RETRY:
            continue
        if status != S.RUNNING:
            return status
        if integers[S.EVERY]:
            times[integers[S.OUTPUT]] = reals[S.STEP_END]
        if integers[S.OUTPUT] < times.size and times[integers[S.OUTPUT]] <= passed(t0, h, run):
            record(t0, h, times, out, step, run)
        step.store(h, run)
        count_turns(run)
        move_charts(run)
        if integers[S.NOTES] > 0:
            note(run)
        integers[S.HISTORY], integers[S.STEP] = (
            min(integers[S.HISTORY] + 1, L.PAST + integers[S.OLDER]),
            integers[S.STEP] + 1,
        )
        reals[S.NOW] = reals[S.STEP_END]
        step.next_length(error, h, times, formulas, run)
        if reals[S.NOW] >= reals[S.NEXT_EVENT]:
            if run.layout[L.TICKS] == 0 or not tick(run):
                return S.EVENT
            if at_stop(run) and integers[S.EVERY]:
                times[integers[S.OUTPUT] - 1] = reals[S.STOP]
            continue
        if integers[S.CUT] > 0:
            if integers[S.PASSED] == MOST_PASSED or near_switch(h, run):
                integers[S.PASSED] = 0
                return S.EVENT
            integers[S.PASSED], integers[S.CUT] = integers[S.PASSED] + 1, 0
    return S.DONE if finished(run) else S.RUNNING
