"""One run of a study, in the present process."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import singledispatch
from time import perf_counter

import numpy as np

from mbdsl.errors import MbdslError
from mbdsl.simulation.progress import Progress
from mbdsl.simulation.simulate import simulated
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.storage import cache_folder
from mbdsl.storage.compilation_notice import silent
from mbdsl.studies.cases import ENDS, Case, Setting, output_interval
from mbdsl.studies.store import OUT_OF_MEMORY, OUT_OF_TIME, Computed


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


class Deadline:
    """Ends a run when its time is over; ``late`` then, with the ``seconds`` that its step loop took.

    Parameters
    ----------
    limit : float [s]
        For the step loop, calibration runs included.
    left : float [s]
        From now on, compilation included.
    compiling : float [s]
        Expected time of a compilation: none is begun that would exceed ``left``.
    """

    def __init__(self, limit: float, left: float = math.inf, compiling: float = 0.0) -> None:
        self.limit, self.end, self.compiling = limit, perf_counter() + left, compiling
        self.begun, self.seconds, self.late = 0.0, 0.0, False

    def progress(self, now: Progress) -> None:
        """Progress starts from zero in every calibration run."""
        clock = perf_counter()
        self.begun = self.begun or clock - now.seconds
        self.seconds = clock - self.begun
        self._check(self.seconds > self.limit or clock > self.end)

    def announcing(self, announce: Callable[[str], None] | None) -> Callable[[str], None]:
        """``announce``, and a check before a compilation."""

        def said(text: str) -> None:
            self._check(text == cache_folder.compiling() and perf_counter() + self.compiling > self.end)
            if announce is not None:
                announce(text)

        return said

    def _check(self, over: bool) -> None:
        if over:
            self.late = True
            raise KeyboardInterrupt


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
    try:
        found = simulate_case(of, case, deadline.progress, deadline.announcing(announce))
    except MbdslError as problem:
        return Computed(case, problem=problem.message)
    except MemoryError:
        return Computed(case, problem=OUT_OF_MEMORY)
    except (ArithmeticError, ValueError) as problem:  # exceptions of third-party code
        return Computed(case, problem=f"{type(problem).__name__}: {problem}")
    except KeyboardInterrupt:
        if not deadline.late:
            raise
        return Computed(case, problem=OUT_OF_TIME)
    if found.status == "interrupted":
        if not deadline.late:
            raise KeyboardInterrupt
        seconds = {"integrate": deadline.seconds, "compile": found.stats["seconds"]["compile"]}
        return Computed(case, stats={"seconds": seconds}, problem=OUT_OF_TIME)
    if case.ends:
        last = len(found.t) - 1
        rows = np.linspace(0, last, min(last, ENDS) + 1).astype(int)
        # nan multipliers are computed on access, which does not happen here
        lam = np.full((len(rows), found.system.m + found.system.p), np.nan)
        return Computed(case, found.t[rows], found.q[rows], found.v[rows], lam, _plain(found.stats))
    return Computed(case, found.t, found.q, found.v, found.lam, _plain(found.stats))


def _plain(stats: Mapping) -> dict:
    """The stats that can be written as JSON."""
    kept = ("method", "h", "tol", "steps", "rejected", "iterations", "matrix_evaluations", "factorisations")
    kept += ("seconds", "warnings")
    return {key: stats[key] for key in kept if key in stats}
