"""The structure of a mechanism as its graph shows it: bodies, joints and forces with loops, drivers and redundancies.

A joint closes a loop if it is not in the spanning tree in which bodies are placed (``MechanismGraph.tree``). Redundant
constraints depend on the pose; they are searched for in the initial positions, if the structure makes them possible.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from mbdsl.elements.kind import JointKind
from mbdsl.mechanism.edge import Edge
from mbdsl.mechanism.graph import MechanismGraph, SubMechanism
from mbdsl.mechanism.graph_algorithms import Loop
from mbdsl.mechanism.reduction import Note, reduce
from mbdsl.mechanism.scene import is_rate
from mbdsl.messages import few
from mbdsl.viewing.structure_redundancy import redundancy

JOINT, DRIVER, FORCE = "joint", "driver", "force"
EQUATION = "equation"  #: the kind of links that are equations of states


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
        Whether the constraints alone determine its motion, if that of the ``moved`` bodies is given.
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
        Whether it allows no relative motion.
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

    def save(self, path: str | os.PathLike) -> None:
        """Write a picture or a page.

        Parameters
        ----------
        path : path
            The file: .svg, .html, or .png and .pdf, which require matplotlib.

        Raises
        ------
        UsageError
            If the suffix is unknown, the file cannot be written, or matplotlib is not installed.
        """
        from mbdsl.viewing.structure_files import save

        save(self, path)

    def __repr__(self) -> str:
        return f"<Structure of {self.summary.splitlines()[0]}>"

    def __str__(self) -> str:
        from mbdsl.viewing.structure_text import text

        return text(self)

    def _repr_svg_(self) -> str:
        from mbdsl.viewing.structure_svg import svg

        return svg(self)


def structure(graph: MechanismGraph, search: bool = True, announce: Callable[[str], None] | None = None) -> Structure:
    """The structure of a mechanism.

    Parameters
    ----------
    graph : MechanismGraph
        Its graph.
    search : bool, optional
        Whether to search for redundant constraints, which requires the initial positions.
    announce : callable, optional
        Receives a line if code has to be compiled for it.

    Returns
    -------
    Structure
    """
    redundant, reasons = redundancy(graph, announce) if search else ({}, [])
    number = {e.name: k for k, e in enumerate(graph.cut_joints, 1)}
    notes = reduce(graph).notes
    found = Structure(
        graph.scene.name,
        graph.scene.doc,
        graph.ground.name,
        _bodies(graph, notes),
        tuple(_link(e, number.get(e.name, 0), redundant.get(e.name, 0)) for e in (*graph.joints, *graph.forces)),
        {p.body: p.parent for p in graph.tree()},
        graph.placed_by,
        graph.distances(),
        graph.cycles(),
        graph.sub_mechanisms,
        graph.summary(),
    )
    return replace(found, remarks=(*_driven(found, notes), *_joined(notes), *reasons))


def _link(e: Edge, loop: int, redundant: int) -> Link:
    kind = e.component.kind
    role, weld = FORCE, False
    if isinstance(kind, JointKind):
        role, weld = (
            DRIVER if kind.driver is not None and not kind.relations else JOINT,
            kind.placing.pose is not None and not kind.placing.free,
        )
    # a coupling is drawn between two of the bodies whose coordinates it reads, a rate from its state to one of them
    reads = e.component.relations or is_rate(e.component)
    first, last = (e.body_j, e.also[-1]) if reads and e.also else (e.body_i, e.body_j)
    name = EQUATION if is_rate(e.component) else kind.name
    return Link(e.name, name, role, first, last, e.rows, e.velocity_rows, loop, redundant, weld)


def _bodies(graph: MechanismGraph, notes: Iterable[Note]) -> dict[str, BodyNode]:
    found = {name: BodyNode(name, c.kind.name) for name, c in graph.bodies.items()}
    group = 0
    for note in notes:
        group += note.action == "merged"
        changes: dict[str, dict[str, Any]] = {
            "merged": {"group": group},
            "grounded": {"fixed": True},
            "moved": {"moved": True},
            "kinematic": {"follows": True},
        }
        change = changes.get(note.action, {})
        for name in note.names if change else ():
            found[name] = replace(found[name], **change)
    merged = {}
    for note in notes:
        if note.action == "merged":
            merged[note.names[0]] = note.names
    for root, names in merged.items():  # later reductions name only the first of them
        for name in names:
            found[name] = replace(found[name], moved=found[root].moved, follows=found[root].follows)
    return found


def _driven(found: Structure, notes: Iterable[Note]) -> list[str]:
    """Sentences on the bodies that each driver moves."""
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
