"""Expressions as mbdsl text."""

from __future__ import annotations

from mbdsl.expressions.symbolic import Expr, walk

_INFIX = {"add": " + ", "sub": " - ", "mul": "*", "div": "/", "lt": " < ", "le": " <= ", "eq": " == ", "ne": " <> "}


def text(root: Expr) -> str:
    """The expression as mbdsl text, for messages and ``mbdsl show``; long expressions are cut."""
    shown: dict[Expr, str] = {}
    for n in walk(root):
        a = [shown[x] for x in n.args]
        if n.op == "const":
            shown[n] = repr(n.value)
        elif n.op == "coordinate":
            shown[n] = ".".join(n.value)
        elif n.op == "input":
            shown[n] = str(n.value)
        elif n.op == "multiplier":
            joint, k = n.value
            shown[n] = f"{joint}.lam[{k + 1}]"
        elif n.op == "time":
            shown[n] = "time"
        elif n.op == "start":
            shown[n] = f"start({text(n.value)})"
        elif n.op in _INFIX:
            shown[n] = f"({a[0]}{_INFIX[n.op]}{a[1]})"
        elif n.op == "neg":
            shown[n] = f"-{a[0]}"
        elif n.op == "select":
            shown[n] = f"(if {a[0]} then {a[1]} else {a[2]})"
        elif n.op == "table":
            data, nth = n.value
            shown[n] = f"{getattr(data, 'name', 'table')}{chr(39) * nth}({a[0]})"
        else:
            shown[n] = f"{n.op}({', '.join(a)})"
        if len(shown[n]) > 400:
            shown[n] = shown[n][:380] + "..."
    return shown[root]
