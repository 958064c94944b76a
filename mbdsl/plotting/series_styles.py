"""The look of each series: colour, mark and line, the same for a method in all figures and on all pages.

The colour and the mark are those of the method. Steps of fixed size have filled marks and a solid line; controlled
steps have hollow marks and a dashed line. Members of a family have similar colours but different marks, and every
colour has a contrast of at least 3:1 to the paper, light or dark (WCAG 2.1, 1.4.11).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from zlib import crc32

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
DASHED = (5.0, 2.5)  #: for controlled steps
CONTROLLED = "--tol"  #: what the name of a series with controlled steps contains, if its method has both kinds


def controlled(look: Look) -> Look:
    """The look of a method with controlled steps."""
    return replace(look, filled=False, dash=DASHED)


#: looks of methods with fixed steps, or of those that have controlled steps only
METHODS = {
    "newmark": Look("#bf4f97", "#eba0cf", "hexagon"),
    "hht-i3": Look("#2f8fd3", "#8ccbf5", "square"),
    "hht-si2": Look("#0a5fa8", "#4fa3e8", "circle"),
    "hht-add": Look("#3b2c85", "#a79bef", "diamond"),
    "nstiff": Look("#c67500", "#f5b041", "up"),
    "nstiff-si2": Look("#b3360a", "#f07b4b", "down"),
    "generalized-alpha": Look("#7d1d4f", "#d4709f", "pentagon"),
    "generalized-alpha-i3": Look("#b04a80", "#eba6c4", "spark"),
    "radau5": Look("#008a64", "#35c89b", "star"),
    "radau9": Look("#006b4e", "#5fd9b3", "plus"),
    "radau13": Look("#2f7d32", "#7fd07f", "cross"),
    "scipy-dop853": controlled(Look("#7a6a00", "#d2c04a", "plus")),
    "scipy-radau": controlled(Look("#7a6a00", "#d2c04a", "cross")),
    "scipy-lsoda": controlled(Look("#7a6a00", "#d2c04a", "left")),
    "scipy": controlled(Look("#7a6a00", "#d2c04a", "slab")),
    "ida": controlled(Look("#5f6b73", "#aebac2", "right")),
    "exudyn": Look("#111111", "#f2f2f2", "bar"),
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


def method_look(name: str, only_controlled: bool = False) -> Look:
    """The look of a method that :data:`METHODS` does not list: it depends on the name alone."""
    digest = crc32(name.lower().encode())
    marks = tuple(MARKS)
    look = replace(OTHERS[digest % len(OTHERS)], mark=marks[digest // len(OTHERS) % len(marks)])
    return controlled(look) if only_controlled else look


def looks(
    names: Iterable[str], methods: Mapping[str, Look] | None = None, figures: Sequence[Sequence[str]] | None = None
) -> dict[str, Look]:
    """Name -> look.

    A series whose name begins with that of a method has the look of the method. If several series of one figure belong
    to a method with one kind of steps, their colours differ. The others get their looks in order.

    Parameters
    ----------
    names : iterable of str
        Names of series.
    methods : mapping, optional
        Looks of methods in addition to :data:`METHODS`.
    figures : sequence of sequence of str, optional
        The names in each figure; default: all names are in one.
    """
    names = list(dict.fromkeys(names))
    known = {**METHODS, **{name.lower(): look for name, look in (methods or {}).items()}}
    found: dict[str, Look] = {}
    for group in figures if figures is not None else [names]:
        count: dict[Look, int] = {}
        alone = {name: _of_method(name, known) for name in dict.fromkeys(group)}
        # a series that is named as its method keeps the look itself
        for name, look in sorted(alone.items(), key=lambda item: item[0].lower().removesuffix(" --tol") not in known):
            if look is not None:
                found.setdefault(name, _variant(look, count.get(look, 0)))
                count[look] = count.get(look, 0) + 1
    others = [name for name in names if name not in found]
    return {name: found[name] if name in found else _other(others.index(name)) for name in names}


def _of_method(name: str, known: Mapping[str, Look]) -> Look | None:
    """The look of the method that ``name`` begins with, as a whole word."""
    lower = name.lower()
    fits = [m for m in known if lower.startswith(m) and not lower[len(m) : len(m) + 1].isalnum()]
    if not fits:
        return None
    look = known[max(fits, key=len)]
    return controlled(look) if CONTROLLED in lower else look


def _variant(look: Look, k: int) -> Look:
    """The ``k``-th series of a method: other depths of its colour, then other marks as well."""
    turn, depth = divmod(k, 3)
    marks = tuple(MARKS)
    mark = marks[(marks.index(look.mark) + turn) % len(marks)]
    light, dark = _mixed(look.light, "#000000", 0.33 * depth), _mixed(look.dark, "#ffffff", 0.33 * depth)
    return replace(look, light=light, dark=dark, mark=mark)


def _other(k: int) -> Look:
    turn, place = divmod(k, len(OTHERS))
    mark = OTHERS[(place + turn) % len(OTHERS)].mark
    return replace(OTHERS[place], mark=mark, dash=DASHES[turn % len(DASHES)])


def _mixed(colour: str, other: str, part: float) -> str:
    pairs = ((int(c[k : k + 2], 16) for c in (colour, other)) for k in (1, 3, 5))
    return "#" + "".join(f"{round(a + part * (b - a)):02x}" for a, b in pairs)


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
    "spark": tuple((1.5 * x, 1.5 * y) for x, y in _corners(8, 0.0, 0.38)),
    "slab": ((-1.3, -0.6), (1.3, -0.6), (1.3, 0.6), (-1.3, 0.6)),
    "bar": ((-0.6, -1.3), (0.6, -1.3), (0.6, 1.3), (-0.6, 1.3)),
    "plus": _PLUS,
    "cross": tuple((_HALF * (x - y), _HALF * (x + y)) for x, y in _PLUS),
}
