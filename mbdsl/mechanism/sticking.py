"""Joints whose friction sticks: their numbers, the rows that hold them, and when they start and stop to slide.

While a joint slides, friction is mu N against the sliding. Where the speed becomes zero the joint is held, if friction
can: its coordinate s keeps the value that it has there, by the row s - place = 0, whose multiplier is the friction. The
row is left out while the joint slides.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from mbdsl.elements import find
from mbdsl.elements.kind import JointKind
from mbdsl.errors import Span
from mbdsl.expressions.symbolic import Expr, call, input_signal, multiplier

#: numbers of a joint, as of discrete variables: the sense of sliding (0: at rest), whether its row holds it, where, and
#: the speed against that sense at which it has stopped, which is more than rounding
SLIDING, HELD, PLACE, EDGE = "sliding", "held", "place", "edge"
NUMBERS = (SLIDING, HELD, PLACE, EDGE)
#: part of the largest friction by which a sticking joint exceeds it before it slides: more than rounding
MARGIN = 1e-9
#: kind along whose coordinate friction acts -> the joint that holds this coordinate, and its law
HOLDS = {
    "translational_spring_damper": ("TranslationalDriver", "s"),
    "rotational_spring_damper": ("RotationalDriver", "phi"),
}


class Sticking(NamedTuple):
    """A joint whose friction sticks: its coordinate and rate, the normal force (or its torque) as expressions."""

    name: str
    row: str  #: the component whose row holds the joint
    mu_s: float
    coordinate: Expr
    rate: Expr
    normal: Expr
    span: Span | None

    @property
    def condition(self) -> Expr:
        """Becomes true where the joint stops, and where friction can no longer hold it."""
        sliding, held, edge = (input_signal(number(self.name, x)) for x in (SLIDING, HELD, EDGE))
        stops = call("and", call("ne", sliding, 0.0), call("lt", sliding * self.rate, -edge))
        most = self.mu_s * (1.0 + MARGIN) * self.normal
        slips = call("and", call("ne", held, 0.0), call("lt", most, call("abs", multiplier(self.row, 0))))
        return call("or", stops, slips)


def number(joint: str, what: str) -> str:
    """The name of a number of a joint among the discrete variables."""
    return f"{joint}.{what}"


def row_name(joint: str) -> str:
    """The name of the component whose row holds a joint."""
    return f"{joint}.stick"


def sticks(kind: object, values: Mapping) -> bool:
    """Whether a component is a joint whose friction sticks."""
    return isinstance(kind, JointKind) and bool(values.get("sticks") and values.get("mu_s"))


def holding(joint: Any) -> tuple[JointKind, dict]:
    """Kind and values of the row that holds a joint, a component."""
    assert isinstance(joint.kind, JointKind)
    name, law = HOLDS[joint.kind.friction_along]
    kind = find(name, joint.kind.spatial)
    assert isinstance(kind, JointKind)
    given = {p.name: joint.values.get(p.name, p.default) for p in kind.parameters}
    return kind, {**given, law: input_signal(number(joint.name, PLACE))}
