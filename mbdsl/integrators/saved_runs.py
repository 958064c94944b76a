"""Saved states of runs, checked before a run continues from them: compiled code does not check its indices.

A checkpoint may be damaged, or made to do damage. The layout of the buffers, the settings of the run and the constants
among its numbers follow from the model and are not read. Everything else is checked for its type, shape and range.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isfinite
from typing import Any

import numpy as np

from mbdsl.integrators.events import SwitchEvents
from mbdsl.integrators.loop import driver, linear_solve, newton, step_control, thinned_records
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run_state import RunState
from mbdsl.kernels import buffer_layout as L
from mbdsl.system.close_approaches import Approach
from mbdsl.system.switches import PRIME

#: buffers of real numbers that are read
BUFFERS = ("vectors", "frames", "gradients", "numbers", "memory", "reals", "seen", "searched", "approaching")
#: integers and real numbers of a run that follow from its settings
SETTINGS = [
    *(S.LAST_STEP, S.STABILISED, S.CONTROLLED, S.EVERY, S.LANDING),
    *(S.WATCHING, S.CORNERS, S.NOTES, S.MARGIN, S.OLDER),
]
CONSTANTS = [S.START, S.STOP, S.TOL, S.LEAST_H, S.WITHIN, S.GRID, S.SLIVER]
COUNTS = 2**53  #: largest value of a counter, which statistics convert to a float
CUTS = 1000  #: largest number of times that a step is cut short


def checked(run: RunState, kept: Mapping[str, Any], rows: int) -> dict[str, Any]:
    """The attributes of a saved state of ``run`` that its buffers get; ``rows`` is the number of outputs with it.

    The run is left with the linear solver of the saved state.

    Raises
    ------
    KeyError, TypeError, ValueError
        If something is missing, or has a type, shape or range that is impossible in this run.
    """
    made: dict[str, Any] = {name: _reals(name, kept[name], getattr(run, name).shape) for name in BUFFERS}
    _check_reals(run, made["reals"])
    made["reals"][CONSTANTS] = run.reals[CONSTANTS]
    for row in (L.POSITION0, L.VELOCITY0):
        _require(np.isfinite(made["vectors"][row, : run.system.n]).all(), "its state is not finite")
    made["integers"] = _run_integers(run, kept["integers"], rows)
    if run.tol is None:
        passed = float(made["reals"][S.NOW] - run.start - made["integers"][S.STEP] * run.h)
        _require(abs(passed) <= 0.5 * run.h, "its number of steps does not belong to its time")
    made["h"] = run.h if run.tol is None else _number("h", kept["h"], 0.0, inf)
    at = kept["pivoting_from"]
    made["pivoting_from"] = None if at is None else _number("pivoting_from", at, run.start, run.stop)
    most = run.rows.count if run.rows is not None else COUNTS if run.every else 0
    made["released"] = _whole("released", kept["released"], 0, most)
    made["missed"] = _missed(run, kept["missed"])
    made["approaches"] = [_approach(run, x) for x in kept["approaches"]]
    solver = _whole("solver", kept["solver"], linear_solve.DENSE, linear_solve.SPARSE_LU)
    if solver != run.solver:
        run.use_solver(solver)
        run.integers[S.FRESH] = 0  # in case that the rest is refused
    made["matrices"] = _reals("matrices", kept["matrices"], run.matrices.shape)
    made["pivots"] = _pivots(run, kept["pivots"])
    made["layout"] = _layout(run, kept["layout"])
    return made


def checked_events(events: SwitchEvents, kept: Mapping[str, Any]) -> dict[str, Any]:
    """The attributes of the saved state of the ``events`` of a run.

    Raises
    ------
    KeyError, TypeError, ValueError
        As :func:`checked`.
    """
    count = len(events.system.tables.switches)
    made: dict[str, Any] = {
        name: [_number(name, t, events.run.start, events.run.stop) for t in kept[name]] for name in ("times", "_cut")
    }
    made["rounding"] = [_number("rounding", x, 0.0, inf) for x in kept["rounding"]]
    made["_fastest"] = _number("_fastest", kept["_fastest"], 0.0, inf)
    _require(len(made["rounding"]) == len(made["times"]), "rounding and times of events differ in number")
    made["_recent"] = [
        (_number("_recent", t, -inf, inf), _integers("_recent", states, (count,))) for t, states in kept["_recent"]
    ]
    return made


def _require(holds: object, problem: str) -> None:
    if not holds:
        raise ValueError(problem)


def _whole(name: str, value: Any, low: int, high: int) -> int:
    fits = isinstance(value, int | np.integer) and not isinstance(value, bool) and low <= value <= high
    _require(fits, f"{name} is not an integer from {low} to {high}")
    return int(value)


def _number(name: str, value: Any, low: float, high: float) -> float:
    """A finite number; times may exceed the ends of the run by rounding."""
    fits = isinstance(value, int | float | np.number) and not isinstance(value, bool) and isfinite(value)
    near = 1e-9 * (high - low) if isfinite(high - low) else 0.0
    _require(fits and low - near <= value <= high + near, f"{name} is not a number in its range")
    return float(value)


def _array(name: str, value: Any, kind: type, shape: tuple[int, ...]) -> np.ndarray:
    fits = isinstance(value, np.ndarray) and value.dtype == kind and value.shape == shape
    _require(fits, f"{name} does not have the size or type that this model needs")
    return value.copy()


def _reals(name: str, value: Any, shape: tuple[int, ...]) -> np.ndarray:
    return _array(name, value, np.float64, shape)


def _integers(name: str, value: Any, shape: tuple[int, ...]) -> np.ndarray:
    return _array(name, value, np.int64, shape)


def _check_reals(run: RunState, reals: np.ndarray) -> None:
    own = reals[: S.ZONE]
    finite = np.isfinite(own)
    finite[S.NEXT_EVENT] |= own[S.NEXT_EVENT] == inf
    _require(finite.all(), f"the entry {np.argmin(finite)} of reals is not finite")
    _require(not np.isnan(reals[S.ZONE : S.REALS]).any(), "a zone is not a number")
    _number("the time reached", float(own[S.NOW]), run.start, run.stop)
    _require(own[S.STEP_SIZE] >= 0.0, "the step size is negative")


def _run_integers(run: RunState, value: Any, rows: int) -> np.ndarray:
    s = S
    found = _integers("integers", value, run.integers.shape)
    found[SETTINGS] = run.integers[SETTINGS]
    matrices = int(found[s.MATRICES])
    most = dict.fromkeys((s.ITERATIONS, s.MATRICES, s.FACTORISATIONS, s.REJECTED, s.EVENTS), COUNTS)
    most |= dict.fromkeys((s.UNSEEN, s.SINCE, s.SAME, s.IN_A_ROW), COUNTS)
    most |= {s.STEP: COUNTS if run.tol is not None else int(found[s.LAST_STEP])}
    most |= {s.FRESH: 1, s.HISTORY: L.PAST + int(found[s.OLDER])}
    most |= {s.ORDER: L.PAST - 1 + int(found[s.OLDER]), s.CUT: CUTS, s.SIGNATURE: PRIME - 1}
    most |= {s.DAMPED: step_control.SELDOM, s.TRUSTED: step_control.TRUST, s.ROUNDING: newton.LONG}
    most |= {
        s.AIMED: 1,
        s.PASSED: driver.MOST_PASSED,
        s.ZONES: s.ROOM,
        s.NEXT_ZONE: int(found[s.ZONES]),
        s.NOTED: int(found[s.NOTES]),
    }
    most |= {
        s.COUPLED: 1,
        s.THIN: thinned_records.MOST,
        s.SOFT: 1,
        s.OUTPUT: rows,
        s.OTHERS: matrices,
        s.DAMPERS: matrices,
    }
    least = {s.OUTPUT: rows, s.DAMPERS: -matrices}
    for k, high in most.items():
        _whole(f"the entry {k} of integers", found[k], least.get(k, 0), high)
    _require(len(most) + len(SETTINGS) == s.INTEGERS, "integers without a range")
    return found


def _pivots(run: RunState, value: Any) -> np.ndarray:
    """Rows and columns, and in the last column the numbers of listed entries."""
    found = _integers("pivots", value, run.pivots.shape)
    own, counts = found[:, :-1], found[:, -1]
    _require(((own >= 0) & (own < max(1, run.system.unknowns))).all(), "a pivot is outside of its matrix")
    _require(((counts >= 0) & (counts <= (found.shape[1] - 1) // 2)).all(), "a list of entries is too long")
    return found


def _layout(run: RunState, value: Any) -> np.ndarray:
    """The layout of the run, with the two flags that change during a run."""
    found, layout = _integers("layout", value, run.layout.shape), run.layout.copy()
    for flag in (L.KEEP, L.NEW_MASS):
        layout[flag] = _whole(f"the entry {flag} of layout", found[flag], 0, 1)
    return layout


def _missed(run: RunState, value: Any) -> list[float]:
    """The number of a term and four times, or nothing."""
    if not value:
        return []
    number, *times = value
    _require(len(times) == 4, "missed does not have four times")
    k = _whole("missed", number, 0, len(run.system.tables.values) - 1)
    return [k, *(_number("missed", t, -inf, inf) for t in times)]


def _approach(run: RunState, value: Any) -> Approach:
    number, *reals, state = value
    _require(len(reals) == 5 and len(state) == 2 * run.system.n, "approaches do not have the states of this model")
    _require(all(isinstance(x, float) for x in (*reals, *state)), "approaches are not numbers")
    k = _whole("approaches", number, 0, run.approaching.shape[1] - 1)
    t, side, d, curvature, error = reals
    return Approach(k, t, side, d, curvature, error, list(state))
