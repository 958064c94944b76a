"""The run of a compiled method on one system: its buffers, start and restart, and calls of the compiled step loop."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from copy import copy
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mbdsl.compilation import code_cache
from mbdsl.errors import InitialisationError, UsageError
from mbdsl.integrators import declared, input_jumps, modules
from mbdsl.integrators.events import PRECISE, Restart, SwitchEvents
from mbdsl.integrators.loop import linear_solve, step_control
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.compiled_loop import compiled, controls_locally, loop_name
from mbdsl.integrators.loop.run_data import CHANGED, RunData
from mbdsl.integrators.loop.step_times import representable
from mbdsl.integrators.method import Method, Start
from mbdsl.integrators.missed_peaks import Overlooked
from mbdsl.integrators.output_times import OutputTimes
from mbdsl.integrators.peak_zones import Landings, landing_part
from mbdsl.integrators.run_state import RunState
from mbdsl.integrators.scheduled_jumps import Jumps, behind_a_jump
from mbdsl.integrators.standstill import WINDOW, Standstill
from mbdsl.integrators.start_values import applied, check_stiffness, first_step, normal_part, onto_constraints, rates
from mbdsl.kernels import buffer_layout as L
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.massless import massless
from mbdsl.system.peaks_along_motion import OnTheWay, not_searched

Array = NDArray[np.float64]

#: h^3 times the initial jerk, relative to the mechanism's size, above which the jerk belongs to a transient
TRANSIENT = 1e-4
#: time over which accelerations at the start are differentiated, relative to h
RATES = 1e-3
#: longest controlled step relative to the run, unless a shorter one is given: a longer step could pass over events of
#: expressions
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


def longest_part(system: System, method: str) -> float:
    """The longest controlled step of a method relative to the run."""
    return LONGEST if system.tables.has_tape else declared(method).longest


class MethodRun(RunState):
    """One run of a compiled method from a consistent initial state."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self.overlooked: Overlooked | None = None
        self.begun: tuple[Array, Array, Array] | None = None  #: q, v, lam behind an event at the start
        self._rates: tuple | None = None
        self._prepare()
        self._load()

    def anew(
        self, times: Array, tol: float | None, every: bool, longest: float, rows: OutputTimes | None = None
    ) -> MethodRun:
        """A copy of this run for the same System, before its start, with other output times and tolerance."""
        run = copy(self)
        run.times, run.tol, run.every, run.longest, run.pivoting_from = times, tol, every, longest, None
        run.rows = rows
        if tol is not None:  # that of the last step may be zero, after an event at the stop time
            run.h = (run.stop - run.start) or run.h
        del run.vectors, run.layout
        run._prepare()
        return run

    def _prepare(self) -> None:
        """Allocate the buffers, and set the constants of the run in them."""
        self.allocate()
        if self.tol is not None:
            self._stop_at_events()
        if self.controlled:
            self._control(modules()[self.method].METHOD)
        if self.rows is not None:
            longest = self.h if self.tol is None else self.reals[S.MOST_H]
            self.integers[S.MARGIN] = 2 + int(np.ceil(1.5 * longest / self.rows.spacing))
            if 2 * self.integers[S.MARGIN] > len(self.times):
                raise ValueError("the window of the output is too small for the longest step")

    def _load(self) -> None:
        """Load or compile the step loop of the method and the functions of the scene."""
        module = modules()[self.method]
        sets = module.METHOD.sets
        code, loop = self.system.module_name(sets), loop_name(self.method)
        # If both have to be compiled: the scene's code in another process, and the method's loop here at the same time
        with code_cache.lock:
            both = not code_cache.is_compiled(code) and not code_cache.is_compiled(loop)
            other = self.system.compile_beside(sets) if both else None
            try:
                self._advance = compiled(self.method, module)
            finally:
                if other is not None:
                    other.wait()
            kernels = self.system.kernels(sets)
        self.evaluate, self.tangent, self.inertia = kernels.evaluate, kernels.tangent, kernels.inertia

    def _stop_at_events(self) -> None:
        """Prepare switches, zones and the bounds of the step size, for a run with a tolerance."""
        self.events = SwitchEvents(self, self.change_inputs)
        self.landings = Landings(self, self.events.blame, self.events.set)
        self.standstill = Standstill(self)
        self.seen = np.zeros(len(self.system.kept(OnTheWay).terms))  # largest values of these terms so far
        self.searched = not_searched()
        reals, integers, span = self.reals, self.integers, self.span
        integers[S.EVERY] = self.every
        reals[[S.NEXT_EVENT, S.KNOWN]] = np.inf
        reals[S.MOST_H] = min(self.longest, longest_part(self.system, self.method) * span)
        reals[S.WITHIN] = landing_part(modules()[self.method].METHOD.order, reals[S.TOL])
        self.set_stop(self.reals[S.STOP])

    def set_stop(self, t: float) -> None:
        """Let the compiled loop end at time t, and set the shortest step to the rounding error of times."""
        self.reals[S.STOP] = t
        self.reals[S.LEAST_H] = max(1e-14 * self.span, 16.0 * np.finfo(float).eps * max(abs(self.start), abs(t)))

    def _control(self, method: Method) -> None:
        reals, integers, span, tol = self.reals, self.integers, self.span, self.reals[S.TOL]
        integers[S.CONTROLLED], integers[S.LANDING] = True, method.order == 0 and not self.every
        reals[S.SPEED] = 1.0 / span if span > 0.0 else 1.0
        between = self.times[0] - self.start if len(self.times) and not self.every else span
        reals[S.FORGOTTEN] = min(span / POINTS, between)
        reals[S.EXPONENT] = 1.0 / (method.order + 1)
        kept = np.array([step_control.KEPT_TO, step_control.KEPT_FROM])
        reals[[S.GOOD, S.BAD]] = step_control.AIM * kept ** -(method.order + 1.0)
        reals[S.LARGEST] = min(LARGEST, (100.0 * tol) ** 0.25)  # interpolation between steps has order 4
        reals[S.NODE] = method.node(self.coefficients)
        reals[S.MASS_WEIGHT] = method.mass_weight(self.coefficients)
        reals[S.DAMPING] = method.damping_weight(self.coefficients)

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
        controlled = self.controlled
        if t is None and self.tol is not None and self.events.set is not None:
            q, v, a, lam = self._act_at_start(q, v, a, lam)
            left_out = self.left_out
        self.mark_left_out()
        system, t0 = self.system, self.start if t is None else t
        method, largest = modules()[self.method].METHOD, self._largest
        if method.inverts_mass:
            self._check_masses()
        if controlled:
            left = max(self.stop - t0, self.reals[S.LEAST_H])
            self.h = 1e-2 / max(1.0 / left, largest(v), largest(a) ** 0.5)
        behind = t0
        if t is None and (behind := behind_a_jump(system, t0, self.stop)) > t0:
            a, lam = accelerations(system, behind, q, v, left_out)
        fa, jerk, fa_rate = self._rates_at(behind, q, v, a, lam)
        found = jerk
        if self.grid:
            self.h = self._to_grid(t0)
        elif controlled:
            self.h = min(self._first_step(v, a, jerk), longest) if h is None else h
            self.h = representable(self.h, self)
        if method.inverts_mass:
            check_stiffness(system, self.method, t0, self.h, q, v, lam)
        fixed = self.grid > 0.0 or not controlled
        stiff = fixed and self.h * largest(jerk) > largest(a) and self.h**3 * largest(jerk) > TRANSIENT
        if stiff:  # the method damps the transient; extrapolated over a step, its rates would spoil the start values
            jerk, fa_rate = np.zeros(system.n), np.zeros(system.n)
        if t is None:
            self._write_numbers()
        in_charts = self._write_start(t0, q, v, a)
        self._begin_method(
            method, Start(self.h, in_charts, v, a, lam, fa, jerk, fa_rate, stiff), t is None or controlled
        )
        if controlled:
            self._begin_control(t0, q, v, jerk)
        elif self.tol is not None:
            self._begin_own(t0, min(self.span, self.stop - t0, longest), found if method.order > PRECISE else jerk)
        if t is None:
            self._begin_events(behind, q, v, lam)
        self._make_ready(t0)

    def _make_ready(self, t: float) -> None:
        """Evaluate the gradients at the start of the first step."""
        self.evaluate(t, self.vectors, self.frames, self.gradients, self.numbers, self.layout)
        self.layout[L.KEEP] = 1
        self.integers[S.HISTORY], self.integers[S.AIMED] = 1, 0
        self.keep_state()

    def _largest(self, x: Array) -> float:
        """The largest of coordinates or rates (n,), in the mechanism's size and in radians."""
        return float(np.abs(x * self.system.tables.scale).max(initial=0.0))

    def _write_numbers(self) -> None:
        """Write the numbers that count turns, and discrete variables, at the start of the run."""
        counters = list(self.system.tables.counters)
        self.numbers[counters] = self.system.tables.numbers[counters]
        if self.tol is not None and self.events.set is not None:
            for at, value in self.events.set.numbers().items():
                self.numbers[at] = value

    def _write_start(self, t: float, q: Array, v: Array, a: Array) -> Array:
        """Write the state at the start of the first step; returns its positions in charts."""
        n, vectors = self.system.n, self.vectors
        in_charts = self.system.into_charts(q, self.numbers)
        vectors[L.POSITION0, :n] = vectors[L.POSITION, :n] = in_charts
        vectors[L.VELOCITY0, :n] = vectors[L.VELOCITY, :n] = v
        vectors[L.FORCE0, :n] = self.system.M(t, q) @ a
        return in_charts

    def _act_at_start(self, q: Array, v: Array, a: Array, lam: Array) -> tuple[Array, Array, Array, Array]:
        """q, v, a and lam behind the event at the start."""
        events = self.events.set
        assert events is not None
        v = events.begin(self.start, self.start + self.span, q, v, events.left_out(self.left_out), self.tol)
        q, self.left_out = events.q, events.left_out(self.left_out)
        if events.acted or events.contacts is not None or events.friction is not None:
            a, lam = accelerations(self.system, self.start, q, v, self.left_out)
            self.begun = q, v, lam
        return q, v, a, lam

    def _rates_at(self, t: float, q: Array, v: Array, a: Array, lam: Array) -> tuple[Array, Array, Array]:
        """Applied forces, jerk and rate of the applied forces; those of the last call are kept."""
        key = t, self.h, q.tobytes(), v.tobytes(), a.tobytes()
        if self._rates is None or self._rates[0] != key:
            self._rates = key, rates(self.system, t, RATES * self.h, q, v, a, lam, self.left_out)
        return self._rates[1]

    def _begin_method(self, method: Method, start: Start, anew: bool) -> None:
        """Set the method's rows and the unknowns, and ``anew`` its memory."""
        vectors = self.vectors
        if anew:
            self.memory = np.array(method.memory(self.coefficients, start), float)
        for row, vector in method.begin(self.coefficients, start).items():
            vectors[row, : len(vector)] = vector
        vectors[L.UNKNOWN] = vectors[L.UNKNOWN0]
        vectors[L.UNKNOWN2] = vectors[L.UNKNOWN0 + L.PAST]

    def _check_masses(self) -> None:
        free = massless(self.system.tables)
        if free.shape[1]:
            name = self.system.names()[int(np.abs(free[:, 0]).argmax())]
            raise InitialisationError(
                f"{self.method} divides forces by masses, but {name} has none",
                hint="give it a mass, or take another method",
            )

    def _begin_events(self, behind: float, q: Array, v: Array, lam: Array) -> None:
        """Find the first times at which steps have to end; ``behind`` the start, if forces jump there."""
        has_order = modules()[self.method].METHOD.order > 0
        if self.tol is None and has_order:
            self.jumps = Jumps(self.system, self.start, self.stop, self.h)
            self.reals[S.NEXT_EVENT] = self.jumps.next[0]
        elif self.tol is not None:
            if has_order:
                self.events.begin(behind, q, v, lam)
            self.landings.begin(self.start)

    def watch(self) -> None:
        """Keep the ends of all steps, and search fixed steps for peaks of laws that they pass over.

        To be called before the first step.
        """
        self.keeps = True
        if self.tol is not None:
            self.landings.record()
        elif self.stop > self.start:
            self.overlooked = Overlooked(self)
        self.keep_state()

    def forgo(self) -> None:
        """Keep no further ends of steps."""
        self.keeps, self.ends = False, []
        if self.tol is not None:
            self.landings.record()
        elif self.overlooked is not None:
            self.overlooked.finish()

    def flush(self) -> None:
        """Keep the ends of steps that are still in the buffer of the compiled loop."""
        if self.overlooked is not None:
            self.overlooked.finish()
        elif self.integers[S.THIN]:
            self.drain()

    def _to_grid(self, t: float) -> float:
        """The first step from t on, of a run with fixed steps that ends steps at events."""
        self.reals[S.NOW] = t
        return float(step_control.to_grid(self))

    def _first_step(self, v: Array, a: Array, jerk: Array) -> float:
        module, reals, scale = modules()[self.method], self.reals, self.vectors[L.SCALE, : self.system.n]
        span = self.stop - self.start
        h = min(0.01 * span, reals[S.MOST_H], 10.0 * self.h)
        speed = max(reals[S.SPEED], float(np.abs(v * scale).max(initial=0.0)))
        if module.METHOD.order == 0:
            return min(h, 0.5 * reals[S.LARGEST] / speed, *self.times[:1] - self.start)
        allowed = step_control.AIM * step_control.SHARE * reals[S.TOL]
        error = partial(module.local_error, h, h, self.coefficients)
        return first_step(h, error, allowed, reals[S.EXPONENT], (scale, speed, span), a, jerk, RATES * self.h)

    def _begin_control(self, t: float, q: Array, v: Array, jerk: Array) -> None:
        """Begin a history of controlled steps: it has the accelerations of a fictitious step before the start."""
        system, reals, integers, h, n = self.system, self.reals, self.integers, self.h, self.system.n
        reals[S.NOW], reals[S.STEP_SIZE], reals[S.LAST_H] = t, h, h
        if reals[S.EXPONENT] < 1.0:
            reals[S.UNIT] = h * h
        integers[S.SAME] = integers[S.SINCE] = integers[S.IN_A_ROW] = integers[S.FRESH] = integers[S.ORDER] = 0
        method = modules()[self.method].METHOD
        a = L.UNKNOWN0 + L.PAST * (method.acceleration_row - L.UNKNOWN)
        self.vectors[a + 1, :n] = self.vectors[a, :n] - h * jerk
        first = t + (reals[S.NODE] - 1.0) * h
        reals[S.NODES : S.NODES + 2] = first, first - h
        reals[S.TIMES : S.TIMES + 2] = t, t - h
        velocity_error = getattr(modules()[self.method], "velocity_error", None)
        if velocity_error is not None:
            error = velocity_error(h, h, self.coefficients) * normal_part(system, t, q, v, jerk, self.left_out)
            self.vectors[L.VELOCITY0, :n] += error
            self.vectors[L.KEPT2, :n] += error  # v of the previous step, in methods that read this row

    def _begin_own(self, t: float, longest: float, jerk: Array) -> None:
        """Begin a history for a method that controls its own steps; its first step is at most ``longest``."""
        reals, n, d = self.reals, self.system.n, 1e-3 * self.h
        reals[S.NOW], reals[S.STEP_SIZE], reals[S.LAST_H], reals[S.UNCUT] = (
            t,
            longest,
            longest,
            longest,
        )
        self.integers[S.FRESH] = 0
        self.vectors[L.UNKNOWN0 + 1, :n] = self.vectors[L.UNKNOWN0, :n] - d * jerk
        reals[S.NODES : S.NODES + 2] = t, t - d

    def change_inputs(self, inputs: Mapping[str, float]) -> int:
        """Set inputs to new values from the present time on; accelerations and forces jump accordingly; a status, of
        when-equations that act on them.

        The history of a method is linear in accelerations and forces, and the jump is added to it. Order 2 is therefore
        kept over any number of jumps.
        """
        system, t = self.system, self.time
        used = {name: value for name, value in inputs.items() if name in system.tables.inputs}
        events = self.events.set if self.tol is not None else None
        outside = {} if events is None else {name: x for name, x in inputs.items() if name in events.inputs}
        if events is not None:
            if outside and events.contacts is not None:  # gaps may jump
                events.contacts.before(t, self.state()[0], events.values)
            events.inputs |= outside

        def change() -> None:
            for name, value in used.items():
                system.set_input(name, value)
                self.numbers[system.tables.inputs[name]] = value

        if system.kept(input_jumps.acts_by_forces):
            vectors, n = self.vectors, system.n
            q = system.out_of_charts(vectors[L.POSITION0, :n], self.numbers)
            v = vectors[L.VELOCITY0, :n]
            self.synchronise()
            self._add(input_jumps.jump(system, t, q, v, self.left_out, change))
        else:
            self.jump(t, t, change)
        if self.tol is not None:
            self.events.resume()
        if outside and events is not None and events.due(self.time, *self.state()[:2], self.left_out):
            return self.act()
        return S.RUNNING

    def act(self, k: int | None = None, value: float = 0.0, numbers: Mapping[str, float] | None = None) -> int:
        """The event of a change from outside at the present time: of the velocity of coordinate ``k``, or of discrete
        variables; a status.

        Raises
        ------
        InitialisationError
            If accelerations do not exist.
        """
        v = self.state()[1].copy()
        if k is not None:
            v[k] = value
        return self._restarted(*self.events.changed(v, numbers or {}))

    def drift(self, t: float) -> int:
        """Move on to time t, so near that accelerations are constant until then, or to an event before it; a status.

        A step so short would magnify rounding.
        """
        system, left_out, due = self.system, self.left_out, float(self.reals[S.NEXT_EVENT])
        end = min(t, due)
        s = end - self.time
        self.synchronise()
        q, v, _ = self.state()
        a, _ = accelerations(system, self.time, q, v, left_out)
        q, v = onto_constraints(system, end, system.moved(q, s * (v + s / 2 * a)), v + s * a, left_out)
        a, lam = accelerations(system, end, q, v, left_out)
        self.begin(q, v, a, lam, left_out, t=end, longest=self.longest)
        return self.cross_event() if due <= t else S.RUNNING

    def set_velocity(self, k: int, value: float) -> None:
        """Set the velocity of a coordinate that no constraint contains, and restart.

        Raises
        ------
        InitialisationError
            If accelerations do not exist.
        """
        system, n, t = self.system, self.system.n, self.time
        self.synchronise()
        q = system.out_of_charts(self.vectors[L.POSITION0, :n].copy(), self.numbers)
        v = self.vectors[L.VELOCITY0, :n].copy()
        v[k] = value
        a, lam = accelerations(system, t, q, v, self.left_out)
        self.begin(q, v, a, lam, self.left_out, t=t)

    def jump(self, before: float, behind: float, change: Callable[[], None] = lambda: None) -> None:
        """Add a jump of accelerations and forces to the history.

        It is the difference between two times, equal up to rounding, or the effect of ``change()`` at one time.

        Raises
        ------
        InitialisationError
            If accelerations do not exist, as in a singular pose.
        """
        system, vectors, n = self.system, self.vectors, self.system.n
        q = system.out_of_charts(vectors[L.POSITION0, :n], self.numbers)
        v = vectors[L.VELOCITY0, :n]
        self.synchronise()
        old = accelerations(system, before, q, v, self.left_out)
        fa = applied(system, before, q, v, old[1])
        change()
        new = accelerations(system, behind, q, v, self.left_out)
        a, lam = new[0] - old[0], new[1] - old[1]
        fa = applied(system, behind, q, v, new[1]) - fa
        self._add(input_jumps.Jump(a, lam, fa, system.M(behind, q) @ a))

    def _add(self, jump: input_jumps.Jump) -> None:
        """Add a jump to the history."""
        vectors, nothing = self.vectors, np.zeros(self.system.n)
        h = float(self.reals[S.LAST_H]) if self.controlled else self.h
        start = Start(h, nothing, nothing, jump.a, jump.lam, jump.fa, nothing, nothing, False)
        method = modules()[self.method].METHOD
        rows = {L.FORCE0: jump.force, **method.begin(self.coefficients, start)}
        older = len(vectors) - 2 * method.older
        histories = {
            L.UNKNOWN0: older,
            L.UNKNOWN0 + L.PAST: older + method.older,
        }
        for row, part in rows.items():
            past = L.PAST if row in histories else 1
            vectors[row : row + past, : len(part)] += part
            if row in histories:
                vectors[histories[row] : histories[row] + method.older, : len(part)] += part

    def _cross_jump(self) -> None:
        """Continue behind a scheduled jump of forces; the last step has ended shortly before it."""
        if self.time < self.stop:
            with suppress(InitialisationError):  # in a singular pose, which has no accelerations: keep the old history
                self.jump(*self.jumps.next)
                self.keep_state()
            self.integers[S.FRESH] = 0
            if not controls_locally(self.method):
                self.integers[S.HISTORY] = 1
        self.jumps.go_on()
        self.reals[S.NEXT_EVENT] = self.jumps.next[0]

    def cross_event(self) -> int:
        """Restart after a switch, if one changes where the last step ended; a status."""
        return self._restarted(*self.events.come())

    def _restarted(self, status: int, restart: Restart | None) -> int:
        """The status after an event, behind which the run restarts."""
        if self.events.set is not None:
            self.events.set.put(self)
        if restart is not None:
            t, q, v, a, lam, longest = restart
            try:
                self.begin(q, v, a, lam, self.left_out, t=t, longest=longest)
            except InitialisationError:
                return self.events.no_accelerations(t, q, v)
            if t >= self.stop:
                self._record_end(q, v, lam)
        return status

    def _record_end(self, q: Array, v: Array, lam: Array) -> None:
        """Output at the stop time, if no step has ended there: an event at this time comes behind the last step."""
        k = int(self.integers[S.OUTPUT])
        if self.every:
            self._make_room()
            self.times[k] = self.stop
        if k < len(self.times) and self.times[k] <= self.stop:
            self.out[k] = np.concatenate([q, v, lam])
            self.integers[S.OUTPUT] = k + 1

    def widen(self, start: Array, far: float) -> None:
        """Scale lengths by the largest displacement from ``start`` (n,) if that exceeds ``far`` times their scale."""
        vectors, reals, lengths = self.vectors, self.reals, self.system.tables.lengths
        way = (vectors[L.POSITION0, : self.system.n] - start) * vectors[L.SCALE, : self.system.n]
        longest = float(np.abs(way[lengths]).max(initial=0.0))
        if longest > far:
            vectors[L.SCALE, : self.system.n][lengths] /= longest
            reals[S.SPEED] = max(reals[S.SPEED] / longest, 1.0 / (self.stop - self.start))

    def advance(self, steps: int = sys.maxsize) -> int:
        """Take at most ``steps`` steps; return a status of :mod:`mbdsl.integrators.loop.loop_state`.

        Fewer steps are taken if the window of the output is full, and in a run with a tolerance at most ``WINDOW``.

        Raises
        ------
        UsageError
            If every step is output, the rows are not released, and they would need too much memory.
        """
        if self.tol is not None and self.events.set is not None and self.events.set.status != S.RUNNING:
            return self.events.set.status  # as at the start
        if self.every:
            status = S.RUNNING
            while steps > 0 and status == S.RUNNING:
                self._make_room()
                if self.out.size > MOST_OUTPUT:
                    raise UsageError(
                        f"{self.written} steps of {self.out.shape[1]} numbers until t = {self.time:g} s do not fit in "
                        "memory",
                        hint="give an output interval",
                    )
                status = self._advance_by(min(steps, ROOM))
                steps -= ROOM
            return self._examined(status)
        status = self._advance_by(steps if self.tol is None else min(steps, WINDOW))
        events = self.events.set if self.tol is not None else None
        if status == S.DONE and events is not None and (events.ended or self.time >= self.stop):
            q, v, lam = self.state()
            if self.time >= self.stop:
                self._record_end(q, v, lam)
            events.end(self.time, q, v, self.left_out)
            status = events.status or S.DONE  # an assertion may fail there
        return self._examined(S.RUNNING if status == S.FULL else status)

    def _examined(self, status: int) -> int:
        """The status after steps, or that of a run that stands still."""
        if self.tol is None:
            return status
        if self.every:
            self._make_room()
        return self.standstill.look(status, self._advance_by)

    def _make_room(self) -> None:
        """Allocate rows of output for the next ``ROOM`` steps."""
        used = int(self.integers[S.OUTPUT])
        if len(self.times) < used + ROOM:
            more = max(ROOM, used // 2)
            self.times = np.concatenate([self.times[:used], np.full(more, np.inf)])
            self.out = np.concatenate([self.out[:used], np.empty((more, self.out.shape[1]))])

    def _advance_by(self, steps: int) -> int:
        most = self.steps + steps
        if self.tol is None:
            call = self._call if self.overlooked is None else partial(self.overlooked.advance, call=self._call)
            return self._continued(call(steps), most, call)
        return self._continued(self.landings.advance(steps, self._call), most, self._call)

    def prepared(self) -> Callable[[int], int]:
        """The step loop as a function of the number of fixed steps, valid until a buffer is replaced.

        If it returns another status than RUNNING, :meth:`continued` has to follow.
        """
        prepare = getattr(self._advance, "prepared", None)  # code that is not compiled has none
        return self._call if prepare is None else prepare(1, self.times, self.out, *self.data())

    def continued(self, status: int, most: int) -> int:
        """Continue up to step ``most`` after a call of ``prepared()`` that returned ``status``; a status."""
        return self._continued(status, most, self._call)

    def _continued(self, status: int, most: int, call: Callable[[int], int]) -> int:
        while self.tol is None and status == S.EVENT:
            self._cross_jump()
            status = call(most - self.steps)
        if status == S.EVENT:
            return self.cross_event()
        if status == S.SINGULAR and self.solver == linear_solve.SPARSE_LU and self.system.unknowns <= PIVOTING_LIMIT:
            # the elimination order gives no usable pivot here: continue with the dense solver with pivoting
            self.use_solver(linear_solve.DENSE)
            self.pivoting_from = self.time
            self.integers[S.FRESH] = 0
            status = self._advance_by(most - self.steps)
        return status

    def data(self) -> RunData:
        """The arguments of the step loop's kernels."""
        buffers = (getattr(self, name) for name in ("coefficients", *CHANGED))
        return RunData(self.evaluate, self.tangent, self.inertia, *buffers)

    def _call(self, steps: int) -> int:
        status = int(self._advance(steps, self.times, self.out, *self.data()))
        if self.layout[L.TICKS]:
            assert self.events.set is not None
            self.events.set.take(self)
        return status
