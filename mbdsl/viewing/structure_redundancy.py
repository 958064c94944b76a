"""Redundant constraints of a mechanism: those that follow from others in the initial positions."""

from __future__ import annotations

from collections.abc import Callable

from mbdsl.elements.kind import JointKind
from mbdsl.errors import InitialisationError
from mbdsl.mechanism.graph import MechanismGraph

MOST_ROWS = 1500  #: number of constraint rows up to which redundant ones are searched for


def redundancy(graph: MechanismGraph, announce: Callable[[str], None] | None) -> tuple[dict[str, int], list[str]]:
    """Joint -> number of redundant rows in the initial state, and sentences on them."""
    drivers = [
        e
        for e in graph.joints
        if isinstance(e.component.kind, JointKind) and e.component.kind.driver and e.component.ports
    ]
    expressions = any(e.component.relations for e in graph.joints) or graph.velocity_rows
    pairs = {frozenset((e.body_i, e.body_j)) for e in drivers}
    possible = graph.loops or graph.velocity_mobility < 0 or len(pairs) < len(drivers) or expressions
    if not possible:
        return {}, []
    if graph.rows + graph.velocity_rows > MOST_ROWS:
        return {}, [f"redundant constraints are not searched for in models of more than {MOST_ROWS} rows"]
    import numpy as np

    from mbdsl.compilation import code_cache
    from mbdsl.initial.consistent import initial_position
    from mbdsl.initial.dependent_rows import redundant_rows
    from mbdsl.initial.redundancy import repeated
    from mbdsl.storage import cache_folder
    from mbdsl.system import build

    system = build(graph.scene, graph)
    sets = 2 if code_cache.is_compiled(system.module_name(2)) else 1
    if announce is not None and (what := system.uncompiled(sets)):
        announce(cache_folder.compiling(what))
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
