"""A fill-reducing order of elimination for symmetric block patterns: minimum degree with precedences."""

from __future__ import annotations

import heapq
from collections.abc import Mapping
from collections.abc import Set as AbstractSet


def minimum_degree(
    adjacent: Mapping[str, AbstractSet[str]],
    sizes: Mapping[str, int],
    after: Mapping[str, AbstractSet[str]],
) -> list[str]:
    """Order the nodes so that each elimination step couples as few unknowns as possible.

    Parameters
    ----------
    adjacent : mapping of node to set of nodes
        Symmetric pattern; a node may be listed among its own neighbours.
    sizes : mapping of node to int
        Unknowns in each node's block.
    after : mapping of node to set of nodes
        Nodes that have to be eliminated before this one. Nodes without an entry are free from the start.

    Returns
    -------
    list of str
        All nodes. Ties are broken towards the node named last: usually, leaves of a chain are declared last.
    """
    neighbours = {node: set(near) - {node} for node, near in adjacent.items()}
    waits = {node: len(after.get(node, ())) for node in neighbours}
    frees: dict[str, list[str]] = {}
    for node, before in after.items():
        for other in before:
            frees.setdefault(other, []).append(node)
    place = {node: -k for k, node in enumerate(neighbours)}
    degree = {node: sum(sizes[other] for other in near) for node, near in neighbours.items()}
    heap = [(degree[node], place[node], node) for node in neighbours if not waits[node]]
    heapq.heapify(heap)
    order: list[str] = []
    done: set[str] = set()
    while heap:
        known, _, node = heapq.heappop(heap)
        if node in done or known != degree[node]:
            continue  # an outdated entry; the heap contains the current one as well
        done.add(node)
        order.append(node)
        front = neighbours.pop(node)
        touched = set(front)
        for other in front:
            new = front - neighbours[other]
            new.discard(other)
            neighbours[other] |= new
            neighbours[other].discard(node)
            degree[other] += sum(sizes[n] for n in new) - sizes[node]
        for other in frees.get(node, ()):
            waits[other] -= 1
            if not waits[other]:
                touched.add(other)
        for other in touched:
            if not waits[other] and other not in done:
                heapq.heappush(heap, (degree[other], place[other], other))
    if len(order) < len(adjacent):
        raise ValueError("the precedences are cyclic")
    return order
