"""A scene whose independent parts are assembled at the start.

The reduced scene (:mod:`mbdsl.mechanism.reduction`) is solved; the results refer to the scene as written.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from mbdsl.compilation import code_cache
from mbdsl.expressions.symbolic import RATE
from mbdsl.initial.consistent import InitialState, Moved, determined, initial_state, state_at
from mbdsl.initial.shared_loads import undetermined
from mbdsl.initial.start_conditions import check_assembled_shapes, check_loose
from mbdsl.initial.weights import members_of
from mbdsl.integrators import backend, declared
from mbdsl.integrators.loop.compiled_loop import loop_name
from mbdsl.mechanism import graph
from mbdsl.mechanism.reduction import Flattened, Note, Part, Reduction, reduce
from mbdsl.mechanism.reduction.gyrostats import Gyrostats
from mbdsl.mechanism.scene import Scene
from mbdsl.mechanism.signal_names import SIZES
from mbdsl.simulation.gyrostat_states import GyrostatStates
from mbdsl.simulation.part_run import KINEMATIC, Array, PartRun, run_of
from mbdsl.simulation.plan import Plan, check_events, check_space
from mbdsl.simulation.planar_states import OutOfPlane, PlanarStates
from mbdsl.simulation.whole_scene import WholeScene
from mbdsl.system import System, build, state_sizes
from mbdsl.system.signals import begin

#: the states in which a mechanism in space is solved
Solved = PlanarStates | GyrostatStates
#: these, and q and v of the scene that is solved, at the start
Start = tuple[Solved, Array, Array]


class AssembledScene:
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
        self._systems, self._spaces = self._built()
        self.parts: list[PartRun] = []
        self.assembled: list[tuple[System, InitialState]] = []

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

    def _moving(self, part: Part, system: System, lap: Callable[[str], None], start: Start | None = None) -> PartRun:
        plan = self.plan
        method = KINEMATIC if part.kinematic else plan.method
        options = {} if part.kinematic else plan.options
        integration = run_of(system, method, plan, options)
        lap("compile")
        initial = self._initial(part, system) if start is None else _solved(system, plan.start, *start)
        if part.kinematic and (initial.redundant or not determined(system, plan.start, initial.q)):
            assert part.dynamic is not None
            self._is_not_kinematic(part)
            system = build(part.dynamic.scene, part.dynamic, size=self._size)
            return self._moving(Part(part.dynamic), system, lap, start)
        if system.tables.states:
            state_sizes.estimate(system.tables, initial.v, initial.a, plan.stop - plan.start)
            integration = run_of(system, method, plan, options)
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


def _solved(system: System, t: float, states: Solved, q: Array, v: Array) -> InitialState:
    """The initial state of a part of a mechanism that was assembled in space."""
    return state_at(system, t, *states.of_part(system, q, v))
