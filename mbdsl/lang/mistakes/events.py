"""Mistakes in when-equations and their functions, and what to write instead."""

from __future__ import annotations

from collections.abc import Iterable

from mbdsl.errors import ModelError, Span
from mbdsl.expressions.symbolic import Expr, leaves
from mbdsl.lang import syntax as s
from mbdsl.lang.event_functions import ACTIONS
from mbdsl.lang.source import span_of
from mbdsl.lang.unparse import inner, write
from mbdsl.lang.values import Value
from mbdsl.mechanism.scene_parts import Component
from mbdsl.messages import did_you_mean

HOLDS = 'it holds `x = ...;`, `reinit(x, ...);`, `terminate("...");` and `assert(condition, "...");`'


def no_discrete(function: str, e: s.Expression, value: Value) -> ModelError:
    """The error for `pre(x)`, `edge(x)` or `change(x)` of a value that events do not set."""
    text = write(e)
    hint = "declare it without a value and set it in a `when`: `discrete Real x(start = 0);`"
    boolean = not isinstance(value, tuple) and value.boolean
    if function == "edge" and boolean:
        hint = f"a `when` acts when its condition becomes true: `when {text} then`"
    elif function == "change" and boolean:
        hint = f"a `when` acts when its condition becomes true: `when {{{text}, not {inner(e)}}} then`"
    elif function == "pre" and not boolean:
        hint = f"write `{text}`: a `reinit` acts after all values have been read"
    return ModelError(f"{function}() takes a discrete variable, found `{text}`", span_of(e.at), hint)


def never_equal(e: s.Binary) -> ModelError:
    """The error for `a == b` in the condition of a `when`, of numbers that vary between events."""
    left, right = write(e.left), write(e.right)
    return ModelError(
        f"`{left} {e.operator} {right}` compares numbers that vary between events: it would not act",
        span_of(e.at),
        f"write `{left} >= {right}`, or `{left} <= {right}`, which becomes true at the crossing",
    )


def refuse_instants(instants: set[str], components: Iterable[Component]) -> None:
    """Raise an error if a law of a component reads one of ``instants``, leaves such as `initial()`."""
    for c in components if instants else ():
        laws = [x for value in c.values.values() for x in (value if isinstance(value, tuple) else (value,))]
        read = leaves(*(x for x in laws if isinstance(x, Expr)))
        if found := {str(x.value) for x in read if x.op == "input"} & instants:
            function = min(found).partition("(")[0]
            call = "sample(start, period)" if function == "sample" else f"{function}()"
            raise ModelError(
                f"a law reads `{call}`, which is true at an event only: it would have no effect",
                c.span,
                f"set a variable at the event and read it: `discrete Real x(start = 0);`, `when {call} then x = ...; "
                "end when;`",
            )


def outside_of_when(item: s.Relation) -> ModelError | None:
    """The error for `reinit(...)` and `terminate(...)` as equations; None for others."""
    name = write(item.left.function) if isinstance(item.left, s.Call) else ""
    if item.right is not None or name not in ("reinit", "terminate"):
        return None
    return ModelError(
        f"`{name}` acts at an event: it stands in a `when`",
        span_of(item.left.at),
        f"write `when condition then {write(item.left)}; end when;`",
    )


def varying_branches(item: s.If) -> str | None:
    """What to write instead of an `if` of derivatives or of when-equations whose condition varies; None of others."""
    first = item.branches[0][1][:1]
    if item.branches[0][0] is None or not first:
        return None
    if isinstance(first[0], s.When):
        both = f"{inner(item.branches[0][0])} and {inner(first[0].branches[0][0])}"
        return f"a condition of a `when` may have parts: `when {both} then`"
    rates = {}
    for condition, items in item.branches:
        for each in items:
            if not isinstance(each, s.Relation) or each.right is None:
                return None
            rates.setdefault(write(each.left), []).append((condition, each.right))
    if any(len(found) != len(item.branches) for found in rates.values()) or item.branches[-1][0] is not None:
        return "an `if` of equations depends on parameters only: choose the value, `der(x) = if c then a else b;`"
    written = [
        f"{left} = {write(s.Choice(tuple((c, e) for c, e in found[:-1] if c is not None), found[-1][1]))};"
        for left, found in rates.items()
    ]
    return f"write `{' '.join(written)}`"


def if_at_start(item: s.If) -> ModelError | None:
    """The error for `if initial() then ...` or `if sample(...) then ...` as an equation; None for others."""
    condition, items = item.branches[0]
    if not isinstance(condition, s.Call) or write(condition.function) not in ("initial", "terminal", "sample"):
        return None
    actions = " ".join(f"{write(x.left)} = {write(x.right)};" for x in items if isinstance(x, s.Relation) and x.right)
    return ModelError(
        f"`{write(condition)}` is the condition of a `when`; an `if` of equations depends on parameters only",
        span_of(condition.at),
        f"write `when {write(condition)} then {actions or '...'} end when;`",
    )


def no_action(found: s.Expression, span: Span | None = None) -> ModelError:
    """The error about an expression in a when-equation."""
    name = write(found.function) if isinstance(found, s.Call) else ""
    hint = did_you_mean(name, ACTIONS) if name and name not in ACTIONS else None
    if isinstance(found, s.Binary) and found.operator == "==":
        hint = f"write `{write(found.left)} = {write(found.right)};`"
    return ModelError(f"found `{write(found)}` in a `when`", span, hint or HOLDS)
