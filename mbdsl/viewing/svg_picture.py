"""One frame of a motion as SVG in a page."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbdsl.plotting.escaping import escape
from mbdsl.viewing.marks import THEME, TextMark
from mbdsl.viewing.picture import Picture
from mbdsl.viewing.projection import drawing
from mbdsl.viewing.tracks import Tracks
from mbdsl.viewing.writers import svg_element

WIDTH, HEIGHT = 860, 430  #: [px]
LETTER, LINE = 8.4, 15.0  #: width of a letter and height of a line of names [px]
NAMED = 24  #: number of bodies up to which their names are written


def still(motion: Tracks, row: int, key: str, title: str, behind: Sequence[int] = (), names: bool = True) -> str:
    """A row of a motion as SVG.

    Parameters
    ----------
    motion : Tracks
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
    picture = Picture(motion, drawing(motion), WIDTH, HEIGHT)
    pale = [f'<g opacity="0.25">{"".join(map(svg_element, picture.mechanism(k)))}</g>' for k in behind]
    marks = [*picture.mechanism(row), *(_names(picture) if names else ())]
    size = f'viewBox="0 0 {WIDTH} {HEIGHT}"'
    head = f'<svg class="still" {size} role="img" aria-labelledby="{key}-title" '
    head += 'stroke-linejoin="round" stroke-linecap="round">'
    head += f'\n<title id="{key}-title">{escape(title)}</title>'
    return "\n".join((head, *pale, *map(svg_element, marks), "</svg>"))


def _names(picture: Picture) -> list[TextMark]:
    """The names of bodies near their centres, each at the first free place around."""
    bodies = picture.motion.scene.bodies()
    found: list[TextMark] = []
    taken: list[tuple[float, float, float]] = []
    for body in bodies if len(bodies) <= NAMED else ():
        x, y, _ = picture.places([picture.motion.spots[f"{body.name}.c"]])[0].tolist()
        if not (np.isfinite(x) and np.isfinite(y)):
            continue
        half, away = 0.5 * LETTER * len(body.name), 0.6 * picture.U + 4.0
        sides = (0.0, -away), (0.0, away + 10.0), (half + away, 4.0), (-half - away, 4.0)
        places = [(x + dx, y + dy) for dx, dy in sides]
        free = (p for p in places if all(abs(p[0] - u) > half + w or abs(p[1] - v) > LINE for u, v, w in taken))
        x, y = next(free, places[0])
        taken.append((x, y, half))
        found.append(TextMark(x, y, body.name, THEME["ink"], LINE, centred=True))
    return found
