"""Pages, figures and tables as data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mbdsl.plotting.series_styles import Look


@dataclass(frozen=True)
class Series:
    """A sequence of points with one name.

    Attributes
    ----------
    name : str
        Name in the legend.
    x, y : (N,)
        Coordinates; a point with a value that is not finite is a gap.
    low, high : (N,) or None
        Range of y at each point.
    hover : sequence of str or None
        A text for each point.
    style : {"both", "line", "marks", "guide", "front"}
        A line with marks, only one of them, a thin line without texts, or a thick pale line behind all others.
    """

    name: str
    x: Sequence[float]
    y: Sequence[float]
    low: Sequence[float] | None = None
    high: Sequence[float] | None = None
    hover: Sequence[str] | None = None
    style: str = "both"


@dataclass(frozen=True)
class Outcome:
    """A case without a point because it failed or was refused; shown above the frame of the figure.

    Attributes
    ----------
    name : str
        Name of its series.
    x : float or None
    text : str
        The reason.
    """

    name: str
    x: float | None
    text: str


@dataclass(frozen=True)
class Cells:
    """A quantity over two parameters, in the colours of cells."""

    label: str  #: name of the quantity, with its unit
    #: values of the parameters, ascending or descending
    x: Sequence[float]
    y: Sequence[float]
    z: Sequence[Sequence[float]]  #: the quantity, one row for each of ``y``; nan where there is none


@dataclass(frozen=True)
class Figure:
    """A diagram.

    Attributes
    ----------
    key : str
        File name of its picture, without suffix.
    title, x_label, y_label : str
        Texts; labels contain the unit.
    series : sequence of Series
        Points.
    x_log, y_log : bool
        Whether an axis is logarithmic.
    outcomes : sequence of Outcome
        Cases without a point.
    floors : sequence of (float, str)
        Values of y below which points are not significant, and their labels.
    equal : bool
        Whether both axes have one scale.
    note : str
        Its statement, in one or two sentences.
    x_ends, y_ends : (float, float) or None
        Least and greatest value of an axis; default: those of the points. Figures of a page with ``x_ends`` share
        their axis, one below the other.
    aspect : float or None
        Height of the frame over its width.
    like : Figure or None
        A figure whose axes it has.
    cells : Cells or None
        A quantity over both axes, in place of series.
    """

    key: str
    title: str
    x_label: str
    y_label: str
    series: Sequence[Series]
    x_log: bool = True
    y_log: bool = True
    outcomes: Sequence[Outcome] = ()
    floors: Sequence[tuple[float, str]] = ()
    equal: bool = False
    note: str = ""
    x_ends: tuple[float, float] | None = None
    y_ends: tuple[float, float] | None = None
    aspect: float | None = None
    like: Figure | None = None
    cells: Cells | None = None


@dataclass(frozen=True)
class Bar:
    """A value with its text."""

    name: str
    value: float  #: its length; not negative
    text: str  #: shown at its end
    #: range of the value
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class Bars:
    """A bar chart: one value for each name."""

    key: str  #: file name of its picture, without suffix
    #: texts; the label of the values contains the unit
    title: str
    label: str
    bars: Sequence[Bar]  #: from the top
    note: str = ""  #: its statement, in one or two sentences


@dataclass(frozen=True)
class TextTable:
    """A table of texts; columns of numbers are aligned to the right.

    Attributes
    ----------
    title : str
    columns : sequence of str
        Headings.
    rows : sequence of sequence of str
        Cells.
    note : str
        A remark below the table.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


@dataclass(frozen=True)
class Page:
    """A page of text, figures and tables.

    Attributes
    ----------
    title : str
    paragraphs : sequence of str
        Text before the items.
    items : sequence of Figure, Bars or Table
        In their order on the page.
    fine_print : sequence of (str, str)
        Names and values that describe the runs, as required to repeat them.
    looks : mapping
        Name of a series -> its look; the others get theirs in order.
    """

    title: str
    paragraphs: Sequence[str] = ()
    items: Sequence[Figure | Bars | TextTable] = field(default_factory=tuple)
    fine_print: Sequence[tuple[str, str]] = ()
    looks: Mapping[str, Look] = field(default_factory=dict)
