"""The potential of a law of one coordinate: its integral, which :func:`array_operations.integral` computes."""

from __future__ import annotations

from mbdsl.expressions.symbolic import Expr, const, leaves, rebuild, walk

VARIABLE = Expr("variable")  #: the coordinate, in the law of an integral


def potential(law: Expr, coordinate: Expr, rate: Expr | None, start: float) -> Expr | None:
    """The integral of ``law`` over its ``coordinate`` from ``start`` on; None if it depends on anything else.

    A dependence on the ``rate`` of the coordinate is damping: the force at rest has the potential.
    """
    new: dict[Expr, Expr] = {}
    for n in walk(law):
        if n is coordinate:
            new[n] = VARIABLE
        elif n is rate:
            new[n] = const(0.0)
        else:
            new[n] = n if all(new[a] is a for a in n.args) else rebuild(n, [new[a] for a in n.args])
    inside = new[law]
    if any(leaf is not VARIABLE for leaf in leaves(inside)) or any(n.op == "angle" for n in walk(inside)):
        return None
    return Expr("integral", (coordinate,), (inside, start))
