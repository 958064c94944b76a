"""``assert(condition, "text", level)`` in the equation section: checked at once, or during the run if the condition
varies."""

from __future__ import annotations

from mbdsl.errors import ModelError
from mbdsl.lang import syntax as s
from mbdsl.lang import values
from mbdsl.lang.connections import NotConnected
from mbdsl.lang.evaluate import evaluate
from mbdsl.lang.scope import Scope
from mbdsl.lang.source import span_of
from mbdsl.lang.unparse import write

LEVELS = ("AssertionLevel.error", "AssertionLevel.warning")


def is_assertion(item: s.Relation) -> bool:
    """Whether an equation is ``assert(...)``."""
    return item.right is None and isinstance(item.left, s.Call) and write(item.left.function) == "assert"


def check(item: s.Relation, scope: Scope) -> bool:
    """Check an assertion; whether its condition is known before the start.

    Raises
    ------
    ModelError
        If its condition is false, or is not a condition.
    """
    condition, text, warns = parts(item)
    try:
        decided = evaluate(condition, scope.for_signals())
    except NotConnected:  # a signal of a joint, spring or driver, before the connections are made
        return False
    if isinstance(decided, tuple) or not decided.boolean:
        raise ModelError(
            f"assert() takes a condition (true or false), found {values.describe(decided)}", span_of(condition.at)
        )
    if decided.varying:
        return False
    if bool(getattr(decided.value, "value", decided.value)):
        return True
    message = f"the assertion `{write(condition)}` is false: {text}"
    if not warns:
        raise ModelError(message, span_of(condition.at))
    scope.namespace.assembly.warn(
        message, condition.at, "its level is AssertionLevel.warning: the model runs all the same"
    )
    return True


def parts(item: s.Relation) -> tuple[s.Expression, str, bool]:
    """The condition of an assertion, its text, and whether it is a warning only.

    Raises
    ------
    ModelError
        If it has other arguments.
    """
    call = item.left
    assert isinstance(call, s.Call)
    given = [a.value for a in call.arguments if a.value is not None]
    if not 2 <= len(given) <= 3:
        raise ModelError(
            f"assert() takes a condition and a text, found {len(given)} arguments",
            span_of(call.at),
            'write `assert(L > 0, "L must be positive");`',
        )
    level = write(given[2]) if len(given) == 3 else LEVELS[0]
    if level not in LEVELS:
        raise ModelError(f"`{level}` is no level of an assertion", span_of(given[2].at), f"levels: {', '.join(LEVELS)}")
    return given[0], given[1].value if isinstance(given[1], s.String) else write(given[1]), level == LEVELS[1]
