"""Joints whose friction sticks: their numbers, the rows that hold them, and when they start and stop to slide.

While a joint slides, friction is mu N against the sliding. Where the speed becomes zero the joint is held, if friction
can: its coordinates keep the values that they have there, by rows such as s - place = 0, whose multipliers are the
friction. The rows are left out while the joint slides.

Joints that slide in several directions r have friction mu N w/|w|, w = r + e d. The unit vector d is the direction of
sliding at the last event, and e is below all speeds that count: d is the direction where sliding begins. Where r has
turned by 60 degrees from d there is an event: the joint has stopped, or d becomes the present direction.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from typing import Any, NamedTuple

from mbdsl.elements.kind import JointKind
from mbdsl.errors import Span
from mbdsl.expressions.frame_derivatives import frames_in
from mbdsl.expressions.symbolic import Expr, call, const, input_signal, multiplier, substitute
from mbdsl.mechanism.connected_groups import connected

#: numbers of a joint, as of discrete variables: the sense of sliding, or 1 of joints that slide in several directions
#: (0: at rest), and the speed against it at which it has stopped, which is more than rounding
SLIDING, EDGE = "sliding", "edge"
NUMBERS = (SLIDING, EDGE)
#: the value of EDGE before the first event, and e relative to it
LEAST_EDGE, EDGES = 1e-12, 4.0
DRIVEN = 1e4  #: the speed at which others move it, relative to EDGE: velocities have errors in methods of index 3
TURN = 0.5  #: cosine of the angle by which the direction of sliding turns between two events
#: part of the largest friction by which a sticking joint exceeds it before it slides: more than rounding
MARGIN = 1e-9


class Sticking(NamedTuple):
    """A joint whose friction sticks, as expressions: rates of sliding, positions that it keeps, the rows that hold it,
    friction along the rates while it is held, and the normal force (or its torque)."""

    name: str
    mu_s: float
    rates: tuple[Expr, ...]
    places: tuple[Expr, ...]
    holds: tuple[Expr, ...]
    grips: tuple[Expr, ...]
    normal: Expr
    span: Span | None = None
    #: the rows that hold all joints in loops of the mechanism, which may hold the same motion; see ``sharing``
    among: tuple[str, ...] = ()

    @property
    def rows(self) -> list[str]:
        """The components whose rows hold the joint."""
        return [row_name(self.name, k) for k in range(len(self.holds))]

    @property
    def by_coordinates(self) -> bool:
        """Whether a row is a coordinate less its place."""
        return len(self.places) == len(self.holds)

    @property
    def held(self) -> list[str]:
        """The numbers that say which of its rows hold it."""
        return [number(self.name, f"held[{k + 1}]") for k in range(len(self.holds))]

    @property
    def directions(self) -> list[str]:
        """The numbers that are the direction of sliding."""
        if len(self.rates) == 1:
            return [number(self.name, SLIDING)]
        return [number(self.name, f"direction[{k + 1}]") for k in range(len(self.rates))]

    @property
    def kept(self) -> list[str]:
        """The numbers that are the place where it is held."""
        return [number(self.name, f"place[{k + 1}]") for k in range(len(self.places))]

    @property
    def starts(self) -> dict[str, float]:
        """Its numbers and their values before the first event."""
        names = [*self.directions, *self.held, *self.kept, *(number(self.name, x) for x in NUMBERS)]
        first = {number(self.name, EDGE): LEAST_EDGE}
        return (
            dict.fromkeys(names, 0.0) | self.alone | ({self.directions[0]: 1.0} if len(self.rates) > 1 else {}) | first
        )

    @property
    def alone(self) -> dict[str, float]:
        """The numbers of ``share`` while each row carries its own multiplier."""
        own = enumerate(self.rows)
        return {self.share(k, row): float(row == name) for k, name in own for row in self.among}

    def share(self, k: int, row: str) -> str:
        """The number that is the part of the multiplier of ``row`` that the k-th row of this joint carries."""
        return number(self.name, f"share[{k + 1}]({row})")

    def sharing(self, rows: tuple[str, ...]) -> Sticking:
        """The joint in a loop with others, of which ``rows`` hold all: rows that depend on others have no multiplier,
        and the friction of each joint is a part of what the others carry together."""

        def carried(leaf: Expr) -> Expr | None:
            if leaf.op != "multiplier" or leaf.value[0] not in self.rows:
                return None
            k = self.rows.index(leaf.value[0])
            parts = [input_signal(self.share(k, row)) * multiplier(row, 0) for row in rows]
            return sum(parts[1:], parts[0])

        return self._replace(grips=tuple(substitute(x, carried) for x in self.grips), among=rows)

    @property
    def condition(self) -> Expr:
        """Becomes true where the joint stops, where friction can no longer hold it, and where others move it whose
        constraints leave none to a row that would hold it."""
        sliding, edge = (input_signal(number(self.name, x)) for x in (SLIDING, EDGE))
        along = [input_signal(d) * rate for d, rate in zip(self.directions, self.rates, strict=True)]
        turned = -edge if len(along) == 1 else TURN * size(self.rates) - edge
        stops = call("and", call("ne", sliding, 0.0), call("lt", sum(along[1:], along[0]), turned))
        most = self.mu_s * (1.0 + MARGIN) * self.normal
        largest = call("abs", self.grips[0]) if len(self.grips) == 1 else size(self.grips)
        rate = call("abs", self.rates[0]) if len(along) == 1 else size(self.rates)
        rows = [input_signal(name) for name in self.held]
        driven = call("and", call("lt", sum(rows[1:], rows[0]), float(len(rows))), call("lt", DRIVEN * edge, rate))
        slips = call("and", call("eq", sliding, 0.0), call("or", call("lt", most, largest), driven))
        return call("or", stops, slips)


def in_loops(scene: Any, names: Sequence[str]) -> set[str]:
    """Those of the joints ``names`` that are in loops of a Scene."""
    bodies = {c.name for c in scene.with_coordinates()}
    links: dict[str, list[str]] = {}
    for c in scene.components.values():
        if isinstance(c.kind, JointKind):
            frames = [
                *c.ports.values(),
                *(x for row in (*c.relations, *c.velocity_constraints) for x in frames_in(row)),
            ]
            ends = [scene.frames[name].body for name in frames]
            links[c.name] = [body if body in bodies else "" for body in ends] + [""] * (not c.ports)
    found = set()
    for name in names:
        a, b = links[name]
        others = [ends for other, ends in links.items() if other != name]
        found |= {name for group in connected(("", *bodies), others) if a in group and b in group}
    return found


def size(vector: Sequence[Expr]) -> Expr:
    """The length of a vector; a single number itself, with its sign."""
    return reduce(lambda a, b: call("hypot", a, b), vector)


def direction(joint: Sticking) -> Sequence[Expr]:
    """The direction w/|w| of sliding; 1 of a joint that slides along one coordinate only."""
    if len(joint.rates) == 1:
        return (const(1.0),)
    e = EDGES * input_signal(number(joint.name, EDGE))
    w = [rate + e * input_signal(d) for rate, d in zip(joint.rates, joint.directions, strict=True)]
    return [x / size(w) for x in w]


def number(joint: str, what: str) -> str:
    """The name of a number of a joint among the discrete variables."""
    return f"{joint}.{what}"


def row_name(joint: str, k: int) -> str:
    """The name of the component whose row is the k-th, from 0, of those that hold a joint."""
    return f"{joint}.stick[{k + 1}]"


def joint_of(row: str) -> str:
    """The joint that a component is, or whose row it is."""
    return row.rpartition(".stick[")[0] or row


def sticks(kind: object, values: Mapping) -> bool:
    """Whether a component is a joint whose friction sticks."""
    return isinstance(kind, JointKind) and bool(values.get("sticks") and values.get("mu_s"))
