"""Rigid contacts of a scene: their numbers, and the conditions at which they close and open."""

from __future__ import annotations

from typing import NamedTuple

from mbdsl.elements.kind import JointKind
from mbdsl.errors import Span
from mbdsl.expressions.symbolic import Expr, call, input_signal, multiplier

#: numbers of a contact, as of discrete variables. MODE: see below. EDGE: the gap [m] below which it has closed, by more
#: than its rounding error
MODE, COUNT, IMPULSE, EDGE = "mode", "count", "impulse", "edge"
NUMBERS = (MODE, COUNT, IMPULSE, EDGE)
#: modes: OPEN; CLOSED by its row; DEPENDENT: closed by the rows of others
OPEN, CLOSED, DEPENDENT = 0.0, 1.0, 2.0


def number(contact: str, what: str) -> str:
    """The name of a number of a contact among the discrete variables."""
    return f"{contact}.{what}"


class Contact(NamedTuple):
    """A rigid contact: its gap is the row of the joint ``name``; e is its coefficient of restitution."""

    name: str
    e: float
    sequential: bool
    condition: Expr  #: becomes true where an open contact closes, and where a closed one opens
    span: Span | None


def is_contact(component) -> bool:
    """Whether a component is a rigid contact."""
    return isinstance(component.kind, JointKind) and component.kind.unilateral


def contact_of(component) -> Contact:
    """The contact that a component is."""
    name = component.name
    mode, edge = input_signal(number(name, MODE)), input_signal(number(name, EDGE))
    closes = call("and", call("eq", mode, OPEN), call("lt", component.relations[0], edge))
    opens = call("and", call("eq", mode, CLOSED), call("lt", 0.0, multiplier(name, 0)))
    sequential = component.values["impacts"] == "sequential"
    return Contact(name, float(component.values["e"]), sequential, call("or", closes, opens), component.span)
