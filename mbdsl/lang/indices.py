"""Indices of arrays: ``x[2]``, ``x[:, end]``, ``link[2:4]``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mbdsl.errors import ModelError
from mbdsl.lang import functions, values
from mbdsl.lang import syntax as s
from mbdsl.lang.evaluate import evaluate
from mbdsl.lang.source import span_of
from mbdsl.lang.values import Quantity, Value

if TYPE_CHECKING:
    from mbdsl.lang.scope import Scope


def element(scope: Scope, value: tuple, step: s.NamePart, owner: str) -> Value:
    """The element of a value, or an array of elements."""
    chosen = positions(scope, step, values.shape(value), owner, "value")

    def take(inner: Value, rest: list[list[int] | int]) -> Value:
        if not rest:
            return inner
        index, *more = rest
        assert isinstance(inner, tuple)
        if isinstance(index, int):
            return take(inner[index - 1], more)
        return tuple(take(inner[i - 1], more) for i in index)

    return take(value, chosen)


def positions(scope: Scope, step: s.NamePart, shape: tuple[int, ...], owner: str, what: str) -> list[list[int] | int]:
    """Indices as numbers, 1-based; lists where a range or `:` was given."""
    if len(step.indices) > len(shape) or (what == "component" and len(step.indices) != len(shape)):
        raise ModelError(
            f"`{owner}` has {len(shape)} dimension{'s' * (len(shape) != 1)}, found {len(step.indices)} indices",
            span_of(step.at),
        )
    found: list[list[int] | int] = []
    for index, size in zip(step.indices, shape, strict=False):
        if isinstance(index, s.Everything):
            found.append(list(range(1, size + 1)))
            continue
        if size != scope.size and not isinstance(index, (s.Number, s.Reference)):
            scope = scope.with_size(size)  # for `end`
        value = evaluate(index, scope)
        if isinstance(value, Quantity) and type(value.value) is int:
            if 1 <= value.value <= size:
                found.append(value.value)
                continue
            numbers = [value.value]
        elif isinstance(value, tuple):
            numbers = [functions.count(v, f"an index of `{owner}`") for v in value]
        else:
            numbers = [functions.count(value, f"an index of `{owner}`")]
        for n in numbers:
            if not 1 <= n <= size:
                raise ModelError(
                    f"`{owner}[{n}]` does not exist: `{owner}` has elements 1 to {size}", span_of(index.at)
                )
        found.append(numbers if isinstance(value, tuple) else numbers[0])
    return found
