"""Events of a model as data: discrete variables, and when-equations that change them.

In expressions, a discrete variable x is a leaf like an input, ``input(x)``. So are ``pre(x)``, its value before the
event, and the truth of ``initial()``, ``terminal()`` and of every ``sample(start, period)``, which are numbers 0 or 1.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property

from mbdsl.errors import Span
from mbdsl.expressions.symbolic import Expr, call, input_signal, leaves

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
    span: Span | None = field(default=None, compare=False)

    def tick(self, k: int) -> float:
        return float(self.start + k * self.period)


@dataclass(frozen=True)
class Action:
    """What a when-equation does: "set" a discrete variable, "reinit" a state or a velocity, "terminate", or "assert".

    ``value`` is the new value, or the condition that must hold. ``target`` is the name that is set, or a signal. An
    assertion that is a warning only sets the number of times that it was false, and has a ``text``.
    """

    what: str
    target: str
    value: Expr | None
    signal: Expr | None = None  #: of reinit: the state or velocity
    text: str = ""
    span: Span | None = field(default=None, compare=False)


@dataclass(frozen=True)
class Branch:
    """Conditions, one of which becomes true, and what is then done."""

    conditions: tuple[Expr, ...]
    actions: tuple[Action, ...]
    span: Span | None = field(default=None, compare=False)


@dataclass(frozen=True)
class WhenEquation:
    """`when ... elsewhen ... end when`: at an event, the first branch whose condition becomes true."""

    branches: tuple[Branch, ...]


def _read(roots: Iterable[Expr]) -> set[str]:
    """The names of the numbers that expressions read."""
    return {str(leaf.value) for leaf in leaves(*roots) if leaf.op == "input"}


@dataclass(frozen=True)
class Events:
    """The discrete variables of a model, the clocks, and the when-equations."""

    variables: dict[str, Discrete] = field(default_factory=dict)
    clocks: tuple[Clock, ...] = ()
    whens: tuple[WhenEquation, ...] = ()

    initial, terminal = INITIAL, TERMINAL  #: names of the truth of ``initial()`` and of ``terminal()``

    def __bool__(self) -> bool:
        return bool(self.whens)

    def latching(self, found: Iterable[tuple[str, Expr, Expr, Span | None]]) -> Events:
        """These events, before which numbers of components are set, (name, condition, value, place of the component):
        where the condition becomes true, and at the start."""
        variables, whens = dict[str, Discrete](), list[WhenEquation]()
        for name, condition, value, span in found:
            variables |= {x: Discrete(x) for x in (INITIAL, name)}
            at_start = call("ne", input_signal(INITIAL), 0.0)
            action = Action("set", name, value, span=span)
            whens.append(WhenEquation((Branch((condition, at_start), (action,), span),)))
        return Events(variables | self.variables, self.clocks, (*whens, *self.whens)) if whens else self

    def of_component(self, branch: Branch) -> bool:
        """Whether a branch sets a number of a component, and no variable of the model."""
        return any(a.what == "set" and not a.text and not self.variables[a.target].type for a in branch.actions)

    @property
    def typed(self) -> list[str]:
        """The variables of the model."""
        return [name for name, x in self.variables.items() if x.type]

    @property
    def written(self) -> list[WhenEquation]:
        """The when-equations and assertions of the model, without those that set numbers of components."""
        return [when for when in self.whens if not all(map(self.of_component, when.branches))]

    @property
    def branches(self) -> list[Branch]:
        return [branch for when in self.whens for branch in when.branches]

    @property
    def conditions(self) -> list[Expr]:
        """The conditions of all branches."""
        return [c for branch in self.branches for c in branch.conditions]

    @cached_property
    def of_clocks(self) -> tuple[tuple[int, Action], ...] | None:
        """Number of the clock and action of all that clocks do, if a compiled step loop can do it: values that depend
        on the state, time and the values before are set, and no other condition reads them. Else None; () of nothing.
        """
        number = {clock.name: k for k, clock in enumerate(self.clocks)}
        found, others = list[tuple[int, Action]](), list[Expr]()
        for when in self.whens:
            conditions = [c for branch in when.branches for c in branch.conditions]
            first = conditions[0]
            clock = first.args[0] if len(conditions) == 1 and first.op == "ne" else None
            if clock is not None and clock.op == "input" and clock.value in number:
                actions = when.branches[0].actions
                if any(a.what != "set" for a in actions):
                    return None
                found += [(number[str(clock.value)], action) for action in actions]
            else:
                others += conditions
        values = [a.value for _, a in found if a.value is not None]
        targets = {a.target for _, a in found}
        pulses = {INITIAL, TERMINAL, *number}
        if _read(others) & (targets | {f"pre({x})" for x in targets} | set(number)):
            return None
        possible = all(leaf.op in ("time", "coordinate", "input") for leaf in leaves(*values))
        return tuple(found) if possible and not _read(values) & (targets | pulses) else None

    @cached_property
    def order(self) -> dict[str, int]:
        """Variable -> its place in an event: after those that its new value reads, but for ``pre(x)``.

        Those of a circle (:meth:`circle`) keep the order of the text.
        """
        found: dict[str, int] = {}
        for name in self._reads:
            self._place(name, found, [])
        return found

    def circle(self) -> list[str]:
        """Variables each of which reads the next one in the same event, the first one again at the end; [] if none."""
        found: dict[str, int] = {}
        return next((c for name in self._reads if (c := self._place(name, found, []))), [])

    @cached_property
    def _reads(self) -> dict[str, list[str]]:
        """Variable that is set -> the variables that are set, which its new values read."""
        actions = [a for branch in self.branches for a in branch.actions if a.what == "set" and a.value is not None]
        reads: dict[str, list[str]] = {a.target: [] for a in actions}
        for a in actions:
            assert a.value is not None
            reads[a.target] += [x for x in sorted(_read([a.value])) if x in reads]
        return reads

    def _place(self, name: str, found: dict[str, int], above: list[str]) -> list[str]:
        """Enter a variable after those that it reads; the circle above it, if there is one."""
        if name in above:
            return [*above[above.index(name) :], name]
        circle: list[str] = []
        if name not in found:
            for x in self._reads[name]:
                circle = circle or self._place(x, found, [*above, name])
            found[name] = len(found)
        return circle

    @property
    def expressions(self) -> list[Expr]:
        """All expressions of the when-equations."""
        values = [x for branch in self.branches for a in branch.actions for x in (a.value, a.signal) if x is not None]
        return [*self.conditions, *values]
