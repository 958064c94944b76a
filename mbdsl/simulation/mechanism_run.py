"""A scene in motion, with its independent parts advanced in parallel."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.integrators import Run, backend, declared
from mbdsl.integrators.event_set import EventSet
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun
from mbdsl.integrators.saved_runs import SETTINGS
from mbdsl.integrators.scheduled_jumps import Jumps
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.scene import Scene
from mbdsl.simulation.left_out_rows import violated, violations
from mbdsl.simulation.part_run import KINEMATIC, Array, PartRun, run_of
from mbdsl.simulation.parts_output import PartsOutput
from mbdsl.simulation.plan import Plan
from mbdsl.system import System, state_sizes
from mbdsl.system.bending import first_bend
from mbdsl.system.tables import gravity

if TYPE_CHECKING:
    from mbdsl.simulation.extremes import Gathered

#: number of steps of the first run between two checks of its displacements
GLANCE = 64
NOISE = 1e-4  #: relative noise of accelerations from positions above which those of the equations are more accurate


@dataclass(frozen=True)
class Kept:
    """A complete or interrupted run, which :meth:`MechanismRun.recall` makes the present one again."""

    plan: Plan
    integrations: list[Run]
    failed: PartRun | None
    failure: int
    gathered: Gathered | None


class MechanismRun(PartsOutput):
    """The run of a scene: its parts are advanced to the same time.

    Attributes
    ----------
    failed : PartRun or None
        The part that failed.
    trial_steps : int
        Number of steps of the other calibration runs, which were made to estimate the error of this one.
    purpose : str
        The purpose of the present run, if it is one of several.
    gathered : Gathered or None
        Ranges of signals over the steps that the present run has forgotten.
    """

    def __init__(self, scene: Scene, plan: Plan, mechanism: MechanismGraph | None = None) -> None:
        super().__init__(scene, plan, mechanism)
        self.trial_steps = 0
        self.purpose = ""
        self.failed: PartRun | None = None
        self.gathered: Gathered | None = None
        self._failure = S.DONE
        self._widens = True  #: whether the run may change the size: the first one
        self._states_sized = False  #: whether the sizes of states are those of a run
        self._steps = round((plan.stop - plan.start) / plan.h)
        #: whether the parts have steps of their own
        self._own_steps = plan.tol is not None or scene.has_events or backend(plan.method) is not None

    def restart(self, plan: Plan) -> None:
        """Return to the start, for another run of the same scene, whose method may be another one."""
        self.plan, self.failed, self.gathered = plan, None, None
        for p in self.parts:
            if p.method not in (plan.method, KINEMATIC):
                keeps = getattr(p.integration, "keeps", False)
                p.method, p.integration = plan.method, run_of(p.system, plan.method, plan, plan.options, keeps)
            elif isinstance(p.integration, MethodRun):
                p.integration = p.integration.anew(plan.times, plan.tol, plan.every, plan.longest, plan.rows)
            else:
                p.integration = run_of(p.system, p.method, plan, plan.options)
            first = p.initial
            p.integration.begin(first.q, first.v, first.a, first.lam, first.redundant)

    def keep(self) -> Kept:
        """The present run, for :meth:`recall`."""
        return Kept(self.plan, [p.integration for p in self.parts], self.failed, self._failure, self.gathered)

    def recall(self, kept: Kept) -> None:
        """Make a stored run the present one again."""
        self.plan, self.failed, self._failure = kept.plan, kept.failed, kept.failure
        self.gathered = kept.gathered
        for p, integration in zip(self.parts, kept.integrations, strict=True):
            p.integration = integration
            p.method = p.method if p.method == KINEMATIC else kept.plan.method

    def parts_of(self, kept: Kept) -> Iterator[tuple[System, Array, Array, Array, Array, tuple[int, ...]]]:
        """System, times (N,), q, v (N, n), lam (N, m + p) and left-out constraints of each part that can move.

        The times are the start and all outputs of a run.
        """
        for p, integration in zip(self.parts, kept.integrations, strict=True):
            if p.method != KINEMATIC:
                done = integration.written
                t = np.append(kept.plan.start, integration.times[:done])
                yield p.system, t, *p.split(np.vstack([p.first, integration.out[:done]])), p.initial.redundant

    @property
    def pivoting_from(self) -> float | None:
        """Time at which the sparse factorisation of a part lost a pivot and dense LU replaced it; None: never."""
        return min((x for p in self.parts if (x := p.integration.pivoting_from) is not None), default=None)

    @property
    def own_reactions(self) -> bool:
        """Whether reactions are those of the method; else they follow from positions and velocities."""
        method = declared(self.plan.method)
        return method.own_reactions and not (method.index == 3 and self.plan.tol is None and self._rounding)

    @property
    def _rounding(self) -> bool:
        """Whether steps are so short that rounding of positions dominates accelerations from their differences."""
        largest = float(np.abs(gravity(self.system.scene)).max()) / self.system.tables.size
        for part in self.parts:
            first, scale = part.initial, part.system.tables.scale
            a, v = (float(np.abs(x * scale).max(initial=0.0)) for x in (first.a, first.v))
            largest = max(largest, a, v**2)
        return bool(np.finfo(float).eps / self.plan.h**2 > NOISE * largest > 0.0)

    @property
    def steps(self) -> int:
        """Number of steps of all parts; with controlled steps, that of the part with most steps."""
        found = [p.integration.steps for p in self.parts]
        return max(found, default=0) if self._own_steps else min(found, default=self._taken)

    @property
    def h(self) -> float:
        """The step, or with controlled steps the shortest present one of all parts [s]."""
        steps = [h for p in self.parts if (h := getattr(p.integration, "step", None))]
        return min(steps, default=self.plan.h) if self.plan.tol is not None else self.plan.h

    def count(self, what: str) -> int:
        """A count ("iterations", "matrix_evaluations", ...) over all parts; see :class:`mbdsl.integrators.Run`."""
        return sum(p.integration.count(what) for p in self.parts)

    def advance(self, steps: int) -> int:
        """Take at most ``steps`` steps; return a status of :mod:`mbdsl.integrators.loop.loop_state`.

        If a part fails, all parts end at the last step that all of them have completed. A failed motion remains failed.
        """
        if self._own_steps and self.parts:
            return self._advance_each(steps)
        status = self._failure
        if self.failed is None:
            status = self._advance_to(self.steps + steps, self.parts, status)
        if not self.parts:
            self._taken = min(self._taken + steps, self._steps)
            status = S.DONE if self._taken == self._steps else S.RUNNING
        return status

    def ended(self, status: int) -> int:
        """A status of the only part, which has failed if it is not RUNNING or DONE."""
        if status not in (S.RUNNING, S.DONE):
            self.failed, self._failure = self.parts[0], status
        return status

    def _advance_to(self, most: int, parts: Sequence[PartRun], status: int) -> int:
        """Advance ``parts`` to step ``most`` or, if one fails, those behind it to its last step; a status."""
        for p in parts:
            found = p.integration.advance(max(0, most - p.integration.steps))
            if found not in (S.RUNNING, S.DONE):
                self.failed, self._failure = p, found
                most = p.integration.steps
            status = found if self.failed is None else self._failure
        return status

    def continued(self, k: int, status: int, most: int) -> int:
        """Continue to step ``most`` after calls of the parts' prepared step loops, of which that of part ``k`` returned
        ``status`` (see :meth:`MethodRun.continued`), and those of the parts behind it were not called; a status."""
        p = self.parts[k]
        assert isinstance(p.integration, MethodRun)
        found = p.integration.continued(status, most)
        if found not in (S.RUNNING, S.DONE):
            self.failed, self._failure = p, found
            most = p.integration.steps
        return self._advance_to(most, self.parts[k + 1 :], found)

    def copied(self) -> MechanismRun:
        """A copy whose runs have buffers of their own, before their start; equations and compiled code are shared."""
        other = copy(self)
        other.parts = []
        for p in self.parts:
            run = p.integration
            assert isinstance(run, MethodRun)
            own = run.anew(run.times, run.tol, run.every, run.longest)
            own.memory, own.integers[SETTINGS] = run.memory.copy(), run.integers[SETTINGS]
            if hasattr(run, "jumps"):  # it is in the middle of a search
                own.jumps = Jumps(run.system, run.start, run.stop, run.h)
            if run.tol is not None and run.events.set is not None and own.events.set is not None:
                own.events.set.like(run.events.set)
            other.parts.append(replace(p, integration=own))
        return other

    def _advance_each(self, steps: int) -> int:
        """As advance, for parts with steps of their own: the part that is furthest behind is advanced first."""
        if self.failed is not None:
            return self._failure
        status = S.DONE
        for p in sorted(self.parts, key=lambda p: p.integration.time):
            found = self._glanced(p, steps) if self._widens else p.integration.advance(steps)
            if found not in (S.RUNNING, S.DONE):
                self.failed, self._failure = p, found
                for other in self.parts:  # the parts behind advance to that time; results end at the last of them
                    while (before := other.integration.time) < p.integration.time:
                        if other.integration.advance(1) != S.RUNNING or other.integration.time == before:
                            break
                return found
            status = S.RUNNING if found == S.RUNNING else status
        return status

    def _glanced(self, p: PartRun, steps: int) -> int:
        """As advance, for a part in the first run, whose displacements may exceed the size by far."""
        run = p.integration
        if not isinstance(run, MethodRun):
            return run.advance(steps)
        status = run.advance(min(steps, GLANCE - run.steps % GLANCE))
        if status == S.RUNNING and run.steps % GLANCE == 0:
            run.widen(p.initial.q, self.system.tables.outgrown_from)
        return status

    def outgrown(self) -> bool:
        """Whether displacements of the first run exceed a size that is not that of the parts, or that is rounding.

        The largest displacement becomes the size, and the run has to be repeated.
        """
        again = self._sized()
        if not self._widens:
            return again
        self._widens, tables = False, self.system.tables
        q = self.states()[1][:, tables.lengths]
        way = float(np.abs(q - q[:1]).max(initial=0.0))
        if not tables.outgrown_from * tables.size < way < np.inf:
            return again
        for own in (tables, *(p.system.tables for p in self.parts)):
            own.resize(way)
        return True

    def _sized(self) -> bool:
        """Set the sizes of states by the first run; whether its weights were far from them."""
        if self._states_sized:
            return False
        self._states_sized, span = True, self.plan.stop - self.plan.start
        ends = [(p, np.vstack([p.first, p.integration.out[: p.integration.written]])) for p in self.parts]
        found = [state_sizes.measured(p.system.tables, p.split(x)[1], span) for p, x in ends if p.system.tables.states]
        return any(found)

    def invalid(self) -> bool:
        """Whether the present state is not one of the model: a body deforms beyond the range of its theory, or a
        constraint that was left out as redundant is violated."""
        for p in self.parts:
            t, (q, v, _) = p.integration.time, p.integration.state()
            if first_bend(p.system, q[None]) is not None:
                return True
            rows = p.initial.redundant
            if rows:
                p.integration.synchronise()
                if violated(violations(p.system, p.initial, np.array([t]), q[None], v[None], {}), rows)[0]:
                    return True
        return False

    def change_inputs(self, inputs: Mapping[str, float]) -> int:
        """Set inputs from the present time on; a status."""
        statuses = [p.integration.change_inputs(inputs) for p in self.parts]
        return next((x for x in statuses if x not in (S.RUNNING, None)), S.RUNNING)

    @property
    def event_set(self) -> EventSet | None:
        """The events of the present run; None of a model without when-equations."""
        run = self.parts[0].integration if self.parts and self.system.scene.has_events else None
        return run.events.set if isinstance(run, MethodRun) else getattr(run, "event_set", None)
