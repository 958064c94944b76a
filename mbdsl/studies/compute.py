"""One run of a study, in the present process."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import singledispatch

import numpy as np

from mbdsl.errors import MbdslError
from mbdsl.simulation.simulate import simulated
from mbdsl.simulation.stored_events import EVENTS, text_of
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.storage.compilation_notice import silent
from mbdsl.studies.cases import ENDS, Case, Setting, output_interval
from mbdsl.studies.store import OUT_OF_MEMORY, OUT_OF_TIME, Computed
from mbdsl.studies.time_limits import Deadline, TooLong


def simulate_case(of: Setting, case: Case, progress=None, announce=None) -> Trajectory:
    """The trajectory of a case."""
    with silent():  # the first run of a study announces the compilation
        return simulated(
            of.scene,
            method=case.method,
            step=case.step,
            tol=case.tol,
            start=of.start,
            stop=of.stop,
            interval=output_interval(of, case),
            options=dict(case.options),
            progress=progress,
            announce=announce,
        )


def attempted(case: Case, run: Callable[[], Computed], deadline: Deadline | None = None) -> Computed:
    """The result of ``run``, or the problem of a run that failed; with the time that it took if ``deadline`` ended
    it."""
    try:
        return run()
    except TooLong:
        spent = deadline.spent if deadline is not None else {}
        return Computed(case, stats={"seconds": spent} if spent else {}, problem=OUT_OF_TIME)
    except MbdslError as problem:
        return Computed(case, problem=problem.message)
    except MemoryError:
        return Computed(case, problem=OUT_OF_MEMORY)
    except (ArithmeticError, ValueError) as problem:  # exceptions of third-party code
        return Computed(case, problem=f"{type(problem).__name__}: {problem}")


@singledispatch
def compute(
    of: Setting, case: Case, limit: float = math.inf, announce=None, left: float = math.inf, compiling: float = 0.0
) -> Computed:
    """One run, successful or not, within the limits of a :class:`Deadline`. A kind of setting can register a
    computation of its own.

    Raises
    ------
    KeyboardInterrupt
    """
    if min(limit, left) <= 0.0:
        return Computed(case, problem=OUT_OF_TIME)
    deadline = Deadline(limit, left, compiling)

    def run() -> Computed:
        found = deadline.run(lambda: simulate_case(of, case, deadline, deadline.announcing(announce)))
        stats = _plain(found.stats)
        if events := text_of(found.find_events()):
            stats[EVENTS] = events
        if not case.ends:
            return Computed(case, found.t, found.q, found.v, found.lam, stats, numbers=found.inputs)
        last = len(found.t) - 1
        rows = np.linspace(0, last, min(last, ENDS) + 1).astype(int)
        # nan multipliers are computed on access, which does not happen here
        lam = np.full((len(rows), found.system.m + found.system.p), np.nan)
        numbers = {name: x[rows] for name, x in found.inputs.items()}
        return Computed(case, found.t[rows], found.q[rows], found.v[rows], lam, stats, numbers=numbers)

    return attempted(case, run, deadline)


def _plain(stats: Mapping) -> dict:
    """The stats that can be written as JSON."""
    kept = ("method", "h", "tol", "steps", "rejected", "iterations", "matrix_evaluations", "factorisations")
    kept += ("seconds", "warnings")
    return {key: stats[key] for key in kept if key in stats}
