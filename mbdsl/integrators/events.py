"""Events: location of the exact time at which a switch changes, and restart of the run behind it.

A step ends shortly before a switch (:mod:`mbdsl.integrators.loop.switch_location`), or at a known time. The motion over
the remaining time s to the switch has constant acceleration: q + s v + s^2/2 a, v + s a. The steps of methods of order
above 5 are so long that this would limit their accuracy; their acceleration changes linearly, from a to that at s/2,
and the time to the switch is that of this motion, whose v has an error of O(s^3). A projection in the metric of M
removes the constraint error. Behind the switch, a and lam are computed anew; q and v are continuous.

If forces drive the motion back from both sides of a switch, as sign(v) does at rest, events follow one another without
progress of time. No step has a solution there, however short, and the run stops with the message ``SLIDING``.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import dropwhile
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import InitialisationError
from mbdsl.expressions.symbolic import Expr, walk
from mbdsl.integrators import declared
from mbdsl.integrators.contact_errors import UnsolvedContactsError
from mbdsl.integrators.event_set import EventSet, ReinitError
from mbdsl.integrators.final_slide import End, final_slide
from mbdsl.integrators.friction_set import UndecidedFrictionError
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.driver import MOST_PASSED
from mbdsl.integrators.loop.step_times import at_stop
from mbdsl.integrators.loop.switch_location import BEHIND, LEFT, REACTIONS, SHORT_OF, TURNING
from mbdsl.integrators.run_state import RunState
from mbdsl.integrators.shared_friction import At, put
from mbdsl.integrators.start_values import onto_constraints
from mbdsl.kernels import buffer_layout as L
from mbdsl.numerics.first_change import first_change
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.switches import Switch, combined

Array = NDArray[np.float64]
States = NDArray[np.int64]
EPS = float(np.finfo(float).eps)
Way = Callable[[float], tuple[Array, Array]]  #: time from the end of a step -> q, v

#: order above which the acceleration is not constant over the remaining time, and order above which steps end at the
#: corners of forces
PRECISE, CORNERED = 5, 8
#: a run makes no progress if more than this number of events lie within this part of its length, and of the length of
#: this number of steps without events: a relay that switches in every step of a long run makes progress
CROWD, STANDSTILL, STEPS = 10, 1e-5, 100.0
#: nor with MANY events within the part HARDLY of its length: it would take hours. Nor with MANY events within this part
#: of the time so far if the rest would have more than TOO_MANY at this rate, as with a body that bounces ever lower
MANY, HARDLY, TOO_MANY = 100, 1e-4, 1e6
#: the same number of events at times that are known in advance, as at the knots of a table of time. They come to an
#: end, unless a law repeats with a tiny period: the rest would have TOO_MANY_KNOWN at the rate of the last FEW
MANY_KNOWN, FEW, TOO_MANY_KNOWN = 10_000, 40, 1e9
#: operations whose value may change without end
REPEATING = ("mod", "floor", "ceil", "sin", "cos", "tan")
#: perturbation of positions and velocities, relative to the mechanism's size and the largest velocity, that may be
#: rounding of many steps
UNDECIDED = 1e-9
#: the same of one step
ROUNDED = 16 * EPS
#: largest error of the located time to a switch, relative to it; of a first search on the way that is then refined; and
#: the part of it by which a refined way may change it
LOCATED, ROUGH, AROUND = 1e-9, 1e-5, 1e-4
#: number of cuts at one time by reactions after which controlled steps do not become shorter
AGAIN = 3
#: message and remedy of a run without progress
SLIDING = "a condition changes back and forth without end: on both sides of it, forces drive the motion back"
SLIDING_HINT = (
    "make the force continuous, for example by tanh(v/v_s) in place of sign(v); "
    "if it is continuous, or if only rounding errors decide the condition, suppress events: noEvent(abs(x)) for abs(x)"
)
#: time, relative to the run, in which a reaction is searched that becomes zero where steps have become too short
SHORT = 1e-6
#: the same, in which an event that acts is searched behind a step that was cut short
TINY = 1e-9
OF_TIME = "a condition on time changes so often that the run would not end"
OF_TIME_HINT = "use a longer period, or a stop time of a few periods"
#: the same if the condition depends on a reaction
BY_ERROR = "a condition on a reaction changes back and forth without end: the error of the reaction decides it"
BY_ERROR_HINT = (
    "reactions of dop853 follow from the motion, without an error of the step: try --method dop853; "
    "or make the force continuous, as by tanh in place of the condition"
)


def reads_reactions(switch: Switch) -> bool:
    """Whether a switch depends on reactions."""
    return any(leaf.op == "multiplier" for leaf in switch.leaves)


def sliding(switches: Sequence[Switch]) -> tuple[str, str]:
    """Message and remedy of a run without progress, in which these switches change."""
    if switches and all(map(reads_reactions, switches)):
        return BY_ERROR, BY_ERROR_HINT
    if switches and all(map(_of_time, switches)):
        return OF_TIME, OF_TIME_HINT
    return SLIDING, SLIDING_HINT


class Restart(NamedTuple):
    """A state (t, q, v, a, lam) at which a run restarts, and the longest first step [s] after it."""

    t: float
    q: Array
    v: Array
    a: Array
    lam: Array
    longest: float


class SwitchEvents:
    """The switches of a run with controlled steps.

    Attributes
    ----------
    times : list of float
        Times [s] of the events so far: changes of switches at which the run was restarted.
    rounding : list of float
        The change of a scaled velocity [1/s] at each of them that is due to rounding of its time: decimals of a model
        are rounded, and so is the width of a window between two of them.
    """

    def __init__(self, run: RunState, change: Callable[[dict[str, float]], object]) -> None:
        self.run, self._change = run, change
        self.system: System = run.system
        self.times: list[float] = []
        self.rounding: list[float] = []
        #: the when-equations of the model; None if it has none
        self.set: EventSet | None = EventSet(self.system) if self.system.scene.has_events else None
        self.unsolved: UnsolvedContactsError | ReinitError | None = None
        self._fastest = 0.0
        self._known: Iterator[float] = iter(())
        self._recent: list[tuple[float, States]] = []
        self._cut: list[float] = []
        self._hidden: list[Switch] = []
        self._found: list[float] = []  # times of the last events that were not known in advance

    def saved(self) -> dict[str, Any]:
        """What a checkpoint keeps, by name."""
        found = {name: getattr(self, name).copy() for name in ("times", "rounding", "_cut", "_recent")}
        return found | {"_fastest": self._fastest, "set": None if self.set is None else self.set.saved()}

    @property
    def changing(self) -> list[Switch]:
        """The switches that change without progress of time."""
        states = np.array([s for _, s in self._recent])
        seen = _changed(self.system, states.min(axis=0), states.max(axis=0)) if self._recent else []
        return seen or self._hidden or self._undecided() or [x for x in self.system.tables.switches if _of_time(x)]

    @property
    def of_whens(self) -> bool:
        """Whether ``changing`` are conditions of when-equations, which no error of reactions decides."""
        branches = () if self.set is None else self.system.scene.events.branches
        nodes = set(walk(*(c for b in branches for c in b.conditions)))
        return bool(self.changing) and all(x.node in nodes and not reads_reactions(x) for x in self.changing)

    def _undecided(self) -> list[Switch]:
        """The switches that a perturbation of the size of rounding changes at the present state."""
        t, (q, v, lam) = self.run.time, self.run.state()
        far, fast = UNDECIDED * self.system.tables.size, UNDECIDED * np.abs(v).max(initial=0.0)
        near = [
            (self.system.moved(q, np.full_like(q, a * far)), v + b * fast)
            for a, b in ((0, 0), (0, 1), (0, -1), (1, 0), (-1, 0))
        ]
        states = np.array([self.system.switches(t, *state, lam) for state in near])
        return _changed(self.system, states.min(axis=0), states.max(axis=0))

    def blame(self, switches: list[Switch]) -> None:
        """Record ``switches`` that change within every step, however short; ``changing`` returns them."""
        self._hidden = switches

    def begin(self, t: float, q: Array, v: Array, lam: Array) -> None:
        """Initialise the switches at the start of the run."""
        run, reals, integers, switches = self.run, self.run.reals, self.run.integers, self.system.tables.switches
        if switches or self.set is not None:
            read = run.grid > 0.0 and self.system.tables.switches_of_multipliers  # a tolerance bounds their error
            turning = self.set is not None and self.set.friction is not None and self.set.friction.turning
            integers[S.WATCHING] = TURNING if turning else REACTIONS if self._of_reactions else BEHIND if read else 1
            # the error estimate hardly sees a corner between two of many stages
            passed = declared(run.method).order <= CORNERED
            integers[S.CORNERS] = passed and all(switch.of_force for switch in switches)
            integers[S.SIGNATURE] = combined(self.system.switches(t, q, v, lam))
            if self._of_reactions:
                integers[S.PASSED] = MOST_PASSED
            self._known = self._times(t)
            self._next(t)
            if not run.controlled:  # the history of others belongs to a length, and is converted with it
                reals[S.STEP_SIZE] = run.h = min(run.h, reals[S.NEXT_EVENT] - t)

    def _next(self, t: float) -> None:
        """Set NEXT_EVENT to a time before the next known event, by more than the rounding error of times."""
        before = self.run.reals[S.LEAST_H]
        later = (x - before for x in self._known)
        due = next((x for x in later if x > t + before), np.inf)
        self.run.reals[S.NEXT_EVENT] = self.run.reals[S.KNOWN] = due
        if self.set is not None:
            self.set.put(self.run)

    def _pass(self, t: float) -> None:
        """Set NEXT_EVENT behind an event at t, which may be a tick: a known time that is still to come stays known."""
        if self.run.reals[S.KNOWN] <= t:
            self._next(t)
        elif self.set is not None:
            self.set.put(self.run)

    @property
    def _fixed(self) -> bool:
        """Whether the steps of a method with stages are fixed: those that end at events have a tolerance that accepts
        all. Fixed steps of multistep methods have a ``grid`` and a nominal tolerance."""
        return not 0.0 < self.run.reals[S.TOL] < 1.0

    @property
    def _of_reactions(self) -> bool:
        """Whether reactions decide events, by friction or because those of steps are behind the motion, as means of
        other multipliers or with steps that no tolerance controls. Those of a step have its error: where it was cut
        short, they are taken from the equations of motion."""
        scene, method = self.system.scene, declared(self.run.method)
        lam, mu, read = method.multipliers
        lags = not method.own_reactions and (self._fixed or read not in (lam, mu))
        return bool(scene.sticking) or any(c.slips or lags for c in scene.contacts)

    @property
    def _lags(self) -> bool:
        """Whether reactions decide events and those of a step are behind the motion."""
        return self._of_reactions and not declared(self.run.method).own_reactions

    @cached_property
    def _turns(self) -> bool:
        """Whether the friction of contacts turns with their slip, so that steps up to its end have no solution."""
        return any(len(c.slips) > 1 for c in self.system.scene.contacts)

    def _times(self, t: float) -> Iterator[float]:
        """The times of events after t that are known in advance [s]."""
        known = self.system.time_events(t, self.run.stop, corners=declared(self.run.method).order > 2)
        return (
            known
            if self.set is None or self.run.layout[L.TICKS]
            else heapq.merge(known, self.set.ticks(t, self.run.stop))
        )

    def rejoin(self) -> None:
        """Generate the known times that are still to come, after the run was restored from a checkpoint."""
        run, before, due = self.run, self.run.reals[S.LEAST_H], self.run.reals[S.KNOWN]
        if due < np.inf:
            self._known = dropwhile(lambda x: x - before <= due, self._times(run.time - 4 * before))

    def resume(self) -> None:
        """Set the signature of the switches after a change of inputs."""
        run = self.run
        q, v, lam = run.state()
        run.integers[S.SIGNATURE] = combined(self.system.switches(run.time, q, v, lam))

    def come(self) -> tuple[int, Restart | None]:
        """Look for a switch that changes here, where a step was cut short or ended at a known time.

        Returns
        -------
        status : int
        restart : Restart or None
            Where the run has to restart; None if it goes on or stops.
        """
        run, reals, integers, system = self.run, self.run.reals, self.run.integers, self.system
        t, (q, v, lam), least = run.time, run.state(), reals[S.LEAST_H]
        known, cut = t >= reals[S.NEXT_EVENT], int(integers[S.CUT])
        # the switch is so close that no step was possible, or that the reactions of every step cut it again
        again = 1 if self._fixed else AGAIN
        at_once = not known and (not cut or self._cut[-again:] == again * [t])
        h, integers[S.CUT] = reals[S.STEP_SIZE] if known else reals[S.UNCUT], 0
        run.synchronise()
        if not known and self._stands_still(t):
            around = self._around(t, q, v, lam)
            if not around or not all(_of_time(x) for x in around):
                self._hidden = around or self._hidden
                return S.SLIDING, None
        if known and self.set is not None and self._ticked(t, q, v, lam):
            return self.set.status, None
        if self._of_reactions:
            lam = self._reactions(t, q, v, lam)
            integers[S.PASSED] = MOST_PASSED
        old, s = system.switches(t, q, v, lam), 2 * least  # s: past the rounding error of a known time
        try:
            if self.set is not None and "dPhi" not in declared(run.method).enforces:  # else the way would leave Phi
                q, v = onto_constraints(system, t, q, v, run.left_out)
            a, lam = accelerations(system, t, q, v, run.left_out)
            located = (s, self._way(q, v, a)) if known else self._located(t, (q, v, a), lam, old, cut, at_once)
            if located is None and at_once and system.tables.switches_of_multipliers:
                # the step's own reactions change a mode, those of the motion may not
                far = max(min(h if run.grid else 0.5 * SHORT * run.span, self._room(t)), 4.0 * least)
                far, refined = self._by_motion(t, q, v, a, far)
                found = self._distance(t, way := self._way(q, v, a), lam, old, far)
                located, h = (found, way) if found else (far, refined), max(h, far)
            if located is None:
                return self._progress(t, old) if at_once else S.RUNNING, None
            (s, way), old_a, begun = located, a, t
            if t + s + least > (due := reals[S.NEXT_EVENT]):  # no step is possible up to there: it is one event
                s = max(s, due + 2 * least - t)
            t, (q, v) = t + s, way(s)
            q, v = onto_constraints(system, t, q, v, run.left_out)
            a, lam = accelerations(system, t, q, v, run.left_out)
        except InitialisationError:
            return self.no_accelerations(t, q, v), None
        new = system.switches(t, q, v, lam)
        if self.set is not None:
            run.write_before(t, lambda x: way(x - begun), lam)
            if (before := np.nextafter(t, -np.inf)) > begun:  # else the end of the last step is at t
                run.keep_state(np.concatenate([[before], q, v, lam]))
            acted = self._acted(t, q, v)
            if isinstance(acted, int):
                return acted, None
            jumped = acted[1] is not v and not (self.set.struck or self.set.status)
            q, v, a, lam = acted
            if jumped and (there := self._cleared(t, q, v, lam, s)) is not q:
                acted = self._acted(t, there, v)
                if isinstance(acted, int):
                    return acted, None
                q, v, a, lam = acted
        self._pass(t)
        integers[S.SIGNATURE] = combined(system.switches(t, q, v, lam))
        integers[S.EVENTS] += 1
        self.times.append(t)
        self.rounding.append(self._of_rounding(t, q, v, a - old_a, known))
        longest = min(h, max(min(run.stop, reals[S.NEXT_EVENT]) - t, least))
        # methods of order 2 pass corners of functions of time, unless the step is rejected
        timed = known or all(_of_time(x) for x in _changed(system, old, new))
        struck = self.set is not None and self.set.struck  # impacts that become ever shorter come to rest
        if struck or (self.set is not None and self.set.contacts is not None and self.set.contacts.eased):
            struck, self._cut = True, []  # and so do shares of friction, which change ever more often until it slides
        status = self._known_progress(t) if timed or struck else self._progress(t, new)
        if self.set is not None:
            status = self.set.status or (S.RUNNING if known and not self._hidden else status)
        return status, Restart(t, q, v, a, lam, longest)

    def _cleared(self, t: float, q: Array, v: Array, lam: Array, s: float) -> Array:
        """The positions behind a jump of velocities, moved along v by a little if that changes a switch.

        The side of a threshold follows from the motion behind the jump: the way is longer than rounding, and than the
        error of a time that was located ``s`` behind a step.
        """
        speed = float(np.abs(v * self.system.tables.scale).max(initial=0.0))
        late = 4.0 * max(ROUNDED / speed if speed > 1e-290 else 0.0, LOCATED * s, self.run.reals[S.LEAST_H])
        there = self.system.moved(q, late * v)
        changes = (self.system.switches(t, q, v, lam) != self.system.switches(t, there, v, lam)).any()
        return there if changes else q

    def _located(
        self, t: float, state: tuple[Array, Array, Array], lam: Array, old: States, cut: int, at_once: bool
    ) -> tuple[float, Way] | None:
        """The time from t to just behind the change of a switch, and the way there from q, v, a; None if it is farther
        away than steps can end before it."""
        run, least, (q, v, a) = self.run, self.run.reals[S.LEAST_H], state
        # an attempt across another event is cut once, one across the end of a slide again and again
        if (at_once or cut > 1) and (end := self._end_of_slide(t, q, v)) is not None and (end.stopped or at_once):
            return end.nodes[-1][0], end.state
        most = self._left(cut) * run.reals[S.LAST_H]
        if at_once:  # reactions of shorter steps have larger errors, of rounding
            most = max(4 * least, 1.01 * run.sliver * run.grid, SHORT * run.span if self._of_reactions else 0.0)
            most = max(most, run.reals[S.UNCUT]) if run.grid and (self._lags or self._turns) else most
        if self.set is not None:  # rounding may keep a gap from closing
            most = max(most, TINY * run.span)
        way = self._way(q, v, a)
        late = self._lags or (run.grid > 0.0 and self.system.tables.switches_of_multipliers)
        if late and combined(self._switches(t, q, v, lam)[0]) != run.integers[S.SIGNATURE]:
            return self._missed(t, way, lam), way
        refines = run.grid or declared(run.method).order > PRECISE
        rough = ROUGH if refines and self.set is not None else LOCATED
        found = self._distance(t, way, lam, old, most, part=rough)
        if found is None and at_once and run.grid:  # accelerations vanish, as those of bodies that do not yet press
            most = max(most, run.reals[S.UNCUT])
            found = self._distance(t, self._refined(t, q, v, a, most), lam, old, most, part=rough)
        if found is None and not at_once:
            found = self._within_rounding(t, q, v, way, lam, old)
        if found is None:
            return None
        if found > 0.0 and refines:
            way = self._refined(t, q, v, a, found)
            near = found if rough > LOCATED else 0.0
            found = self._distance(t, way, lam, old, most, near) or found
        # within the rounding error of times after an event, a condition may remain on its former side
        return max(found, 2 * least) if at_once and self.set is not None else found, way

    def _missed(self, t: float, way: Way, lam: Array) -> float:
        """The time from t back to just behind the change of a switch, which the reactions of the last step have not
        shown because they are less accurate than the motion; 0 if it changes here."""
        low, before = -self.run.reals[S.LAST_H], self.run.integers[S.SIGNATURE]

        def look(s: float) -> tuple[bool, Array]:
            states, values = self._switches(t + s, *way(s), lam)
            return combined(states) == before, values

        same, values = look(low)
        if not same:
            return 0.0
        return first_change(look, low, 0.0, (values, look(0.0)[1]), self._close(LOCATED))

    def _end_of_slide(self, t: float, q: Array, v: Array) -> End | None:
        """Where a joint or contact stops that slides in several directions, if this is near."""
        if self.set is None or not (slides := self.set.turning):
            return None
        run, limits = self.run, (float(self.run.reals[S.LEAST_H]), self._room(t))
        if not limits[1] > 4.0 * limits[0]:
            return None
        at = At(t, q, v, run.left_out, dict(self.set.values), [])
        end = final_slide(self.system, slides, at, run.grid or run.reals[S.LAST_H], run.tol, limits)
        put(self.system, self.set.values, run.left_out)
        return end

    def _room(self, t: float) -> float:
        """The time from t to the next known event, or to the end [s]."""
        return float(min(self.run.reals[S.NEXT_EVENT], self.run.reals[S.STOP]) - t)

    def _acted(
        self, t: float, q: Array, v: Array, given: Mapping[str, float] | None = None
    ) -> tuple[Array, Array, Array, Array] | int:
        """q, v, a and lam behind the event at time t, or the status of a run that stops there."""
        run, system, before = self.run, self.system, v
        assert self.set is not None
        try:
            v = self.set.act(t, q, v, run.left_out, given=given)
            q, run.left_out = self.set.q, self.set.left_out(run.left_out)
            system.activate(run.left_out)
            if v is not before:
                q, v = onto_constraints(system, t, q, v, run.left_out)
            a, lam = accelerations(system, t, q, v, run.left_out)
        except (UnsolvedContactsError, ReinitError) as problem:
            self.unsolved = problem
            return S.UNSOLVED
        except UndecidedFrictionError:
            raise
        except InitialisationError:
            return self.no_accelerations(t, q, v)
        for at, value in self.set.numbers().items():
            run.numbers[at] = value
        return q, v, a, lam

    def changed(self, v: Array, numbers: Mapping[str, float]) -> tuple[int, Restart | None]:
        """The event of a change from outside at the present time, to the velocities v (n,) and discrete variables.

        Returns
        -------
        status, restart
            As of :meth:`come`.
        """
        run, system = self.run, self.system
        assert self.set is not None
        run.synchronise()
        t, q = run.time, run.state()[0].copy()
        acted = self._acted(t, q, v, numbers)
        if isinstance(acted, int):
            return acted, None
        q, v, a, lam = acted
        run.integers[S.SIGNATURE] = combined(system.switches(t, q, v, lam))
        return self.set.status, Restart(t, q, v, a, lam, run.longest)

    def _left(self, cut: int) -> float:
        """The largest remaining time to a switch at which it is an event, by the last step, which was cut ``cut``
        times. Where reactions decide, their errors let steps end earlier."""
        return max(LEFT, min(1.0, 2.0 * SHORT_OF * 10.0 ** (cut - 1))) if self._of_reactions else LEFT

    def _ticked(self, t: float, q: Array, v: Array, lam: Array) -> bool:
        """Whether a clock has ticked that changes discrete variables only; the jump of forces is then in the history.

        At all other events the run restarts, which takes ten times as long.
        """
        run, s, events = self.run, 2 * self.run.reals[S.LEAST_H], self.set
        if events is None or declared(run.method).order > 2 or not events.ticks_by(t + s):
            return False  # the history of methods of higher order would need the jumps of rates
        there = self.system.moved(q, s * v)  # what happens at the time of the tick, but for rounding, is one event
        if (self.system.switches(t, q, v, lam) != self.system.switches(t + s, there, v, lam)).any():
            return False
        try:
            acted = events.act(t + s, q, v, run.left_out, put=False)
        except (ReinitError, UnsolvedContactsError):  # the event that follows says why
            events.undo()
            return False
        if acted is not v or events.q is not q or events.left_out(run.left_out) != tuple(sorted(run.left_out)):
            events.undo()
            return False
        self._pass(t + s)
        at_stop(run)
        run.integers[S.EVENTS] += 1
        self._change({name: x for name, x in events.values.items() if name in self.system.tables.inputs})
        return True

    def _of_rounding(self, t: float, q: Array, v: Array, jump: Array, known: bool) -> float:
        """The effect on a scaled velocity of rounding the time of an event with a jump of accelerations: of decimals
        of times, and if it is not ``known`` in advance, of positions at the largest speed of any event so far."""
        scale = self.system.tables.scale
        late = float(np.spacing(abs(t)))
        self._fastest = max(self._fastest, float(np.abs(v * scale).max(initial=0.0)))
        if not known:
            least = 1.0 / self.run.span
            late += EPS * float(np.abs(q * scale).max(initial=0.0) / max(self._fastest, least))
        return float(np.abs(jump * scale).max(initial=0.0)) * late

    def _way(self, q: Array, v: Array, a: Array, c: Array | float = 0.0) -> Way:
        """q and v after the time s, with the accelerations a + 2 c s."""
        if declared(self.run.method).order <= PRECISE and not self.run.grid:
            return lambda s: (self.system.moved(q, s * (v + s / 2 * a)), v + s * a)
        return lambda s: (self.system.moved(q, s * (v + s / 2 * a + s * s / 3 * c)), v + s * a + s * s * c)

    def _refined(self, t: float, q: Array, v: Array, a: Array, s: float) -> Way:
        """The same over the time s to a switch, with the change of the accelerations up to the middle of it."""
        middle = self._way(q, v, a)(s / 2)
        b, _ = accelerations(self.system, t + s / 2, *middle, self.run.left_out)
        return self._way(q, v, a, (b - a) / s)

    def _by_motion(self, t: float, q: Array, v: Array, a: Array, s: float) -> tuple[float, Way]:
        """The same over a time of at most s; where a tolerance controls steps, the accelerations at its end are those
        of the way, but for the tolerance."""
        run, scale = self.run, self.system.tables.scale
        while True:
            way = self._refined(t, q, v, a, s)
            q1, v1 = way(s)
            if self._fixed or run.grid or s <= 8.0 * run.reals[S.LEAST_H]:
                return s, way
            b, _ = accelerations(self.system, t + s, q1, v1, run.left_out)
            error = s * float(np.abs((b + a - 2.0 * (v1 - v) / s) * scale).max(initial=0.0))
            if error <= (run.tol or 0.0) * float(np.abs(v1 * scale).max(initial=0.0)):
                return s, way
            s /= 2

    def no_accelerations(self, t: float, q: Array, v: Array) -> int:
        """The status of a run that stops at a state without accelerations."""
        if self.set is not None and self.set.contacts is not None:
            self.unsolved = self.set.contacts.without_value(t, q)
            if self.unsolved is not None:
                return S.UNSOLVED
        finite = np.isfinite(self.system.Q(t, q, v)).all()
        return S.SINGULAR if finite else S.NOT_FINITE

    def _stands_still(self, t: float) -> bool:
        """Whether steps are cut short again and again, which happens also without events."""
        self._cut = [*self._cut[1 - 4 * MANY :], t]
        return len(self._cut) == 4 * MANY and t - self._cut[0] < HARDLY * self._horizon

    @property
    def _horizon(self) -> float:
        """The time in which a run without chattering has few events [s]."""
        return min(self.run.span, STEPS * float(self.run.reals[S.UNCUT] or self.run.span))

    def _around(self, t: float, q: Array, v: Array, lam: Array) -> list[Switch]:
        """The switches that differ between the state at t and the end of the last attempt or its search."""
        vectors, system, n = self.run.vectors, self.system, self.system.n
        rows = ((L.BEFORE, L.BEFORE2), (L.POSITION, L.VELOCITY))
        ends = [(system.out_of_charts(vectors[x, :n], self.run.numbers), vectors[w, :n]) for x, w in rows]
        states = np.array([system.switches(t, *end, lam) for end in ((q, v), *ends)])
        return _changed(system, states.min(axis=0), states.max(axis=0))

    def _distance(
        self, t: float, way: Way, lam: Array, old: States, most: float, near: float = 0.0, part: float = LOCATED
    ) -> float | None:
        """The time from t until just behind the next change of a switch; None if it is longer than ``most``.

        Its error is at most the ``part`` of it. It is first looked for close to ``near``.
        """
        if combined(old) != self.run.integers[S.SIGNATURE]:
            return 0.0  # the last Newton correction of the step has changed a switch

        def look(s: float) -> tuple[bool, Array]:
            states, values = self._switches(t + s, *way(s), lam)
            return bool((states == old).all()), values

        low, high = 0.0, most
        if near > 0.0:
            low, high = near * (1.0 - AROUND), min(most, near * (1.0 + AROUND))
        same, there = look(high)
        if same and high < most:
            low, high = 0.0, most
            same, there = look(high)
        if same:
            return None
        same, here = look(low)
        if not same and low > 0.0:
            low, high, there = 0.0, low, here
            here = look(low)[1]
        return first_change(look, low, high, (here, there), self._close(part))

    def _close(self, part: float) -> tuple[float, float]:
        """The largest error of a located time: relative to it, and absolute."""
        return part, 0.01 * float(self.run.reals[S.LEAST_H])

    def _switches(self, t: float, q: Array, v: Array, lam: Array) -> tuple[States, Array]:
        """The states of the switches at a state, and the quantities that decide them."""
        states = self.system.switches(t, q, v, self._reactions(t, q, v, lam))
        return states, self.system.quantities()

    def _within_rounding(self, t: float, q: Array, v: Array, way: Way, lam: Array, old: States) -> float | None:
        """The time until just behind a change of a switch that the rounding error of q and v could hide; None if there
        is none. Where a motion begins on the threshold of a switch, steps up to it do not change q."""
        s = self._distance(t, way, lam, old, 2.0 * self.run.reals[S.LAST_H])
        if not s:
            return None
        (q1, v1), scale = way(s), self.system.tables.scale
        far, fast = ROUNDED / scale, ROUNDED * np.abs(v * scale).max(initial=0.0) / scale
        q1 = self.system.moved(q, np.clip(q1 - q, -far, far))
        v1 = v + np.clip(v1 - v, -fast, fast)
        near = self.system.switches(t, q1, v1, self._reactions(t, q1, v1, lam))
        return s if (near != old).any() else None

    def _reactions(self, t: float, q: Array, v: Array, lam: Array) -> Array:
        """The multipliers at a state; ``lam``, those of a state nearby, if no switch depends on them."""
        if not self.system.tables.switches_of_multipliers or self._all_open:
            return lam
        try:
            return accelerations(self.system, t, q, v, self.run.left_out)[1]
        except InitialisationError:
            return lam

    @property
    def _all_open(self) -> bool:
        """Whether only rigid contacts look at reactions, and none of them is closed."""
        contacts = self.set.contacts if self.set is not None else None
        return contacts is not None and self._only_contacts and contacts.all_open(self.set.values)  # type: ignore[union-attr]

    @cached_property
    def _only_contacts(self) -> bool:
        """Whether the switches that read reactions are those of rigid contacts."""
        own = {c.condition for c in self.system.scene.contacts}
        return all(x.node in own for x in self.system.tables.switches if reads_reactions(x))

    def _known_progress(self, t: float) -> int:
        """The status after an event at a time that was known in advance."""
        run, times = self.run, self.times
        close = len(times) > MANY_KNOWN and t - times[-MANY_KNOWN] < HARDLY * run.span
        few = len(times) > FEW and (t - times[-FEW]) * TOO_MANY_KNOWN < FEW * (run.stop - t)
        if few and self._repeating:
            self._hidden = self._repeating
            return S.SLIDING
        return S.SLIDING if close else S.RUNNING

    @cached_property
    def _repeating(self) -> list[Switch]:
        """The switches that depend on time alone and change without end."""

        def repeats(n: Expr) -> bool:
            return n.op in REPEATING or (n.op == "table" and n.value[0].extrapolation == "periodic")

        return [x for x in self.system.tables.switches if _of_time(x) and any(map(repeats, walk(x.node)))]

    def _progress(self, t: float, states: States) -> int:
        """Record an event at t not known in advance; return SLIDING if events make no progress, else RUNNING."""
        length = self._horizon
        if self._recent and t - self._recent[0][0] > STANDSTILL * length:
            self._recent = []
        self._recent.append((t, states))
        self._found = [*self._found[-MANY:], t]
        if len(self._found) > MANY:
            taken, run = t - self._found[0], self.run
            dense = taken < HARDLY * (t - run.start) and taken * TOO_MANY < MANY * (run.stop - t)
            if dense or taken < HARDLY * length:
                return S.SLIDING
        return S.SLIDING if len(self._recent) > CROWD else S.RUNNING


def _of_time(switch: Switch) -> bool:
    """Whether a switch depends on time alone, so that forces cannot drive the motion back over it."""
    return all(leaf.op == "time" for leaf in switch.leaves)


def _changed(system: System, old: States, new: States) -> list[Switch]:
    return [system.tables.switches[k] for k in np.flatnonzero(old != new).tolist()]
