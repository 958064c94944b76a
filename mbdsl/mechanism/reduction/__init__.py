"""Reduction: the parts of a scene that have to be solved, without the motions that are known before the first step.

Welded bodies are merged, bodies that drivers move one after the other become part of the ground, and independent
sub-mechanisms are separated. Of a model in space, sub-mechanisms that can only move in a plane become planar first;
in the others, rotors that are symmetric about their axles become parts of gyrostats.
The trajectory still refers to the scene as it was written: every body belongs to a part (or to the ground), and its
motion follows from that of a frame there.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from mbdsl.elements.kind import ForceKind, JointKind, SensorKind
from mbdsl.errors import ModelError
from mbdsl.expressions.symbolic import Expr, leaves
from mbdsl.mechanism import graph as mechanism
from mbdsl.mechanism.edge import Edge
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.reduction import drivers, welds
from mbdsl.mechanism.reduction.gyrostats import Gyrostats, gyrostats
from mbdsl.mechanism.reduction.note import Note
from mbdsl.mechanism.reduction.planar_motion import NotPlanar, PlanarMotion, planar_motion
from mbdsl.mechanism.scene import Component, Frame, InitialValue, Scene

__all__ = ["Note", "Part", "Reduction", "reduce"]


@dataclass(frozen=True)
class Part:
    """An independent sub-mechanism, as a scene of its own.

    It is ``kinematic`` if, by counting, its constraints leave no degree of freedom. If they are independent, too, they
    determine the motion, and forces and friction, which ``scene`` then lacks, follow from the motion. ``dynamic`` is
    the part with forces and friction.
    """

    graph: MechanismGraph
    kinematic: bool = False
    dynamic: MechanismGraph | None = None

    @property
    def scene(self) -> Scene:
        return self.graph.scene


@dataclass(frozen=True)
class Flattened:
    """A sub-mechanism in space that is solved in a plane, or with gyrostats: the ``reduction`` of the scene that is
    solved, whose parts are those of the whole reduction from number ``first`` on."""

    motion: PlanarMotion | Gyrostats
    reduction: Reduction
    first: int

    @property
    def numbers(self) -> range:
        return range(self.first, self.first + len(self.reduction.parts))


@dataclass(frozen=True)
class Reduction:
    """The ``parts`` to solve, possibly none. They were cut from ``scene``, whose ground includes all that became part
    of it; ``loose`` are initial values that depend on this ground only. ``flattened`` are the sub-mechanisms in space
    whose parts are planar, or have gyrostats."""

    graph: MechanismGraph
    scene: Scene
    parts: tuple[Part, ...]
    notes: tuple[Note, ...] = ()
    loose: tuple[InitialValue, ...] = ()
    flattened: tuple[Flattened, ...] = ()

    @property
    def nothing_done(self) -> bool:
        """Whether the only part is the scene itself."""
        return len(self.parts) == 1 and self.parts[0].graph is self.graph


def reduce(graph: MechanismGraph, planar: bool = True) -> Reduction:
    """The parts of the mechanism of ``graph``; with ``planar`` those of a model in space that can only move in a plane
    are planar, and the others may have gyrostats. Sensors are left out. A scene with events is one part: conditions and
    what they change may belong to any bodies."""
    if graph.scene.has_events:
        return Reduction(graph, graph.scene, (Part(graph),))
    sensors = {c.name for c in graph.scene.components.values() if isinstance(c.kind, SensorKind)}
    if not sensors:
        return _reduce(graph, planar)
    kept = {name: c for name, c in graph.scene.components.items() if name not in sensors}
    found = _reduce(mechanism.build(replace(graph.scene, components=kept)), planar)
    if found.nothing_done:
        return replace(found, graph=graph, scene=graph.scene, parts=(replace(found.parts[0], graph=graph),))
    return replace(found, graph=graph)


def _reduce(graph: MechanismGraph, planar: bool) -> Reduction:
    scene, notes = graph.scene, list[Note]()
    reduced = graph
    for step in () if scene.spatial else (welds.merge, drivers.carry):
        found, more = step(reduced)
        notes += more
        if found is not reduced.scene:
            found, more = _without_idle(found)
            notes += more
            if not found.with_coordinates():
                return Reduction(graph, found, (), tuple(notes), found.initial)
            reduced = mechanism.build(found)
    groups = _groups(reduced)
    whole = reduced is graph and len(groups) == 1
    owner = {body: k for k, group in enumerate(groups) for body in group}
    parts, flattened, own = list[Part](), list[Flattened](), list[Part]()
    for k, group in enumerate(groups):
        alone = reduced if len(groups) == 1 else mechanism.build(_cut(reduced, owner, k))
        if len(groups) > 1:
            notes.append(Note("split", tuple(group), "nothing joins it to the rest"))
        motion: PlanarMotion | Gyrostats | None = _planar(alone, notes) if scene.spatial and planar else None
        if scene.spatial and planar and motion is None and not alone.scene.states():
            motion, more = gyrostats(alone)
            notes += more
        if motion is None:
            own.append(_part(alone))
            parts.append(own[-1])
        else:
            inner = reduce(motion.reduced, planar=False)
            flattened.append(Flattened(motion, inner, len(parts)))
            parts += inner.parts
            notes += inner.notes
    notes += _solved(own)
    loose = tuple(x for x in reduced.scene.initial if not whole and not _owners(reduced.scene, owner, x.target))
    return Reduction(graph, reduced.scene, tuple(parts), tuple(notes), loose, tuple(flattened))


def _planar(graph: MechanismGraph, notes: list[Note]) -> PlanarMotion | None:
    """The planar motion of a mechanism in space, if it can only move in a plane.

    A note says so. Another one says what prevents it, if all bodies are held in a plane.
    """
    bodies = tuple(graph.bodies)
    if states := graph.scene.states():
        why = "solved in space: states are not reduced to a plane"
        notes.append(Note("kept", bodies, why, (states[0].name,), states[0].span))
        return None
    try:
        motion = planar_motion(graph)
    except NotPlanar as problem:
        by = problem.component
        why = f"held in a plane, but solved in space because of {by.name}: {problem.why}"
        notes.append(Note("kept", bodies, why, (by.name,), by.span))
        return None
    if motion is not None:
        normal = ", ".join(f"{x:.6g}" for x in motion.plane.normal)
        why = f"can only move in planes with the normal {{{normal}}}: solved as planar"
        first = graph.joints[0].component
        notes.append(Note("planar", bodies, why, (), first.span))
    return motion


def _solved(parts: list[Part]) -> list[Note]:
    why = "its constraints leave nothing free"
    return [Note("kinematic", tuple(part.graph.bodies), why) for part in parts if part.kinematic]


def _without_idle(scene: Scene) -> tuple[Scene, list[Note]]:
    """Remove forces between bodies that do not move freely, which have no effect, and joints of these bodies only."""
    bodies = {c.name for c in scene.with_coordinates()}
    idle = []
    for c in scene.components.values():
        if isinstance(c.kind, (ForceKind, JointKind)) and (c.ports or c.relations):
            expressions = (
                *c.relations,
                *c.velocity_constraints,
                *(e for e in c.values.values() if isinstance(e, Expr)),
            )
            read = {leaf.value[0] for leaf in leaves(*expressions) if leaf.op == "coordinate"}
            frames = {*c.ports.values(), *(read if c.relations or c.velocity_constraints else ())}
            if not any(scene.frames[name].body in bodies for name in frames):
                idle.append(c)
    if not idle:
        return scene, []
    components = {name: c for name, c in scene.components.items() if c not in idle}
    names = tuple(c.name for c in idle)
    return replace(scene, components=components), [
        Note("dropped", names, "acts on nothing that moves freely", names, idle[0].span)
    ]


def _groups(graph: MechanismGraph) -> list[list[str]]:
    """Bodies of the independent parts; bodies in the same initial value are assembled together."""
    groups = [list(p.bodies) for p in graph.sub_mechanisms]
    if len(groups) == 1:
        return groups
    owner = {body: k for k, group in enumerate(groups) for body in group}
    links = [sorted(_owners(graph.scene, owner, x.target)) for x in graph.scene.initial]
    joined = mechanism.connected(range(len(groups)), [link for link in links if len(link) > 1])
    return [[body for k in group for body in groups[k]] for group in joined]


def _owners(scene: Scene, owner: dict[str, int], target: Expr) -> set[int]:
    """The parts that an expression depends on."""
    frames = [leaf.value[0] for leaf in leaves(target) if leaf.op == "coordinate"]
    return {owner[scene.frames[f].body] for f in frames if scene.frames[f].body in owner}


def _cut(graph: MechanismGraph, owner: dict[str, int], k: int) -> Scene:
    """The scene of part ``k`` alone."""
    scene = graph.scene
    bodies = {body for body, part in owner.items() if part == k}
    edges: Iterable[Edge] = (*graph.joints, *graph.forces)
    mine = {e.name for e in edges if any(b in bodies for b in (e.body_i, e.body_j, *e.also))}
    known = {e.name for e in (*graph.joints, *graph.forces)} | set(owner)

    def keep(c: Component) -> bool:
        return c.name not in known or c.name in bodies or c.name in mine

    def near(frame: Frame) -> bool:
        return frame.body not in owner or frame.body in bodies

    return replace(
        scene,
        components={name: c for name, c in scene.components.items() if keep(c)},
        frames={name: f for name, f in scene.frames.items() if near(f)},
        initial=tuple(x for x in scene.initial if k in _owners(scene, owner, x.target)),
        variables={},
    )


def _part(graph: MechanismGraph) -> Part:
    """A part; it is kinematic if, by counting, the constraints alone determine the motion."""
    if graph.coordinates != graph.rows or graph.velocity_rows or graph.states:
        return Part(graph)
    scene = graph.scene
    components = {}
    for name, c in scene.components.items():
        if not isinstance(c.kind, ForceKind):
            components[name] = replace(c, friction=None, friction_rows=())
    try:
        bare = mechanism.build(replace(scene, components=components))
    except ModelError:  # a body is held by forces alone
        return Part(graph)
    if any(p.mobility for p in bare.sub_mechanisms):
        return Part(graph)
    return Part(bare, True, graph)
