"""Backends: third-party integrators, which receive the equations of a system and return states.

A backend is a module (or any object) with

    METHOD           its declaration, a :class:`mbdsl.integrators.Method`
    solve(problem)   a generator of states (t, q, v), or (t, q, v, lam) with lam (m + p,) if METHOD.own_reactions

It yields a state at each of ``problem.times``, and may yield others, in order of time. If the run ends early, the
states yielded so far are kept; a run can be interrupted between two states. Turns of beams in absolute nodal
coordinates are counted from the last state: a backend should therefore yield every step that it has accepted. It
reports a failure by ``IntegrationError`` with the reason. :class:`External` is the run of a backend.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from mbdsl.errors import MbdslError, UsageError
from mbdsl.integrators import backend
from mbdsl.integrators.loop import loop_state as S
from mbdsl.kernels.arrays import Array
from mbdsl.messages import install
from mbdsl.numerics.hermite import between
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.index1 import Index1
from mbdsl.system.peaks_along_motion import OnTheWay, not_searched

if TYPE_CHECKING:
    from mbdsl.integrators.event_set import EventSet
    from mbdsl.system.close_approaches import Approach
    from mbdsl.system.peaks_in_time import Zone


#: status in addition to those of :mod:`mbdsl.integrators.loop.loop_state`; the reason is in ``External.reason``
FAILED = -1


@dataclass(frozen=True)
class Problem:
    """The initial value problem that a backend solves."""

    #: the equations: its methods evaluate single quantities; :class:`mbdsl.system.index1.Index1` and
    #: :class:`mbdsl.system.stabilised_index2.StabilisedIndex2` are reduced forms
    system: System
    start: float
    stop: float
    #: (states,) [s]: times after the start at which a state is needed; the last is ``stop``. With controlled steps
    #: these are the output times. With fixed steps they are the ends of the steps, and outputs between them are
    #: interpolated.
    times: Array
    #: (n,): consistent initial state, with accelerations
    q: Array
    v: Array
    a: Array
    lam: Array  #: (m + p,): initial multipliers
    left_out: tuple[int, ...]  #: redundant constraints: their multipliers are zero
    h: float  #: [s] step size of fixed steps
    #: tolerance of controlled steps: of angles [rad], and of positions relative to the mechanism's size; see
    #: ``tolerances``
    tol: float | None
    options: Mapping[str, float | None]  #: parameters of the method
    #: [s] known times of jumps and corners of the equations, in order; no step should pass over one. They are generated
    #: lazily, because there may be very many. Other jumps and corners are detected by ``System.switches``.
    breaks: Iterable[float] = ()
    #: intervals of time (``start``, ``end``) [s] in each of which a step should end, because a law or table has a peak
    #: there that a longer step would miss; ordered by their ends, and generated lazily
    zones: Iterable[Zone] = ()
    longest: float = np.inf  #: [s] largest allowed size of controlled steps
    #: the backend fills in "steps", "rejected", "iterations" (of Newton's method),
    #: "matrix_evaluations", "factorisations", "evaluations" (of the equations), and "events" (jumps encountered)
    counts: Counter[str] = field(default_factory=Counter)
    #: the backend fills in states at which a condition almost changes (:mod:`mbdsl.system.close_approaches`)
    approaches: list[Approach] = field(default_factory=list)
    #: (3,): what the search for peaks keeps (:mod:`mbdsl.system.peaks_along_motion`)
    searched: Array = field(default_factory=not_searched)
    events: EventSet | None = None  #: what acts at events, if METHOD.knows them; it has acted at the start

    @property
    def peaks(self) -> OnTheWay:
        """The search for peaks of laws of the state that lie between two states of the solution."""
        return self.system.kept(OnTheWay)

    def tolerances(self) -> tuple[Array, Array]:
        """Absolute tolerances of all coordinates and of all velocities, (n,) each.

        Tolerances of velocities are ``tol`` times a reference velocity. This is the largest of the initial velocity,
        the mechanism's size per length of the run, and the geometric mean of that and of the velocity that the initial
        acceleration reaches over the mechanism's size. It is a mean because this acceleration may belong to a short
        transient.
        """
        assert self.tol is not None
        scale, slow = self.system.tables.scale, 1.0 / ((self.stop - self.start) or 1.0)
        speed = float(np.abs(self.v * scale).max(initial=0.0))
        pace = float(np.sqrt(np.abs(self.a * scale).max(initial=0.0)))
        return self.tol / scale, self.tol * max(speed, slow, np.sqrt(pace * slow)) / scale


@dataclass(eq=False)
class External:
    """A run by a backend; see :class:`mbdsl.integrators.Run`. With ``every``, all states and their times are kept.

    After a failure, ``reason`` and ``hint`` are its reason and remedy, and ``cause`` is the exception of the backend.
    """

    system: System
    method: str
    h: float
    start: float
    stop: float
    times: Array
    options: Mapping[str, float | None]
    tol: float | None = None
    every: bool = False
    longest: float = np.inf

    def __post_init__(self) -> None:
        start, stop = self.start, self.stop
        self.times = np.array([stop] if stop > start else []) if self.every else self.times.copy()
        self._backend = backend(self.method)
        due = self.times.copy() if self.tol is not None else _ends_of_steps(start, stop, self.h)
        self._given: dict[str, Any] = {"start": start, "stop": stop, "times": due, "h": self.h, "tol": self.tol}
        self._given |= {"longest": self.longest, "options": dict(self.options)}
        self.out = np.zeros((len(self.times), self.system.n + self.system.unknowns))
        self.pivoting_from: float | None = None
        self.written = 0
        self.time = start
        self.reason, self.hint = "", ""
        self.cause: Exception | None = None
        self.approaches: list[Approach] = []
        self.searched = not_searched()
        self._counts: Counter[str] = Counter()
        self.system.kernels(self._backend.METHOD.sets)
        self.event_set: EventSet | None = None
        self.begun: tuple[Array, Array, Array] | None = None  #: q, v, lam behind an event at the start
        if self._backend.METHOD.knows and self.system.scene.has_events:
            from mbdsl.integrators.event_set import EventSet

            self.event_set = EventSet(self.system)

    @property
    def steps(self) -> int:
        """Steps taken."""
        return self.count("steps")

    def count(self, what: str) -> int:
        """A number in ``Problem.counts``; 0 if the backend does not count it."""
        return int(self._counts[what])

    def begin(self, q: Array, v: Array, a: Array, lam: Array, left_out: tuple[int, ...] = ()) -> None:
        """Set the consistent initial state, and the redundant constraints that are left out."""
        span = self._given["start"], self._given["stop"]
        from mbdsl.system.peaks_in_time import Replayed

        zones = self.system.time_zones(*span, longest=span[1] - span[0])
        given = {**self._given, "breaks": Replayed(self.system.time_events(*span)), "zones": zones}
        if self.event_set is not None:
            q, v, lam = self.begun = self._act_at_start(q, v, left_out)
            left_out = self.event_set.all_left_out(left_out)
            given["events"] = self.event_set
        problem = Problem(self.system, q=q, v=v, a=a, lam=lam, left_out=left_out, counts=self._counts, **given)
        self.approaches, self.searched = problem.approaches, problem.searched
        self._q, self._v, self._lam = q, v, lam
        self._left_out, self._index1 = left_out, Index1(self.system, left_out)
        for name, body in self.system.tables.models.items():
            self.system.set_turn(name, body.turn)
        self.system.count_angles_from_start()
        self._states: Iterator[tuple] = iter(self._backend.solve(problem))

    def _act_at_start(self, q: Array, v: Array, left_out: tuple[int, ...]) -> tuple[Array, Array, Array]:
        """q, v and lam behind the event at the start; later, the method solves the contacts."""
        events, start, stop = self.event_set, self._given["start"], self._given["stop"]
        assert events is not None
        v = events.begin(start, stop, q, v, events.left_out(left_out), self._given["tol"])
        _, lam = accelerations(self.system, start, events.q, v, events.left_out(left_out))
        events.contacts = None
        return events.q, v, lam

    def advance(self, steps: int) -> int:
        """Take at most ``steps`` states from the backend; return a status of ``loop_state``, or FAILED."""
        for _ in range(steps):
            if self.event_set is not None and self.event_set.status != S.RUNNING:
                return self.event_set.status
            if self._done:
                return self._ended()
            try:
                self._keep(*_state(next(self._states)))
            except StopIteration:
                return self._fail("it ended before the stop time", None)
            except MbdslError as problem:
                self.hint = problem.hint or ""
                return self._fail(problem.message, problem)
            except Exception as problem:
                return self._fail(f"{type(problem).__name__}: {problem}", problem)
        if self.event_set is not None and self.event_set.status != S.RUNNING:
            return self.event_set.status
        return self._ended() if self._done else S.RUNNING

    def _ended(self) -> int:
        if self.event_set is not None:
            self.event_set.end(self.time, self._q, self._v, self._left_out)
            return self.event_set.status or S.DONE  # an assertion may fail there
        return S.DONE

    @property
    def _done(self) -> bool:
        times = self._given["times"]
        return not len(times) or self.time == times[-1]

    def _fail(self, reason: str, cause: Exception | None) -> int:
        self.reason, self.cause = " ".join(reason.split()), cause
        return FAILED

    def _keep(self, t: float, q: Array, v: Array, lam: Array | None = None) -> None:
        """Check a state of the backend and keep it; write it if it belongs to the next output time."""
        times = self._given["times"]
        last = int(np.searchsorted(times, self.time, side="right"))  # index of the next output time
        due, before = float(times[last]), float(times[last - 1]) if last else self._given["start"]
        near = 1e-9 * (due - before)
        if not self.time - near <= t <= due + near:
            raise ValueError(f"it yielded t = {t:.9g} s after {self.time:.9g} s, with an output due at {due:.9g} s")
        q, v = np.array(q, float), np.array(v, float)  # copies: the backend may change its arrays
        if q.shape != (self.system.n,) or v.shape != q.shape:
            raise ValueError(f"it yielded q and v of shapes {q.shape} and {v.shape} for n = {self.system.n}")
        if not (np.isfinite(q).all() and np.isfinite(v).all()):
            raise ArithmeticError(f"its state at t = {t:.9g} s has values that are not finite")
        given = np.full(len(self._lam), np.nan) if lam is None else lam
        on_time = t >= due - near
        moved = t > self.time
        self.system.count_turns(q)
        self.system.count_angles_up_to(t, q)
        before = self.time, self._q, self._v, self._lam
        self.time = due if on_time else max(self.time, float(t))  # no output is written twice
        self._q, self._v, self._lam = q, v, given
        if self.every:
            if on_time or moved:
                self._write(np.concatenate([q, v, given]))
        elif on_time:
            self._write_outputs(*before)

    def _write_outputs(self, t: float, q: Array, v: Array, lam: Array) -> None:
        """Write the outputs after the state at t, up to the present one: those between are interpolated."""
        near = 1e-9 * (self.time - t)
        while self.written < len(self.out) and (output := float(self.times[self.written])) <= self.time + near:
            row = self._q, self._v, self._lam
            if output < self.time - near:
                qs, vs, lams = (np.array(pair) for pair in ((q, self._q), (v, self._v), (lam, self._lam)))
                rotations = self.system.tables.rotations[:, 0]
                found = between(np.array([output]), np.array([t, self.time]), qs, vs, lams, rotations)
                own_q, own_v = (x[0] for x in found[:2])
                held = self._index1.project(output, self._index1.join(own_q, own_v))
                row = *self._index1.split(held), found[2][0]
            self._write(np.concatenate(row), output)

    def _write(self, row: Array, t: float | None = None) -> None:
        if self.written == len(self.out):  # only if all states are kept
            more = max(64, self.written)
            self.out = np.concatenate([self.out, np.zeros((more, self.out.shape[1]))])
            self.times = np.concatenate([self.times, np.full(more, np.inf)])
        self.out[self.written], self.times[self.written] = row, self.time if t is None else t
        self.written += 1

    def state(self) -> tuple[Array, Array, Array]:
        """The present q, v (n,) and lam (m + p,)."""
        return self._q, self._v, self._lam

    def synchronise(self) -> None:
        """Nothing: inputs and counted turns of the run are those of the system."""

    def change_inputs(self, inputs: Mapping[str, float]) -> int:
        raise UsageError(f"{self.method} cannot change inputs during a run", hint="take a method with fixed steps")


def _ends_of_steps(start: float, stop: float, h: float) -> Array:
    """The ends of equal steps (N,) [s], of which the last is ``stop``."""
    count = round((stop - start) / h)
    return np.append(start + h * np.arange(1, count), stop) if count else np.empty(0)


def _state(found: object) -> tuple:
    """What a backend yields, if it is a tuple of three or four."""
    if not isinstance(found, tuple) or len(found) not in (3, 4):
        what = f"a tuple of {len(found)}" if isinstance(found, tuple) else f"a {type(found).__name__}"
        raise TypeError(f"it yielded {what}, expected (t, q, v) or (t, q, v, lam)")
    return found


def require(module: str, extra: str, name: str):
    """Import the ``module`` that the backend ``name`` needs.

    Raises
    ------
    UsageError
        If it is not installed; the remedy names the ``extra`` of mbdsl that installs it.
    """
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError:
        raise UsageError(f"{name} needs {module.split('.')[0]}", hint=install(extra)) from None
