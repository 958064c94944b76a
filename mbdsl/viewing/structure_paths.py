"""Paths in the graph of a mechanism: distances of bodies from the ground, and short independent loops."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mbdsl.mechanism.edge import Edge
from mbdsl.mechanism.graph import GROUND, MechanismGraph


def distances(graph: MechanismGraph, strong: list[Edge], weak: list[Edge]) -> dict[str, int]:
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


def cycles(
    joints: Sequence[Edge], closing: Sequence[Edge], levels: Mapping[str, int]
) -> list[tuple[tuple[str, ...], str]]:
    """For each closing joint the bodies of a shortest loop through it, the spanning tree and the closing joints before
    it, and the name of the joint.

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
        found.append(((*path[first:], *path[: first + 1]), e.name))
        add(e)
    return found


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
