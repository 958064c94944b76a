"""What networkx finds in the graph of a mechanism: components, cycles, cut joints, trees, chains and places.

The methods that need networkx import it: ``mbdsl check`` and ``simulate`` do without, as the import takes 0.3 s.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import networkx as nx

    from mbdsl.mechanism.edge import Edge
    from mbdsl.mechanism.scene import Component, Scene

GROUND = ""  #: the node of all components without coordinates


class Placement(NamedTuple):
    """``body`` can be placed from ``parent``, which is already placed, by ``joint``; None if no joint leads to it."""

    body: str
    parent: str
    joint: str | None


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


class GraphAlgorithms:
    """The methods of a MechanismGraph that networkx answers."""

    if TYPE_CHECKING:
        scene: Scene
        ground: Component
        bodies: Mapping[str, Component]
        joints: tuple[Edge, ...]
        forces: tuple[Edge, ...]

        @property
        def kinematic_joints(self) -> tuple[Edge, ...]: ...

        def tree(self) -> tuple[Placement, ...]: ...

    def networkx(self, forces: bool = True) -> nx.MultiGraph:
        """The same graph for networkx.

        Parameters
        ----------
        forces : bool, optional
            Whether it has all joints and forces; otherwise it has only joints that constrain positions, without the
            drivers of other joints.

        Returns
        -------
        networkx.MultiGraph
            Nodes are bodies and the ground (``""``), with the attribute ``component``; edges are joints and forces by
            their names, with ``component``, ``rows`` and ``velocity_rows``.
        """
        import networkx as nx

        graph = nx.MultiGraph(name=self.scene.name)
        graph.add_node(GROUND, component=self.ground)
        for name, component in self.bodies.items():
            graph.add_node(name, component=component)
        for e in (*self.joints, *self.forces) if forces else self.kinematic_joints:
            rows = {"rows": e.rows, "velocity_rows": e.velocity_rows}
            graph.add_edge(e.body_i, e.body_j, key=e.name, component=e.component, **rows)
        return graph

    def components(self) -> list[set[str]]:
        """The groups of bodies that joints connect without passing through the ground."""
        import networkx as nx

        graph = self.networkx(forces=False)
        graph.remove_node(GROUND)
        return [set(group) for group in nx.connected_components(graph)]

    def spanning_tree(self) -> nx.DiGraph:
        """The tree by which bodies are placed, from the ground; edges have the attribute ``joint``, or None there."""
        import networkx as nx

        return nx.DiGraph((parent, body, {"joint": self.placed_by[body]}) for body, parent, _ in self.tree())

    @cached_property
    def placed_by(self) -> dict[str, str | None]:
        """Body -> the joint between it and its parent in the tree, rather than a driver; None if there is none."""
        strong = {e.name for e in self.kinematic_joints}
        found = {}
        for body, parent, name in self.tree():
            between = (e.name for e in self.kinematic_joints if {e.body_i, e.body_j} == {body, parent})
            found[body] = name if name in strong else next(between, name)
        return found

    @cached_property
    def cut_joints(self) -> tuple[Edge, ...]:
        """The joints that close loops: those that are not in the tree by which bodies are placed."""
        tree = set(self.placed_by.values())
        return tuple(e for e in self.kinematic_joints if e.name not in tree)

    def cycles(self) -> tuple[Loop, ...]:
        """Independent short loops.

        For each cut joint the bodies of a shortest loop through it, the tree and the cut joints before it. Each has a
        joint that no loop before it has, so that they are independent. It begins where it is nearest to the ground.
        """
        import networkx as nx

        graph, levels, found = self.networkx(forces=False), self.distances(), []
        graph.remove_edges_from([(e.body_i, e.body_j, e.name) for e in self.cut_joints])
        for e in self.cut_joints:
            path = nx.shortest_path(graph, e.body_i, e.body_j)
            first = min(range(len(path)), key=lambda k: levels[path[k]])
            found.append(Loop((*path[first:], *path[: first + 1]), e.name))
            graph.add_edge(e.body_i, e.body_j)
        return tuple(found)

    def chain(self, a: str, b: str = GROUND) -> tuple[str, ...]:
        """The bodies from one to another over the fewest joints; empty if joints do not connect them."""
        import networkx as nx

        graph = self.networkx(forces=False)
        return tuple(nx.shortest_path(graph, a, b)) if nx.has_path(graph, a, b) else ()

    def distances(self) -> dict[str, int]:
        """Body -> number of joints from the ground, on the way with the fewest forces, then with the fewest joints."""
        import networkx as nx

        long = len(self.bodies) + 1  # more than any way has joints
        graph, strong = nx.Graph(), {e.name for e in self.kinematic_joints}
        graph.add_nodes_from((GROUND, *self.bodies))
        for e in sorted((*self.joints, *self.forces), key=lambda e: e.name in strong):
            graph.add_edge(e.body_i, e.body_j, weight=1 if e.name in strong else 1 + long)
        for group in list(nx.connected_components(graph)):
            if GROUND not in group:  # a law of velocities holds it
                graph.add_edge(GROUND, next(body for body in self.bodies if body in group), weight=1 + long)
        return {body: size % long for body, size in nx.single_source_dijkstra_path_length(graph, GROUND).items()}

    def layout(self) -> dict[str, tuple[float, float]]:
        """Body -> its place in a drawing: x is the distance from the ground, y between -1 and 1."""
        import networkx as nx

        graph, levels = self.networkx(), self.distances()
        nx.set_node_attributes(graph, levels, "level")
        return {body: (levels[body], float(y)) for body, (_, y) in nx.multipartite_layout(graph, "level").items()}
