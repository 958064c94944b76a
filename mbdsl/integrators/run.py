"""One integration in progress: the buffers, the compiled loop, and ``advance``."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mbdsl import jit, layout
from mbdsl.errors import InitialisationError, UsageError
from mbdsl.integrators import control, linear, modules, sparse, state
from mbdsl.integrators.events import Events
from mbdsl.integrators.jumps import Jumps
from mbdsl.integrators.lookout import Landings
from mbdsl.integrators.method import Method, Start
from mbdsl.integrators.options import check_options
from mbdsl.integrators.overlooked import Overlooked
from mbdsl.integrators.starting import applied, check_stiffness, first_step, normal_part, rates
from mbdsl.integrators.step_loop import compiled, controls_locally, loop_name
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.close_approaches import Approach

Array = NDArray[np.float64]

#: h^3 times the jerk at the start, relative to the mechanism, beyond which it belongs to a transient
TRANSIENT = 1e-4
#: longest controlled step, as a part of the run, for want of a shorter one: what lies between steps is not seen
LONGEST = 0.02
#: outputs of a run where nothing is said about them: within what is between two, velocities may forget
POINTS = 500
#: largest displacement in a controlled step of what constraints determine, relative to the mechanism
LARGEST = 0.1
#: floats of stored output beyond which a larger interval is asked for
MOST_OUTPUT = 250_000_000
#: rows of output that are made room for at once, where their number is not known
ROOM = 4096
#: largest system that the dense solver with pivoting may take over
PIVOTING_LIMIT = 2000


@dataclass
class Integration:
    """Buffers and compiled functions of one run from a consistent initial state.

    ``h`` is the step and divides stop - start; with a tolerance ``tol`` it is all of that, and becomes the first step
    when the run begins. With ``every``, each step is output, and ``times`` are found.
    """

    system: System
    method: str
    h: float
    start: float
    stop: float
    times: Array  #: output times after the start
    options: Mapping[str, float | None] = field(default_factory=dict)
    left_out: tuple[int, ...] = ()
    tol: float | None = None
    every: bool = False
    longest: float = np.inf  #: steps of controlled size may not be longer
    pivoting_from: float | None = None  #: since when pivots are searched for, as the order from the graph lost one

    def __post_init__(self) -> None:
        self.overlooked: Overlooked | None = None
        self.missed: list[float] = []
        self.approaches: list[Approach] = []
        self._rates: tuple | None = None
        self.approaching = np.zeros((5, 0))  # see Approaches.add
        self._prepare()
        self._load()

    @property
    def controlled(self) -> bool:
        """Whether the lengths of steps follow from local errors."""
        return self.tol is not None and controls_locally(self.method)

    def anew(self, times: Array, tol: float | None, every: bool, longest: float) -> Integration:
        """Another run of the same System, which has not begun yet."""
        run = copy(self)
        run.times, run.tol, run.every, run.longest, run.pivoting_from = times, tol, every, longest, None
        del run.Y, run.I
        run._prepare()
        return run

    def _prepare(self) -> None:
        """The buffers."""
        declaration = modules()[self.method].METHOD
        self.matrices = declaration.matrices + 2 * self.controlled
        self._use(linear.SPARSE_LU)
        options = check_options(self.method, self.options, force=True)
        self.c = np.array(declaration.coefficients(options), float)
        self.K = np.zeros(state.K_SIZE)
        self.J = np.zeros(state.J_SIZE, np.int64)
        self.out = np.zeros((len(self.times), self.system.n + self.system.unknowns))
        steps = round((self.stop - self.start) / self.h)
        self.K[state.START], self.K[state.STOP], self.K[state.H] = self.start, self.stop, self.h
        self.K[state.T] = self.K[state.NOW] = self.start
        self.K[state.TOL] = self.tol or 0.0
        self.K[state.CONTRACTION] = 0.1
        # parts of h times the speed, of the local error, and of the size: where a rings, its differences say nothing
        # (All but the stabilised index-2 methods find reactions from what 1/h^2 magnifies.)
        self.K[state.VELOCITY_TOL : state.LOOSEST + 1] = 8e-12, 1e-5 if declaration.sets == 2 else 1e-6, 1e-11
        # What turns unknowns and residuals into positions; the largest change of an unknown from step to step, as a
        # position, that means anything: of an acceleration, no motion worth following has it.
        self.K[state.UNIT], self.K[state.WILD] = self.h**2, 25.0
        if declaration.order == 0:
            # There is no local error, and nothing that is left adds up over steps; but there are other assemblies, and
            # who makes steps so large may end up in one.
            self.K[state.RELATIVE_TOL : state.WILD + 1] = 1e300, 4e-15, 1.0, 0.5
        self.J[state.LAST_STEP], self.J[state.SAME] = steps, control.LONG_AGO
        self.K[state.NEXT_EVENT] = np.inf
        if self.tol is not None:
            self._stop_at_events()
        if self.controlled:
            self._control(declaration)
        self.J[state.STABILISED] = declaration.sets > 1

    def _load(self) -> None:
        """The compiled functions."""
        module = modules()[self.method]
        sets = module.METHOD.sets
        code, loop = self.system.module_name(sets), loop_name(self.method)
        # What has to be compiled is compiled side by side: the scene's code elsewhere, the method's loop here.
        with jit.lock:
            both = not jit.is_compiled(code) and not jit.is_compiled(loop)
            other = self.system.compile_beside(sets) if both else None
            self._advance = compiled(self.method, module)
            if other is not None:
                other.wait()
            kernels = self.system.kernels(sets)
        self.evaluate, self.tangent, self.inertia = kernels.evaluate, kernels.tangent, kernels.inertia

    def _stop_at_events(self) -> None:
        """Where steps of any length may end."""
        self.events, self.landings = Events(self), Landings(self)
        self.seen = np.zeros(len(self.system.on_the_way.terms))  # how large these have been
        K, J, span = self.K, self.J, self.stop - self.start
        J[state.EVERY], K[state.NEXT_EVENT], K[state.MOST_H] = self.every, np.inf, min(self.longest, LONGEST * span)
        K[state.LEAST_H] = max(1e-14 * span, 16.0 * np.finfo(float).eps * max(abs(self.start), abs(self.stop)))

    def _control(self, method: Method) -> None:
        K, J, span, tol = self.K, self.J, self.stop - self.start, self.K[state.TOL]
        J[state.CONTROLLED], J[state.LANDING] = True, method.order == 0 and not self.every
        K[state.SPEED] = 1.0 / span if span > 0.0 else 1.0
        between = self.times[0] - self.start if len(self.times) and not self.every else span
        K[state.FORGOTTEN] = min(span / POINTS, between)
        K[state.EXPONENT] = 1.0 / (method.order + 1)
        K[state.LARGEST] = min(LARGEST, (100.0 * tol) ** 0.25)  # q between outputs is of order 4
        K[state.NODE], K[state.MASS_WEIGHT] = method.node(self.c), method.mass_weight(self.c)
        K[state.DAMPING] = method.damping_weight(self.c)

    def _use(self, solver: int) -> None:
        """Lay out the buffers for a solver; the vectors keep their content."""
        system, N = self.system, self.system.unknowns
        rows, columns = system.tables.pattern
        if solver == linear.SPARSE_LU:
            pattern = sparse.analyse(N, rows, columns, system.elimination_order())
            slots, size, length, table = pattern.slots, pattern.size, pattern.length, pattern.table
        else:
            slots, size, table = rows * N + columns, N * N, np.empty(0, np.int64)
            length = size + 2 * N  # the scales of rows and columns
        method = modules()[self.method].METHOD
        work = system.workspace(slots, layout.ROWS + method.rows)
        kept = self.I[layout.KEEP] if hasattr(self, "I") else 0
        if hasattr(self, "Y"):
            work.Y[:], work.Z[:], work.C[:], work.F[:] = self.Y, self.Z, self.C, self.F
        self.Y, self.Z, self.C, self.F = work.Y, work.Z, work.C, work.F
        self.I = np.concatenate([work.I, table])
        self.I[layout.SOLVER], self.I[layout.SPARSE], self.I[layout.SIZE] = solver, len(work.I), size
        self.I[layout.LAM_ROW], self.I[layout.MU_ROW], self.I[layout.LAW_ROW] = method.multipliers
        self.I[layout.INERTIA_ROW], self.I[layout.INERTIA_ROW2] = method.inertia_rows
        self.I[layout.MASS_ROW], self.I[layout.TANGENT_ROW] = method.mass_row, method.tangent_row
        self.I[layout.ACCELERATION] = method.acceleration_row
        self.I[layout.PSI_ROW], self.I[layout.KEEP] = layout.X, kept
        self.A = np.zeros((self.matrices, length + 1))  # the last entry is the method's own
        self.P = np.zeros((self.matrices, max(N, 2 * size + 1)), np.int64)  # pivots, or rows and columns of entries
        self.solver = solver
        self._leave_out()

    def _leave_out(self) -> None:
        m = self.system.m
        for row in self.left_out:
            if row < m:
                self.I[self.I[layout.PAIRS] + layout.PAIR * row + 5] = 1
            else:
                self.I[self.I[self.I[layout.GAMMAS] + row - m] + 3] = 1

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
        """Set the consistent state at the start, and the redundant constraints that are not solved for.

        Controlled steps may begin anew at a later time ``t``, as behind a jump, with a first step ``h``, or one
        that is found and at most the ``longest``.

        Raises
        ------
        InitialisationError
            If the method needs a mass for every coordinate and one has none.
        """
        self.left_out = left_out
        self._leave_out()
        controlled = self.controlled
        system, t0, Y = self.system, self.start if t is None else t, self.Y
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
            self.c[:] = method.coefficients(check_options(self.method, self.options, force=True))
            left = max(self.stop - t0, self.K[state.LEAST_H])
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
        if stiff:  # a method damps what it cannot follow, but must not be thrown off by it
            jerk, fa_rate = np.zeros(n), np.zeros(n)
        if t is None:
            self.F[self._counters] = system.tables.F[self._counters]
        Y[layout.Q0, :n] = Y[layout.Q, :n] = q
        Y[layout.V0, :n] = Y[layout.V, :n] = v
        Y[layout.F0, :n] = system.M(t0, q) @ a
        start = Start(self.h, q, v, a, lam, fa, jerk, fa_rate, stiff)
        for row, vector in method.begin(self.c, start).items():
            Y[row, : len(vector)] = vector
        Y[layout.X] = Y[layout.XA]
        Y[layout.X2] = Y[layout.XA + layout.PAST]
        if controlled:
            self._begin_control(t0, q, v, jerk)
        elif self.tol is not None:
            self._begin_own(t0, min(self.stop - t0, longest), jerk)
        if self.tol is not None and t is None and method.order:
            self.events.begin(t0, q, v, lam)
        if self.tol is not None and t is None:
            self.landings.begin(t0)
        elif self.tol is None and method.order:
            self.jumps = Jumps(self)
        # what the start's own evaluation finds is the past of the first step
        self.evaluate(t0, Y, self.Z, self.C, self.F, self.I)
        self.I[layout.KEEP] = 1
        self.J[state.HISTORY] = 1

    def watch(self) -> None:
        """Search fixed steps for peaks of laws that they pass over; called before the first step."""
        if self.tol is None and self.stop > self.start:
            self.overlooked = Overlooked(self)

    def _first_step(self, v: Array, a: Array, jerk: Array) -> float:
        module, K, scale = modules()[self.method], self.K, self.Y[layout.SCALE, : self.system.n]
        span = self.stop - self.start
        h = min(0.01 * span, K[state.MOST_H], 10.0 * self.h)
        speed = max(K[state.SPEED], float(np.abs(v * scale).max(initial=0.0)))
        if module.METHOD.order == 0:
            return min(h, 0.5 * K[state.LARGEST] / speed, *self.times[:1] - self.start)
        allowed = control.AIM * control.SHARE * K[state.TOL]
        return first_step(module.local_error, self.c, h, allowed, K[state.EXPONENT], scale, speed, span, a, jerk)

    def _begin_control(self, t: float, q: Array, v: Array, jerk: Array) -> None:
        """No steps yet, but the accelerations of one that might have been."""
        system, K, J, h, n = self.system, self.K, self.J, self.h, self.system.n
        K[state.NOW], K[state.H], K[state.LAST_H] = t, h, h
        if K[state.EXPONENT] < 1.0:
            K[state.UNIT] = h * h
        J[state.SAME] = J[state.SINCE] = J[state.IN_A_ROW] = J[state.FRESH] = J[state.ORDER] = 0
        method = modules()[self.method].METHOD
        a = layout.XA + layout.PAST * (method.acceleration_row - layout.X)
        self.Y[a + 1, :n] = self.Y[a, :n] - h * jerk
        first = t + (K[state.NODE] - 1.0) * h
        K[state.NODES : state.NODES + 2] = first, first - h
        K[state.TIMES : state.TIMES + 2] = t, t - h
        velocity_error = getattr(modules()[self.method], "velocity_error", None)
        if velocity_error is not None:
            error = getattr(velocity_error, "py_func", velocity_error)(h, h, self.c) * normal_part(
                system, t, q, v, jerk, self.left_out
            )
            self.Y[layout.V0, :n] += error
            self.Y[layout.V1, :n] += error  # where it is read, that is v of a step before

    def _begin_own(self, t: float, longest: float, jerk: Array) -> None:
        """No steps yet, of a method that finds the first one itself, up to the ``longest``."""
        K, n, d = self.K, self.system.n, 1e-3 * self.h
        K[state.NOW], K[state.H], K[state.LAST_H], K[state.UNCUT] = t, longest, longest, longest
        self.J[state.FRESH] = 0
        self.Y[layout.XA + 1, :n] = self.Y[layout.XA, :n] - d * jerk
        K[state.NODES : state.NODES + 2] = t, t - d

    def change_inputs(self, inputs: Mapping[str, float]) -> None:
        """From here on the inputs have other values; accelerations and forces jump by what that makes of them.

        What a method keeps of the past is linear in them, so that order 2 is kept over any number of jumps.
        """
        system, t = self.system, self.time
        used = {name: value for name, value in inputs.items() if name in system.tables.inputs}

        def change() -> None:
            for name, value in used.items():
                system.set_input(name, value)
                self.F[system.tables.inputs[name]] = value

        self.jump(t, t, change)
        if self.tol is not None:
            self.events.resume()

    def jump(self, before: float, behind: float, change: Callable[[], None] = lambda: None) -> None:
        """Accelerations and forces jump between two times that are one but for rounding, or by a ``change``.

        Raises
        ------
        InitialisationError
            If there are none, as in a singular pose.
        """
        system, Y, n = self.system, self.Y, self.system.n
        q, v = Y[layout.Q0, :n], Y[layout.V0, :n]
        self.synchronise()
        old = accelerations(system, before, q, v, self.left_out)
        fa = applied(system, before, q, v, old[1])
        change()
        new = accelerations(system, behind, q, v, self.left_out)
        a, lam = new[0] - old[0], new[1] - old[1]
        fa = applied(system, behind, q, v, new[1]) - fa
        nothing = np.zeros(n)
        jump = Start(self.h, nothing, nothing, a, lam, fa, nothing, nothing, False)
        rows = {layout.F0: system.M(behind, q) @ a, **modules()[self.method].METHOD.begin(self.c.copy(), jump)}
        for row, part in rows.items():
            past = layout.PAST if row in (layout.XA, layout.XA + layout.PAST) else 1
            Y[row : row + past, : len(part)] += part

    def widen(self, start: Array, far: float) -> None:
        """Scale lengths by the largest displacement from ``start`` (n,) if that exceeds ``far`` times their scale."""
        Y, K, lengths = self.Y, self.K, self.system.tables.lengths
        way = (Y[layout.Q0, : self.system.n] - start) * Y[layout.SCALE, : self.system.n]
        longest = float(np.abs(way[lengths]).max(initial=0.0))
        if longest > far:
            Y[layout.SCALE, : self.system.n][lengths] /= longest
            K[state.SPEED] = max(K[state.SPEED] / longest, 1.0 / (self.stop - self.start))

    def synchronise(self) -> None:
        """The system's numbers become those of the run: whoever looked at another time has left others there."""
        system = self.system
        for name, at in system.tables.inputs.items():
            system.set_input(name, self.F[at])
        for at in self._counters:
            system.set_number(at, self.F[at])

    @property
    def _counters(self) -> list[int]:
        """Where in F the angles are that turns are counted on from."""
        return [body.counter for body in self.system.tables.models.values() if body.counter >= 0]

    @property
    def time(self) -> float:
        """The time reached [s]."""
        if self.tol is not None:
            return float(self.K[state.NOW])
        return float(self.K[state.START] + self.J[state.STEP] * self.h)

    @property
    def step(self) -> float:
        """The length of the next step [s]."""
        return float(self.K[state.H])

    @property
    def steps(self) -> int:
        """Steps taken."""
        return int(self.J[state.STEP])

    @property
    def written(self) -> int:
        """Outputs written to ``out``."""
        return int(self.J[state.OUTPUT])

    def count(self, what: str) -> int:
        """How many "rejected", "iterations", "matrix_evaluations" or "factorisations"."""
        return int(self.J[state.COUNTERS[what]]) if what in state.COUNTERS else 0

    def state(self) -> tuple[Array, Array, Array]:
        """q, v (n,) and lam (m + p,) as they are now; views."""
        n, Y = self.system.n, self.Y
        return Y[layout.Q0, :n], Y[layout.V0, :n], Y[layout.XA, n : self.system.unknowns]

    def advance(self, steps: int = sys.maxsize) -> int:
        """Take at most ``steps`` steps; a status of :mod:`mbdsl.integrators.state`."""
        if self.every:
            status = state.RUNNING
            while steps > 0 and status == state.RUNNING:
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
        """For as many outputs as are written at most before it is asked again."""
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
            while status == state.EVENT:
                self.jumps.come()
                status = call(most - self.steps)
        else:
            status = self.landings.advance(steps, self._call)
        if status == state.EVENT:
            return self.events.come()
        if status == state.SINGULAR and self.solver == linear.SPARSE_LU and self.system.unknowns <= PIVOTING_LIMIT:
            # The order from the graph gave no usable pivots here: go on with a solver that searches for them.
            self._use(linear.DENSE)
            self.pivoting_from = self.time
            self.J[state.FRESH] = 0
            status = self._advance_by(most - self.steps)
        return status

    def _call(self, steps: int) -> int:
        return int(
            self._advance(
                self.evaluate,
                self.tangent,
                self.inertia,
                steps,
                self.c,
                self.K,
                self.J,
                self.Y,
                self.Z,
                self.C,
                self.F,
                self.I,
                self.A,
                self.P,
                self.times,
                self.out,
            )
        )
