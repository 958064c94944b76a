"""The run of a compiled method on one system: its buffers, start and restart, and calls of the compiled step loop."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from copy import copy
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mbdsl.compilation import buffer_layout, code_cache
from mbdsl.errors import InitialisationError, UsageError
from mbdsl.integrators import modules
from mbdsl.integrators.events import Events
from mbdsl.integrators.loop import linear_solve, loop_state, sparse_lu, step_control
from mbdsl.integrators.loop.compiled_loop import compiled, controls_locally, loop_name
from mbdsl.integrators.loop.run_data import RunData
from mbdsl.integrators.method import Method, Start
from mbdsl.integrators.missed_peaks import Overlooked
from mbdsl.integrators.options import check_options
from mbdsl.integrators.peak_zones import Landings
from mbdsl.integrators.scheduled_jumps import Jumps
from mbdsl.integrators.start_values import applied, check_stiffness, first_step, normal_part, rates
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.close_approaches import Approach

Array = NDArray[np.float64]

#: h^3 times the initial jerk, relative to the mechanism's size, above which the jerk belongs to a transient
TRANSIENT = 1e-4
#: longest controlled step relative to the run, unless a shorter one is given: a longer step could pass over events
LONGEST = 0.02
#: default number of output intervals; errors of velocities that dampers remove within one interval are not counted
POINTS = 500
#: largest displacement in a controlled step of kinematics, relative to the mechanism's size
LARGEST = 0.1
#: largest number of floats in the stored output; a run with more stops and asks for an output interval
MOST_OUTPUT = 250_000_000
#: number of rows of output that are allocated at once if every step is output
ROOM = 4096
#: largest number of unknowns for which the dense solver with pivoting may replace the sparse one
PIVOTING_LIMIT = 2000


@dataclass
class Integration:
    """Buffers and compiled functions of one run from a consistent initial state.

    ``h`` is the step size, a whole fraction of stop - start. With a tolerance ``tol`` it is stop - start at first, and
    the size of the first step after ``begin``. With ``every``, each step is output, and ``times`` are the steps' ends.
    """

    system: System
    method: str
    h: float
    start: float
    stop: float
    times: Array  #: output times after the start
    options: Mapping[str, float | None] | None = None  #: all options of the method, completed; None: the defaults
    left_out: tuple[int, ...] = ()
    tol: float | None = None
    every: bool = False
    longest: float = np.inf  #: largest allowed size of controlled steps
    pivoting_from: float | None = None  #: time since which the dense solver with pivoting replaces the sparse one

    def __post_init__(self) -> None:
        self.overlooked: Overlooked | None = None
        self.missed: list[float] = []
        self.approaches: list[Approach] = []
        self.approaching = np.zeros((5, 0))  # see Approaches.add
        self._rates: tuple | None = None
        self._prepare()
        self._load()

    @property
    def controlled(self) -> bool:
        """Whether :mod:`mbdsl.integrators.loop.step_control` controls the step size by local errors."""
        return self.tol is not None and controls_locally(self.method)

    def anew(self, times: Array, tol: float | None, every: bool, longest: float) -> Integration:
        """A copy of this run for the same System, before its start, with other output times and tolerance."""
        run = copy(self)
        run.times, run.tol, run.every, run.longest, run.pivoting_from = times, tol, every, longest, None
        del run.vectors, run.layout
        run._prepare()
        return run

    def _prepare(self) -> None:
        """Allocate the buffers, and set the constants of the run in them."""
        declaration = modules()[self.method].METHOD
        self._use(linear_solve.SPARSE_LU)
        options = check_options(self.method, {}, force=True) if self.options is None else self.options
        self.coefficients = np.array(declaration.coefficients(options), float)
        self.coefficients.flags.writeable = False
        self.memory = np.zeros(0)  # set when the run begins
        self.reals = np.zeros(loop_state.REALS)
        self.integers = np.zeros(loop_state.INTEGERS, np.int64)
        self.out = np.zeros((len(self.times), self.system.n + self.system.unknowns))
        steps = round((self.stop - self.start) / self.h)
        self.reals[loop_state.START], self.reals[loop_state.STOP], self.reals[loop_state.STEP_SIZE] = (
            self.start,
            self.stop,
            self.h,
        )
        self.reals[loop_state.STEP_END] = self.reals[loop_state.NOW] = self.start
        self.reals[loop_state.TOL] = self.tol or 0.0
        self.reals[loop_state.CONTRACTION] = 0.1
        # Newton's tolerances, relative to h times the speed, to the local error, and to the mechanism's size. The last
        # one bounds the second, because differences of an oscillating a do not show the local error. The second is
        # smaller for methods other than stabilised index 2, whose reactions have the error of positions times 1/h^2.
        self.reals[loop_state.VELOCITY_TOL : loop_state.LOOSEST + 1] = (
            8e-12,
            1e-5 if declaration.sets == 2 else 1e-6,
            1e-11,
        )
        # UNIT converts unknowns and residuals to positions. WILD is the largest change of an unknown over a step, as a
        # position: the step is too large for a motion whose acceleration changes more.
        self.reals[loop_state.UNIT], self.reals[loop_state.WILD] = self.h**2, 25.0
        if declaration.order == 0:
            # Kinematics has no local error, and errors of the iteration do not accumulate. But after a large step the
            # iteration may find another assembly of the mechanism: a bound on displacements.
            self.reals[loop_state.RELATIVE_TOL : loop_state.WILD + 1] = 1e300, 4e-15, 1.0, 0.5
        self.integers[loop_state.LAST_STEP], self.integers[loop_state.SAME] = steps, step_control.LONG_AGO
        self.reals[loop_state.NEXT_EVENT] = np.inf
        if self.tol is not None:
            self._stop_at_events()
        if self.controlled:
            self._control(declaration)
        self.integers[loop_state.STABILISED] = declaration.sets > 1

    def _load(self) -> None:
        """Load or compile the step loop of the method and the functions of the scene."""
        module = modules()[self.method]
        sets = module.METHOD.sets
        code, loop = self.system.module_name(sets), loop_name(self.method)
        # If both have to be compiled: the scene's code in another process, and the method's loop here at the same time
        with code_cache.lock:
            both = not code_cache.is_compiled(code) and not code_cache.is_compiled(loop)
            other = self.system.compile_beside(sets) if both else None
            self._advance = compiled(self.method, module)
            if other is not None:
                other.wait()
            kernels = self.system.kernels(sets)
        self.evaluate, self.tangent, self.inertia = kernels.evaluate, kernels.tangent, kernels.inertia

    def _stop_at_events(self) -> None:
        """Prepare switches, zones and the bounds of the step size, for a run with a tolerance."""
        self.events, self.landings = Events(self), Landings(self)
        self.seen = np.zeros(len(self.system.on_the_way.terms))  # largest values of these terms so far
        reals, integers, span = self.reals, self.integers, self.stop - self.start
        integers[loop_state.EVERY], reals[loop_state.NEXT_EVENT], reals[loop_state.MOST_H] = (
            self.every,
            np.inf,
            min(self.longest, LONGEST * span),
        )
        reals[loop_state.LEAST_H] = max(1e-14 * span, 16.0 * np.finfo(float).eps * max(abs(self.start), abs(self.stop)))

    def _control(self, method: Method) -> None:
        reals, integers, span, tol = self.reals, self.integers, self.stop - self.start, self.reals[loop_state.TOL]
        integers[loop_state.CONTROLLED], integers[loop_state.LANDING] = True, method.order == 0 and not self.every
        reals[loop_state.SPEED] = 1.0 / span if span > 0.0 else 1.0
        between = self.times[0] - self.start if len(self.times) and not self.every else span
        reals[loop_state.FORGOTTEN] = min(span / POINTS, between)
        reals[loop_state.EXPONENT] = 1.0 / (method.order + 1)
        reals[loop_state.LARGEST] = min(LARGEST, (100.0 * tol) ** 0.25)  # interpolation between steps has order 4
        reals[loop_state.NODE], reals[loop_state.MASS_WEIGHT] = (
            method.node(self.coefficients),
            method.mass_weight(self.coefficients),
        )
        reals[loop_state.DAMPING] = method.damping_weight(self.coefficients)

    def _use(self, solver: int) -> None:
        """Lay out the buffers for a linear solver; ``vectors`` and the tables of the scene keep their content."""
        system, N = self.system, self.system.unknowns
        rows, columns = system.tables.pattern
        if solver == linear_solve.SPARSE_LU:
            pattern = sparse_lu.analyse(N, rows, columns, system.elimination_order())
            slots, size, length, table = pattern.slots, pattern.size, pattern.length, pattern.table
        else:
            slots, size, table = rows * N + columns, N * N, np.empty(0, np.int64)
            length = size + 2 * N  # with the scales of rows and columns
        method = modules()[self.method].METHOD
        work = system.workspace(slots, buffer_layout.ROWS + method.rows)
        kept = self.layout[buffer_layout.KEEP] if hasattr(self, "layout") else 0
        if hasattr(self, "vectors"):
            work.vectors[:], work.frames[:], work.gradients[:], work.numbers[:] = (
                self.vectors,
                self.frames,
                self.gradients,
                self.numbers,
            )
        self.vectors, self.frames, self.gradients, self.numbers = (
            work.vectors,
            work.frames,
            work.gradients,
            work.numbers,
        )
        self.layout = np.concatenate([work.layout, table])
        self.layout[buffer_layout.SOLVER], self.layout[buffer_layout.SPARSE], self.layout[buffer_layout.SIZE] = (
            solver,
            len(work.layout),
            size,
        )
        self.layout[buffer_layout.LAM_ROW], self.layout[buffer_layout.MU_ROW], self.layout[buffer_layout.LAW_ROW] = (
            method.multipliers
        )
        self.layout[buffer_layout.INERTIA_ROW], self.layout[buffer_layout.INERTIA_ROW2] = method.inertia_rows
        self.layout[buffer_layout.MASS_ROW], self.layout[buffer_layout.TANGENT_ROW] = (
            method.mass_row,
            method.tangent_row,
        )
        self.layout[buffer_layout.ACCELERATION] = method.acceleration_row
        self.layout[buffer_layout.PSI_ROW], self.layout[buffer_layout.KEEP] = buffer_layout.UNKNOWN, kept
        count = method.matrices + 2 * self.controlled
        self.matrices = np.zeros((count, length + 1))  # the method may use the last entry of each
        self.pivots = np.zeros((count, max(N, 2 * size + 1)), np.int64)  # pivots, or rows and columns of entries
        self.solver = solver
        self._leave_out()

    def _leave_out(self) -> None:
        m = self.system.m
        for row in self.left_out:
            if row < m:
                self.layout[self.layout[buffer_layout.PAIRS] + buffer_layout.PAIR * row + 5] = 1
            else:
                self.layout[self.layout[self.layout[buffer_layout.GAMMAS] + row - m] + 3] = 1

    def begin(
        self,
        q: Array,
        v: Array,
        a: Array,
        lam: Array,
        left_out: tuple[int, ...] = (),
        t: float | None = None,
        h: float | None = None,
        longest: float = np.inf,
    ) -> None:
        """Set the consistent initial state, and the redundant constraints that are left out.

        A run with a tolerance may restart at a later time ``t``, as after a jump. Its first step is ``h``; by default
        it is estimated, and at most ``longest``.

        Raises
        ------
        InitialisationError
            If the method needs a mass for every coordinate and one has none.
        """
        self.left_out = left_out
        self._leave_out()
        controlled = self.controlled
        system, t0, vectors = self.system, self.start if t is None else t, self.vectors
        n, mass, scale = system.n, system.mass(), system.tables.scale
        method = modules()[self.method].METHOD
        if method.inverts_mass and not (mass > 0.0).all():
            name = system.names()[int(np.flatnonzero(~(mass > 0.0))[0])]
            raise InitialisationError(
                f"{self.method} divides forces by masses, but {name} has none",
                hint="give it a mass, or take another method",
            )

        def largest(x: Array) -> float:
            return float(np.abs(x * scale).max(initial=0.0))

        if controlled:
            left = max(self.stop - t0, self.reals[loop_state.LEAST_H])
            self.h = 1e-2 / max(1.0 / left, largest(v), largest(a) ** 0.5)
        key = t0, self.h, q.tobytes(), v.tobytes(), a.tobytes()
        if self._rates is None or self._rates[0] != key:
            self._rates = key, rates(system, t0, 1e-3 * self.h, q, v, a, lam, left_out)
        fa, jerk, fa_rate = self._rates[1]
        if controlled:
            self.h = min(self._first_step(v, a, jerk), longest) if h is None else h
        if method.inverts_mass:
            check_stiffness(system, self.method, t0, self.h, q, v, lam)
        stiff = not controlled and self.h * largest(jerk) > largest(a) and self.h**3 * largest(jerk) > TRANSIENT
        if stiff:  # the method damps the transient; extrapolated over a step, its rates would spoil the start values
            jerk, fa_rate = np.zeros(n), np.zeros(n)
        if t is None:
            self.numbers[self._counters] = system.tables.numbers[self._counters]
        vectors[buffer_layout.POSITION0, :n] = vectors[buffer_layout.POSITION, :n] = q
        vectors[buffer_layout.VELOCITY0, :n] = vectors[buffer_layout.VELOCITY, :n] = v
        vectors[buffer_layout.FORCE0, :n] = system.M(t0, q) @ a
        start = Start(self.h, q, v, a, lam, fa, jerk, fa_rate, stiff)
        if t is None or controlled:
            self.memory = np.array(method.memory(self.coefficients, start), float)
        for row, vector in method.begin(self.coefficients, start).items():
            vectors[row, : len(vector)] = vector
        vectors[buffer_layout.UNKNOWN] = vectors[buffer_layout.UNKNOWN0]
        vectors[buffer_layout.UNKNOWN2] = vectors[buffer_layout.UNKNOWN0 + buffer_layout.PAST]
        if controlled:
            self._begin_control(t0, q, v, jerk)
        elif self.tol is not None:
            self._begin_own(t0, min(self.stop - t0, longest), jerk)
        if self.tol is not None and t is None and method.order:
            self.events.begin(t0, q, v, lam)
        if self.tol is not None and t is None:
            self.landings.begin(t0)
        elif self.tol is None and method.order:
            self.jumps = Jumps(system, self.start, self.stop, self.h)
            self.reals[loop_state.NEXT_EVENT] = self.jumps.next[0]
        # this evaluation gives the gradients at the start of the first step
        self.evaluate(t0, vectors, self.frames, self.gradients, self.numbers, self.layout)
        self.layout[buffer_layout.KEEP] = 1
        self.integers[loop_state.HISTORY] = 1

    def watch(self) -> None:
        """Search fixed steps for peaks of laws that they pass over; to be called before the first step."""
        if self.tol is None and self.stop > self.start:
            self.overlooked = Overlooked(self)

    def _first_step(self, v: Array, a: Array, jerk: Array) -> float:
        module, reals, scale = modules()[self.method], self.reals, self.vectors[buffer_layout.SCALE, : self.system.n]
        span = self.stop - self.start
        h = min(0.01 * span, reals[loop_state.MOST_H], 10.0 * self.h)
        speed = max(reals[loop_state.SPEED], float(np.abs(v * scale).max(initial=0.0)))
        if module.METHOD.order == 0:
            return min(h, 0.5 * reals[loop_state.LARGEST] / speed, *self.times[:1] - self.start)
        allowed = step_control.AIM * step_control.SHARE * reals[loop_state.TOL]
        return first_step(
            module.local_error, self.coefficients, h, allowed, reals[loop_state.EXPONENT], scale, speed, span, a, jerk
        )

    def _begin_control(self, t: float, q: Array, v: Array, jerk: Array) -> None:
        """Begin a history of controlled steps: it has the accelerations of a fictitious step before the start."""
        system, reals, integers, h, n = self.system, self.reals, self.integers, self.h, self.system.n
        reals[loop_state.NOW], reals[loop_state.STEP_SIZE], reals[loop_state.LAST_H] = t, h, h
        if reals[loop_state.EXPONENT] < 1.0:
            reals[loop_state.UNIT] = h * h
        integers[loop_state.SAME] = integers[loop_state.SINCE] = integers[loop_state.IN_A_ROW] = integers[
            loop_state.FRESH
        ] = integers[loop_state.ORDER] = 0
        method = modules()[self.method].METHOD
        a = buffer_layout.UNKNOWN0 + buffer_layout.PAST * (method.acceleration_row - buffer_layout.UNKNOWN)
        self.vectors[a + 1, :n] = self.vectors[a, :n] - h * jerk
        first = t + (reals[loop_state.NODE] - 1.0) * h
        reals[loop_state.NODES : loop_state.NODES + 2] = first, first - h
        reals[loop_state.TIMES : loop_state.TIMES + 2] = t, t - h
        velocity_error = getattr(modules()[self.method], "velocity_error", None)
        if velocity_error is not None:
            error = getattr(velocity_error, "py_func", velocity_error)(h, h, self.coefficients) * normal_part(
                system, t, q, v, jerk, self.left_out
            )
            self.vectors[buffer_layout.VELOCITY0, :n] += error
            self.vectors[buffer_layout.KEPT2, :n] += error  # v of the previous step, in methods that read this row

    def _begin_own(self, t: float, longest: float, jerk: Array) -> None:
        """Begin a history for a method that controls its own steps; its first step is at most ``longest``."""
        reals, n, d = self.reals, self.system.n, 1e-3 * self.h
        reals[loop_state.NOW], reals[loop_state.STEP_SIZE], reals[loop_state.LAST_H], reals[loop_state.UNCUT] = (
            t,
            longest,
            longest,
            longest,
        )
        self.integers[loop_state.FRESH] = 0
        self.vectors[buffer_layout.UNKNOWN0 + 1, :n] = self.vectors[buffer_layout.UNKNOWN0, :n] - d * jerk
        reals[loop_state.NODES : loop_state.NODES + 2] = t, t - d

    def change_inputs(self, inputs: Mapping[str, float]) -> None:
        """Set inputs to new values from the present time on; accelerations and forces jump accordingly.

        The history of a method is linear in accelerations and forces, and the jump is added to it. Order 2 is therefore
        kept over any number of jumps.
        """
        system, t = self.system, self.time
        used = {name: value for name, value in inputs.items() if name in system.tables.inputs}

        def change() -> None:
            for name, value in used.items():
                system.set_input(name, value)
                self.numbers[system.tables.inputs[name]] = value

        self.jump(t, t, change)
        if self.tol is not None:
            self.events.resume()

    def jump(self, before: float, behind: float, change: Callable[[], None] = lambda: None) -> None:
        """Add a jump of accelerations and forces to the history.

        It is the difference between two times, equal up to rounding, or the effect of ``change()`` at one time.

        Raises
        ------
        InitialisationError
            If accelerations do not exist, as in a singular pose.
        """
        system, vectors, n = self.system, self.vectors, self.system.n
        q, v = vectors[buffer_layout.POSITION0, :n], vectors[buffer_layout.VELOCITY0, :n]
        self.synchronise()
        old = accelerations(system, before, q, v, self.left_out)
        fa = applied(system, before, q, v, old[1])
        change()
        new = accelerations(system, behind, q, v, self.left_out)
        a, lam = new[0] - old[0], new[1] - old[1]
        fa = applied(system, behind, q, v, new[1]) - fa
        nothing = np.zeros(n)
        jump = Start(self.h, nothing, nothing, a, lam, fa, nothing, nothing, False)
        rows = {
            buffer_layout.FORCE0: system.M(behind, q) @ a,
            **modules()[self.method].METHOD.begin(self.coefficients, jump),
        }
        for row, part in rows.items():
            past = (
                buffer_layout.PAST
                if row in (buffer_layout.UNKNOWN0, buffer_layout.UNKNOWN0 + buffer_layout.PAST)
                else 1
            )
            vectors[row : row + past, : len(part)] += part

    def _cross_jump(self) -> None:
        """Continue behind a scheduled jump of forces; the last step has ended shortly before it."""
        if self.time < self.stop:
            with suppress(InitialisationError):  # in a singular pose, which has no accelerations: keep the old history
                self.jump(*self.jumps.next)
            self.integers[loop_state.FRESH] = 0
            if not controls_locally(self.method):
                self.integers[loop_state.HISTORY] = 1
        self.jumps.go_on()
        self.reals[loop_state.NEXT_EVENT] = self.jumps.next[0]

    def widen(self, start: Array, far: float) -> None:
        """Scale lengths by the largest displacement from ``start`` (n,) if that exceeds ``far`` times their scale."""
        vectors, reals, lengths = self.vectors, self.reals, self.system.tables.lengths
        way = (vectors[buffer_layout.POSITION0, : self.system.n] - start) * vectors[
            buffer_layout.SCALE, : self.system.n
        ]
        longest = float(np.abs(way[lengths]).max(initial=0.0))
        if longest > far:
            vectors[buffer_layout.SCALE, : self.system.n][lengths] /= longest
            reals[loop_state.SPEED] = max(reals[loop_state.SPEED] / longest, 1.0 / (self.stop - self.start))

    def synchronise(self) -> None:
        """Set inputs and counted turns of the system to those of the run; other evaluations may have changed them."""
        system = self.system
        for name, at in system.tables.inputs.items():
            system.set_input(name, self.numbers[at])
        for at in self._counters:
            system.set_number(at, self.numbers[at])

    @property
    def _counters(self) -> list[int]:
        """Offsets in ``numbers`` of the angles whose turns are counted."""
        return [body.counter for body in self.system.tables.models.values() if body.counter >= 0]

    @property
    def time(self) -> float:
        """The time reached [s]."""
        if self.tol is not None:
            return float(self.reals[loop_state.NOW])
        return float(self.reals[loop_state.START] + self.integers[loop_state.STEP] * self.h)

    @property
    def step(self) -> float:
        """The length of the next step [s]."""
        return float(self.reals[loop_state.STEP_SIZE])

    @property
    def steps(self) -> int:
        """Steps taken."""
        return int(self.integers[loop_state.STEP])

    @property
    def written(self) -> int:
        """Outputs written to ``out``."""
        return int(self.integers[loop_state.OUTPUT])

    def count(self, what: str) -> int:
        """Number of "rejected", "events", "iterations", "matrix_evaluations", "factorisations"; 0 if not counted."""
        return int(self.integers[loop_state.COUNTERS[what]]) if what in loop_state.COUNTERS else 0

    def state(self) -> tuple[Array, Array, Array]:
        """The present q, v (n,) and lam (m + p,), as views."""
        n, vectors = self.system.n, self.vectors
        return (
            vectors[buffer_layout.POSITION0, :n],
            vectors[buffer_layout.VELOCITY0, :n],
            vectors[buffer_layout.UNKNOWN0, n : self.system.unknowns],
        )

    def advance(self, steps: int = sys.maxsize) -> int:
        """Take at most ``steps`` steps; return a status of :mod:`mbdsl.integrators.loop.loop_state`.

        Raises
        ------
        UsageError
            If every step is output, and the output would need too much memory.
        """
        if self.every:
            status = loop_state.RUNNING
            while steps > 0 and status == loop_state.RUNNING:
                self._make_room()
                if self.out.size > MOST_OUTPUT:
                    raise UsageError(
                        f"{self.written} steps of {self.out.shape[1]} numbers until t = {self.time:g} s do not fit in "
                        "memory",
                        hint="give an output interval",
                    )
                status = self._advance_by(min(steps, ROOM))
                steps -= ROOM
            return status
        return self._advance_by(steps)

    def _make_room(self) -> None:
        """Allocate rows of output for the next ``ROOM`` steps."""
        used = self.written
        if len(self.times) < used + ROOM:
            more = max(ROOM, used // 2)
            self.times = np.concatenate([self.times[:used], np.full(more, np.inf)])
            self.out = np.concatenate([self.out[:used], np.empty((more, self.out.shape[1]))])

    def _advance_by(self, steps: int) -> int:
        most = self.steps + steps
        if self.tol is None:
            call = self._call if self.overlooked is None else partial(self.overlooked.advance, call=self._call)
            status = call(steps)
            while status == loop_state.EVENT:
                self._cross_jump()
                status = call(most - self.steps)
        else:
            status = self.landings.advance(steps, self._call)
        if status == loop_state.EVENT:
            return self.events.come()
        if (
            status == loop_state.SINGULAR
            and self.solver == linear_solve.SPARSE_LU
            and self.system.unknowns <= PIVOTING_LIMIT
        ):
            # the elimination order gives no usable pivot here: continue with the dense solver with pivoting
            self._use(linear_solve.DENSE)
            self.pivoting_from = self.time
            self.integers[loop_state.FRESH] = 0
            status = self._advance_by(most - self.steps)
        return status

    def data(self) -> RunData:
        """The arguments of the step loop's kernels."""
        return RunData(
            self.evaluate,
            self.tangent,
            self.inertia,
            self.coefficients,
            self.memory,
            self.reals,
            self.integers,
            self.vectors,
            self.frames,
            self.gradients,
            self.numbers,
            self.layout,
            self.matrices,
            self.pivots,
        )

    def _call(self, steps: int) -> int:
        return int(self._advance(steps, self.times, self.out, *self.data()))
