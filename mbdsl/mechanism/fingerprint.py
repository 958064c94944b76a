"""The complete content of a Scene as one text: scenes with the same text have the same motion.

Every number is written with all its digits, every expression and table in full. Nothing depends on the process, such as
addresses or hashes. Left out are documentation, source files and positions, parameters (the fields that use them hold
their values), and the times and method of the experiment, because the arguments of a run replace them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from numbers import Real

from mbdsl.elements.kind import Kind
from mbdsl.expressions.symbolic import Expr, walk
from mbdsl.mechanism.scene import Component, Experiment, Scene

LEFT_OUT = {"span", "doc", "files", "parameters"}  #: fields that do not change the motion
GIVEN = {"start", "stop", "interval", "method"}  #: fields of an experiment that the arguments of a run replace


def fingerprint(scene: Scene) -> str:
    """The text of ``scene``.

    Returns
    -------
    str
        A line for each component, frame, initial value and so on, in the order of their declaration, which is the order
        of coordinates; before it a line for each new operation of its expressions, ``%7 = mul %3 %6``.

    Raises
    ------
    TypeError
        If the scene holds an object of an unknown type.
    """
    return "\n".join(_Lines(scene).lines)


class _Lines:
    """The lines of a scene; shared parts of expressions have one line, so that the text is linear in their size."""

    def __init__(self, scene: Scene) -> None:
        self.lines: list[str] = []
        self.numbers: dict[Expr, str] = {}
        for f in fields(scene):
            part = getattr(scene, f.name)
            if f.name in LEFT_OUT:
                continue
            if isinstance(part, Mapping):  # in their order
                for name, x in part.items():
                    self.lines.append(f"{f.name} {name!r}: {self.told(x)}")
            else:
                self.lines.append(f"{f.name}: {self.told(part)}")

    def told(self, x: object) -> str:
        """The content of ``x``."""
        if x is None or isinstance(x, bool | str):
            return repr(x)
        if isinstance(x, Real):
            return repr(float(x))
        if isinstance(x, Expr):
            return self.number(x)
        if isinstance(x, tuple | list):
            return self.row(x)
        if isinstance(x, Mapping):  # of values and ports: by name
            return "{" + ", ".join(f"{key!r}: {self.told(x[key])}" for key in sorted(x)) + "}"
        if isinstance(x, Kind):
            return x.name
        if is_dataclass(x) and not isinstance(x, type):
            out = LEFT_OUT | (GIVEN if isinstance(x, Experiment) else set())
            out |= {"signals"} if isinstance(x, Component) else set()  # formulas of its kind
            told = (f"{f.name}={self.told(getattr(x, f.name))}" for f in fields(x) if f.name not in out)
            return f"{type(x).__name__}({', '.join(told)})"
        raise TypeError(f"what {type(x).__name__} holds is not known")

    def row(self, xs: Iterable) -> str:
        return "(" + ", ".join(self.told(x) for x in xs) + ")"

    def number(self, root: Expr) -> str:
        """The number of an expression; adds lines for those of its operations that have no number yet."""
        for n in walk(root):
            if n not in self.numbers:
                own = f"%{len(self.numbers)}"
                # constants of 0 and -0 are one node
                value = n.value + 0.0 if n.op == "const" else n.value  # type: ignore[operator]
                told = "" if value is None else f" {self.told(value)}"
                self.lines.append(f"{own} = {n.op}{told}{''.join(f' {self.numbers[a]}' for a in n.args)}")
                self.numbers[n] = own
        return self.numbers[root]
