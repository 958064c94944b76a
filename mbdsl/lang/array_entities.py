"""Entities of a namespace, alone or as elements of arrays: each is made under its full name."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from math import prod
from typing import Any

from mbdsl.errors import ModelError
from mbdsl.lang import functions, limits
from mbdsl.lang import syntax as s
from mbdsl.lang.entities import ComponentArray, Namespace
from mbdsl.lang.evaluate import evaluate
from mbdsl.lang.modifiers import Contexts
from mbdsl.lang.scope import Scope
from mbdsl.lang.source import placed, span_of

#: makes an entity from its full name, the arrays around it, and its own indices
Make = Callable[[str, Contexts, tuple[int, ...]], Any]


def enter(namespace: Namespace, d: s.Declaration, make: Make, scope: Scope, most: int, looped: bool) -> None:
    """Make one entity or an array of them, of at most so many elements; in a loop the indices denote the element."""
    full = namespace.full(d.name)
    if looped:
        index = tuple(_index(i, scope) for i in d.indices)
        array = namespace.members.get(d.name)
        if array is None:
            array = namespace.members[d.name] = ComponentArray(full, len(index), d.at)
        name = f"{full}[{','.join(map(str, index))}]"
        if not isinstance(array, ComponentArray) or len(array.sizes) != len(index) or index in array.items:
            twice = isinstance(array, ComponentArray) and index in array.items
            what = "is declared twice" if twice else "is already declared"
            raise ModelError(f"`{name}` {what}", span_of(d.at))
        array.add(index, make(name, namespace.contexts, index))
        return
    if not d.indices:
        if d.name in namespace.members:
            raise ModelError(f"`{full}` is declared twice", span_of(d.at), "in a loop, components have indices: `J[i]`")
        namespace.members[d.name] = make(full, namespace.contexts, ())
        return
    sizes = [_index(i, scope, "the size of an array", 0) for i in d.indices]
    count = prod(sizes)
    if count > most:
        raise ModelError(
            f"`{full}` has {count} elements, but a model has at most {limits.COMPONENTS} components", span_of(d.at)
        )
    array = namespace.members[d.name] = ComponentArray(full, len(sizes), d.at)
    array.sizes = tuple(sizes)
    for index in product(*(range(1, size + 1) for size in sizes)):
        contexts = (*namespace.contexts, *((i - 1, size) for i, size in zip(index, sizes, strict=True)))
        array.items[index] = make(f"{full}[{','.join(map(str, index))}]", contexts, index)


def _index(e: s.Expression, scope: Scope, what: str = "an index", least: int = 1) -> int:
    if isinstance(e, s.Everything):
        raise ModelError("the size of an array of components must be given", span_of(e.at))
    with placed(e.at):
        n = functions.count(evaluate(e, scope), what)
        if n < least:
            raise ModelError(f"{what} is {n}, it must be at least {least}")
    return n
