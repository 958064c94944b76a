"""A plot in characters, for terminals: braille dots, or ASCII where the encoding has no braille."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Iterator
from itertools import groupby

from mbdsl.messages import visible, width
from mbdsl.plotting.axes import Axis, axis
from mbdsl.plotting.figure_layout import Drawn, PlotArea, lay_out
from mbdsl.plotting.figures import Figure, Page

COLUMNS = 80  #: width where there is no terminal
NARROWEST = 40
TALLEST, LOWEST = 16, 5  #: lines of a frame
DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  #: braille dots by row and column (Unicode, U+2800)
COLOURS = (36, 33, 32, 35, 34, 31, 96, 93)  #: SGR parameters of the foreground (ECMA-48, 8.3.117)
LETTERS = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
APART = 14  #: columns between two letters on a curve
LEGEND = 8  #: largest number of lines of a legend
PLAIN = str.maketrans(
    {"─": "-", "│": "|", "└": "+", "┤": "+", "┴": "+", "┬": "+", "−": "-", "×": "x", "·": "*", "…": "~", "²": "^2"}
    | dict(zip("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789", strict=True))
    | {"\u202f": " "}
)


def text(page: Page, columns: int = COLUMNS, lines: int = 0, colour: bool = False, ascii_only: bool = False) -> str:
    """The plot in characters.

    Parameters
    ----------
    page : Page
        The plot; its paragraphs are below the figures.
    columns : int, optional
        Width of the lines.
    lines : int, optional
        Number of lines that should not be exceeded; 0 for any number.
    colour : bool, optional
        Whether curves differ by colours; otherwise by letters on them.
    ascii_only : bool, optional
        Whether only ASCII characters are used.

    Returns
    -------
    str
        Lines, without a line end after the last.
    """
    columns = max(columns, NARROWEST)
    height, figures = TALLEST, [item for item in page.items if isinstance(item, Figure)]
    if lines:
        rest = lines - 2 - len(page.paragraphs) - 4 * len(figures)
        height = max(LOWEST, min(TALLEST, rest // max(len(figures), 1)))
    frames = [lay_out(figure, page.looks) for figure in figures if figure.cells is None]
    drawn = [_Panel(frame, columns, height, colour, ascii_only) for frame in frames]
    margin = max((panel.margin for panel in drawn), default=0)
    found = [_fitting(page.title, columns)] if page.title else []
    for k, panel in enumerate(drawn):
        found += panel.lines(margin, last=k == len(drawn) - 1)
    for figure in figures:
        if figure.cells is not None:
            where = f", {figure.title}" if figure.title else ""
            found.append(f"map of {figure.cells.label} over {figure.x_label} and {figure.y_label}{where}")
    found += [line for note in page.paragraphs for line in textwrap.wrap(visible(note), columns)]
    whole = "\n".join(line.rstrip() for line in found)
    return whole.translate(PLAIN).encode("ascii", "backslashreplace").decode() if ascii_only else whole


class _Panel:
    """A panel: its frame in characters, with labels and legend."""

    def __init__(self, frame: PlotArea, columns: int, height: int, colour: bool, ascii_only: bool) -> None:
        figure = frame.figure
        self.frame, self.figure, self.columns, self.height = frame, figure, columns, height
        self.colour, self.ascii = colour, ascii_only
        self.y = _sparser(frame.y, max(2, height // 3))
        self.margin = 1 + max((width(label) for _, label in self.y.ticks), default=1)
        self.letters = len(frame.drawn) > 1 and not colour

    def lines(self, margin: int, last: bool) -> Iterator[str]:
        size = self.columns - margin - 2
        yield from self._legend()
        cells = self._cells(size)
        marks = {min(self.height - 1, int((1.0 - p) * self.height)): label for p, label in self.y.ticks}
        for j, row in enumerate(cells):
            label = marks.get(j, "")
            side = "┤" if j in marks else "│"
            yield " " * (margin - width(label)) + label + side + row
        yield from self._foot(margin, size, last)

    def _foot(self, margin: int, size: int, last: bool) -> Iterator[str]:
        x = _sparser(self.frame.x, max(2, size // 12))
        places = [(min(size - 1, int(p * size)), label) for p, label in x.ticks]
        rule = ["─"] * size
        for place, _ in places:
            rule[place] = "┴" if not last else "┬"
        yield " " * margin + "└" + "".join(rule)
        if not last:
            return
        line = [" "] * (margin + size + 2)
        free = 0
        for place, label in places:
            start = min(max(margin + 1 + place - width(label) // 2, 0), len(line) - width(label))
            if start >= free:
                line[start : start + len(label)] = label
                free = start + len(label) + 1
        yield "".join(line)
        yield " " * (margin + 1) + _fitting(x.titled(self.figure.x_label), size).center(size)

    def _legend(self) -> Iterator[str]:
        """The label of the vertical axis, and the names with their samples."""
        label = _fitting(self.y.titled(self.figure.y_label), self.columns)
        drawn = self.frame.drawn
        if len(drawn) == 1 and self.figure.y_label.startswith(drawn[0].series.name):
            yield self._painted(label, 0)
            return
        entries = []
        for k, one in enumerate(drawn):
            name = _fitting(one.series.name, self.columns - 6)
            sample = LETTERS[k % len(LETTERS)] if self.letters else ("*" if self.ascii else "⠒⠒")
            if self.colour and one.look.dash:
                sample = "*" if self.ascii else "⠂⠂"
            entries.append((self._painted(sample, k) + " " + name, width(sample) + 1 + width(name)))
        line, used, shown, rows = label, width(label), 0, 1
        for entry, length in entries:
            if used + 3 + length > self.columns:
                if rows == LEGEND:
                    break
                yield line
                line, used, rows = "  " + entry, 2 + length, rows + 1
            else:
                line, used = line + "   " + entry, used + 3 + length
            shown += 1
        yield line
        if shown < len(entries):
            yield f"  ... ({len(entries)} in all)"

    def _painted(self, text: str, k: int) -> str:
        return f"\x1b[{COLOURS[self._hue(k)]}m{text}\x1b[0m" if self.colour else text

    def _hue(self, k: int) -> int:
        """The colour of a curve: curves of one signal, which have the same look but for dashes, share it."""
        hues = list(dict.fromkeys(drawn.look.light for drawn in self.frame.drawn))
        return hues.index(self.frame.drawn[k].look.light) % len(COLOURS)

    def _cells(self, size: int) -> list[str]:
        """The rows of the frame."""
        dots, owner = [[0] * size for _ in range(self.height)], [[-1] * size for _ in range(self.height)]
        signs: dict[tuple[int, int], str] = {}
        for k, drawn in enumerate(self.frame.drawn):
            visited = dict.fromkeys(_dots(drawn, 2 * size, 4 * self.height))
            for x, y in visited:
                if self.colour and drawn.look.dash and (x // 2) % 2:
                    continue  # another result: dashed
                row, column = self.height - 1 - y // 4, x // 2
                dots[row][column] |= DOTS[3 - y % 4][x % 2]
                owner[row][column] = k
            if self.letters:
                cells = dict.fromkeys((self.height - 1 - y // 4, x // 2) for x, y in visited)
                _put_letters(signs, k, cells, size, dense=self.ascii)
        blank = "*" if self.ascii else ""
        return [
            "".join(
                self._painted("".join(signs.get((j, i), blank or chr(0x2800 + dots[j][i])) for i in run), k)
                if k >= 0
                else " " * len(run)
                for k, run in _runs(owner[j])
            )
            for j in range(self.height)
        ]


def _fitting(text: str, columns: int) -> str:
    """A text on one line with control characters escaped, shortened to a width."""
    text = visible(text, line=True)
    if width(text) <= columns:
        return text
    while width(text) > columns - 1:
        text = text[:-1]
    return f"{text}…"


def _runs(owners: list[int]) -> Iterator[tuple[int, list[int]]]:
    """Neighbouring cells with the same curve."""
    for k, run in groupby(range(len(owners)), key=lambda i: owners[i]):
        yield k, list(run)


def _put_letters(
    signs: dict[tuple[int, int], str], k: int, cells: Iterable[tuple[int, int]], size: int, dense: bool
) -> None:
    """Letters on the cells of a curve: on all of them, or some columns apart and shifted from curve to curve."""
    wanted = None
    for row, column in cells:
        if dense:
            signs.setdefault((row, column), LETTERS[k % len(LETTERS)])
        elif (wanted is None and column % APART == (5 * k + 3) % APART) or (wanted is not None and column == wanted):
            if (row, column) not in signs:
                signs[row, column] = LETTERS[k % len(LETTERS)]
                wanted = column + APART if column + APART < size else -1


def _dots(drawn: Drawn, columns: int, rows: int) -> Iterator[tuple[int, int]]:
    """The dots of a curve, counted from the left and from the bottom; segments are divided into steps of one dot."""
    before = None
    for x, y in zip(drawn.x, drawn.y, strict=True):
        if math.isnan(x) or math.isnan(y):
            before = None
            continue
        here = x * columns, y * rows
        if before is None:
            before = here
        steps = int(max(abs(here[0] - before[0]), abs(here[1] - before[1]))) + 1
        if steps > 4 * (columns + rows):  # far outside the frame
            steps = 4 * (columns + rows)
        for s in range(1, steps + 1):
            a = before[0] + (here[0] - before[0]) * s / steps
            b = before[1] + (here[1] - before[1]) * s / steps
            if -1e-9 <= a <= columns + 1e-9 and -1e-9 <= b <= rows + 1e-9:
                yield min(int(max(a, 0.0)), columns - 1), min(int(max(b, 0.0)), rows - 1)
        before = here


def _sparser(found: Axis, wanted: int) -> Axis:
    """The axis with about ``wanted`` labels."""
    return axis(found.low, found.high, found.log, wanted)
