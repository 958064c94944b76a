"""Derivatives of expressions: partial ones, exact on the graph, and those with respect to time."""

from __future__ import annotations

import math
from collections.abc import Callable

from mbdsl.expressions.symbolic import RATE, Expr, call, const, coordinate, expr, is_const, is_velocity, leaves, walk

#: op -> partial derivatives with respect to its arguments, as functions of (node, *args)
PARTIALS: dict[str, Callable[..., tuple[Expr | float, ...]]] = {
    "add": lambda n, a, b: (1.0, 1.0),
    "sub": lambda n, a, b: (1.0, -1.0),
    "mul": lambda n, a, b: (b, a),
    "div": lambda n, a, b: (1.0 / b, -n / b),
    "neg": lambda n, a: (-1.0,),
    "pow": lambda n, a, b: (b * a ** (b - 1.0), 0.0 if is_const(b) else n * call("log", a)),
    "sin": lambda n, a: (call("cos", a),),
    "cos": lambda n, a: (-call("sin", a),),
    "tan": lambda n, a: (1.0 + n * n,),
    "asin": lambda n, a: (1.0 / call("sqrt", 1.0 - a * a),),
    "acos": lambda n, a: (-1.0 / call("sqrt", 1.0 - a * a),),
    "atan": lambda n, a: (1.0 / (1.0 + a * a),),
    "atan2": lambda n, a, b: (b / (a * a + b * b), -a / (a * a + b * b)),
    "angle": lambda n, a, b: (b / (a * a + b * b), -a / (a * a + b * b)),
    "sinh": lambda n, a: (call("cosh", a),),
    "cosh": lambda n, a: (call("sinh", a),),
    "tanh": lambda n, a: (1.0 - n * n,),
    "exp": lambda n, a: (n,),
    "log": lambda n, a: (1.0 / a,),
    "log10": lambda n, a: (1.0 / (a * math.log(10.0)),),
    "sqrt": lambda n, a: (0.5 / n,),
    "hypot": lambda n, a, b: (call("ratio", a, n), call("ratio", b, n)),
    "ratio": lambda n, a, b: (call("ratio", 1.0, b), -call("ratio", n, b)),
    "abs": lambda n, a: (call("sign", a),),
    "min": lambda n, a, b: (call("le", a, b), call("lt", b, a)),
    "max": lambda n, a, b: (call("le", b, a), call("lt", a, b)),
    "mod": lambda n, a, b: (1.0, -call("floor", a / b)),
    "select": lambda n, c, a, b: (0.0, c, call("not", c)),
}


def diff(root: Expr, *variables: Expr) -> list[Expr]:
    """Exact partial derivatives of ``root`` with respect to each leaf in ``variables`` (forward, on the graph)."""
    order = walk(root)
    one, zero = const(1.0), const(0.0)
    return [_forward(order, {variable: one}).get(root, zero) for variable in variables]


def _forward(order: list[Expr], seeds: dict[Expr, Expr]) -> dict[Expr, Expr]:
    """The derivatives of nodes that are not zero. The nodes are in an order of :func:`walk`, and ``seeds`` are the
    derivatives of leaves."""
    d: dict[Expr, Expr] = {}
    zero, depending = const(0.0), d.keys()
    for n in order:
        if n in seeds:
            d[n] = seeds[n]
        elif depending.isdisjoint(n.args):
            continue
        elif n.op == "table":
            table, nth = n.value
            d[n] = Expr("table", n.args, (table, nth + 1)) * d[n.args[0]]
        elif n.op == "select":
            d[n] = call("select", n.args[0], d.get(n.args[1], zero), d.get(n.args[2], zero))
        elif n.op in PARTIALS:
            total = zero
            for a, p in zip(n.args, PARTIALS[n.op](n, *n.args), strict=True):
                if a in d:
                    total = total + expr(p) * d[a]
            d[n] = total
        # comparisons, floor, ceil, sign: piecewise constant
        if n in d and is_const(d[n], 0.0):
            del d[n]
    return d


def _rate(leaf: Expr) -> Expr | None:
    """The time derivative of a coordinate of a frame; None of velocities."""
    frame, key = leaf.value
    if key in RATE or key == "z":
        return coordinate(frame, RATE.get(key, "vz"))
    if is_velocity(leaf):
        return None
    # a component of an axis a of a frame in space: (omega x a)_i
    i = "xyz".index(key[1])
    j, k = "xyz"[(i + 1) % 3], "xyz"[(i + 2) % 3]
    axis, spin = (lambda other: coordinate(frame, key[0] + other)), (lambda other: coordinate(frame, "w" + other))
    return spin(j) * axis(k) - spin(k) * axis(j)


def flow(root: Expr) -> Expr:
    """The time derivative of an expression of positions of frames; as ``der``, in an order that is linear in its size
    where it depends on many leaves."""
    order = walk(root)
    seeds = {n: rate for n in order if n.op == "coordinate" and (rate := _rate(n)) is not None}
    return _forward(order, seeds).get(root, const(0.0))


def der(root: Expr, rates: Callable[[Expr], Expr | None] = lambda leaf: None) -> Expr:
    """Total time derivative of an expression of positions, and of leaves that have ``rates``: states.

    Raises
    ------
    ValueError
        If ``root`` depends on a quantity whose rate is not a variable: velocities, reactions, inputs.
    """
    variables = leaves(root)
    total = const(0.0)
    for leaf, partial in zip(variables, diff(root, *variables), strict=True):
        if leaf.op == "time":
            rate: Expr = const(1.0)
        elif (known := rates(leaf)) is not None:
            rate = known
        elif leaf.op == "coordinate" and (found := _rate(leaf)) is not None:
            rate = found
        else:
            raise ValueError(_no_rate(leaf))
        total = total + partial * rate
    return total


def _no_rate(leaf: Expr) -> str:
    if leaf.op == "multiplier":
        joint, _ = leaf.value
        return f"der() of a reaction of `{joint}`: reactions follow from the motion, their rates are not known"
    if leaf.op == "input":
        return f"der() of `{leaf.value}`: inputs and discrete variables jump, their rates are not known"
    return "der() takes a position or an angle: accelerations cannot be used; filter the velocity, `der(y) = (v - y)/T`"
