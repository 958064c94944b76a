"""Rigid contacts of a scene: their numbers, their friction, and the conditions at which they close, open and slide."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from mbdsl.elements import of_variant
from mbdsl.elements.kind import JointKind
from mbdsl.errors import Span
from mbdsl.expressions.frame_derivatives import by_rate, frames_in
from mbdsl.expressions.symbolic import Expr, call, const, input_signal, multiplier

#: numbers of a contact, as of discrete variables. MODE: see below. EDGE: the gap [m] below which it has closed, by more
#: than its rounding error, or than that of the contacts by which it is closed
MODE, COUNT, IMPULSE, EDGE = "mode", "count", "impulse", "edge"
#: of one with friction. COEFFICIENT: of the force along the slip, by the normal force. SLIDING: the sense of sliding.
#: HELD: whether it sticks, see ``held``. SLOW: the speed that counts as rest. ALONG, ALONG_2, in space: the
#: direction of the slip at the last event
COEFFICIENT, SLIDING, HELD, SLOW, ALONG, ALONG_2 = "coefficient", "sliding", "held", "slow", "along", "along_2"
#: the forces that it carries besides the multipliers of its rows, where contacts hold the same motion
SHARES = ("share[1]", "share[2]", "share[3]")
NUMBERS = (MODE, COUNT, IMPULSE, EDGE, COEFFICIENT, SLIDING, HELD, SLOW, ALONG, ALONG_2, *SHARES)
#: modes: OPEN; CLOSED by its row; DEPENDENT: closed by the rows of others
OPEN, CLOSED, DEPENDENT = 0.0, 1.0, 2.0
FRICTION = "ContactFriction"  #: kind of the force that is the friction of a contact
#: part of the largest friction by which a contact that sticks exceeds it before it slides: more than rounding
MARGIN = 1e-8
LEANS = 0.01  #: inclination above which a standing cylinder counts as leaning


def number(contact: str, what: str) -> str:
    """The name of a number of a contact among the discrete variables."""
    return f"{contact}.{what}"


def held(by_others: Sequence[bool]) -> float:
    """The number HELD of a contact that sticks; ``by_others``: which of its slips the rows of others hold."""
    return 1.0 + sum(2.0**k for k, x in enumerate(by_others) if x)


def idle(held: Any, k: int) -> Any:
    """Whether the row of slip k, from 0, does not act, by the number HELD: the contact does not stick, or the rows of
    others hold it."""
    return (held - 1.0) // 2.0**k % 2.0 != 0.0


def carried(contact: str, k: int) -> Expr:
    """The force along row k, from 0, of a contact with friction: opens the gap, or acts along a slip."""
    return input_signal(number(contact, SHARES[k])) - multiplier(contact, k)


class Contact(NamedTuple):
    """A rigid contact: its gap is the row of the joint ``name``, its slips [m/s] are the rows of velocities of it."""

    name: str
    e: float
    sequential: bool
    slips: tuple[Expr, ...]  #: none without friction
    mu: float
    mu_s: float
    span: Span | None
    closing: Expr
    absent: bool  #: whether it is left out: it never closes
    unit: str = "m"  #: of its gap, "rad" of stops of angles
    aim: tuple[Expr, ...] = ()  #: of the first of the five points of a cylinder, see rim_corners.py

    @property
    def corner(self) -> tuple[str, ...]:
        """If it is the first point of a cylinder: the names of the numbers that give the direction of its corner."""
        return tuple(f"{self.name.rpartition('.')[0]}.corner[{k + 1}]" for k in range(len(self.aim)))

    @property
    def starts(self) -> dict[str, float]:
        """Its numbers, and their values at the start."""
        own = {number(self.name, x): 0.0 for x in (NUMBERS if self.slips else NUMBERS[:4])}
        return own | dict(zip(self.corner, (1.0, 0.0), strict=False))

    @property
    def gap(self) -> Expr:
        closes = self.closing.args[0].args[1]
        return closes.args[0].args[1]

    @property
    def condition(self) -> Expr:
        """Becomes true where an open contact closes, and where a closed one opens, stops or begins to slide, or where
        the lowest point of a cylinder that leans has turned away from its corner."""
        if self.aim:
            size = call("hypot", *self.aim)
            b, c = (input_signal(c) * x for c, x in zip(self.corner, self.aim, strict=True))
            leans = call("and", call("lt", LEANS, size), call("lt", size, 0.3))
            turned = call("and", leans, call("lt", -(b + c), 0.5 * size))
            return call("or", self._replace(aim=()).condition, turned)
        if not self.slips:
            return self.closing
        sliding, held, slow = (input_signal(number(self.name, x)) for x in (SLIDING, HELD, SLOW))
        if len(self.slips) == 1:
            speed = sliding * self.slips[0]
        else:  # the direction of the slip has turned by 60 deg, or changed its sense
            along = [input_signal(number(self.name, x)) for x in (ALONG, ALONG_2)]
            speed = along[0] * self.slips[0] + along[1] * self.slips[1] - 0.5 * call("hypot", *self.slips)
        stops = call("and", call("ne", sliding, 0.0), call("lt", speed, -0.5 * slow))
        friction = [carried(self.name, k + 1) for k in range(len(self.slips))]
        size = call("abs", *friction) if len(friction) == 1 else call("hypot", *friction)
        most = self.mu_s * (1.0 + MARGIN) * carried(self.name, 0)
        slips = call("and", call("ne", held, 0.0), call("lt", most, size))
        return call("or", self.closing, call("or", stops, slips))


def is_contact(component) -> bool:
    """Whether a component is a rigid contact."""
    return isinstance(component.kind, JointKind) and component.kind.unilateral


def contact_of(component) -> Contact:
    """The contact that a component is."""
    name, values = component.name, component.values
    mode, edge = input_signal(number(name, MODE)), input_signal(number(name, EDGE))
    below = call("not", call("le", edge, component.relations[0]))  # a gap without a value is an event, too
    closes = call("and", call("ne", mode, CLOSED), below)
    pulls = (
        call("lt", carried(name, 0), 0.0) if component.velocity_constraints else call("lt", 0.0, multiplier(name, 0))
    )
    opens = call("and", call("eq", mode, CLOSED), pulls)
    own = component.velocity_constraints, float(values["mu"]), float(values["mu_s"])
    sequential = values["impacts"] == "sequential"
    more = values["impacts"] == "never", component.units.get("gap", "m"), values.get("aim", ())
    return Contact(name, float(values["e"]), sequential, *own, component.span, call("or", closes, opens), *more)


def rubbing(name: str, slips: Sequence[Expr], spatial: bool) -> list[tuple[str, list[Expr]]]:
    """What friction exerts while a contact slides: frames, and the components of force and torque on them.

    In the plane it is c N along the slip, c being its number COEFFICIENT. In space it has the direction of the slip; at
    rest, where there is none, that of ALONG.
    """
    if not slips:
        return []
    force = input_signal(number(name, COEFFICIENT)) * -multiplier(name, 0)
    forces = [force]
    if len(slips) > 1:
        slow = input_signal(number(name, SLOW))
        u = [x + slow * input_signal(number(name, y)) for x, y in zip(slips, (ALONG, ALONG_2), strict=True)]
        sliding = input_signal(number(name, SLIDING))
        # without sliding the coefficient is zero: the speed must not be
        speed = call("hypot", *u) + (1.0 - sliding)
        forces = [force * x / speed for x in u]
    found = []
    for frame in dict.fromkeys(f for x in slips for f in frames_in(x)):
        rates = [by_rate(x, frame, spatial) for x in slips]
        loads = [
            sum((s * g for s, g in zip(forces[1:], of[1:], strict=True)), forces[0] * of[0])
            for of in zip(*rates, strict=True)
        ]
        found.append((frame, [x if isinstance(x, Expr) else const(x) for x in loads]))
    return found


def friction_kind(spatial: bool):
    """The kind of the friction of contacts, a force and torque on one frame."""
    return of_variant("contact_friction", spatial).KIND
