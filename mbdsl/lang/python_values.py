"""Values from Python as expressions of the language."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from mbdsl.elements.kind import Kind
from mbdsl.errors import UsageError
from mbdsl.expressions.symbolic import Expr
from mbdsl.lang import syntax as s
from mbdsl.lang.calls import GivenText
from mbdsl.lang.lexer import KEYWORDS
from mbdsl.lang.parser import read_expression
from mbdsl.lang.values import Quantity

#: the name that an object such as a Handle stands for; None for values
NameOf = Callable[[object], str | None]
_NAME = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)(?: ?\[ ?([0-9]+(?:, ?[0-9]+)*) ?\])?")


def no_name(value: object) -> None:
    """No object stands for a name."""


def expression(value: Any, what: str, name_of: NameOf = no_name) -> s.Expression:
    """The syntax tree of a value from Python; ``what`` names the argument in messages."""
    if isinstance(value, s.Expression):
        return value
    if (name := name_of(value)) is not None:
        return read_expression(GivenText(what, name))
    if isinstance(value, str):
        return read_expression(GivenText(what, value))
    if isinstance(value, Expr):
        return s.Literal(Quantity(value))
    if hasattr(value, "tolist"):  # numpy's scalars and arrays
        value = value.tolist()
    if isinstance(value, bool):
        return s.Boolean(value)
    if isinstance(value, int | float):
        return s.Number(value)
    if isinstance(value, Sequence) and not isinstance(value, bytes | bytearray):
        shown = _shown(value)
        return s.ArrayNode(
            tuple(expression(v, what, name_of) for v in value), at=(GivenText(what, shown), 0, len(shown))
        )
    hint = 'a text has its unit: `"30 deg"`'
    raise UsageError(f"`{what}`: found {_shown(value)}, expected a number, a text or a sequence", hint=hint)


def argument(name: str, value: Any, owner: str, name_of: NameOf = no_name) -> s.Argument:
    """``name = value``; a mapping gives ``name(key = value, ...)``."""
    what = f"{owner}.{name}"
    if not isinstance(value, Mapping):
        return s.Argument(name, expression(value, what, name_of))
    for key in value:
        if not isinstance(key, str):
            raise UsageError(f"`{what}`: found the key {_shown(key)}, expected a name")
        split_name(key, what)
    return s.Argument(name, None, tuple(argument(k, v, what, name_of) for k, v in value.items()))


def of_kind(kind: Kind, owner: str, key: str, value: Any) -> Any:
    """The value of a parameter or signal; if a parameter has choices, a text is one of them and not an expression."""
    parameter, signal = kind.parameter(key), any(x.name == key for x in kind.signals)
    if parameter is None and signal and value is not None and not isinstance(value, Mapping):
        hint = f'give its initial value: `{key}={{"start": {value!r}, "fixed": True}}`'
        raise UsageError(f"{owner}.{key} is a signal, found {_shown(value)}", hint=hint)
    if parameter is not None and key == "frames" and not isinstance(value, Mapping):
        hint = '`frames={"tip": (0.3, 0.0)}`'
        raise UsageError(f"{owner}.frames: found {_shown(value)}, expected frames by their names", hint=hint)
    if parameter is not None and parameter.choices and isinstance(value, str) and not value.startswith('"'):
        return s.String(value)
    return value


def split_name(name: Any, what: str) -> tuple[str, tuple[s.Number, ...]]:
    """``link[3]`` as name and indices, checked."""
    if not isinstance(name, str):
        raise UsageError(f"{what}: found {_shown(name)}, expected a name", hint='the name is a text: "rod"')
    match = _NAME.fullmatch(name)
    if match is None:
        hint = "a name is made of letters a-z, digits and `_`, and does not begin with a digit"
        raise UsageError(f"{what}: {name!r} is not a name", hint=hint)
    if match.group(1) in KEYWORDS:
        raise UsageError(f"{what}: `{match.group(1)}` is a word of the language, not a name")
    return match.group(1), tuple(s.Number(int(i)) for i in (match.group(2) or "").split(",") if i)


def text(value: Any, what: str) -> str:
    """A text that is not an expression, such as a description."""
    if not isinstance(value, str):
        raise UsageError(f"{what}: found {_shown(value)}, expected a text")
    return value


def flag(value: Any, what: str) -> bool:
    """True or False."""
    if not isinstance(value, bool):
        raise UsageError(f"{what}: found {_shown(value)}, expected True or False")
    return value


def _shown(value: object) -> str:
    shown = repr(value)
    return shown if len(shown) <= 60 else f"{shown[:56]} ..."
