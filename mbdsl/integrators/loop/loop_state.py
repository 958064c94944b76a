"""Names of the statuses that a step loop returns, and of the entries of a run's buffers ``reals`` and ``integers``."""

# -- status --------------------------------------------------------------------------------------------------
# EVENT: a step has ended at a known time or shortly before a switch; LOOK: ``reals`` holds no further zone; RETRY: a
# shorter step is to be tried; FULL: there may be too little room for the output of the next step; STIFF: stability
# limits the steps of an explicit method
RUNNING, DONE, SINGULAR, DIVERGED, NOT_FINITE, TOO_LARGE, TOO_SMALL, SLIDING, EVENT, LOOK, RETRY, FULL = range(12)
STIFF = 12
#: an assertion of the model does not hold; when-equations act without end at one time
ASSERTED, ENDLESS, UNSOLVED = 13, 14, 15

# -- reals of the run ----------------------------------------------------------------------------------------
# times of start and stop; step size; time at the end of the step; contraction of Newton's iteration; its tolerances,
# relative to h times the speed, to the local error and to the mechanism's size; factor from unknowns to positions;
# largest change of an unknown over a step, as a position
START, STOP, STEP_SIZE, STEP_END, CONTRACTION, VELOCITY_TOL, RELATIVE_TOL, LOOSEST, UNIT, WILD = range(10)
# of controlled steps: time reached; tolerance; largest scaled velocity so far; sizes of the last step, the smallest and
# the largest allowed step; 1/(order + 1); time of accelerations within a step, relative to the step; factor on M in the
# iteration matrix; largest displacement in kinematics; time in which dampers may remove errors of velocities; factor on
# h D in the iteration matrix
NOW, TOL, SPEED, LAST_H, LEAST_H, MOST_H, EXPONENT, NODE, MASS_WEIGHT, LARGEST, FORGOTTEN, DAMPING = range(10, 22)
NODES, TIMES = 22, 26  #: times of the accelerations, and of the multipliers, of the last four steps, newest first
# of estimates of the error: the raw error of the last complete estimate, and the part of it that counts
RAW, REDUCED = 32, 33
GOOD, BAD = 34, 35  #: errors, relative to the allowed one, between which the step size is kept
# of switches: next known time of an event; step size before the step was cut short
NEXT_EVENT, UNCUT = 30, 31
RADIUS = 36  #: h |lambda| of the last step, lambda the largest eigenvalue; of explicit methods
WITHIN = 37  #: the part of a zone after which a step that would pass over it ends; see ``peak_zones.landing_part``
#: start and end of the next zones, and the number of zones held (:mod:`mbdsl.integrators.loop.zone_landing`)
ZONE, ROOM = 38, 32
# of fixed steps that end at events: the step of the grid, 0 for other steps; part of it below which no step is taken
GRID, SLIVER = ZONE + 2 * ROOM, ZONE + 2 * ROOM + 1
KNOWN = SLIVER + 1  #: the next known event that is no tick of a clock, as NEXT_EVENT
REALS = KNOWN + 1

# -- integers of the run -------------------------------------------------------------------------------------
# steps done, and their total number; Newton iterations; matrix evaluations; factorisations; outputs written; whether
# the iteration matrix can be used (0: it has to be renewed); steps in the history; order of extrapolation; whether
# UNKNOWN2 is used; steps since the contraction was measured
STEP, LAST_STEP, ITERATIONS, MATRICES, FACTORISATIONS, OUTPUT, FRESH, HISTORY, ORDER, STABILISED, UNSEEN = range(11)
# of controlled steps: whether steps are controlled; rejected steps; steps since the start, and since the last change of
# the step size; successive rejections; whether every step is output; whether no step passes over an output time;
# complete estimates until the effect of stiff dampers is evaluated; steps for which corrections in the last digit count
# as rounding
CONTROLLED, REJECTED, SINCE, SAME, IN_A_ROW, EVERY, LANDING, DAMPED, ROUNDING = range(11, 20)
# of switches: whether there are any; their signature; whether all are switches of forces, so that corners may be
# passed; number of times that the present step was cut short; number of events
WATCHING, SIGNATURE, CORNERS, CUT, EVENTS = range(20, 25)
# of zones: index of the next zone; number of zones in ``reals``; number of states recorded behind the other reals, and
# its limit
NEXT_ZONE, ZONES, NOTED, NOTES = range(25, 29)
# number of rows that must be free in the output before a step; 0: all rows of the run have room
MARGIN = 29
# number of steps before the last ``PAST`` ones whose unknowns the prediction uses, 0 or 2; they are in the last rows
# of ``vectors``
OLDER = 30
TRUSTED = 31  #: number of further steps for which the part that counts may be that of the last complete estimate
# numbers of the iteration matrices with which the last matrix and the one before it belong; the second is negative if
# dampers are not stiff
OTHERS, DAMPERS = 32, 33
COUPLED = 34  #: whether corrections are those of the full system (:mod:`mbdsl.integrators.loop.coupled_correction`)
SOFT = 35  #: whether matrices of Radau IIA correct little along nearly dependent constraints
PASSED = 36  #: successive steps that were cut short before a switch which is farther away than expected
AIMED = 37  #: whether a step was cut short since the last restart
#: number of steps after which recorded states are dropped that follow from others (:mod:`.thinned_records`); 0: never
THIN = 38
INTEGERS = 39
#: name in the statistics -> index in ``integers``
COUNTERS = {
    "rejected": REJECTED,
    "events": EVENTS,
    "iterations": ITERATIONS,
    "matrix_evaluations": MATRICES,
    "factorisations": FACTORISATIONS,
}
