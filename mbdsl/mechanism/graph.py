"""The MechanismGraph: bodies are nodes, joints and forces are edges; the structure of a model without its numbers.

Here the structure is checked (all bodies are held, no joint connects a body to itself), counted (loops, Gruebler count)
and ordered (placement of bodies, elimination of unknowns), in plain Python. :mod:`mbdsl.mechanism.graph_algorithms` has
the methods that networkx answers.
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

from mbdsl.elements.kind import BodyKind, ForceKind, JointKind
from mbdsl.errors import ModelWarning
from mbdsl.expressions.symbolic import Expr, leaves
from mbdsl.mechanism import checks
from mbdsl.mechanism.connected_groups import connected
from mbdsl.mechanism.contacts import is_contact
from mbdsl.mechanism.edge import Edge
from mbdsl.mechanism.elimination_order import minimum_degree
from mbdsl.mechanism.graph_algorithms import GROUND, GraphAlgorithms, Placement
from mbdsl.mechanism.scene import Component, Scene, is_rate, is_state
from mbdsl.mechanism.sticking import joint_of
from mbdsl.messages import count, few
from mbdsl.storage.garbage_collection import uncollected


class SubMechanism(NamedTuple):
    """Bodies that joints and forces connect without passing through the ground, and their degrees of freedom."""

    bodies: tuple[str, ...]
    coordinates: int
    rows: int
    velocity_rows: int = 0

    @property
    def mobility(self) -> int:
        return self.coordinates - self.rows

    @property
    def velocity_mobility(self) -> int:
        return self.mobility - self.velocity_rows


@dataclass(frozen=True)
class MechanismGraph(GraphAlgorithms):
    """Structure of a :class:`~mbdsl.mechanism.scene.Scene`. Bodies, joints and forces keep the scene's order."""

    scene: Scene
    ground: Component  #: the (first) ground; as a node it is ``GROUND``
    bodies: Mapping[str, Component]  #: the components with coordinates
    joints: tuple[Edge, ...]
    forces: tuple[Edge, ...]
    warnings: tuple[ModelWarning, ...] = field(default=(), compare=False)  #: suspicious properties that are not errors

    def __repr__(self) -> str:
        return f"<MechanismGraph of {self.summary().splitlines()[0]}>"

    def _repr_html_(self) -> str:
        from mbdsl.mechanism.scene_tables import of_graph

        return of_graph(self)

    # -- counts ----------------------------------------------------------------------------------------------
    @cached_property
    def coordinates(self) -> int:
        """The number of coordinates of the bodies, without states."""
        return sum(_mechanical(c) for c in self.bodies.values())

    @property
    def states(self) -> list[str]:
        """Names of the states, which are among the ``bodies``."""
        return [name for name, c in self.bodies.items() if is_state(c)]

    def without_contacts(self) -> MechanismGraph:
        """The graph while all rigid contacts are open; bodies that only contacts hold are in it."""
        joints = tuple(e for e in self.joints if not is_contact(e.component))
        return replace(self, scene=self.scene.without_contacts(), joints=joints)

    @cached_property
    def rows(self) -> int:
        return sum(e.rows for e in self.joints)

    @cached_property
    def velocity_rows(self) -> int:
        """Rows that constrain velocities only."""
        return sum(e.velocity_rows for e in self.joints)

    @property
    def mobility(self) -> int:
        """Gruebler count: coordinates minus constraint rows. Redundant constraints make it less than the mobility."""
        return self.coordinates - self.rows

    @property
    def velocity_mobility(self) -> int:
        """The same for velocities, which rows at velocity level constrain as well."""
        return self.mobility - self.velocity_rows

    @cached_property
    def loops(self) -> int:
        """Independent kinematic loops. A driver parallel to the joint that it drives closes none."""
        edges = self.kinematic_joints
        groups = connected((GROUND, *self.bodies), ((e.body_i, e.body_j) for e in edges))
        return len(edges) - (len(self.bodies) + 1) + len(groups)

    @cached_property
    def kinematic_joints(self) -> tuple[Edge, ...]:
        """Joints that constrain positions, without the drivers of other joints between the same bodies."""
        joints = [e for e in self.joints if e.placing_rows]
        driven = {frozenset((e.body_i, e.body_j)) for e in joints if not _is_driver(e)}
        return tuple(e for e in joints if not (_is_driver(e) and frozenset((e.body_i, e.body_j)) in driven))

    @cached_property
    def sub_mechanisms(self) -> tuple[SubMechanism, ...]:
        """Parts that do not influence one another (the ground does not move and therefore connects nothing)."""
        links = [(e.body_i, e.body_j, *e.also) for e in (*self.joints, *self.forces)]
        groups = connected(self.bodies, ([b for b in link if b != GROUND] for link in links))
        number = {body: k for k, group in enumerate(groups) for body in group}
        rows, velocity_rows = [0] * len(groups), [0] * len(groups)
        for e in self.joints:
            k = number[e.body_j if e.body_i == GROUND else e.body_i]
            rows[k] += e.rows
            velocity_rows[k] += e.velocity_rows
        return tuple(
            SubMechanism(tuple(group), sum(_mechanical(self.bodies[b]) for b in group), rows[k], velocity_rows[k])
            for k, group in enumerate(groups)
        )

    # -- orders ----------------------------------------------------------------------------------------------
    @cached_property
    def _tree(self) -> tuple[Placement, ...]:
        at: dict[str, list[Edge]] = {GROUND: [], **{name: [] for name in self.bodies}}
        for e in (*self.joints, *self.forces):
            at[e.body_i].append(e)
            if e.body_j != e.body_i:
                at[e.body_j].append(e)
        placed, order, ticket = {GROUND}, [], 0
        # The joint with the most rows comes first, then the one nearest to the ground: a rod is placed by its pin on
        # the crank rather than by the slot that guides its other end.
        heap: list[tuple[int, int, int, str, str, Edge]] = []

        def reach(body: str, depth: int) -> None:
            nonlocal ticket
            placed.add(body)
            for e in at[body]:
                ticket += 1
                if e.other(body) not in placed:
                    heapq.heappush(heap, (-e.placing_rows, depth, ticket, e.other(body), body, e))

        reach(GROUND, 1)
        for start in self.bodies:  # a body without joints passes the checks if a law of velocities depends on it
            while heap:
                _, depth, _, body, parent, e = heapq.heappop(heap)
                if body not in placed:
                    order.append(Placement(body, parent, e.name if e.placing_rows else None))
                    reach(body, depth + 1)
            if start not in placed:
                order.append(Placement(start, GROUND, None))
                reach(start, 1)
        return tuple(order)

    def tree(self) -> tuple[Placement, ...]:
        """A spanning tree, in the order in which bodies can be placed, each from one that is already placed."""
        return self._tree

    def elimination_order(self) -> list[str]:
        """Names of bodies and joints in an order that keeps a factorisation of the Newton matrix sparse and safe.

        Minimum degree, under three rules that keep every pivot block regular without numerical pivoting as long as
        all masses are positive and the constraints independent: the joint that connects a body with its parent in the
        spanning tree comes after that body; a joint that closes a loop, even if at velocity level only, after all
        bodies of the loop; an expression in velocities after all bodies between those it reads and the ground.
        """
        parent = {p.body: p.parent for p in self._tree}
        hangs = {p.joint: p.body for p in self._tree if p.joint}
        sizes = {name: _coordinates(c) for name, c in self.bodies.items()}
        constraining = {e.name: size for e in self.joints if (size := e.slots + e.velocity_rows)}
        sizes |= constraining
        adjacent: dict[str, set[str]] = {name: set() for name in sizes}
        after: dict[str, set[str]] = {}
        for e in (*self.joints, *self.forces):
            nodes, name = {e.body_i, e.body_j, *e.also, *e.reads}, e.component.name
            nodes.discard(GROUND)
            if name in constraining:
                after[name] = self._needs(e, parent, hangs.get(name))
                nodes.add(name)
            for node in nodes:
                adjacent[node] |= nodes
        return minimum_degree(adjacent, sizes, after)

    def _needs(self, joint: Edge, parent: Mapping[str, str], child: str | None) -> set[str]:
        if joint.also and (joint.velocity_rows or not joint.component.ports):
            ends = (joint.body_i, joint.body_j, *joint.also)
            return {body for end in ends for body in _loop(end, GROUND, parent)} - {GROUND}
        # A child that can rotate has full rank in the rows of every joint; a point mass has none in a row of angles.
        if child is not None and "phi" in _kind(self.bodies[child]).coordinates:
            return {child}
        return set(_loop(joint.body_i, joint.body_j, parent)) - {GROUND}

    # -- description -----------------------------------------------------------------------------------------
    def summary(self) -> str:
        """Counts and mobility, a few lines."""
        of_states, whens = set(self.states), self.scene.events.written
        parts = [p for p in self.sub_mechanisms if not of_states.issuperset(p.bodies)]
        states = len(of_states)
        contacts = [is_contact(e.component) for e in self.joints if not e.component.kind.contacts]
        counts = [count(len(self.bodies) - states, "body", "bodies"), count(contacts.count(False), "joint")]
        counts += [count(sum(contacts), "rigid contact")] if any(contacts) else []
        counts += [count(len(self.forces) - states, "force"), count(self.loops, "independent loop")]
        counts += [count(states, "state")] if states else []
        counts += [count(len(whens), "when-equation")] if whens else []
        sides = f"{count(self.coordinates, 'coordinate')} - {count(self.rows, 'constraint row')}"
        lines = [f"{self.scene.name}: {', '.join(counts)}", f"mobility {self.mobility} = {sides} (Gruebler count)"]
        if self.velocity_rows:
            more = count(self.velocity_rows, "velocity-level row")
            lines.append(f"mobility of velocities {self.velocity_mobility} = {self.mobility} - {more}")
        if self.scene.inputs:
            lines.append(f"{count(len(self.scene.inputs), 'input')}: {few(list(self.scene.inputs))}")
        if len(parts) > 1:
            lines.append(f"{len(parts)} independent sub-mechanisms:")
            lines += [
                f"  mobility {_mobility(p)}: {few([x for x in p.bodies if x not in of_states])}" for p in parts[:20]
            ]
            lines += [f"  and {len(parts) - 20} more"] if len(parts) > 20 else []
        for p in parts:
            if p.velocity_mobility < 0:
                rows = count(-p.velocity_mobility, "constraint row")
                lines.append(f"at least {rows} of {few(p.bodies)} must be redundant, or the part cannot be assembled")
        return "\n".join(lines)

    def describe(self) -> str:
        """The whole structure, as ``mbdsl show --stage graph`` prints it."""
        tree = self.tree()
        closing = {e.name for e in self.cut_joints}
        lines = [self.summary(), "", "bodies"]
        bodies = {name: c for name, c in self.bodies.items() if not is_state(c)}
        lines += [f"  {n}  {c.kind.name}  {', '.join(c.coordinates)}" for n, c in bodies.items()]
        rates = [e for e in self.forces if is_rate(e.component)]
        if rates:
            lines += ["", "states"]
            lines += [f"  {e.body_j}  reads {', '.join((*e.also, *e.reads)) or 'itself and time only'}" for e in rates]
        for title, edges in (("joints", self.joints), ("forces", [e for e in self.forces if e not in rates])):
            lines += ["", title] if edges else []
            for e in edges:
                loop = "  closes a loop" if e.name in closing else ""
                rows = f"  {count(e.rows, 'row')}" if title == "joints" else ""
                rows += f", {count(e.velocity_rows, 'velocity-level row')}" if e.velocity_rows else ""
                frames = ", ".join(e.component.ports.values()) or ", ".join((e.body_j, *e.also))
                lines.append(f"  {e.name}  {e.component.kind.name}({frames}){rows}{loop}")
        lines += ["", "placed from the ground"]
        for p in (p for p in tree if not is_state(self.bodies[p.body])):
            by = f"by {p.joint}" if p.joint else "as its initial values say"
            lines.append(f"  {p.body}  {by}, from {p.parent or self.ground.name}")
        return "\n".join(lines)


