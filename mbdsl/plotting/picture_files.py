"""Files of matplotlib: PNG, SVG and PDF, the same bytes for the same content, with the fonts embedded."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, BinaryIO

from mbdsl.errors import UsageError
from mbdsl.messages import install
from mbdsl.plotting.series_styles import LIGHT_PAPER

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLE: dict[str, Any] = {
    "svg.hashsalt": "mbdsl",
    "svg.fonttype": "path",
    "pdf.fonttype": 42,  # TrueType: texts can be searched and copied
    "text.parse_math": False,  # names are not formulas: a $ is shown as such
}
#: times and versions, which would differ from run to run
METADATA: dict[str, dict[str, None]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}


@contextmanager
def drawn(
    stream: BinaryIO,
    suffix: str,
    size: tuple[float, float],
    dpi: float,
    style: Mapping[str, Any],
    instead: str = "",
    **given: Any,
) -> Iterator[Figure]:
    """An empty figure of matplotlib, which is written to a stream when the block ends.

    Parameters
    ----------
    stream : binary stream
        Where it is written.
    suffix : {".png", ".svg", ".pdf"}
        The format.
    size : (float, float) [inch]
        Width and height.
    dpi : float
        Pixels per inch of a PNG.
    style : mapping
        Settings of matplotlib, in addition to ``STYLE``.
    instead : str, optional
        Formats that need no matplotlib, for the error message: ".svg and .html".
    **given
        Further arguments of the figure.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    try:
        import matplotlib.figure
        import matplotlib.style
        from matplotlib.backends.backend_agg import FigureCanvasAgg
    except ImportError as problem:
        hint = install("plot") + (f"; {instead} need no further package" if instead else "")
        what = "PNG and PDF files" if instead else "pictures"
        raise UsageError(f"matplotlib, which draws {what}, is not installed", hint=hint) from problem
    with matplotlib.style.context(["default", {**STYLE, **style}]):
        figure = matplotlib.figure.Figure(figsize=size, facecolor=LIGHT_PAPER, **given)
        FigureCanvasAgg(figure)
        yield figure
        figure.savefig(stream, format=suffix[1:], dpi=dpi, metadata=METADATA[suffix])
