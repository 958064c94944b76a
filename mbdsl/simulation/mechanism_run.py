"""Motion: a scene in motion, with its independent parts advanced in parallel.

The reduced scene (:mod:`mbdsl.mechanism.reduction`) is solved; the results refer to the scene as written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mbdsl.compilation import code_cache
from mbdsl.expressions.symbolic import RATE
from mbdsl.initial.consistent import InitialState, Moved, determined, initial_state, state_at
from mbdsl.initial.shared_loads import undetermined
from mbdsl.initial.start_conditions import check_assembled_shapes, check_loose
from mbdsl.initial.weights import members_of
from mbdsl.integrators import Run, backend, declared
from mbdsl.integrators.event_set import EventSet
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.compiled_loop import controls_locally, has_own_step, loop_name
from mbdsl.integrators.run import MethodRun
from mbdsl.integrators.saved_runs import SETTINGS
from mbdsl.integrators.scheduled_jumps import Jumps
from mbdsl.integrators.single_steps import STEPS
from mbdsl.mechanism import graph
from mbdsl.mechanism.reduction import Flattened, Note, Part, Reduction, reduce
from mbdsl.mechanism.reduction.gyrostats import Gyrostats
from mbdsl.mechanism.scene import Scene
from mbdsl.mechanism.signal_names import SIZES
from mbdsl.numerics.hermite import between
from mbdsl.simulation import derived_signals
from mbdsl.simulation.gyrostat_states import GyrostatStates
from mbdsl.simulation.left_out_rows import violated, violations
from mbdsl.simulation.plan import Plan, check_events, check_space
from mbdsl.simulation.planar_states import OutOfPlane, PlanarStates
from mbdsl.simulation.whole_scene import WholeScene
from mbdsl.system import System, build, state_sizes
from mbdsl.system.bending import first_bend
from mbdsl.system.signals import begin
from mbdsl.system.tables import gravity

if TYPE_CHECKING:
    from mbdsl.simulation.extremes import Gathered

Array = NDArray[np.float64]
KINEMATIC = "kinematic"
#: number of steps of the first run between two checks of its displacements
GLANCE = 64
#: tolerances of runs with fixed steps that end at events: errors shorten no step; of methods with a step of their own
NOMINAL, LOOSE = 1e-6, 1e6
NOISE = 1e-4  #: relative noise of accelerations from positions above which those of the equations are more accurate


#: the states in which a mechanism in space is solved
Solved = PlanarStates | GyrostatStates
#: q, v (N, n) and lam (N, m + p)
State = tuple[Array, Array, Array]
#: t (N,), q, v (N, n), lam (N, m + p)
Ends = tuple[Array, Array, Array, Array]
#: times (N,), q, v (N, n), lam (N, m + p) of the scene, and q and v of each part
Rows = tuple[Array, Array, Array, Array, list[tuple[Array, Array]]]
#: these, and q and v of the scene that is solved, at the start
Start = tuple[Solved, Array, Array]


@dataclass
class PartRun:
    """A part with its equations."""

    part: Part
    system: System
    method: str
    initial: InitialState
    integration: Run

    @property
    def first(self) -> Array:
        """The row (1, 2 n + m + p) of outputs at the start, behind the event there."""
        begun = getattr(self.integration, "begun", None)
        return np.concatenate(begun or (self.initial.q, self.initial.v, self.initial.lam))[None]

    @property
    def last(self) -> Array:
        """The row (1, 2 n + m + p) at the present time."""
        return np.concatenate(self.integration.state())[None]

    def split(self, rows: Array) -> State:
        """q, v (N, n) and lam (N, m + p) of rows of outputs."""
        n = self.system.n
        return rows[:, :n], rows[:, n : 2 * n], rows[:, 2 * n :]

    def accelerations(self, t: Array, q: Array, v: Array) -> Array | None:
        """Those (N, n) of the equations of motion at N states; None if they depend on more than the states."""
        if self.system.tables.inputs or self.system.counts_angles or self.method == KINEMATIC:
            return None
        return derived_signals.motion(self.system, t, q, v, self.initial.redundant, {})[0]


@dataclass(frozen=True)
class Kept:
    """A complete or interrupted run, which :meth:`MechanismRun.recall` makes the present one again."""

    plan: Plan
    integrations: list[Run]
    failed: PartRun | None
    failure: int
    gathered: Gathered | None


class MechanismRun:
    """The parts of a scene, assembled at the start.

    Attributes
    ----------
    system : System
        That of the scene as written, to which a trajectory refers. It is that of the only part if nothing was reduced.
    parts : list of PartRun
    assembled : list of (System, InitialState)
        The initial state of each part, or of the mechanism in space that parts solve in a plane or with gyrostats.
    whole : WholeScene
        The map from the states of the parts to that of the scene.
    failed : PartRun or None
        The part that failed.
    trial_steps : int
        Number of steps of the other calibration runs, which were made to estimate the error of this one.
    purpose : str
        The purpose of the present run, if it is one of several.
    gathered : Gathered or None
        Ranges of signals over the steps that the present run has forgotten.

    Raises
    ------
    InitialisationError
        If no consistent initial state is found.
    """

    def __init__(self, scene: Scene, plan: Plan, mechanism: graph.MechanismGraph | None = None) -> None:
        self.plan = plan
        mechanism = mechanism if mechanism is not None else graph.build(scene)
        if scene.has_events:
            check_events(plan.method, scene)
        self.reduction = Reduction(mechanism, scene, (Part(mechanism),)) if plan.general else reduce(mechanism)
        if any(part.scene.spatial for part in self.reduction.parts):
            check_space(plan.method, scene)
        self.system = build(scene, mechanism, plan.general)
        # unspecified initial values must not depend on the reduction
        self._size = self.system.tables.size
        self._widens = True  #: whether the run may change the size: the first one
        self._states_sized = False  #: whether the sizes of states are those of a run
        self._systems, self._spaces = self._built()
        self.parts: list[PartRun] = []
        self.assembled: list[tuple[System, InitialState]] = []
        self.trial_steps = 0
        self.purpose = ""
        self.failed: PartRun | None = None
        self.gathered: Gathered | None = None
        self._failure = S.DONE
        self._steps = round((plan.stop - plan.start) / plan.h)
        self._own_steps = (
            plan.tol is not None or scene.has_events or backend(plan.method) is not None
        )  # different for each part
        self._taken = 0

    def _built(self) -> tuple[list[System], list[System]]:
        """The systems of the parts, and of the mechanisms in space that parts solve in a plane or with gyrostats."""
        reduction, size = self.reduction, self._size
        if reduction.nothing_done:
            return [self.system], []
        alone = [flat.motion.graph for flat in reduction.flattened]
        return (
            [build(part.scene, part.graph, size=size) for part in reduction.parts],
            [self.system if g is reduction.graph else build(g.scene, g, size=size) for g in alone],
        )

    def uncompiled(self) -> list[str]:
        """Descriptions of the code that has to be compiled; [] if none."""
        found = [text for part, system in self._pairs() for text in self._uncompiled(part, system)]
        found += [text for system in self._spaces for text in system.uncompiled()]
        return list(dict.fromkeys(found))

    def _pairs(self):
        return zip(self.reduction.parts, self._systems, strict=True)

    def _uncompiled(self, part: Part, system: System) -> list[str]:
        method = KINEMATIC if part.kinematic else self.plan.method
        found = system.uncompiled(declared(method).sets)
        if backend(method) is None and not code_cache.is_compiled(loop_name(method)):
            found.append(f"method {method}")
        return found

    def prepare(self, lap: Callable[[str], None] = lambda phase: None) -> None:
        """Compile or load the code, and assemble the initial states; ``lap`` is called after each phase."""
        check_loose(self.reduction, self.system, self.plan.start)
        solved_as: list[Solved] = []
        starts: dict[int, Start] = {}
        for flat, space in zip(self.reduction.flattened, self._spaces, strict=True):
            first = initial_state(space, flat.motion.graph, self.plan.start)
            made = GyrostatStates if isinstance(flat.motion, Gyrostats) else PlanarStates
            states: Solved = made(flat, [self._systems[k] for k in flat.numbers], self._size)
            try:
                start = states.of(space, first)
            except OutOfPlane:
                self._solve_in_space(flat)
                self.prepare(lap)
                return
            self.system.tables.first_angles |= space.tables.first_angles
            self.assembled.append((space, first))
            lap("initialise")
            solved_as.append(states)
            starts |= dict.fromkeys(flat.numbers, (states, *start))
        for k, (part, system) in enumerate(self._pairs()):
            self.parts.append(self._moving(part, system, lap, starts.get(k)))
        own = [(p.system, p.initial) for k, p in enumerate(self.parts) if k not in starts]
        self.assembled += own
        names = self.system.constraint_names()
        row = {name: k for k, name in enumerate(names)} if any(x.redundant for _, x in self.assembled) else {}
        self.left_out = tuple(sorted({*(row[name] for name in self.redundant), *self.system.tables.switchable}))
        solved = [p.method != KINEMATIC for p in self.parts]
        self.whole = WholeScene(self.system, self.reduction, [p.system for p in self.parts], solved, solved_as)
        if self.system.tables.starts and not any(p.system is self.system for p in self.parts):
            q, v, _ = self.whole.state(np.array([self.plan.start]), [p.split(p.first) for p in self.parts])
            begin(self.system, self.plan.start, q[0], v[0])

    def _solve_in_space(self, flat: Flattened) -> None:
        """Solve all parts in space, because ``flat`` is assembled in another plane than its joints say."""
        check_space(self.plan.method, self.system.scene)
        self.reduction = reduce(self.reduction.graph, planar=False)
        why = "assembled in another plane than that of its joints, or with other turns"
        note = Note("kept", tuple(flat.motion.graph.bodies), why)
        self.reduction = replace(self.reduction, notes=(*self.reduction.notes, note))
        self._systems, self._spaces = self._built()
        self.assembled = []

    def watch(self) -> None:
        """Keep the ends of all steps, and search fixed steps for peaks of laws between them.

        Called after ``prepare``, before the first step.
        """
        for p in self.parts:
            if isinstance(p.integration, MethodRun):
                p.integration.watch()

    def _moving(self, part: Part, system: System, lap: Callable[[str], None], start: Start | None = None) -> PartRun:
        plan = self.plan
        method = KINEMATIC if part.kinematic else plan.method
        options = {} if part.kinematic else plan.options
        integration = _run(system, method, plan, options)
        lap("compile")
        initial = self._initial(part, system) if start is None else _solved(system, plan.start, *start)
        if part.kinematic and (initial.redundant or not determined(system, plan.start, initial.q)):
            assert part.dynamic is not None
            self._is_not_kinematic(part)
            system = build(part.dynamic.scene, part.dynamic, size=self._size)
            return self._moving(Part(part.dynamic), system, lap, start)
        if system.tables.states:
            state_sizes.estimate(system.tables, initial.v, initial.a, plan.stop - plan.start)
            integration = _run(system, method, plan, options)
        integration.begin(initial.q, initial.v, initial.a, initial.lam, initial.redundant)
        lap("initialise")
        return PartRun(part, system, method, initial, integration)

    def _initial(self, part: Part, system: System) -> InitialState:
        """The assembled state of a part."""
        plan, members = self.plan, members_of(self.reduction, system)
        flexible = [c for c in system.scene.bodies() if c.deforms and len(c.coordinates) > len(RATE)]
        static = [c.name for c in flexible if c.values["shape"] == "static"]
        relax = None
        if flexible:
            from mbdsl.statics.static_shape import relaxed

            relax = partial(relaxed, system, plan.start, static)
        initial = initial_state(system, part.graph, plan.start, members, relax, bool(static))
        check_assembled_shapes(system, initial)
        return initial

    def restart(self, plan: Plan) -> None:
        """Return to the start, for another run of the same scene, whose method may be another one."""
        self.plan, self.failed, self.gathered = plan, None, None
        for p in self.parts:
            if p.method not in (plan.method, KINEMATIC):
                keeps = getattr(p.integration, "keeps", False)
                p.method, p.integration = plan.method, _run(p.system, plan.method, plan, plan.options, keeps)
            elif isinstance(p.integration, MethodRun):
                p.integration = p.integration.anew(plan.times, plan.tol, plan.every, plan.longest, plan.rows)
            else:
                p.integration = _run(p.system, p.method, plan, plan.options)
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

    def _is_not_kinematic(self, part: Part) -> None:
        """Correct the note on a part that counting of constraints took for kinematic."""
        names, why = tuple(part.graph.bodies), "as many constraints as coordinates, but not independent ones"
        kept = [
            n if (n.action, n.names) != ("kinematic", names) else Note("kept", names, why) for n in self.reduction.notes
        ]
        self.reduction = replace(self.reduction, notes=tuple(kept))

    @property
    def redundant(self) -> list[str]:
        """Names of the redundant constraints that are left out."""
        return [
            system.constraint_names()[k]
            for system, first in self.assembled
            for k in first.redundant
            if k not in system.tables.switchable
        ]

    @property
    def not_unique(self) -> list[str]:
        """Names of the reactions that the equations of motion do not determine, as "pin.fz", and of their sizes."""
        firsts = self.assembled
        found = [name for system, first in firsts for name in undetermined(system, first.t, first.q, first.redundant)]
        sizes = dict.fromkeys(name[:-1] for name in found if name[:-1].rpartition(".")[2] in SIZES)
        return found + list(sizes)

    @property
    def moved(self) -> tuple[Moved, ...]:
        """Guesses, and the values after assembly."""
        return tuple(moved for _, first in self.assembled for moved in first.moved)

    @property
    def distance(self) -> float:
        """The largest scaled coordinate at the start."""
        largest = (np.abs(p.initial.q * p.system.tables.scale).max(initial=0.0) for p in self.parts)
        return max(map(float, largest), default=0.0)

    @property
    def sizes(self) -> dict[str, int]:
        """Numbers of coordinates n and of constraints m and p that are solved for, and of parts."""
        sums = {key: sum(getattr(p.system, key) for p in self.parts) for key in ("n", "m", "p")}
        return {**sums, "parts": len(self.parts)}

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
    def time(self) -> float:
        """The time that all parts have reached [s]."""
        return min((p.integration.time for p in self.parts), default=self.plan.start + self._taken * self.plan.h)

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

    # -- from the parts to the scene ---------------------------------------------------------------------------
    def present(self) -> tuple[Array, Array, Array]:
        """Present q, v (n,) and lam (m + p,)."""
        q, v, lam = self.whole.state(np.array([self.time]), [p.split(p.last) for p in self.parts])
        return q[0], v[0], lam[0]

    def rows(self, times: Array, states: Sequence[State]) -> Rows:
        """The rows of the scene at ``times`` (N,), from those of its parts."""
        return times, *self.whole.state(times, states), [(q, v) for q, v, _ in states]

    def output(self, partial: bool) -> Rows:
        """Times (N,), q, v (N, n) and lam (N, m + p) from the start on, and q and v of each part.

        ``partial`` includes the last step reached, even if it is not an output time. Times that are not ``shown`` are
        left out.
        """
        plan, reached = self.plan, self.time
        if plan.every and self.parts:
            return self._output_of_every_step()
        done = min((p.integration.written for p in self.parts), default=len(plan.times))
        if not self.parts:
            done = int((plan.times <= reached + 1e-9 * plan.h).sum())
        times = np.concatenate([[plan.start], plan.times[:done]])
        extra = partial and reached > times[-1] + 1e-9 * plan.h
        if extra and any(p.integration.time != reached for p in self.parts):
            extra = False  # a part that is ahead cannot go back
        states = []
        for p in self.parts:
            rows = [p.first, p.integration.out[:done], *([p.last] if extra else [])]
            states.append(p.split(np.concatenate(rows)))
        if extra:
            times = np.append(times, reached)
        if plan.shown is not None:
            shown = np.concatenate([[True], plan.shown[:done], np.ones(int(extra), bool)])
            times, states = times[shown], [(q[shown], v[shown], lam[shown]) for q, v, lam in states]
        return self.rows(times, states)

    def states(self) -> tuple[Array, Array, Array]:
        """Times (N,), q and v (N, n) at the start and at all times of the plan that the present run has reached."""
        shown = self.plan
        self.plan = replace(shown, shown=None)
        t, q, v, *_ = self.output(False)
        self.plan = shown
        return t, q, v

    def _output_of_every_step(self) -> Rows:
        """For parts with steps of their own: at the steps of all parts, up to the time that all have reached."""
        done = [(p, p.integration, p.integration.written) for p in self.parts]
        known = [np.append(self.plan.start, run.times[:count]) for _, run, count in done]
        states = [p.split(np.concatenate([p.first, run.out[:count]])) for p, run, count in done]
        return self.rows(*self._together(known, states))

    def _together(
        self, known: Sequence[Array], states: list[State], precise: bool = False
    ) -> tuple[Array, list[State]]:
        """The states of all parts at all of their ``known`` times that all of them have reached.

        Between its own times, a part has cubic polynomials; ``precise``: of degree 5.
        """
        if all(np.array_equal(known[0], t) for t in known):
            return known[0], states
        times = np.unique(np.concatenate(known))
        times = times[(times >= max(t[0] for t in known)) & (times <= min(t[-1] for t in known))]
        found = []
        for p, t, own in zip(self.parts, known, states, strict=True):
            a = p.accelerations(t, *own[:2]) if precise else None
            found.append(between(times, t, *own, p.system.tables.rotations[:, 0], a))
        return times, found

    def kept_numbers(self) -> int:
        """Quantity of numbers in the states that the parts keep at the ends of their steps."""
        runs = [p.integration for p in self.parts]
        return sum(rows.size for run in runs if isinstance(run, MethodRun) for rows in run.ends)

    def forgo(self) -> None:
        """Keep no further ends of steps."""
        for p in self.parts:
            if isinstance(p.integration, MethodRun):
                p.integration.forgo()

    def ends_of_steps(self) -> Callable[..., Ends] | None:
        """A function that returns times (N,), q, v (N, n) and lam (N, m + p) at the ends of the steps that all parts
        have taken so far, and on both sides of jumps of forces; None if they are not kept.

        Its argument is a slice of the kept states (:meth:`blocks`).
        """
        parts: list[list[Array]] = []  # joined when they are needed
        for p in self.parts:
            run = p.integration
            if not isinstance(run, MethodRun) or not run.keeps:
                return None
            run.flush()
            parts.append(run.ends[:])
        sizes, whole, together = [p.system.n for p in self.parts], self.whole, self._together
        precise = has_own_step(self.plan.method)

        def found(some: slice = slice(None)) -> Ends:
            for of_part in parts:
                of_part[:] = [np.concatenate(of_part)] if len(of_part) > 1 else of_part
            states = [_ordered(rows[some], n) for (rows,), n in zip(parts, sizes, strict=True)]
            times, known = together([t for t, *_ in states], [(q, v, lam) for _, q, v, lam in states], precise)
            return times, *whole.state(times, known, own=False)

        return found if parts else None

    def blocks(self, rows: int) -> list[slice]:
        """Slices of about so many kept states, each with the last state of the one before; one of all, if they are
        those of several parts, or not in order."""
        run = self.parts[0].integration
        assert isinstance(run, MethodRun)
        times = run.kept[:, 0]
        if len(self.parts) > 1 or not (np.diff(times) > 0.0).all():
            return [slice(None)]
        return [slice(k, k + rows + 1) for k in range(0, len(times) - 1, rows)] or [slice(None)]

    def release_steps(self, until: float) -> None:
        """Forget the ends of steps before a time [s], but the last of each part."""
        for p in self.parts:
            run = p.integration
            assert isinstance(run, MethodRun)
            rows = run.kept
            left = rows[-1:]
            if len(self.parts) > 1 or left[0, 0] != until:
                before = rows[:, 0] <= until
                left = rows[rows[:, 0] >= rows[before, 0].max()]
            run.ends = [left.copy()]


def _ordered(rows: Array, n: int) -> tuple[Array, Array, Array, Array]:
    """t, q, v and lam of kept states at ascending times."""
    if not (np.diff(rows[:, 0]) > 0.0).all():
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        same = 1 + np.flatnonzero(np.diff(rows[:, 0]) <= 0.0)
        rows[same, 0] = np.nextafter(rows[same, 0], np.inf)
    return rows[:, 0].copy(), rows[:, 1 : 1 + n], rows[:, 1 + n : 1 + 2 * n], rows[:, 1 + 2 * n :]


def _solved(system: System, t: float, states: Solved, q: Array, v: Array) -> InitialState:
    """The initial state of a part of a mechanism that was assembled in space."""
    return state_at(system, t, *states.of_part(system, q, v))


def _run(system: System, method: str, plan: Plan, options: Mapping[str, float | None], keeps: bool = False) -> Run:
    """A part's run, by compiled code, which may keep its steps, or by a backend."""
    arguments = system, method, plan.h, plan.start, plan.stop, plan.times, options
    if backend(method) is not None:
        from mbdsl.integrators.backends import External

        return External(*arguments, tol=plan.tol, every=plan.every, longest=plan.longest)
    tol, grid, longest = plan.tol, 0.0, plan.longest
    span = STEPS * plan.h if plan.single else 0.0
    if tol is None and system.scene.has_events:  # steps of a fixed size, which events shorten
        if controls_locally(method):
            tol, grid = NOMINAL, plan.h
        else:
            tol, longest = LOOSE, min(longest, plan.h)
    own = partial(MethodRun, *arguments, tol=tol, every=plan.every, longest=longest)
    return own(grid=grid, span=span, rows=plan.rows, keeps=keeps)