@uncollected
def build(scene: Scene) -> MechanismGraph:
    """The graph of ``scene``, checked.

    Raises
    ------
    ModelError
        If there is no ground or no body, a joint has both frames on one body, or a body is not held.
    """
    grounds = [c for c in scene.components.values() if isinstance(c.kind, BodyKind) and not c.kind.coordinates]
    checks.ground_and_bodies(scene, grounds)
    bodies = {c.name: c for c in scene.with_coordinates()}
    joints = tuple(_edge(scene, bodies, c) for c in scene.components.values() if isinstance(c.kind, JointKind))
    forces = tuple(_edge(scene, bodies, c) for c in scene.components.values() if isinstance(c.kind, ForceKind))
    # A law of the velocity of a body shows that the body is meant to move without being held.
    meant = ((GROUND, *e.also) for e in joints if not e.component.ports)
    held = connected((GROUND, *bodies), (*((e.body_i, e.body_j) for e in (*joints, *forces)), *meant))
    # a rotor of a gyrostat turns relative to the body of which its frames are
    fixed = {name for name, c in scene.components.items() if not _to_rotor(scene, c)}
    checks.joints_join([e for e in joints if e.name in fixed], grounds[0])
    checks.forces_act([e for e in forces if e.name in fixed])
    checks.all_held(bodies, [group for group in held if GROUND not in group], grounds[0])
    return MechanismGraph(
        scene, grounds[0], bodies, joints, forces, checks.warnings(joints, [e for e in forces if e.name in fixed])
    )


