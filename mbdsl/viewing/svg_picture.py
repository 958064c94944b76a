"""One frame of a motion as SVG: the shapes of the film, drawn as lines and areas."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from mbdsl.plotting.escaping import escape
from mbdsl.viewing.motion import Motion
from mbdsl.viewing.picture import Picture
from mbdsl.viewing.pixels import INK, Point
from mbdsl.viewing.shapes import Drawing, drawing

WIDTH, HEIGHT = 860, 430  #: [px]
LETTER, LINE = 8.4, 15.0  #: width of a letter and height of a line of names [px]
NAMED = 24  #: number of bodies up to which their names are written


class SvgPicture(Picture):
    """Draws frames of a motion as elements of SVG, all in the same view."""

    def __init__(self, motion: Motion, drawing: Drawing, width: int = WIDTH, height: int = HEIGHT) -> None:
        super().__init__(motion, drawing, width, height)
        self.parts: list[str] = []

    def elements(self, row: int) -> list[str]:
        """The mechanism in a row of the motion."""
        self.parts = []
        self.shown(row)
        return self.parts

    def names(self, row: int) -> list[str]:
        """The names of bodies near their centres, each at the first free place around."""
        self.row = row
        bodies = self.motion.scene.bodies()
        if len(bodies) > NAMED:
            return []
        found: list[str] = []
        taken: list[tuple[float, float, float]] = []
        for body in bodies:
            x, y, _ = self.place(self.motion.spots[f"{body.name}.c"])
            if not (np.isfinite(x) and np.isfinite(y)):
                continue
            half, away = 0.5 * LETTER * len(body.name), 0.6 * self.U + 4.0
            sides = (0.0, -away), (0.0, away + 10.0), (half + away, 4.0), (-half - away, 4.0)
            places = [(x + dx, y + dy) for dx, dy in sides]
            free = (p for p in places if all(abs(p[0] - u) > half + w or abs(p[1] - v) > LINE for u, v, w in taken))
            x, y = next(free, places[0])
            taken.append((x, y, half))
            found.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="middle">{escape(body.name)}</text>')
        return found

    # -- primitives ----------------------------------------------------------------------------------------------
    def line(self, points: Iterable[Point], width: float, colour: str) -> None:
        found = [(x, y) for x, y in points if np.isfinite(x) and np.isfinite(y)]
        if len(found) > 1:
            self.parts.append(
                f'<path fill="none" stroke="{escape(colour)}" stroke-width="{width:.2f}" d="{_way(found)}"/>'
            )

    def area(self, points: Iterable[Point], fill: str, outline: str = INK, width: float | None = None) -> None:
        found = list(points)
        if np.isfinite(found).all():
            width = self.thin if width is None else width
            look = f'fill="{fill}" stroke="{outline}" stroke-width="{width:.2f}"'
            self.parts.append(f'<path {look} d="{_way(found)}Z"/>')

    def areas(self, parts: Sequence[Sequence[Point]], fill: str) -> None:
        if all(np.isfinite(part).all() for part in parts):
            ways = "".join(f"{_way(part)}Z" for part in parts)
            self.parts.append(f'<path fill="{escape(fill)}" fill-rule="evenodd" d="{ways}"/>')

    def circle(self, at: Sequence[float], radius: float, fill: str | None, outline: str = INK, width=None) -> None:
        x, y = at[:2]
        if np.isfinite(x) and np.isfinite(y):
            look = f'fill="{fill or "none"}" stroke="{outline}" stroke-width="{width or self.thin:.2f}"'
            self.parts.append(f'<circle {look} cx="{x:.2f}" cy="{y:.2f}" r="{radius:.2f}"/>')


def _way(points: Sequence[Point]) -> str:
    return "M" + "L".join(f"{x:.2f} {y:.2f}" for x, y in points)


def still(motion: Motion, row: int, key: str, title: str, behind: Sequence[int] = (), names: bool = True) -> str:
    """A row of a motion as SVG.

    Parameters
    ----------
    motion : Motion
        The motion, all of which is in the view.
    row : int
        The row that is shown.
    key : str
        Beginning of its ids.
    title : str
        Title for screen readers.
    behind : sequence of int, optional
        Rows that are drawn pale behind it.
    names : bool, optional
        Whether to write the names of bodies.

    Returns
    -------
    str
        ``<svg>``, without a background.
    """
    found = SvgPicture(motion, drawing(motion))
    pale = [f'<g opacity="0.25">{"".join(found.elements(k))}</g>' for k in behind]
    shown = [*pale, *found.elements(row), *(found.names(row) if names else ())]
    size = f'viewBox="0 0 {WIDTH} {HEIGHT}"'
    head = f'<svg class="still" {size} role="img" aria-labelledby="{key}-title" '
    head += 'stroke-linejoin="round" stroke-linecap="round">'
    return "\n".join((head, f'<title id="{key}-title">{escape(title)}</title>', *shown, "</svg>"))
