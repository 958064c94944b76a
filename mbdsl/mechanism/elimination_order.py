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
    names = list(adjacent)
    index = {node: k for k, node in enumerate(names)}
    size = [sizes[node] for node in names]
    neighbours = [{index[other] for other in near if other != node} for node, near in adjacent.items()]
    degree = [sum([size[other] for other in near]) for near in neighbours]
    waits = [len(after.get(node, ())) for node in names]
    frees: list[list[int]] = [[] for _ in names]
    for name, before in after.items():
        for earlier in before:
            frees[index[earlier]].append(index[name])
    # an entry of the heap: the degree, then the position counted from the last node, in one number
    count = len(names)
    last = count - 1
    heap = [degree[k] * count + last - k for k in range(count) if not waits[k]]
    heapq.heapify(heap)
    order: list[int] = []
    done = [False] * count
    while heap:
        known, behind = divmod(heapq.heappop(heap), count)
        node = last - behind
        if done[node] or known != degree[node]:
            continue  # an outdated entry; the heap contains the current one as well
        done[node] = True
        order.append(node)
        touched = _eliminate(node, neighbours, degree, size)
        for other in frees[node]:
            waits[other] -= 1
            if not waits[other]:
                touched.add(other)
        for other in touched:
            if not waits[other] and not done[other]:
                heapq.heappush(heap, degree[other] * count + last - other)
    if len(order) < count:
        raise ValueError("the precedences are cyclic")
    return [names[k] for k in order]


def _eliminate(node: int, neighbours: list[set[int]], degree: list[int], size: list[int]) -> set[int]:
    """Couple the neighbours of a node with each other, and remove it; returns its neighbours."""
    front = neighbours[node]
    for other in front:
        near = neighbours[other]
        near.discard(node)
        degree[other] -= size[node]
        new = front - near
        new.discard(other)
        if new:
            near |= new
            degree[other] += sum([size[k] for k in new])
    neighbours[node] = set()
    return set(front)
