"""The structure of a mechanism as its graph shows it: bodies, joints and forces with what a reader asks about them.

A joint closes a loop if it is not in the spanning tree in which bodies are placed (``MechanismGraph.tree``). Redundant
constraints depend on the pose; they are searched for in the initial positions, if the structure makes them possible.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from mbdsl.elements.kind import JointKind
from mbdsl.errors import InitialisationError
from mbdsl.mechanism.edge import Edge
from mbdsl.mechanism.graph import GROUND, MechanismGraph, SubMechanism
from mbdsl.mechanism.reduction import Note, reduce
from mbdsl.messages import few

JOINT, DRIVER, FORCE = "joint", "driver", "force"
MOST_ROWS = 1500  #: number of constraint rows up to which redundant ones are searched for


@dataclass(frozen=True)
class BodyNode:
    """A body.

    Attributes
    ----------
    name, kind : str
        Its name and the name of its kind.
    group : int
        Number from 1 of the welded bodies that it is merged with; 0 if there are none.
    fixed : bool
        Whether it is welded to the ground.
    moved : bool
        Whether drivers alone determine its motion, as a function of time.
    follows : bool
        Whether its constraints, with those of the bodies around it, leave nothing free.
    """

    name: str
    kind: str
    group: int = 0
    fixed: bool = False
    moved: bool = False
    follows: bool = False


@dataclass(frozen=True)
class Link:
    """A joint, a driver or a force between two bodies.

    Attributes
    ----------
    name, kind : str
        Its name and the name of its kind.
    role : {"joint", "driver", "force"}
    a, b : str
        Names of the bodies; "" is the ground.
    rows, velocity_rows : int
        Numbers of constraints of positions and of velocities alone.
    loop : int
        Number from 1 of the loop that it closes; 0 if it closes none.
    redundant : int
        Number of redundant constraints.
    weld : bool
        Whether it leaves nothing free.
    """

    name: str
    kind: str
    role: str
    a: str
    b: str
    rows: int = 0
    velocity_rows: int = 0
    loop: int = 0
    redundant: int = 0
    weld: bool = False

    def other(self, body: str) -> str:
        """Return the body at the other end.

        Parameters
        ----------
        body : str
            The body at one end.

        Returns
        -------
        str
            Its name; "" for the ground.
        """
        return self.b if body == self.a else self.a


class Loop(NamedTuple):
    """A loop.

    Attributes
    ----------
    bodies : tuple of str
        Names of its bodies in order, the first one once more at the end; "" is the ground.
    closed_by : str
        Name of the joint that closes it.
    """

    bodies: tuple[str, ...]
    closed_by: str


@dataclass(frozen=True)
class Structure:
    """The structure of a mechanism.

    Attributes
    ----------
    name, doc, ground : str
        Names of the model and of its ground, and the model's description.
    bodies : dict of str to BodyNode
    links : tuple of Link
    parents : dict of str to str
        Body -> the body from which it is placed.
    by : dict of str to str or None
        Body -> the joint by which it is placed from there, if there is one.
    levels : dict of str to int
        Body -> number of links from the ground; that of the ground (``""``) is 0.
    loops : tuple of Loop
    parts : tuple of SubMechanism
        Independent sub-mechanisms.
    summary : str
        Counts and mobility.
    remarks : tuple of str
        Sentences on drivers, merged bodies and redundant constraints.
    """

    name: str
    doc: str
    ground: str
    bodies: Mapping[str, BodyNode]
    links: tuple[Link, ...]
    parents: Mapping[str, str]
    by: Mapping[str, str | None]
    levels: Mapping[str, int]
    loops: tuple[Loop, ...]
    parts: tuple[SubMechanism, ...]
    summary: str
    remarks: tuple[str, ...] = ()

    def label(self, body: str) -> str:
        """Return the name of a body or of the ground.

        Parameters
        ----------
        body : str
            Name of a body, or "" for the ground.

        Returns
        -------
        str
        """
        return body or self.ground

    def loop_text(self, number: int) -> str:
        """Return the bodies of a loop as a text.

        Parameters
        ----------
        number : int
            Number of the loop, from 1.

        Returns
        -------
        str
            The bodies from one of them back to it, and the joint that closes the loop.
        """
        loop = self.loops[number - 1]
        path = few([self.label(body) for body in loop.bodies], 12).replace(", ", " - ")
        return f"loop {number}: {path}, closed by {loop.closed_by}"


def structure(graph: MechanismGraph, search: bool = True, announce: Callable[[str], None] | None = None) -> Structure:
    """The structure of a mechanism.

    Parameters
    ----------
    graph : MechanismGraph
        Its graph.
    search : bool, optional
        Whether to search for redundant constraints, which takes the initial positions.
    announce : callable, optional
        Receives a line if code has to be compiled for it.

    Returns
    -------
    Structure
    """
    edges, joints = (*graph.joints, *graph.forces), graph.kinematic_joints
    strong = {e.name: e for e in joints}
    parents = {p.body: p.parent for p in graph.tree()}
    by = {p.body: p.joint for p in graph.tree()}
    for body, name in by.items():  # rather by a joint than by its driver
        if name not in strong:
            ends = {body, parents[body]}
            by[body] = next((e.name for e in joints if {e.body_i, e.body_j} == ends), name)
    closing = [e for e in joints if e.name not in by.values()]
    redundant, reasons = _redundant(graph, announce) if search else ({}, [])
    number = {e.name: k for k, e in enumerate(closing, 1)}
    notes = reduce(graph).notes
    levels = _levels(graph, list(joints), [e for e in edges if e.name not in strong])
    found = Structure(
        graph.scene.name,
        graph.scene.doc,
        graph.ground.name,
        _bodies(graph, notes),
        tuple(_link(e, number.get(e.name, 0), redundant.get(e.name, 0)) for e in edges),
        parents,
        by,
        levels,
        _loops(joints, closing, levels),
        graph.sub_mechanisms,
        graph.summary(),
    )
    return replace(found, remarks=(*_driven(found, notes), *_joined(notes), *reasons))


def _link(e: Edge, loop: int, redundant: int) -> Link:
    kind = e.component.kind
    role, weld = FORCE, False
    if isinstance(kind, JointKind):
        role, weld = JOINT if kind.driver is None else DRIVER, kind.pose is not None and not kind.free
    return Link(e.name, kind.name, role, e.body_i, e.body_j, e.rows, e.velocity_rows, loop, redundant, weld)


def _levels(graph: MechanismGraph, strong: list[Edge], weak: list[Edge]) -> dict[str, int]:
    """Distances from the ground: by strong edges alone as far as they reach, then by one weak edge, and so on."""

    def around(edges: list[Edge]) -> dict[str, list[str]]:
        at: dict[str, list[str]] = {GROUND: [], **{body: [] for body in graph.bodies}}
        for e in edges:
            at[e.body_i].append(e.body_j)
            at[e.body_j].append(e.body_i)
        return at

    near, further = around(strong), around(weak)
    levels, order = {GROUND: 0}, [GROUND]
    done = searched = 0

    def reach(others: list[str], level: int) -> None:
        for other in others:
            if other not in levels:
                levels[other] = level
                order.append(other)

    while True:
        while done < len(order):
            reach(near[order[done]], levels[order[done]] + 1)
            done += 1
        while searched < len(order) and done == len(order):
            new = [other for other in further[order[searched]] if other not in levels]
            reach(new[:1], levels[order[searched]] + 1)
            searched += not new
        if done == len(order):
            free = [body for body in graph.bodies if body not in levels]
            if not free:
                return levels
            reach(free[:1], 1)  # a law of its velocity holds it


def _loops(joints: Sequence[Edge], closing: Sequence[Edge], levels: Mapping[str, int]) -> tuple[Loop, ...]:
    """For each closing joint a shortest loop through it, the spanning tree and the closing joints before it.

    Each has a joint that no loop before it has, so that they are independent.
    """
    late = {e.name for e in closing}
    near: dict[str, list[str]] = {}

    def add(e: Edge) -> None:
        near.setdefault(e.body_i, []).append(e.body_j)
        near.setdefault(e.body_j, []).append(e.body_i)

    for e in joints:
        if e.name not in late:
            add(e)
    found = []
    for e in closing:
        path = _path(e.body_i, e.body_j, near)
        first = min(range(len(path)), key=lambda k: levels[path[k]])
        found.append(Loop((*path[first:], *path[: first + 1]), e.name))
        add(e)
    return tuple(found)


def _path(a: str, b: str, near: Mapping[str, Sequence[str]]) -> list[str]:
    """A shortest path from a to b, by breadth-first search."""
    before, order = {a: a}, [a]
    for body in order:
        if b in before:
            break
        for other in near.get(body, ()):
            if other not in before:
                before[other] = body
                order.append(other)
    path = [b]
    while path[-1] != a:
        path.append(before[path[-1]])
    return path[::-1]


def _bodies(graph: MechanismGraph, notes: Iterable[Note]) -> dict[str, BodyNode]:
    found = {name: BodyNode(name, c.kind.name) for name, c in graph.bodies.items()}
    group = 0
    for note in notes:
        group += note.action == "merged"
        change = {
            "merged": {"group": group},
            "grounded": {"fixed": True},
            "moved": {"moved": True},
            "kinematic": {"follows": True},
        }.get(note.action, {})
        for name in note.names if change else ():
            found[name] = replace(found[name], **change)  # type: ignore[arg-type]
    merged = {}
    for note in notes:
        if note.action == "merged":
            merged[note.names[0]] = note.names
    for root, names in merged.items():  # later reductions name the first of them only
        for name in names:
            found[name] = replace(found[name], moved=found[root].moved, follows=found[root].follows)
    return found


def _driven(found: Structure, notes: Iterable[Note]) -> list[str]:
    """What each driver moves."""
    lines, named = [], set()
    for note in notes:
        if note.action == "moved":
            lines.append(f"{note.by[-1]} moves {few(note.names)}: a known function of time")
            named.add(note.by[-1])
    for link in found.links:
        if link.role == DRIVER and link.name not in named:
            ends = " and ".join(found.label(body) for body in (link.a, link.b))
            lines.append(f"{link.name} prescribes the motion between {ends}")
    for note in notes:
        if note.action == "kinematic":
            what = "follows" if len(note.names) == 1 else "follow"
            lines.append(f"{few(note.names)} {what} from the constraints alone, which leave nothing free")
    return lines


def _joined(notes: Iterable[Note]) -> list[str]:
    lines = []
    for note in notes:
        if note.action == "merged":
            lines.append(f"{few(note.names)} are solved as one body: {few(note.by)} {_joins(note.by)} them")
        elif note.action == "grounded":
            what = "is" if len(note.names) == 1 else "are"
            lines.append(f"{few(note.names)} {what} part of the ground, welded by {few(note.by)}")
        elif note.action == "kept":
            lines.append(f"{few(note.names)} is kept as a joint: {note.why}")
        elif note.action == "dropped":
            lines.append(f"{few(note.names)}: {note.why}")
    return lines


def _joins(names: tuple[str, ...]) -> str:
    return "joins" if len(names) == 1 else "join"


def _redundant(graph: MechanismGraph, announce: Callable[[str], None] | None) -> tuple[dict[str, int], list[str]]:
    """Joint -> number of redundant rows in the initial state, and sentences on them."""
    drivers = [e for e in graph.joints if isinstance(e.component.kind, JointKind) and e.component.kind.driver]
    pairs = {frozenset((e.body_i, e.body_j)) for e in drivers}
    possible = graph.loops or graph.velocity_mobility < 0 or len(pairs) < len(drivers) or graph.velocity_rows
    if not possible:
        return {}, []
    if graph.rows + graph.velocity_rows > MOST_ROWS:
        return {}, [f"redundant constraints are not searched for in models of more than {MOST_ROWS} rows"]
    import numpy as np

    from mbdsl.compilation import code_cache
    from mbdsl.initial.consistent import initial_position, redundant_rows
    from mbdsl.initial.redundancy import repeated
    from mbdsl.storage import cache_folder
    from mbdsl.system import build

    system = build(graph.scene, graph)
    sets = 2 if code_cache.is_compiled(system.module_name(2)) else 1
    if announce is not None and not code_cache.is_compiled(system.module_name(sets)):
        announce(cache_folder.compiling())
    system.kernels(sets)
    t, v = float(graph.scene.experiment.start), np.zeros(system.n)
    try:
        q = initial_position(system, graph, t)
    except InitialisationError as problem:
        return {}, [
            f"redundant constraints are not searched for, because there is no initial position: {problem.message}"
        ]
    rows = redundant_rows(system, t, q, v)
    names = [system.constraint_names()[row].rpartition(".")[0] for row in rows]
    lines = [f"redundant: {line}" for line in repeated(system, t, q, v, rows)]
    return {name: names.count(name) for name in names}, lines
