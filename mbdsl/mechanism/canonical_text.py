"""The content of a value, such as a Scene, as one text: its canonical serialisation.

Two scenes are equal if and only if their texts are equal, and the key of a stored run is a digest of such a text. Every
number is written with all its digits, every expression and table in full. Nothing depends on the process, such as
addresses or hashes. Fields declared with ``compare=False`` do not count: documentation, source files, positions.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from numbers import Real
from typing import Any

from mbdsl.elements.kind import Kind
from mbdsl.expressions.symbolic import Expr, walk
from mbdsl.mechanism.points import Points


def canonical_text(value: object) -> str:
    """The text of a dataclass.

    Parameters
    ----------
    value : dataclass
        A Scene, or another dataclass of numbers, texts, expressions, kinds, mappings, tuples and such dataclasses.

    Returns
    -------
    str
        A line for each field, and for each entry of a field that is a mapping (components, frames) in their order,
        which is the order of coordinates; before it a line for each new operation of its expressions,
        ``%7 = mul %3 %6``.

    Raises
    ------
    TypeError
        If the value holds an object of an unknown type.
    """
    return "\n".join(_Lines(value).lines)


class _Lines:
    """The lines of a value; shared parts of expressions have one line, so that the text is linear in their size."""

    def __init__(self, value: object) -> None:
        self.lines: list[str] = []
        self.numbers: dict[Expr, str] = {}
        for name, part in _content(value):
            if isinstance(part, Mapping):  # in their order
                for key, x in part.items():
                    self.lines.append(f"{name} {key!r}: {self.text(x)}")
            else:
                self.lines.append(f"{name}: {self.text(part)}")

    def text(self, x: object) -> str:
        """The content of ``x``."""
        if x is None or isinstance(x, bool | str):
            return repr(x)
        if isinstance(x, Real):
            return repr(float(x))
        if isinstance(x, Expr):
            return self.number(x)
        if isinstance(x, Points):
            return f"points {x.digest}"
        if isinstance(x, tuple | list):
            return self.row(x)
        if isinstance(x, frozenset):
            return self.row(sorted(x))
        if isinstance(x, Mapping):  # of values and ports: by name
            return "{" + ", ".join(f"{key!r}: {self.text(x[key])}" for key in sorted(x)) + "}"
        if isinstance(x, Kind):
            return x.name
        if is_dataclass(x) and not isinstance(x, type):
            return f"{type(x).__name__}({', '.join(f'{name}={self.text(part)}' for name, part in _content(x))})"
        raise TypeError(f"the content of {type(x).__name__} is not known")

    def row(self, xs: Iterable) -> str:
        return "(" + ", ".join(self.text(x) for x in xs) + ")"

    def number(self, root: Expr) -> str:
        """The number of an expression; adds lines for those of its operations that have no number yet."""
        for n in walk(root):
            if n not in self.numbers:
                # constants of 0 and -0 are one node
                value = n.value + 0.0 if n.op == "const" else n.value
                payload = "" if value is None else f" {self.text(value)}"
                own = f"%{len(self.numbers)}"  # after the operations of an expression in the payload
                self.lines.append(f"{own} = {n.op}{payload}{''.join(f' {self.numbers[a]}' for a in n.args)}")
                self.numbers[n] = own
        return self.numbers[root]


def _content(x: Any) -> list[tuple[str, object]]:
    return [(f.name, getattr(x, f.name)) for f in fields(x) if f.compare]
