"""Modifiers: ``m = 2 kg`` and ``rod(m = 2 kg)``, bound to the scope in which they were written."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from mbdsl.elements.kind import Kind
from mbdsl.errors import ModelError
from mbdsl.lang import syntax as s
from mbdsl.lang import values
from mbdsl.lang.evaluate import evaluate
from mbdsl.lang.mistakes.tokens import misread_argument, text_of
from mbdsl.lang.source import At, span_of
from mbdsl.lang.unparse import write_argument
from mbdsl.lang.values import Value
from mbdsl.messages import count

if TYPE_CHECKING:
    from mbdsl.lang.scope import Scope

#: position in each array around an element: (index from 0, size), outermost first
Contexts = tuple[tuple[int, int], ...]


class Modifier:
    """``name(inner) = value``; ``level`` is the number of arrays around the place where it was written."""

    __slots__ = ("_cached", "at", "each", "elements", "final", "inner", "level", "name", "scope", "value")

    def __init__(self, argument: s.Argument, scope: Scope, level: int) -> None:
        self.name = argument.name
        self.value = argument.value
        self.scope = scope
        self.each = argument.each
        self.final = argument.final
        self.at: At = argument.at
        self.level = level
        self.inner: dict[str, Modifier] = {}
        self.elements: dict[tuple[int, ...], Modifier] = {}  # from overrides: link[3].m
        self._cached: Value | None = None
        _, self.inner = bind(argument.modifiers, scope, level) if argument.modifiers else ((), {})

    @property
    def value_at(self) -> At:
        """The place of its value, of a modifier that has one."""
        assert self.value is not None
        return self.value.at

    def evaluate(self) -> Value:
        """The value, evaluated once (it does not depend on the element it is for)."""
        if self._cached is None:
            assert self.value is not None
            self._cached = evaluate(self.value, self.scope)
        return self._cached

    def pick(self, value: Value, rank: int, contexts: Contexts) -> Value:
        """The part of ``value`` for the element at ``contexts``; a value of ``rank`` dimensions applies to all."""
        extra = len(values.shape(value)) - rank
        inside = contexts[self.level :]
        if extra <= 0 or not inside:
            return value
        if self.each:
            raise ModelError(
                f"`each` gives the same value to every element, found {values.describe(value)}", self.value_span()
            )
        used = inside[-extra:] if extra <= len(inside) else inside
        for index, size in used:
            assert isinstance(value, tuple)
            if len(value) != size:
                raise ModelError(
                    f"found an array of {len(value)} values for `{self.name}` of {size} elements",
                    self.value_span(),
                    f"give {size} values, or a single one for all",
                )
            value = value[index]
        return value

    def start(self) -> tuple[s.Expression | None, s.Expression | None]:
        """The values of ``name(start = ..., fixed = ...)``, or that of ``name = ...`` and None."""
        start, fixed = self.inner.get("start"), self.inner.get("fixed")
        return self.value if start is None else start.value, None if fixed is None else fixed.value

    def value_span(self):
        return span_of(self.value.at if self.value is not None else self.at)

    def under(self, weaker: Modifier) -> Modifier:
        """Both modifiers combined; this one has priority."""
        joined = Modifier.__new__(Modifier)
        for slot in Modifier.__slots__:
            setattr(joined, slot, getattr(self, slot))
        if self.value is None and weaker.value is not None:
            joined.value, joined.scope, joined.level, joined._cached = weaker.value, weaker.scope, weaker.level, None
            joined.each, joined.at = weaker.each, weaker.at
        joined.inner = merge(self.inner, weaker.inner)
        joined.elements = {**weaker.elements, **self.elements}
        return joined


Modifiers = dict[str, Modifier]


def bind(arguments: Iterable[s.Argument], scope: Scope, level: int) -> tuple[list[s.Expression], Modifiers]:
    """Positional arguments, and modifiers by name."""
    positional: list[s.Expression] = []
    named: Modifiers = {}
    for argument in arguments:
        if not argument.name:
            assert argument.value is not None
            if (mistake := misread_argument(argument.value, bool(named))) is not None:
                raise mistake
            if named:
                raise ModelError(
                    f"found `{text_of(argument.value)}` after a named argument",
                    span_of(argument.value.at),
                    "frames come first, then `name = value`",
                )
            positional.append(argument.value)
        elif argument.name in named and not argument.indices:
            raise ModelError(
                f"`{argument.name}` is given twice",
                span_of(argument.at),
                notes=(("first given here", span_of(named[argument.name].at)),),
            )
        else:
            if argument.indices:
                raise ModelError(
                    f"`{write_argument(argument)}`: single elements cannot be modified",
                    span_of(argument.at),
                    "give an array of values: `name = {...}`",
                )
            named[argument.name] = Modifier(argument, scope, level)
    return positional, named


def coordinates_named(
    kind: Kind, owner: str, positional: list[s.Expression], own: Modifiers, scope: Scope, level: int
) -> Modifiers:
    """The modifiers ``own``, with those of coordinates that are given by position.

    Raises
    ------
    ModelError
        If there are too many, or if one of them is given by name, too.
    """
    if len(positional) > len(kind.coupled):
        raise ModelError(
            f"{kind.name} `{owner}` takes {count(len(kind.coupled), 'coordinate')}, found {len(positional)}",
            span_of(positional[len(kind.coupled)].at),
            "everything else is given by name; a coordinate may be an expression of several",
        )
    found = {}
    for name, e in zip(kind.coupled, positional, strict=False):
        if name in own:
            notes = ((f"`{name}` of `{owner}` is given by name here", span_of(own[name].at)),)
            raise ModelError(f"`{name}` of {kind.name} `{owner}` is given twice", span_of(e.at), notes=notes)
        found[name] = Modifier(s.Argument(name, e, at=e.at), scope, level)
    return {**found, **own}


def refuse_inner(modifier: Modifier, what: str, hint: str | None = None) -> None:
    """Refuse ``m(foo = 3) = 1 kg`` and ``--set crank.m.value=99`` where ``what`` takes a value and nothing else."""
    for name, inner in modifier.inner.items():
        raise ModelError(f"{what} takes a value only, it has no attribute `{name}`", span_of(inner.at), hint)
    for inner in modifier.elements.values():
        raise ModelError(f"{what} takes a value only, its elements cannot be modified", span_of(inner.at), hint)


def merge(stronger: Modifiers, weaker: Modifiers) -> Modifiers:
    """The modifiers of both, the first with priority."""
    if not stronger:
        return weaker
    result = dict(weaker)
    for name, modifier in stronger.items():
        below = weaker.get(name)
        if below is not None and below.final:
            raise ModelError(
                f"`{name}` is final, it cannot be modified",
                modifier.value_span(),
                notes=(("made final here", span_of(below.at)),),
            )
        result[name] = modifier.under(below) if below is not None else modifier
    return result
