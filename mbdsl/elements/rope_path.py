"""The path of a rope over discs, as expressions over the frames at their centres, and the tensions of its spans.

A disc i has the signed radius r_i, positive if the rope turns to the left around it (in space: counter-clockwise about
the z axis of its frame); an end that is a point has r = 0. Span j is the common tangent of discs i and i + 1. With
d = o_(i+1) - o_i, r = r_(i+1) - r_i and the normal n to the left of its direction u,

    d = s u + r n,   s = sqrt(d . d - r^2),   u = (s d - r n x d)/(d . d)

The rope that span j takes up, if it holds fast to both discs, is

    g_j = s_j + r_i a_i - r_(i+1) a'_(i+1)

where a_i is the angle by which u has turned since the start, relative to disc i, where it leaves the disc, and a' where
it arrives. dg_j = u . (do_(i+1) - do_i) - r_i dphi_i + r_(i+1) dphi_(i+1): the tension T_j does the virtual work
-T_j dg_j, that of forces along the span at both tangent points. Over all spans, the angles of the discs cancel, except
for drums at the ends: the sum of the g_j is the length of the path, with the arcs |r_i| w_i, and of what was wound on
drums since the start.

**Without friction** (mu = 0) T = k e + c e' in all spans, with the stretch e = L - L_0 of this length, and zero where
the rope is slack, e < 0. The damping is limited to -k e < c e' < k e: so T is continuous where the rope becomes taut,
and never negative.

**With friction** the tensions on both sides of a disc differ (L. Euler, 1769; J. A. Eytelwein, 1808),

    T_j/T_(j+1) = exp(mu w_i tanh(v_i/v_s)),   v_i = sum_(m <= j) (g_m' - p_m L'/P)

v_i is the sliding speed of a rope whose strain is uniform, p_m the length of span m and of half the arcs at its ends,
and P that of all. The T_j are those of which the mean, weighted by p_j, is the T without friction. Then the power of
the tensions is that of spring and damper less the sum of (T_j - T_(j+1)) v_i, which friction dissipates.

**Holding fast** (no mu) every span is a rope of its own, of stiffness k P/p_j at the start, between discs on which it
is wound. Its free length at the start is the share p_j/P of that of the rope: all tensions are equal there.

In space, the span leaves a disc where its projection to the plane of the disc is tangent to the circle; the disc at its
other end is projected with the radius r_(i+1) n_i . n_(i+1). This is exact where spans lie in the planes of their
discs. Otherwise the groove deflects the rope by a small angle, and the forces follow from the same g_j.

The stiffness is that of the whole rope, and does not change with what is wound on drums. Ropes have no mass, and do not
leave their discs: w_i has to remain positive, else there is a warning.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import cos, pi, sin
from typing import TypeAlias

from mbdsl.expressions.derivatives import flow
from mbdsl.expressions.symbolic import Expr, at_start, call, const

Vector: TypeAlias = "tuple[Expr, ...]"
Coordinate: TypeAlias = Callable[[str], Expr]
#: the centre [rad] of angles of wrapping at the start, in addition to `turns`: between -45 and 315 degrees
CENTRE = 0.75 * pi
#: part of its length by which a rope is taken shorter: one as long as its path is taut, and rounding does not decide it
TAUT = 1e-12


def dot(a: Vector, b: Vector) -> Expr:
    """The scalar product."""
    return sum((x * y for x, y in zip(a, b, strict=True)), const(0.0))


def since_start(y: Expr, x: Expr) -> Expr:
    """The angle [rad] by which the direction (x, y) has turned since the start, with its turns."""
    cosine, sine = at_start(x), at_start(y)
    sides = y * cosine - x * sine, x * cosine + y * sine
    return call("angle", *sides, flow(call("atan2", *sides)))


def cross(a: Vector, b: Vector) -> Vector:
    """The vector product in space."""
    return tuple(a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3] for i in range(3))


@dataclass(frozen=True)
class Disc:
    """A disc of signed ``radius`` [m] about the origin of a frame, whose coordinates ``at`` gives; a point for 0."""

    at: Coordinate
    radius: float
    spatial: bool

    @cached_property
    def origin(self) -> Vector:
        return tuple(self.at(key) for key in ("xyz" if self.spatial else "xy"))

    def axis(self, name: str) -> Vector:
        """An axis of the frame in space."""
        return tuple(self.at(name + key) for key in "xyz")

    def left(self, u: Vector) -> Vector:
        """The vector n x u, in the plane of the disc."""
        return cross(self.axis("z"), u) if self.spatial else (-u[1], u[0])

    def in_plane(self, d: Vector) -> Vector:
        """The part of a vector in the plane of the disc."""
        if not self.spatial:
            return d
        n = self.axis("z")
        along = dot(n, d)
        return tuple(x - along * y for x, y in zip(d, n, strict=True))

    def seen(self, other: Disc) -> Expr:
        """The signed radius of another disc, projected to the plane of this one."""
        if not (self.spatial and other.radius):
            return const(other.radius)
        return other.radius * dot(self.axis("z"), other.axis("z"))

    def turned(self, u: Vector) -> Expr:
        """The angle by which the direction u, relative to the disc, has turned since the start, with its turns."""
        if not self.spatial:
            phi = self.at("phi")
            return since_start(u[1], u[0]) - (phi - at_start(phi))
        y, x = (dot(u, self.axis(name)) for name in "yx")
        return since_start(y, x)

    def wrapped(self, arriving: Vector, leaving: Vector, turns: float) -> tuple[Expr, Expr]:
        """The angle [rad] by which a rope is wrapped around the disc, and a formula of its value at the start."""
        side = 1.0 if self.radius > 0.0 else -1.0
        y, x = side * dot(self.left(arriving), leaving), dot(arriving, leaving)
        c, s = cos(CENTRE), sin(CENTRE)
        first = call("atan2", y * c - x * s, x * c + y * s) + (CENTRE + 2.0 * pi * turns)
        return at_start(first) + since_start(y, x), first


@dataclass(frozen=True)
class RopeSpan:
    """The rope between two discs: its straight length, its directions where it leaves a and arrives at b, and g."""

    a: Disc
    b: Disc

    def _tangent(self, disc: Disc, r: Expr) -> tuple[Expr, Vector]:
        """Length and direction of the common tangent of both discs in the plane of one of them."""
        d = disc.in_plane(tuple(y - x for x, y in zip(self.a.origin, self.b.origin, strict=True)))
        square = dot(d, d)
        s = call("sqrt", square - r * r)
        return s, tuple((s * x - r * y) / square for x, y in zip(d, disc.left(d), strict=True))

    @cached_property
    def leaving(self) -> Vector:
        return self._tangent(self.a, self.a.seen(self.b) - self.a.radius)[1]

    @cached_property
    def arriving(self) -> Vector:
        return self._tangent(self.b, self.b.radius - self.b.seen(self.a))[1]

    @cached_property
    def points(self) -> tuple[Vector, Vector]:
        """The points where the rope leaves disc a, and where it arrives at disc b."""
        ends = []
        for disc, u in ((self.a, "leaving"), (self.b, "arriving")):
            lever = disc.left(getattr(self, u)) if disc.radius else (const(0.0),) * len(disc.origin)
            ends.append(tuple(o - disc.radius * x for o, x in zip(disc.origin, lever, strict=True)))
        return ends[0], ends[1]

    @cached_property
    def straight(self) -> Expr:
        """The distance of these points."""
        if not self.a.spatial and (self.a.radius or self.b.radius):
            return self._tangent(self.a, const(self.b.radius - self.a.radius))[0]
        first, second = self.points
        d = tuple(y - x for x, y in zip(first, second, strict=True))
        if self.a.spatial:
            return call("hypot", call("hypot", d[0], d[1]), d[2])
        return call("hypot", *d)

    @cached_property
    def g(self) -> Expr:
        found = self.straight
        if self.a.radius:
            found = found + self.a.radius * self.a.turned(self.leaving)
        return found - self.b.radius * self.b.turned(self.arriving) if self.b.radius else found


def pull(k: Expr | float, c: Expr | float, stretch: Expr, rate: Expr) -> Expr:
    """The tension of a spring and damper that only pull, see the head of this file."""
    spring = call("max", 0.0, k * stretch)
    if not (isinstance(c, Expr) or c):
        return spring
    return spring + call("max", -spring, call("min", spring, c * rate))


class Path:
    """A rope over discs: its ``signals`` by name, the ``tensions`` of its ``spans``, and its potential ``energy``.

    Parameters
    ----------
    values : mapping
        The parameters of the rope.
    frames : sequence of callable
        The coordinates of its frames by key: both ends, and the discs between them.
    spatial : bool
        Whether these are frames in space.
    """

    def __init__(self, values: Mapping, frames: Sequence[Coordinate], spatial: bool) -> None:
        self.values = values
        inner = values["radii"]
        first, last = values["drums"]
        radii = (first, *inner, last)
        self.discs = [Disc(at, r, spatial) for at, r in zip(frames, radii, strict=True)]
        self.spans = [RopeSpan(a, b) for a, b in pairwise(self.discs)]
        between = zip(self.discs[1:-1], self.spans, self.spans[1:], values["wound"], strict=False)
        wraps = [disc.wrapped(before.arriving, after.leaving, n) for disc, before, after, n in between]
        #: by how much the rope is wrapped around the disc at the beginning of each span but the first
        self.wraps = [now for now, _ in wraps]
        #: length of each span and of half the arcs at its ends
        self.parts = self._parts(self.wraps)
        self.length = _sum(self.parts)
        #: the same at the start
        self.first_parts = [at_start(part) for part in self._parts([first for _, first in wraps])]
        #: the stretch of each span that holds fast, or of the whole rope
        self.tensions, self.stretches, self.energy = self._fast() if self.holds_fast else self._sliding()
        stretch = _sum(self.stretches)
        self.signals = {
            "s": self.length,
            "v": flow(self.length),
            "stretch": stretch,
            "tension": self.tensions[0],
            "taken": self.spans[0].g,
            "tension_b": self.tensions[-1],
            "slack": call("le", stretch, 0.0),
            "power": _sum([self._power(j) for j in range(len(self.spans))]),
        }

    def _parts(self, wraps: Sequence[Expr]) -> list[Expr]:
        arcs = [const(0.0), *(abs(r) * w for r, w in zip(self.values["radii"], wraps, strict=True)), const(0.0)]
        return [x.straight + 0.5 * (arcs[j] + arcs[j + 1]) for j, x in enumerate(self.spans)]

    def _power(self, j: int) -> Expr:
        """The power of the tension of span j."""
        return -(self.tensions[j] * flow(self.spans[j].g))

    @property
    def searched(self) -> Expr | None:
        """The law that is searched for moments between steps in which the rope is taut, as laws of springs are.

        None with discs: intervals of their tangents are too wide. There, the end of a step that passes such a moment
        shows it, unless the rope is slack again by the motion of its ends alone.
        """
        return None if any(disc.radius for disc in self.discs) else self.tensions[0]

    @property
    def holds_fast(self) -> bool:
        """Whether the rope does not slide on the discs between its ends."""
        return bool(self.values["radii"]) and self.values["mu"] is None

    def _free(self) -> Expr:
        """The free length at the start, of the rope that is not wound on drums."""
        given = self.values["length"]
        return (_sum(self.first_parts) if given is None else const(given)) * (1.0 - TAUT)

    def _fast(self) -> tuple[list[Expr], list[Expr], Expr]:
        k, c, whole = self.values["k"], self.values["c"], _sum(self.first_parts)
        strain = self._free() / whole
        tensions, energy, stretches = [], const(0.0), []
        for span, own in zip(self.spans, self.first_parts, strict=True):
            e, rate, share = span.g - at_start(span.straight) + own * (1.0 - strain), flow(span.g), whole / own
            tensions.append(pull(k * share, c and c * share, e, rate))
            positive = call("max", 0.0, e)
            energy = energy + 0.5 * k * share * positive * positive
            stretches.append(e)
        return tensions, stretches, energy

    def _sliding(self) -> tuple[list[Expr], list[Expr], Expr]:
        k, c = self.values["k"], self.values["c"]
        stretch = self.length - self._free()
        for disc, u, sign in ((self.discs[0], "leaving", 1.0), (self.discs[-1], "arriving", -1.0)):
            if disc.radius:
                span = self.spans[0 if sign > 0.0 else -1]
                stretch = stretch + sign * disc.radius * disc.turned(getattr(span, u))
        rates = [flow(span.g) for span in self.spans] if self.values["mu"] else []
        rate = flow(stretch)
        mean = pull(k, c, stretch, rate)
        positive = call("max", 0.0, stretch)
        energy = 0.5 * k * (positive * positive)
        if not rates:
            return [mean] * len(self.spans), [stretch], energy
        ratios, passed = [const(1.0)], const(0.0)
        for j, wrap in enumerate(self.wraps):
            passed = passed + rates[j] - self.parts[j] / self.length * rate
            slide = call("tanh", passed / self.values["v_s"])
            ratios.append(ratios[-1] * call("exp", -(self.values["mu"] * wrap * slide)))
        weighted = _sum([x * part for x, part in zip(ratios, self.parts, strict=True)])
        first = mean * self.length / weighted
        return [first * x for x in ratios], [stretch], energy

    def longer(self, j: int) -> Expr:
        """By how much span j is longer than the rope in it."""
        return self.stretches[j] if self.holds_fast else self.stretches[0] * (self.parts[j] / self.length)

    def of_span(self, j: int) -> dict[str, Expr]:
        """The signals of span j alone."""
        s, tension = self.spans[j].straight, self.tensions[j]
        return {
            **self.signals,
            "tension": tension,
            "tension_b": tension,
            "taken": self.spans[j].g,
            "s": s,
            "v": flow(s),
            "power": self._power(j),
        }


def _sum(terms: Sequence[Expr]) -> Expr:
    found = terms[0]
    for x in terms[1:]:
        found = found + x
    return found
