"""``assert(condition, "text")`` in the equation section: checked at once, or during the run if the condition varies."""

from __future__ import annotations

from mbdsl.errors import ModelError
from mbdsl.lang import syntax as s
from mbdsl.lang import values
from mbdsl.lang.connections import NotConnected
from mbdsl.lang.evaluate import evaluate
from mbdsl.lang.scope import Scope
from mbdsl.lang.source import span_of
from mbdsl.lang.unparse import write


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
    call = item.left
    assert isinstance(call, s.Call)
    given = [a.value for a in call.arguments if a.value is not None]
    if not 2 <= len(given) <= 3:
        raise ModelError(
            f"assert() takes a condition and a text, found {len(given)} arguments",
            span_of(call.at),
            'write `assert(L > 0, "L must be positive");`',
        )
    condition = given[0]
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
    text = given[1].value if isinstance(given[1], s.String) else write(given[1])
    raise ModelError(f"the assertion `{write(condition)}` is false: {text}", span_of(condition.at))
