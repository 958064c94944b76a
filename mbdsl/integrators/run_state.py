"""State of a run of a compiled method: the settings, and the buffers that the compiled step loop works on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from mbdsl.integrators import modules
from mbdsl.integrators.loop import linear_solve, sparse_lu, step_control
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.compiled_loop import controls_locally
from mbdsl.integrators.loop.coupled_correction import BLOCKS
from mbdsl.integrators.loop.run_data import CHANGED
from mbdsl.integrators.loop.thinned_records import LEAST
from mbdsl.integrators.method import Method
from mbdsl.integrators.options import check_options
from mbdsl.integrators.output_times import OutputTimes
from mbdsl.integrators.tick_history import weights
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array, Integers
from mbdsl.storage.garbage_collection import uncollected
from mbdsl.system import System
from mbdsl.system.close_approaches import Approach
from mbdsl.system.peaks_along_motion import Turns, not_searched


def copied(value: Any) -> Any:
    """A copy of an array or a list; other values do not change."""
    return value.copy() if isinstance(value, np.ndarray | list) else value


def _pattern(system: System) -> sparse_lu.Pattern:
    return sparse_lu.analyse(system.unknowns, *system.tables.pattern, system.elimination_order())


#: quantity of numbers that the compiled loop records of steps that are kept without a search: they fit into the caches,
#: and need no new memory of the operating system
RECORDED = 16_000


#: the part of a fixed step below which no step is taken, but where the caller reads the state at each fixed step
SLIVER = 0.1
#: mark of the fields that change during a run, without which it cannot be continued
KEPT = {"kept": True}


@dataclass
class RunState:
    """Settings and buffers of one run; the fields with the mark KEPT are in checkpoints and saved states.

    ``h`` is the step size, a whole fraction of stop - start. With a tolerance ``tol`` it is stop - start at first, and
    the size of the first step after the start. With ``every``, each step is output, and ``times`` are the steps' ends.
    """

    system: System
    method: str
    h: float = field(metadata=KEPT)
    start: float
    stop: float
    times: Array = field(metadata=KEPT)  #: output times after the start
    options: Mapping[str, float | None] | None = None  #: all options of the method, completed; None: the defaults
    left_out: tuple[int, ...] = ()
    tol: float | None = None
    every: bool = False
    longest: float = np.inf  #: largest allowed size of controlled steps
    grid: float = 0.0  #: the fixed step, of a run whose steps end at events as well; else 0
    sliver: float = SLIVER  #: the part of a fixed step below which none is taken
    span: float = 0.0  #: the time over which progress and rounding are judged, of a run without a stop time
    rows: OutputTimes | None = None  #: the output times, of a run that has a window of them only in ``times``
    #: time since which the dense solver with pivoting replaces the sparse one
    pivoting_from: float | None = field(default=None, metadata=KEPT)
    keeps: bool = False  #: whether the states at the ends of all steps are kept, for extremes of signals

    # -- buffers of the compiled loop; see :class:`mbdsl.integrators.loop.run_data.RunData` --------------------------
    memory: Array = field(init=False, metadata=KEPT)
    reals: Array = field(init=False, metadata=KEPT)
    integers: Integers = field(init=False, metadata=KEPT)
    vectors: Array = field(init=False, metadata=KEPT)
    frames: Array = field(init=False, metadata=KEPT)
    gradients: Array = field(init=False, metadata=KEPT)
    numbers: Array = field(init=False, metadata=KEPT)
    layout: Integers = field(init=False, metadata=KEPT)
    matrices: Array = field(init=False, metadata=KEPT)
    pivots: Integers = field(init=False, metadata=KEPT)
    acts: bool = field(init=False, default=True)  #: whether the compiled loop does what clocks of the model do
    solver: int = field(init=False, metadata=KEPT)  #: DENSE or SPARSE_LU
    # -- output ------------------------------------------------------------------------------------------------------
    out: Array = field(init=False, metadata=KEPT)  #: (times, n + unknowns)
    released: int = field(init=False, metadata=KEPT)  #: rows of output that were taken from the run
    # -- searches for peaks ------------------------------------------------------------------------------------------
    seen: Array = field(init=False, metadata=KEPT)  #: largest values so far of the terms searched for peaks
    searched: Array = field(init=False, metadata=KEPT)
    missed: list[float] = field(init=False, metadata=KEPT)
    approaches: list[Approach] = field(init=False, metadata=KEPT)
    approaching: Array = field(init=False, metadata=KEPT)  #: see Approaches.add

    def __post_init__(self) -> None:
        self.span = self.span or self.stop - self.start
        self.seen, self.searched, self.approaching = np.zeros(0), not_searched(), np.zeros((5, 0))
        self.missed, self.approaches = [], []

    def saved(self, *shared: str) -> dict[str, Any]:
        """What is kept of the run, by name: copies, but for the arrays that are ``shared``."""
        found = {each.name: getattr(self, each.name) for each in fields(self) if each.metadata.get("kept")}
        return {name: copied(x) if name not in shared else x for name, x in found.items()}

    @property
    def controlled(self) -> bool:
        """Whether :mod:`mbdsl.integrators.loop.step_control` controls the step size by local errors."""
        return self.tol is not None and controls_locally(self.method)

    def allocate(self) -> None:
        """Allocate the buffers, and set the constants of the run in them."""
        declaration = modules()[self.method].METHOD
        self.acts = True
        self.use_solver(linear_solve.SPARSE_LU)
        options = check_options(self.method, self.options or {}, force=True)
        self.coefficients = np.array(declaration.coefficients(options), float)
        self.coefficients = self._with_ticks(declaration)
        self.coefficients.flags.writeable = False
        self.memory = np.zeros(0)  # set when the run begins
        self.reals = reals = np.zeros(S.REALS)
        self.integers = integers = np.zeros(S.INTEGERS, np.int64)
        self.released = 0
        self.ends: list[Array] = []  #: the parts of ``kept``
        if self.rows is not None:
            self.times = self.rows.visible(0)
        self.out = np.zeros((len(self.times), self.system.n + self.system.unknowns))
        reals[S.START], reals[S.STEP_SIZE] = self.start, self.h
        reals[S.STOP] = self.stop if self.span >= self.stop - self.start else self.start + self.span
        reals[S.STEP_END] = reals[S.NOW] = self.start
        reals[S.TOL] = self.tol or 0.0
        reals[S.GRID], reals[S.SLIVER] = self.grid, self.sliver
        reals[S.CONTRACTION] = 0.1
        # Newton's tolerances, relative to h times the speed, to the local error, and to the mechanism's size. The last
        # one bounds the second, because differences of an oscillating a do not show the local error. The second is
        # smaller for methods other than stabilised index 2, whose reactions have the error of positions times 1/h^2.
        relative = 1e-5 if declaration.sets == 2 else 1e-6
        # The first is smaller in space, where it is relative to speeds without spins.
        of_speed = 2e-12 if len(self.system.tables.rotations) else 8e-12
        reals[S.VELOCITY_TOL : S.LOOSEST + 1] = of_speed, relative, 1e-11
        # UNIT converts unknowns and residuals to positions. WILD is the largest change of an unknown over a step, as a
        # position: the step is too large for a motion whose acceleration changes more.
        reals[S.UNIT], reals[S.WILD] = self.h**2, 25.0
        if declaration.order == 0:
            # Kinematics has no local error, and errors of the iteration do not accumulate. But after a large step the
            # iteration may find another assembly of the mechanism: a bound on displacements.
            reals[S.RELATIVE_TOL : S.WILD + 1] = 1e300, 4e-15, 1.0, 0.5
        integers[S.LAST_STEP] = round((self.stop - self.start) / self.h)
        integers[S.SAME] = step_control.LONG_AGO
        reals[S.NEXT_EVENT] = np.inf
        integers[S.STABILISED], integers[S.OLDER] = declaration.sets > 1, declaration.older

    @uncollected
    def use_solver(self, solver: int) -> None:
        """Lay out the buffers for a linear solver; ``vectors`` and the tables of the scene keep their content."""
        system, N = self.system, self.system.unknowns
        rows, columns = system.tables.pattern
        if solver == linear_solve.SPARSE_LU:
            pattern = system.kept(_pattern)
            slots, size, length, table = pattern.slots, pattern.size, pattern.length, pattern.table
        else:
            slots, size, table = rows * N + columns, N * N, np.empty(0, np.int64)
            length = size + 2 * N  # with the scales of rows and columns
        method = modules()[self.method].METHOD
        work = system.workspace(slots, L.ROWS + method.rows + 2 * method.older)
        kept = self.layout[L.KEEP] if hasattr(self, "layout") else 0
        if hasattr(self, "vectors"):
            work.vectors[:], work.frames[:] = self.vectors, self.frames
            work.gradients[:], work.numbers[:] = self.gradients, self.numbers
        self.vectors, self.frames = work.vectors, work.frames
        self.gradients, self.numbers = work.gradients, work.numbers
        more = getattr(modules()[self.method], "tables", None)  # of the method's own
        if more is not None and solver == linear_solve.SPARSE_LU:
            table = np.concatenate([table, more(system, len(work.layout) + len(table))])
        self.layout = layout = np.concatenate([work.layout, table])
        layout[L.SOLVER] = solver
        layout[L.TICKS] *= self.acts
        layout[L.SPARSE] = len(work.layout)
        layout[L.SIZE] = size
        layout[[L.LAM_ROW, L.MU_ROW, L.LAW_ROW]] = method.multipliers
        layout[[L.INERTIA_ROW, L.INERTIA_ROW2]] = method.inertia_rows
        layout[L.MASS_ROW] = method.mass_row
        layout[L.TANGENT_ROW] = method.tangent_row
        layout[L.ACCELERATION] = method.acceleration_row
        layout[L.PSI_ROW] = L.UNKNOWN
        layout[L.KEEP] = kept
        layout[L.CHART] = 2 if method.second_rates else 1
        layout[L.PAST_POSITIONS] = method.past_positions
        count = method.matrices + 2 * self.controlled
        if method.coupled and len(system.tables.rotations):
            count += BLOCKS
        self.matrices = np.zeros((count, length + 1))  # the method may use the last entry of each
        self.pivots = np.zeros((count, max(N, 2 * size + 1)), np.int64)  # pivots, or rows and columns of entries
        self.solver = solver
        self.mark_left_out()

    def _with_ticks(self, method: Method) -> Array:
        """The coefficients of the method, and what ticks of clocks add to its history, if the compiled loop does it."""
        found = weights(method, self.coefficients, self.system, len(self.vectors)) if self.controlled else None
        self.acts = found is not None
        self.layout[L.TICKS] *= self.acts
        return np.append(self.coefficients, found or [])

    def mark_left_out(self) -> None:
        """Mark the constraints that are left out in ``layout``: redundant ones, and those that hold at times only."""
        m = self.system.m
        self.system.mark_switchable(self.layout, self.left_out)
        marked = [(row, 0) for rows in self.system.tables.contact_rows for row in rows]
        for row, left_out in [*marked, *((row, 1) for row in self.left_out)]:
            if row < m:
                self.layout[self.layout[L.PAIRS] + L.PAIR * row + L.LEFT_OUT] = left_out
            else:
                self.layout[self.layout[self.layout[L.GAMMAS] + row - m] + 3] = left_out

    def record(self, numbers: int, thin: bool) -> None:
        """Let the compiled loop record the ends of steps, with room for so many ``numbers``; ``thin`` drops some.

        Behind the records, ``reals`` has the recent largest speeds and multipliers.
        """
        width, integers = 1 + self.system.n + self.system.unknowns, self.integers
        integers[S.NOTED], integers[S.NOTES] = 0, max(16, numbers // width) if numbers else 0
        integers[S.THIN] = LEAST if thin else 0
        reals = np.zeros(S.REALS + integers[S.NOTES] * width + self.system.unknowns)
        reals[: S.REALS] = self.reals[: S.REALS]
        self.reals = reals

    @property
    def recorded(self) -> Array:
        """The records of the compiled loop: t, q, v, lam (N, 1 + n + unknowns), a view."""
        width = 1 + self.system.n + self.system.unknowns
        end = S.REALS + self.integers[S.NOTED] * width
        return self.reals[S.REALS : end].reshape(-1, width)

    def state_of_steps(self) -> list[Array]:
        """What steps change, as views: the buffers without the records."""
        end = S.REALS + self.integers[S.NOTES] * (1 + self.system.n + self.system.unknowns)
        others = [getattr(self, name) for name in CHANGED if name != "reals"]
        return [self.reals[: S.REALS], self.reals[end:], *others]

    def record_from(self, state: Array) -> None:
        """Begin the records with a state that is kept."""
        self.integers[S.NOTED] = 1
        self.recorded[0] = state

    def drain(self) -> None:
        """Keep the recorded states, the first of which is kept."""
        if len(noted := self.recorded) > 1:
            self.keep_ends(noted[1:])
            self.record_from(noted[-1])

    def keep_ends(self, rows: Array) -> None:
        """Keep recorded states at the ends of steps. Short parts are joined, so that there are few of them."""
        if self.keeps and len(rows):
            ends = self.ends
            ends.append(rows.copy())
            while len(ends) > 1 and len(ends[-2]) <= 2 * len(ends[-1]) and ends[-2].size + ends[-1].size <= RECORDED:
                ends[-2:] = [np.concatenate(ends[-2:])]

    def keep_state(self, state: Array | None = None) -> None:
        """Keep a state (t, q, v, lam), by default the present one: at the start, and on both sides of a jump."""
        state = np.concatenate([[self.time], *self.state()]) if state is None else state
        if self.integers[S.THIN]:
            self.drain()
            self.record_from(state)
        self.keep_ends(state[None])

    def write_before(self, t: float, way: Callable[[float], tuple[Array, Array]], lam: Array) -> None:
        """Output at times before an event at t, which no step has reached; ``way``: time -> q, v up to the event."""
        k = int(self.integers[S.OUTPUT])
        while not self.every and k < len(self.times) and self.times[k] < t - 4.0 * self.reals[S.LEAST_H]:
            self.out[k] = np.concatenate([*way(self.times[k]), lam])
            k += 1
        self.integers[S.OUTPUT] = k

    @property
    def kept(self) -> Array:
        """t, q, v, lam at ends of steps and behind jumps (N, 1 + n + unknowns), in no order."""
        if len(self.ends) != 1:
            self.ends = [np.concatenate([np.empty((0, 1 + self.system.n + self.system.unknowns)), *self.ends])]
        return self.ends[0]

    def synchronise(self) -> None:
        """Set inputs and counted turns of the system to those of the run; other evaluations may have changed them."""
        system = self.system
        system.activate(self.left_out)
        for name, at in system.tables.inputs.items():
            system.set_input(name, self.numbers[at])
        for at in system.tables.counters:
            system.set_number(at, self.numbers[at])

    @property
    def turns(self) -> Turns:
        """The angles that count turns, at the end of the last accepted step."""
        return Turns(-1, {node: float(self.numbers[at]) for node, at in self.system.searched_angles.items()})

    @property
    def time(self) -> float:
        """The time reached [s]."""
        if self.tol is not None:
            return float(self.reals[S.NOW])
        return float(self.reals[S.START] + self.integers[S.STEP] * self.h)

    @property
    def step(self) -> float:
        """The length of the next step [s]."""
        return float(self.reals[S.STEP_SIZE])

    @property
    def steps(self) -> int:
        """Steps taken."""
        return int(self.integers[S.STEP])

    @property
    def written(self) -> int:
        """Outputs written, with those that were released."""
        return self.released + int(self.integers[S.OUTPUT])

    def release(self, count: int) -> tuple[Array, Array]:
        """Take the first ``count`` rows of output from the run: their times (count,) [s], and the rows."""
        used = int(self.integers[S.OUTPUT])
        times, rows = self.times[:count].copy(), self.out[:count].copy()
        self.released += count
        self.integers[S.OUTPUT] = used - count
        self.out[: used - count] = self.out[count:used].copy()
        if self.rows is not None:
            self.times = self.rows.visible(self.released)
        else:
            self.times[: used - count] = self.times[count:used].copy()
            self.times[used - count :] = np.inf
        return times, rows

    def count(self, what: str) -> int:
        """Number of "rejected", "events", "iterations", "evaluations", "matrix_evaluations", "factorisations"; 0 if not
        counted.

        Explicit methods count evaluations of the equations in the place of iterations.
        """
        if what in ("iterations", "evaluations"):
            explicit = modules()[self.method].METHOD.explicit
            return int(self.integers[S.ITERATIONS]) if explicit == (what == "evaluations") else 0
        return int(self.integers[S.COUNTERS[what]]) if what in S.COUNTERS else 0

    def state(self) -> tuple[Array, Array, Array]:
        """The present q, v (n,) and lam (m + p,), as views."""
        n, vectors = self.system.n, self.vectors
        return (
            self.system.out_of_charts(vectors[L.POSITION0, :n], self.numbers),
            vectors[L.VELOCITY0, :n],
            vectors[L.UNKNOWN0, n : self.system.unknowns],
        )
