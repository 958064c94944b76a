"""What a page shows, as data: figures, tables and text. Nothing here draws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Series:
    """Points with one name, in order: a line with marks, or only one of both.

    ``low`` and ``high`` are the spread of y, point by point. ``hover`` says more about each point. A point that is not
    a finite number is a gap.
    """

    name: str
    x: Sequence[float]
    y: Sequence[float]
    low: Sequence[float] | None = None
    high: Sequence[float] | None = None
    hover: Sequence[str] | None = None
    style: str = "both"  #: "both", "line", "marks"; "guide": a thin line, no hover; "front": thick, pale, behind


@dataclass(frozen=True)
class Outcome:
    """What has no point because it failed, or was refused: shown at its x, at the edge of the figure."""

    name: str  #: of the series that it belongs to
    x: float | None
    text: str


@dataclass(frozen=True)
class Figure:
    """Axes and what is in them.

    ``floors`` are (y, what is not to be told below it); what is far below is told in words.
    """

    key: str  #: file name of its picture, without suffix
    title: str
    x_label: str
    y_label: str
    series: Sequence[Series]
    x_log: bool = True
    y_log: bool = True
    outcomes: Sequence[Outcome] = ()
    floors: Sequence[tuple[float, str]] = ()
    equal: bool = False  #: one scale for both axes
    note: str = ""  #: what it says, in a sentence or two


@dataclass(frozen=True)
class Table:
    """Cells as they are to be read; columns of numbers are set to the right."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


@dataclass(frozen=True)
class Page:
    """A title, paragraphs, and the figures and tables in their order."""

    title: str
    paragraphs: Sequence[str] = ()
    items: Sequence[Figure | Table] = field(default_factory=tuple)
    fine_print: Sequence[tuple[str, str]] = ()  #: what a run can be repeated by: (name, value)
