"""One run of a study, in the present process."""

from __future__ import annotations

import math
from collections.abc import Mapping
from time import perf_counter

import numpy as np

from mbdsl.errors import MbdslError
from mbdsl.simulation.progress import Progress
from mbdsl.simulation.simulate import simulated
from mbdsl.simulation.trajectory import Trajectory
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


def compute(of: Setting, case: Case, limit: float = math.inf, announce=None) -> Computed:
    """One run, successful or not.

    Raises
    ------
    KeyboardInterrupt
    """
    if limit <= 0.0:
        return Computed(case, problem=OUT_OF_TIME)
    begun, late = 0.0, False

    def watch(progress: Progress) -> None:
        nonlocal begun, late
        begun = begun or perf_counter() - progress.seconds  # progress starts from zero in every calibration run
        if perf_counter() - begun > limit:
            late = True
            raise KeyboardInterrupt

    try:
        found = simulate_case(of, case, watch, announce)
    except MbdslError as problem:
        return Computed(case, problem=problem.message)
    except MemoryError:
        return Computed(case, problem=OUT_OF_MEMORY)
    except (ArithmeticError, ValueError) as problem:  # exceptions of third-party code
        return Computed(case, problem=f"{type(problem).__name__}: {problem}")
    if found.status == "interrupted":
        if not late:
            raise KeyboardInterrupt
        return Computed(case, problem=OUT_OF_TIME)
    if case.ends:
        last = len(found.t) - 1
        rows = np.linspace(0, last, min(last, ENDS) + 1).astype(int)
        # nan multipliers are computed on access, which does not happen here
        lam = np.full((len(rows), found.system.m + found.system.p), np.nan)
        return Computed(case, found.t[rows], found.q[rows], found.v[rows], lam, _plain(found.stats))
    return Computed(case, found.t, found.q, found.v, found.lam, _plain(found.stats))


def _plain(stats: Mapping) -> dict:
    """The stats that can be written as JSON."""
    kept = ("method", "h", "tol", "steps", "rejected", "iterations", "matrix_evaluations", "factorisations", "seconds")
    return {key: stats[key] for key in kept if key in stats}
