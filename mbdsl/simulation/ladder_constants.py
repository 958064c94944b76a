"""The constants of a ladder of runs: runs with decreasing steps or tolerances, and the error that they show.

The runs are those of the tolerance calibration (:mod:`mbdsl.simulation.tolerance_calibration`), whose sizes are
tolerances ``eps`` of the method, and those of an accuracy (:mod:`mbdsl.studies.ladder`), whose sizes are steps or
tolerances.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class LadderConstants:
    """Numbers without a unit, unless one is given."""

    # -- every ladder
    aim: float = 0.5  #: target of the error over the tolerance: the next run should not miss it by a little
    saturated: float = 0.05  #: difference of two runs above which it does not measure their errors any more
    falls: float = 0.7  #: the runs converge if further runs reduce the difference, or the error, to this part of it
    # -- sizes of calibration runs
    first: float = 1024.0  #: first eps over the tolerance, order 1 and 2: a cheap run that shows the order
    first_of_high_order: float = 64.0  #: the same for other methods, whose longer steps show no order
    loosest: float = 4e-3  #: largest first eps: with a larger one steps do not resolve the motion
    strictest: float = 1e-7  #: least first eps, order 1 and 2: the run shows whether less would take too many steps
    ratio: float = 8.0  #: ratio of successive eps: a step of a method of order 2 becomes half as long
    nearest: float = 4.0  #: least ratio of successive eps: closer runs differ too little to show an order
    doubtful: float = 0.5  #: order in eps below which the needed eps cannot be extrapolated
    least: float = 1e-5  #: least eps over the tolerance: runs that need less are said not to converge
    least_of_high_order: float = 1e-10  #: the same for methods of order above 5, whose errors fall irregularly
    most_runs: int = 14  #: largest number of runs
    most_steps: float = 2e7  #: most steps expected of a run: half a minute at 1.5 us a step
    # -- what two runs show
    chance: float = 3.0  #: factor by which a claim may be too small because two runs agree by chance
    chance_of_backends: float = 30.0  #: the same for backends: changes of order and step make errors fall irregularly
    least_fall: float = 1.25  #: least factor by which the error counts as reduced from one run to the next
    least_fall_with_events: float = 1.01  #: the same of a model with events, which may cut all steps of both runs
    least_order: float = 1.0 / 3.0  #: least order in eps that three runs show: less is due to chance
    most_order: float = 1.0  #: largest order in eps: the local error is held to eps
    points: int = 200  #: least number of times at which runs are compared
    most_compared: int = 10_000  #: largest number of times at which runs are compared, because they are kept
    dense: int = 512  #: largest number of outputs in a step, with more than ``most_compared`` outputs
    together: float = 1e-3  #: two runs that fail within this part of the run of each other fail at the same time
    # -- amplified rounding
    grown: float = 10.0  #: logarithm of the amplification above which steps have to resolve its rate
    resolved: float = 0.5  #: largest product of that rate and a step
    shortest: float = 2e-4  #: shortest such step, relative to the run: more steps would cost more than they show
    finer: tuple[int, ...] = (4, 32)  #: how many times finer the growth is sampled before it ends a run, in turn
    settled: float = 0.1  #: relative change of its logarithm below which finer samples change nothing
    most_numbers: float = 5e7  #: numbers in all steps of a run above which they are not stored for that: 400 MB
    # -- runs of an accuracy
    most_of_accuracy: int = 12  #: largest number of runs of a method
    most_blind: int = 6  #: the same if all of them are identical, so that they show no error
    credit: float = 100.0  #: largest reduction of the error that a further run aims at: the order may be lower
    rounding: float = 1e-6  #: errors below this that do not decrease any more are due to rounding
    most_seconds: float = 600.0  #: longest expected time of a run [s], or relative to the first run if that is longer
    wavers: float = 0.3  #: an observed order this much below the declared one shows that steps are still too long


LADDER = LadderConstants()


def order_bounds(
    sizes: Sequence[float], differences: Sequence[float], low: float, high: float, halvings: int
) -> tuple[float, float]:
    """Bounds of the order p of errors C h^p, from the two differences of solutions at three sizes, by bisection.

    (h_1^p - h_2^p) / (h_2^p - h_3^p) increases with p, and is the ratio of the differences. ``low`` and ``high`` are
    the first bounds.
    """
    one, two = differences
    r, s = sizes[0] / sizes[1], sizes[2] / sizes[1]
    for _ in range(halvings):
        p = 0.5 * (low + high)
        low, high = (p, high) if (r**p - 1.0) * two < one * (1.0 - s**p) else (low, p)
    return low, high
