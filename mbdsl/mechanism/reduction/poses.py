"""Poses (x, y, phi) in the plane, of numbers or of expressions in time: composition and inverse."""

from __future__ import annotations

from typing import TypeAlias

from mbdsl.expressions.symbolic import Expr, call

Number: TypeAlias = "Expr | float"
Pose: TypeAlias = "tuple[Number, Number, Number]"


def compose(outer: Pose, inner: Pose) -> Pose:
    """The pose ``inner``, relative to ``outer``, in the axes in which ``outer`` is given."""
    x, y, phi = outer
    c, s = call("cos", phi), call("sin", phi)
    return _plain(x + c * inner[0] - s * inner[1], y + s * inner[0] + c * inner[1], phi + inner[2])


def invert(pose: Pose) -> Pose:
    """The inverse: composed with ``pose`` it is the identity."""
    x, y, phi = pose
    c, s = call("cos", phi), call("sin", phi)
    return _plain(-(c * x) - s * y, s * x - c * y, -phi)


def _plain(*values: Number) -> Pose:
    x, y, phi = (v.value if isinstance(v, Expr) and v.op == "const" else v for v in values)
    return x, y, phi  # type: ignore[return-value]
