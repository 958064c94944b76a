"""Closed profiles of points, arcs and smooth curves, and the features of which their nearest points are.

The solid is to the left of the profile. A feature is a straight piece, an arc or a corner. With the constants of
``Feature``, the distance of a point x from it, negative within the solid, and where it is the nearest point, are

    s = n . x - d + sigma (|x - c| - R),   a . x >= alpha,   b . x < beta

Straight pieces have sigma = 0; arcs and corners have n = 0, d = 0, and sigma = 1 if they are convex, -1 if they are
concave; corners have R = 0. Neighbours share alpha, beta and their directions, so that exactly one of them is valid at
a point near to a convex part of the profile: the distance and its gradient are continuous there.

Smooth profiles consist of two arcs from each point to the next (biarcs: K. M. Bolton, Computer-Aided Design 7 (1975)
89-92), which have the same tangent where they meet; the tangent at a point is that of the circle through it and its
neighbours.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import asin, copysign, cos, hypot, sin, sqrt
from typing import NamedTuple

Point = tuple[float, float]
#: sine of the angle below which two pieces have the same tangent
SAME = 1e-9


class Feature(NamedTuple):
    """The constants of a straight piece, an arc or a corner."""

    ax: float
    ay: float
    alpha: float
    bx: float
    by: float
    beta: float
    nx: float
    ny: float
    d: float
    sigma: float
    cx: float
    cy: float
    R: float


class Piece(NamedTuple):
    """A piece of the profile from p to q; the radius of an arc is positive if it is convex, and 0 of a straight one."""

    p: Point
    q: Point
    radius: float

    @property
    def normal(self) -> Point:
        """The unit vector at right angles to the chord, out of the solid."""
        x, y = self.q[0] - self.p[0], self.q[1] - self.p[1]
        length = hypot(x, y)
        return y / length, -x / length

    @property
    def centre(self) -> Point:
        """Of an arc."""
        half = 0.5 * hypot(self.q[0] - self.p[0], self.q[1] - self.p[1])
        depth = copysign(sqrt(max(0.0, self.radius**2 - half**2)), self.radius)
        (x, y), (nx, ny) = (0.5 * (self.p[0] + self.q[0]), 0.5 * (self.p[1] + self.q[1])), self.normal
        return x - depth * nx, y - depth * ny

    def halves(self) -> tuple[Piece, ...]:
        """Two arcs in place of one of more than a quarter of a circle, whose two conditions may be the same line."""
        half, r = 0.5 * hypot(self.q[0] - self.p[0], self.q[1] - self.p[1]), self.radius
        if half * half < 0.5 * r * r or r == 0.0:
            return (self,)
        (x, y), (nx, ny) = self.centre, self.normal
        middle = x + r * nx, y + r * ny
        return Piece(self.p, middle, r), Piece(middle, self.q, r)

    def tangent(self, at: Point) -> Point:
        """The direction of the profile at one of the ends."""
        if self.radius == 0.0:
            nx, ny = self.normal
            return -ny, nx
        (x, y), r = self.centre, self.radius
        return -(at[1] - y) / r, (at[0] - x) / r

    def distance(self) -> tuple[float, ...]:
        """The constants of s."""
        if self.radius == 0.0:
            nx, ny = self.normal
            return nx, ny, nx * self.p[0] + ny * self.p[1], 0.0, 0.0, 0.0, 0.0
        return 0.0, 0.0, 0.0, copysign(1.0, self.radius), *self.centre, abs(self.radius)


def problem(points: Sequence[Point], arcs: Sequence[float], smooth: bool) -> str | None:
    """Why points and radii are no closed profile; None if they are one."""
    n = len(points)
    if n < (2 if arcs else 3):
        return f"`points` has {n} points, a closed profile needs at least three, or two with `arcs`"
    if smooth and arcs:
        return "a `smooth` profile finds its own arcs: leave `arcs` out"
    if arcs and len(arcs) != n:
        return f"`arcs` has {len(arcs)} radii, expected {n}: one for the piece from each of the `points` to the next"
    for i, piece in enumerate(pieces(points, arcs), 1):
        chord = hypot(piece.q[0] - piece.p[0], piece.q[1] - piece.p[1])
        if chord == 0.0:
            return f"`points`: point {i % n + 1} is the same as point {i}; the last one is joined to the first one"
        if piece.radius and 2.0 * abs(piece.radius) < chord * (1.0 - SAME):
            return f"`arcs`: radius {i} is {abs(piece.radius):g} m, less than half of the distance {chord:g} m"
    if area(points, arcs) == 0.0:
        return "`points` are on a line, the profile encloses nothing"
    return None


def pieces(points: Sequence[Point], arcs: Sequence[float]) -> list[Piece]:
    """The pieces from each point to the next."""
    return [Piece(p, points[(i + 1) % len(points)], arcs[i] if arcs else 0.0) for i, p in enumerate(points)]


def area(points: Sequence[Point], arcs: Sequence[float]) -> float:
    """Twice the area of the polygon, positive counterclockwise; of two arcs, 1."""
    if len(points) == 2:
        return 1.0
    return sum(p[0] * q[1] - p[1] * q[0] for p, q, _ in pieces(points, arcs))


def features(
    points: Sequence[Point], arcs: Sequence[float], smooth: bool, hole: bool, radius: float = 0.0
) -> tuple[list[Feature], tuple[int, ...]]:
    """The features of a closed profile, and the lengths of its chains, which come first.

    A circle of a ``radius`` [m] rolls along a chain without touching another piece: chains end at concave corners and
    at concave arcs that are smaller than the circle. If there is only one, there are no chains: ().

    Parameters
    ----------
    points : sequence of (x, y)
        In the order of the profile, in either sense [m].
    arcs : sequence of float
        Of each piece its radius, positive if it bulges out of the enclosed area; 0: straight [m]. Empty: all straight.
    smooth : bool
        Whether the profile is a smooth curve through the points.
    hole : bool
        Whether the solid is outside of the profile.
    radius : float, optional
        Of the circle that rolls along it [m]; 0: a point.
    """
    turned = (area(points, arcs) < 0.0) != hole
    radii = [-x if hole else x for x in arcs]
    if turned:
        points, radii = points[::-1], [*radii[-2::-1], *radii[-1:]]
    found = [half for x in (_biarcs(points) if smooth else pieces(points, radii)) for half in x.halves()]
    ends = [(x.tangent(x.p), x.tangent(x.q)) for x in found]
    corners: list[Feature | None] = [None] * len(found)
    for i, piece in enumerate(found):
        (_, b), (a, _) = ends[i], ends[(i + 1) % len(found)]
        turn, along = b[0] * a[1] - b[1] * a[0], b[0] * a[0] + b[1] * a[1]
        if abs(turn) < SAME and along > 0.0:
            ends[(i + 1) % len(found)] = (b, ends[(i + 1) % len(found)][1])
            continue
        x, y = piece.q
        alpha, beta = b[0] * x + b[1] * y, a[0] * x + a[1] * y
        corners[i] = Feature(*b, alpha, *a, beta, 0.0, 0.0, 0.0, copysign(1.0, turn), x, y, 0.0)
    in_order = list[Feature]()
    for piece, (a, b), corner in zip(found, ends, corners, strict=True):
        alpha, beta = (t[0] * x[0] + t[1] * x[1] for t, x in ((a, piece.p), (b, piece.q)))
        in_order += [Feature(*a, alpha, *b, beta, *piece.distance()), *([corner] if corner else [])]
    return _chained(in_order, radius)


def _chained(in_order: list[Feature], radius: float) -> tuple[list[Feature], tuple[int, ...]]:
    """The features with those of chains first, and the lengths of the chains.

    The chain of a polygon with a single concave corner is cut in its middle: in the corner both its ends touch.
    """
    ends = [i for i, x in enumerate(in_order) if x.sigma < 0.0 and radius >= x.R]
    if not ends:
        return in_order, ()
    chains = [in_order[i + 1 : k] for i, k in pairwise(ends)]
    chains = [x for x in (*chains, in_order[ends[-1] + 1 :] + in_order[: ends[0]]) if x]
    if len(chains) == 1 and not any(x.R for x in in_order):
        half = len(chains[0]) // 2
        chains = [chains[0][:half], chains[0][half:]]
    if len(chains) < 2:
        return in_order, ()
    return [*(x for chain in chains for x in chain), *(in_order[i] for i in ends)], tuple(map(len, chains))


def outline(points: Sequence[Point], arcs: Sequence[float], smooth: bool) -> list[Point]:
    """Points of the profile for pictures, those of arcs up to six degrees apart."""
    signs = arcs if smooth or area(points, arcs) > 0.0 else [-x for x in arcs]
    found = list[Point]()
    for piece in (half for x in (_biarcs(points) if smooth else pieces(points, signs)) for half in x.halves()):
        found.append(piece.p)
        if piece.radius:
            (x, y), (px, py) = piece.centre, piece.p
            cx, cy = px - x, py - y
            a = 2.0 * asin(hypot(piece.q[0] - px, piece.q[1] - py) / (2.0 * piece.radius))
            count = int(abs(a) / 0.1)
            for k in range(1, count + 1):
                c, s = cos(a * k / (count + 1)), sin(a * k / (count + 1))
                found.append((x + c * cx - s * cy, y + s * cx + c * cy))
    return found


def _biarcs(points: Sequence[Point]) -> list[Piece]:
    """Two arcs from each point to the next, or one straight piece where both are straight."""
    n, found = len(points), list[Piece]()
    tangents = [_tangent(points[i - 1], points[i], points[(i + 1) % n]) for i in range(n)]
    for i, p in enumerate(points):
        q, t, u = points[(i + 1) % n], tangents[i], tangents[(i + 1) % n]
        v = q[0] - p[0], q[1] - p[1]
        # both arcs have tangents of the same length d: |v - d (t + u)| = 2 d
        vt, tu, vv = v[0] * (t[0] + u[0]) + v[1] * (t[1] + u[1]), t[0] * u[0] + t[1] * u[1], v[0] ** 2 + v[1] ** 2
        bent = 2.0 * (1.0 - tu)
        d = vv / (vt + sqrt(vt * vt + bent * vv))
        middle = 0.5 * (p[0] + q[0] + d * (t[0] - u[0])), 0.5 * (p[1] + q[1] + d * (t[1] - u[1]))
        found += [_arc(p, middle, t), _arc(middle, q, _end(p, middle, t))]
    return found


def _tangent(p: Point, q: Point, r: Point) -> Point:
    """The tangent at q of the circle through p, q and r: that of the parabola with the lengths of the chords."""
    a, b = hypot(q[0] - p[0], q[1] - p[1]), hypot(r[0] - q[0], r[1] - q[1])
    x, y = ((q[i] - p[i]) * b / a + (r[i] - q[i]) * a / b for i in range(2))
    length = hypot(x, y)
    return x / length, y / length


def _end(p: Point, q: Point, t: Point) -> Point:
    """The tangent at q of the arc from p to q that has the tangent t at p: t mirrored at the chord."""
    x, y = q[0] - p[0], q[1] - p[1]
    factor = 2.0 * (t[0] * x + t[1] * y) / (x * x + y * y)
    return factor * x - t[0], factor * y - t[1]


def _arc(p: Point, q: Point, t: Point) -> Piece:
    """The arc from p to q with the tangent t at p; positive radius to the left."""
    x, y = q[0] - p[0], q[1] - p[1]
    across, square = t[0] * y - t[1] * x, x * x + y * y
    return Piece(p, q, 0.0 if abs(across) < SAME * sqrt(square) else 0.5 * square / across)
