"""The look of each series: colour, mark and line, the same for a name in all figures.

Colours and marks together remain distinguishable for colour-blind readers: members of a family share a hue but no mark,
and every colour has a contrast of at least 3:1 to the paper, light or dark (WCAG 2.1, 1.4.11).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

LIGHT_PAPER, DARK_PAPER = "#ffffff", "#15181d"


@dataclass(frozen=True)
class Look:
    """Colour on light and on dark paper, a mark (one of :data:`MARKS`), and the dashes of its line (empty: solid)."""

    light: str
    dark: str
    mark: str
    filled: bool = True
    dash: tuple[float, ...] = ()


NEUTRAL = Look("#6b7280", "#9aa4b2", "circle")  #: for guides and fronts
DASHED = (5.0, 2.5)  #: for third-party integrators and other programs
METHODS = {
    "newmark": Look("#bf4f97", "#eba0cf", "hexagon", False),
    "hht-i3": Look("#2f8fd3", "#8ccbf5", "square", False),
    "hht-si2": Look("#0a5fa8", "#4fa3e8", "circle"),
    "hht-add": Look("#3b2c85", "#a79bef", "diamond"),
    "nstiff": Look("#c67500", "#f5b041", "up", False),
    "nstiff-si2": Look("#b3360a", "#f07b4b", "down"),
    "generalized-alpha": Look("#7d1d4f", "#d4709f", "pentagon"),
    "generalized-alpha-i3": Look("#b04a80", "#eba6c4", "pentagon", False),
    "radau5": Look("#008a64", "#35c89b", "star"),
    "scipy-dop853": Look("#7a6a00", "#d2c04a", "plus", dash=DASHED),
    "scipy-radau": Look("#7a6a00", "#d2c04a", "cross", dash=DASHED),
    "scipy-lsoda": Look("#7a6a00", "#d2c04a", "left", dash=DASHED),
    "scipy": Look("#7a6a00", "#d2c04a", "square", dash=DASHED),
    "ida": Look("#5f6b73", "#aebac2", "right", dash=DASHED),
    "exudyn": Look("#111111", "#f2f2f2", "diamond", False, dash=DASHED),
}
OTHERS = (
    Look("#0072b2", "#56b4e9", "circle"),
    Look("#c94f00", "#ff9a5c", "square"),
    Look("#00855f", "#35c89b", "up"),
    Look("#a63d88", "#e59bcd", "diamond"),
    Look("#7a6a00", "#d2c04a", "down"),
    Look("#3b2c85", "#a79bef", "pentagon"),
    Look("#8c1d18", "#f28b82", "hexagon"),
    Look("#3d4a52", "#c3ced6", "star"),
)
DASHES = ((), (6.0, 2.0), (2.0, 1.5), (7.0, 2.0, 1.5, 2.0), (10.0, 3.0))


def looks(names: Iterable[str]) -> dict[str, Look]:
    """Name -> look.

    A series whose name begins with that of a method has the hue and mark of the method; the others get theirs in order.
    """
    names = list(dict.fromkeys(names))
    taken = dict.fromkeys((_method(name) for name in names), -1)
    taken.update({name.lower(): 0 for name in names if name.lower() in METHODS})
    found = {}
    for name in names:
        method = _method(name)
        if method == name.lower():
            found[name] = METHODS[method]
        else:
            taken[method] += 1
            found[name] = _variant(METHODS[method], taken[method]) if method else _other(taken[method])
    return found


def _variant(look: Look, k: int) -> Look:
    """The ``k``-th series of a method: darker colours first, then dashes as well."""
    turn, depth = divmod(k, 3)
    light, dark = _mixed(look.light, "#000000", 0.33 * depth), _mixed(look.dark, "#ffffff", 0.33 * depth)
    return replace(look, light=light, dark=dark, filled=look.filled ^ (k % 2 == 1), dash=DASHES[turn % len(DASHES)])


def _other(k: int) -> Look:
    turn, place = divmod(k, len(OTHERS))
    mark = OTHERS[(place + turn) % len(OTHERS)].mark
    return replace(OTHERS[place], mark=mark, dash=DASHES[turn % len(DASHES)])


def _mixed(colour: str, other: str, part: float) -> str:
    pairs = ((int(c[k : k + 2], 16) for c in (colour, other)) for k in (1, 3, 5))
    return "#" + "".join(f"{round(a + part * (b - a)):02x}" for a, b in pairs)


def _method(name: str) -> str:
    """The method that ``name`` begins with, as a whole word; "" if there is none."""
    lower = name.lower()
    fits = [m for m in METHODS if lower.startswith(m) and not lower[len(m) : len(m) + 1].isalnum()]
    return max(fits, key=len, default="")


def _corners(n: int, turn: float, inner: float = 1.0) -> tuple[tuple[float, float], ...]:
    """Corners of a polygon, the first one ``turn`` of a circle from the top; every second one at radius ``inner``."""
    angles = [2.0 * math.pi * (k / n + turn) for k in range(n)]
    radii = [inner if k % 2 else 1.0 for k in range(n)]
    return tuple((r * math.sin(a), -r * math.cos(a)) for r, a in zip(radii, angles, strict=True))


_PLUS = tuple(
    (x * 1.05, y * 1.05)
    for x, y in (
        *((-0.33, -1), (0.33, -1), (0.33, -0.33), (1, -0.33), (1, 0.33), (0.33, 0.33)),
        *((0.33, 1), (-0.33, 1), (-0.33, 0.33), (-1, 0.33), (-1, -0.33), (-0.33, -0.33)),
    )
)
_HALF = math.sqrt(0.5)

#: mark -> its corners for a radius of 1, y downwards; a circle has none
MARKS: dict[str, tuple[tuple[float, float], ...]] = {
    "circle": (),
    "square": tuple((1.25 * x, 1.25 * y) for x, y in _corners(4, 0.125)),
    "diamond": tuple((1.2 * x, 1.2 * y) for x, y in _corners(4, 0.0)),
    "up": tuple((1.25 * x, 1.25 * y) for x, y in _corners(3, 0.0)),
    "down": tuple((1.25 * x, 1.25 * y) for x, y in _corners(3, 0.5)),
    "left": tuple((1.25 * x, 1.25 * y) for x, y in _corners(3, 0.75)),
    "right": tuple((1.25 * x, 1.25 * y) for x, y in _corners(3, 0.25)),
    "pentagon": tuple((1.15 * x, 1.15 * y) for x, y in _corners(5, 0.0)),
    "hexagon": tuple((1.1 * x, 1.1 * y) for x, y in _corners(6, 0.0)),
    "star": tuple((1.5 * x, 1.5 * y) for x, y in _corners(10, 0.0, 0.45)),
    "plus": _PLUS,
    "cross": tuple((_HALF * (x - y), _HALF * (x + y)) for x, y in _PLUS),
}
