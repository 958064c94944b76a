"""Events of a model as data: discrete variables, and when-equations that change them.

In expressions, a discrete variable x is a leaf like an input, ``input(x)``. So are ``pre(x)``, its value before the
event, and the truth of ``initial()``, ``terminal()`` and of every ``sample(start, period)``, which are numbers 0 or 1.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

from mbdsl.errors import Span
from mbdsl.expressions.symbolic import Expr, call, input_signal

INITIAL, TERMINAL = "initial()", "terminal()"


@dataclass(frozen=True)
class Discrete:
    """A number that only events change. ``type`` is Real, Integer or Boolean; "" for the numbers beside the variables:
    those before an event, ``pre(x)``, and the truth of ``initial()`` and of clocks."""

    name: str
    start: float = 0.0
    type: str = ""
    unit: str = ""
    doc: str = field(default="", compare=False)
    span: Span | None = field(default=None, compare=False)


@dataclass(frozen=True)
class Clock:
    """`sample(start, period)`: ticks at start + k period, exact fractions of seconds, k = 0, 1, ..."""

    name: str
    start: Fraction
    period: Fraction

    def tick(self, k: int) -> float:
        return float(self.start + k * self.period)


class Action(NamedTuple):
    """What a when-equation does: "set" a discrete variable, "reinit" a state or a velocity, "terminate", or "assert".

    ``value`` is the new value, or the condition that must hold. ``target`` is the name that is set, or a signal.
    """

    what: str
    target: str
    value: Expr | None
    signal: Expr | None = None  #: of reinit: the state or velocity
    text: str = ""
    span: Span | None = None


class Branch(NamedTuple):
    """Conditions, one of which becomes true, and what is then done."""

    conditions: tuple[Expr, ...]
    actions: tuple[Action, ...]
    span: Span | None = None


@dataclass(frozen=True)
class When:
    """`when ... elsewhen ... end when`: at an event, the first branch whose condition becomes true."""

    branches: tuple[Branch, ...]


@dataclass(frozen=True)
class Events:
    """The discrete variables of a model, the clocks, and the when-equations."""

    variables: dict[str, Discrete] = field(default_factory=dict)
    clocks: tuple[Clock, ...] = ()
    whens: tuple[When, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.whens)

    def latching(self, found: Iterable[tuple[str, Expr, Expr]]) -> Events:
        """These events, before which numbers of components are set, (name, condition, value): where the condition
        becomes true, and at the start."""
        variables, whens = dict[str, Discrete](), list[When]()
        for name, condition, value in found:
            variables |= {x: Discrete(x) for x in (INITIAL, name)}
            at_start = call("ne", input_signal(INITIAL), 0.0)
            whens.append(When((Branch((condition, at_start), (Action("set", name, value),)),)))
        return Events(variables | self.variables, self.clocks, (*whens, *self.whens)) if whens else self

    @property
    def branches(self) -> list[Branch]:
        return [branch for when in self.whens for branch in when.branches]

    @property
    def conditions(self) -> list[Expr]:
        """The conditions of all branches."""
        return [c for branch in self.branches for c in branch.conditions]

    @property
    def expressions(self) -> list[Expr]:
        """All expressions of the when-equations."""
        values = [x for branch in self.branches for a in branch.actions for x in (a.value, a.signal) if x is not None]
        return [*self.conditions, *values]
