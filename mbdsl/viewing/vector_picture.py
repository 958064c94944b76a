"""One frame of a motion with its overlays as lines and areas, written as SVG or, by matplotlib, as PDF."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.plotting.escaping import escape
from mbdsl.plotting.picture_files import drawn
from mbdsl.plotting.series_styles import LIGHT_PAPER
from mbdsl.viewing.overlays import colour_bar
from mbdsl.viewing.picture import GHOST, Picture
from mbdsl.viewing.pixels import INK, Point, mixed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LETTERS = {"font.family": ["DejaVu Sans"]}


@dataclass(frozen=True)
class Shape:
    """Closed or open lines in pixels, or a text at the first point; y is down."""

    parts: tuple[tuple[Point, ...], ...]
    fill: str | None = None
    stroke: str | None = None
    width: float = 0.0
    closed: bool = True
    text: str = ""


class VectorPicture(Picture):
    """Collects the shapes of a frame instead of drawing pixels."""

    shapes_drawn: list[Shape]

    def collected(self, row: int) -> list[Shape]:
        """The shapes of a row of the motion, those of another motion behind it first."""
        self.shapes_drawn, found = [], []
        if (ghost := self.ghost) is not None:
            behind = VectorPicture.__new__(VectorPicture)
            behind.__dict__.update(ghost.__dict__)
            behind.shapes_drawn = []
            at = np.searchsorted(ghost.motion.t, self.motion.t[row], side="right") - 1
            behind.shown(max(0, int(at)))
            found = [replace(s, fill=_pale(s.fill), stroke=_pale(s.stroke)) for s in behind.shapes_drawn]
        self.shown(row)
        self.overlays.draw(self)
        if self.strain:
            colour_bar(self, self.colours[self.motion.curves[0].body], self.strain)
        return [*found, *self.shapes_drawn]

    # -- primitives ----------------------------------------------------------------------------------------------
    def line(self, points: Iterable[Point], width: float, colour: str) -> None:
        found = tuple((float(x), float(y)) for x, y in points if np.isfinite(x) and np.isfinite(y))
        if len(found) > 1:
            self.shapes_drawn.append(Shape((found,), None, colour, width, closed=False))

    def area(self, points: Iterable[Point], fill: str, outline: str = INK, width: float | None = None) -> None:
        found = tuple((float(x), float(y)) for x, y in points)
        if np.isfinite(found).all():
            self.shapes_drawn.append(Shape((found,), fill, outline, self.thin if width is None else width))

    def areas(self, parts: Sequence[Sequence[Point]], fill: str) -> None:
        if all(np.isfinite(part).all() for part in parts):
            self.shapes_drawn.append(Shape(tuple(tuple((float(x), float(y)) for x, y in p) for p in parts), fill))

    def circle(self, at: Sequence[float], radius: float, fill: str | None, outline: str = INK, width=None) -> None:
        x, y = at[:2]
        if np.isfinite(x) and np.isfinite(y):
            turn = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
            points = tuple(zip((x + radius * np.cos(turn)).tolist(), (y + radius * np.sin(turn)).tolist(), strict=True))
            self.shapes_drawn.append(Shape((points,), fill, outline, width or self.thin))

    def label(self, at: Point, text: str, colour: str, size: float) -> None:
        self.shapes_drawn.append(Shape(((at,),), colour, None, size, text=text))


def _pale(colour: str | None) -> str | None:
    """The colour of a motion behind the first."""
    return None if colour is None else mixed(LIGHT_PAPER, colour, GHOST)


def content(picture: VectorPicture, suffix: str) -> bytes:
    """The first row of a motion as the content of a file.

    Parameters
    ----------
    picture : VectorPicture
        The picture.
    suffix : {".svg", ".pdf"}
        The format.

    Returns
    -------
    bytes

    Raises
    ------
    UsageError
        If matplotlib is not installed (.pdf).
    """
    shapes, (width, height) = picture.collected(0), picture.size
    if suffix == ".svg":
        head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
        head += f'height="{height}" stroke-linejoin="round" stroke-linecap="round">'
        paper = f'<rect width="100%" height="100%" fill="{LIGHT_PAPER}"/>'
        return "\n".join((head, paper, *map(_element, shapes), "</svg>\n")).encode()
    stream = io.BytesIO()
    with drawn(stream, suffix, (width / 96, height / 96), 96.0, LETTERS, ".svg and .html") as figure:
        ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        ax.set(xlim=(0.0, width), ylim=(height, 0.0))
        ax.set_axis_off()
        for shape in shapes:
            _draw(ax, shape)
    return stream.getvalue()


def _element(shape: Shape) -> str:
    if shape.text:
        x, y = shape.parts[0][0]
        look = f'fill="{shape.fill}" font-size="{shape.width:g}" font-family="system-ui, sans-serif"'
        return f'<text x="{x:.1f}" y="{y:.1f}" dominant-baseline="central" {look}>{escape(shape.text)}</text>'
    end = "Z" if shape.closed else ""
    ways = "".join("M" + "L".join(f"{x:.2f} {y:.2f}" for x, y in part) + end for part in shape.parts)
    look = f'fill="{shape.fill or "none"}" fill-rule="evenodd"'
    look += f' stroke="{shape.stroke}" stroke-width="{shape.width:.2f}"' if shape.stroke else ""
    return f'<path {look} d="{ways}"/>'


def _draw(ax: Axes, shape: Shape) -> None:
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    if shape.text:
        ax.text(*shape.parts[0][0], shape.text, color=shape.fill, fontsize=0.72 * shape.width, va="center")
        return
    ways = []
    for part in shape.parts:
        points = [*part, part[0]] if shape.closed else list(part)
        codes = [Path.MOVETO, *[Path.LINETO] * (len(part) - 1), *([Path.CLOSEPOLY] if shape.closed else [])]
        ways.append(Path(points, codes))
    patch = PathPatch(
        Path.make_compound_path(*ways),
        facecolor=shape.fill or "none",
        edgecolor=shape.stroke or "none",
        linewidth=0.75 * shape.width,
        capstyle="round",
        joinstyle="round",
    )
    ax.add_patch(patch)
