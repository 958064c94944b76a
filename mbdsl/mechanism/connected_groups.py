"""Connected groups of nodes."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import TypeVar

Node = TypeVar("Node", bound=Hashable)


def connected(nodes: Iterable[Node], links: Iterable[Iterable[Node]]) -> list[list[Node]]:
    """The connected groups of ``nodes``, in order (union-find with path halving)."""
    root = {node: node for node in nodes}

    def find(node: Node) -> Node:
        while root[node] != node:
            root[node] = root[root[node]]
            node = root[node]
        return node

    for link in links:
        first: Node | None = None
        for node in link:
            if first is None:
                first = find(node)
            else:
                root[find(node)] = first
    groups: dict[Node, list[Node]] = {}
    for node in root:
        groups.setdefault(find(node), []).append(node)
    return list(groups.values())
