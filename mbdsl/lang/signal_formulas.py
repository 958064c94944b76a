"""Signals of a component: formulas of its kind, read in the component's own scope when they are asked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING

from mbdsl.expressions.symbolic import Expr, multiplier
from mbdsl.lang import syntax as s
from mbdsl.lang.evaluate import Budget
from mbdsl.lang.parser import parse_expression
from mbdsl.lang.values import Quantity, Value

if TYPE_CHECKING:
    from mbdsl.lang.flat_component import Part


class Signals(Mapping[str, Expr]):
    """Signals of a component by full name, made when they are looked at."""

    __slots__ = ("_names", "_part")

    def __init__(self, part: Part) -> None:
        self._part = part
        self._names = part.signal_names()

    def __getitem__(self, name: str) -> Expr:
        owner, _, own = name.rpartition(".")
        if owner != self._part.name or own not in self._names:
            raise KeyError(name)
        return self._part.signal(own).value  # type: ignore[return-value]

    def __iter__(self) -> Iterator[str]:
        return (f"{self._part.name}.{name}" for name in self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __reduce__(self) -> tuple:
        """Pickled as a dict: what they are made from is the whole model in the making."""
        return dict, (dict(self),)

    def __repr__(self) -> str:
        return f"Signals({', '.join(self)})"


class Formula:
    """The scope of a kind's formula: ports, own parameters, signals, and the multipliers ``lam[1]``, ``lam[2]``, ...

    ``laws``: a name that is both, of a signal and of a law parameter, means the law (what a driver demands, not what
    is measured).
    """

    def __init__(self, part: Part, laws: bool = False) -> None:
        self.part = part
        self.laws = laws
        self.budget: Budget = part.assembly.budget

    def value(self, reference: s.Reference) -> Value:
        first = reference.steps[0]
        if len(reference.steps) == 2:
            frame = self.part.frames[first.name] if first.name == "c" else self.part.port_frame(first.name)
            return self.part.assembly.coordinate(frame, reference.steps[1].name)
        if first.name == "lam":
            return Quantity(multiplier(self.part.name, first.indices[0].value - 1))  # type: ignore[union-attr,attr-defined]
        if self.laws and (law := self.part.own_law(first.name)) is not None:
            return law
        own = self.part.own(first.name)
        if isinstance(own, Quantity | tuple):
            for index in first.indices:
                own = own[index.value - 1]  # type: ignore[union-attr,index,attr-defined]
            return own
        return self.part.signal(first.name)

    def apply(self, reference: s.Reference, argument: Value) -> Value | None:
        return None

    def with_locals(self, names: dict[str, Value]) -> Formula:
        raise TypeError("the formula of a kind has no loops")

    def last(self) -> Value:
        raise TypeError("the formula of a kind has no `end`")

    def declared(self, name: str) -> str | None:
        return None

    def function_names(self) -> list[str]:
        return []


@cache
def formula(text: str) -> s.Expression:
    """The syntax tree of a kind's formula."""
    return parse_expression(text, "<formula>")
