"""Names for what a run keeps in ``reals`` and ``integers``, and for what its loop answers."""

from __future__ import annotations

# -- status --------------------------------------------------------------------------------------------------
RUNNING, DONE, SINGULAR, DIVERGED, NOT_FINITE, TOO_LARGE, TOO_SMALL, SLIDING, EVENT, LOOK = range(10)

# -- reals of the run ----------------------------------------------------------------------------------------
START, STOP, STEP_SIZE, STEP_END, CONTRACTION, VELOCITY_TOL, RELATIVE_TOL, LOOSEST, UNIT, WILD = range(10)
# of controlled steps: the time reached; tolerance; largest velocity so far; the step before, the shortest and the
# longest allowed; 1/(order + 1); where in a step its accelerations belong; factor on M in the iteration matrix; the
# largest displacement; time within which velocities may forget; factor on h D
NOW, TOL, SPEED, LAST_H, LEAST_H, MOST_H, EXPONENT, NODE, MASS_WEIGHT, LARGEST, FORGOTTEN, DAMPING = range(10, 22)
NODES, TIMES = 22, 26  #: times that the unknowns of the last four steps belong to: accelerations, multipliers
# of switches: the next time that is known beforehand; the step before it was cut short
NEXT_EVENT, UNCUT = 30, 31
#: zones in which a step has to end: start and end of each, so many at once (:mod:`mbdsl.integrators.loop.zone_landing`)
ZONE, ROOM = 32, 32
REALS = ZONE + 2 * ROOM

# -- integers of the run -------------------------------------------------------------------------------------
STEP, LAST_STEP, ITERATIONS, MATRICES, FACTORISATIONS, OUTPUT, FRESH, HISTORY, ORDER, STABILISED, UNSEEN = range(11)
# of controlled steps: whether they are; rejected ones; those since the start, or since the last one that was changed in
# length; in a row rejected; whether every step is output, or ends at the next output at most;
# where dampers are stiff, after how many steps what they take away is looked at; for how many steps corrections in the
# last digit are known to be rounding
CONTROLLED, REJECTED, SINCE, SAME, IN_A_ROW, EVERY, LANDING, DAMPED, ROUNDING = range(11, 20)
# of switches: whether they are watched, their signature, whether corners may be passed, how often the step was cut
# short, and events
WATCHING, SIGNATURE, CORNERS, CUT, EVENTS = range(20, 25)
# of zones: which is next, how many are known; states that are noted behind the other reals, and room for how many
NEXT_ZONE, ZONES, NOTED, NOTES = range(25, 29)
INTEGERS = 29
#: what statistics call them
COUNTERS = {
    "rejected": REJECTED,
    "events": EVENTS,
    "iterations": ITERATIONS,
    "matrix_evaluations": MATRICES,
    "factorisations": FACTORISATIONS,
}