def _to_rotor(scene: Scene, component: Component) -> bool:
    """Whether a joint or force is between frames that turn relative to each other on the same gyrostat."""
    return len({getattr(scene.frames[name], "rotor", 0) for name in component.ports.values()}) > 1


def _edge(scene: Scene, bodies: Mapping[str, Component], component: Component) -> Edge:
    def body(frame: str) -> str:
        owner = scene.frames[frame].body
        return owner if owner in bodies else GROUND

    laws = [value for value in component.values.values() if isinstance(value, Expr)]
    found = leaves(*laws, *component.relations, *component.velocity_constraints)
    reads = {joint_of(leaf.value[0]): None for leaf in found if leaf.op == "multiplier"}
    frames = [leaf.value[0] for leaf in found if leaf.op == "coordinate"]
    for joint in (scene.components[name] for name in reads):
        of_joint = leaves(*joint.relations, *joint.velocity_constraints)
        frames += [*joint.ports.values(), *(x.value[0] for x in of_joint if x.op == "coordinate")]
    read = sorted({body(frame) for frame in frames})
    ends = [body(frame) for frame in component.ports.values()]
    if not ends:
        ends = [GROUND, next((b for b in read if b != GROUND), GROUND)]
    return Edge(component, ends[0], ends[-1], tuple(b for b in read if b not in (*ends, GROUND)), tuple(reads))


def _mobility(p: SubMechanism) -> str:
    return f"{p.mobility} ({p.velocity_mobility} of velocities)" if p.velocity_rows else str(p.mobility)


def _kind(component: Component) -> BodyKind:
    kind = component.kind
    if not isinstance(kind, BodyKind):
        raise TypeError(f"{component.name} is not a body")
    return kind


def _coordinates(component: Component) -> int:
    return len(component.coordinates)


def _mechanical(component: Component) -> int:
    return 0 if is_state(component) else len(component.coordinates)


def _is_driver(e: Edge) -> bool:
    return isinstance(e.component.kind, JointKind) and e.component.kind.driver is not None


def _loop(i: str, j: str, parent: Mapping[str, str]) -> list[str]:
    """Bodies on the loop that an edge between i and j closes in the tree, their common ancestor included."""
    up = [i]
    while up[-1] in parent:
        up.append(parent[up[-1]])
    place = {body: k for k, body in enumerate(up)}
    path = []
    while j not in place:
        path.append(j)
        j = parent[j]
    return up[: place[j] + 1] + path
