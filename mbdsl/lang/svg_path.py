"""Outlines from the path data of SVG: ``M 0 0 L 10 0 C 15 0 20 5 20 10 Z`` to lines of points.

Source: W3C, SVG 1.1 (Second Edition), section 8.3 (path data) and appendix F.6 (elliptical arcs).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise
from math import acos, ceil, cos, hypot, pi, radians, sin, sqrt

Point = tuple[float, float]

NUMBERS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
_TOKEN = re.compile(r"\s*,?\s*(?:([MmLlHhVvCcSsQqTtAaZz])|([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?))")
_FLAG = re.compile(r"\s*,?\s*([01])")
CURVE = 16  #: lines for a cubic or quadratic curve
LARGEST = 1e9
ARC = pi / 18  #: largest angle of a line of an arc [rad]


class PathError(ValueError):
    """Text that is not path data; ``args`` hold the message."""


def flattened(text: str) -> list[tuple[list[Point], bool]]:
    """The lines of a path, and whether each is closed.

    Parameters
    ----------
    text : str
        The attribute ``d`` of a ``path`` element.

    Returns
    -------
    list of (list of (x, y), bool)
        In the path's own units, y down. Curves are replaced by 16 lines each, arcs by a line every 10 degrees.

    Raises
    ------
    PathError
        If the text is not path data.
    """
    found: list[tuple[list[Point], bool]] = []
    points: list[Point] = []
    at = start = (0.0, 0.0)
    control: Point | None = None  # of the previous curve, whose mirror image smooth curves begin with
    previous = ""
    for name, n in _commands(text):
        key = name.upper()
        if not previous and key != "M":
            raise PathError(f"begins with `{name}`; a path begins with `M x y`")
        x0, y0 = at if name.islower() else (0.0, 0.0)
        if key == "M":
            _end(found, points)
            at = start = x0 + n[0], y0 + n[1]
            points = [at]
        elif key == "Z":
            if len(points) > 1:
                found.append((points, True))
            at, points = start, [start]
        else:
            ends = _ends(key, n, (x0, y0), at, control, previous)
            points += ends[0]
            at, control = points[-1], ends[1]
        previous = key
    _end(found, points)
    return found


def _end(found: list[tuple[list[Point], bool]], points: list[Point]) -> None:
    if len(points) > 1:
        found.append((points, False))


def _commands(text: str) -> Iterator[tuple[str, list[float]]]:
    """Commands with their numbers; repeated numbers repeat the command."""
    place, name = 0, ""
    text = text.rstrip()
    while place < len(text):
        match = _TOKEN.match(text, place)
        if match is None:
            raise PathError(f"found `{text[place : place + 12].strip()}` after {place} characters")
        if match.group(1):
            name, place = match.group(1), match.end()
            if name in "Zz":
                yield name, []
                continue
        elif not name or name in "Zz":
            raise PathError(f"found the number `{match.group(2)}` without a command")
        numbers: list[float] = []
        while len(numbers) < NUMBERS[name.upper()]:
            flag = name in "Aa" and len(numbers) in (3, 4)
            match = (_FLAG if flag else _TOKEN).match(text, place)
            number = match and (match.group(1) if flag else match.group(2))
            if not match or not number:
                raise PathError(f"`{name}` takes {NUMBERS[name.upper()]} numbers, found {len(numbers)}")
            if abs(float(number)) > LARGEST:
                raise PathError(f"the number {number} is too large")
            numbers.append(float(number))
            place = match.end()
        yield name, numbers
        name = {"M": "L", "m": "l"}.get(name, name)


def _ends(
    key: str, n: list[float], origin: Point, at: Point, control: Point | None, previous: str
) -> tuple[list[Point], Point | None]:
    """The points after ``at`` of a line, curve or arc, and the last control point of a curve."""
    x0, y0 = origin
    if key == "L":
        return [(x0 + n[0], y0 + n[1])], None
    if key == "H":
        return [(x0 + n[0], at[1])], None
    if key == "V":
        return [(at[0], y0 + n[0])], None
    if key == "A":
        return _arc(at, n, (x0 + n[5], y0 + n[6])), None
    given = [(x0 + n[k], y0 + n[k + 1]) for k in range(0, len(n), 2)]
    if key in "ST":
        smooth = control is not None and previous in {"S": "CS", "T": "QT"}[key]
        mirrored = (2 * at[0] - control[0], 2 * at[1] - control[1]) if smooth and control is not None else at
        given = [mirrored, *given]
    return [_bezier([at, *given], k / CURVE) for k in range(1, CURVE + 1)], given[-2]


def _bezier(points: list[Point], part: float) -> Point:
    """A point of a Bezier curve, by de Casteljau's algorithm."""
    while len(points) > 1:
        points = [(x + (u - x) * part, y + (w - y) * part) for (x, y), (u, w) in pairwise(points)]
    return points[0]


def _arc(a: Point, n: list[float], b: Point) -> list[Point]:
    """An arc from a to b: from end points to centre and angles, F.6.5 and F.6.6."""
    rx, ry, large, sweep = abs(n[0]), abs(n[1]), n[3] == 1.0, n[4] == 1.0
    if a == b:
        return [b]
    if rx == 0.0 or ry == 0.0:
        return [b]
    c, s = cos(radians(n[2])), sin(radians(n[2]))
    dx, dy = (a[0] - b[0]) / 2, (a[1] - b[1]) / 2
    x, y = (c * dx + s * dy) / rx, (-s * dx + c * dy) / ry  # on the unit circle
    size = hypot(x, y)
    if size > 1.0:
        rx, ry, x, y = rx * size, ry * size, x / size, y / size
    root = sqrt(max(0.0, 1.0 / (x * x + y * y) - 1.0)) * (-1.0 if large == sweep else 1.0)
    cx, cy = root * y, -root * x
    first = _angle(x - cx, y - cy)
    turn = _angle(-x - cx, -y - cy) - first
    if sweep and turn < 0.0:
        turn += 2 * pi
    if not sweep and turn > 0.0:
        turn -= 2 * pi
    mx, my = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
    steps = max(1, ceil(abs(turn) / ARC))
    found = []
    for k in range(1, steps):
        u = first + turn * k / steps
        px, py = rx * (cx + cos(u)), ry * (cy + sin(u))
        found.append((mx + c * px - s * py, my + s * px + c * py))
    return [*found, b]


def _angle(x: float, y: float) -> float:
    angle = acos(max(-1.0, min(1.0, x / (hypot(x, y) or 1.0))))
    return angle if y >= 0.0 else -angle
