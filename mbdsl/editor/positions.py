"""Places in a text: offsets of characters here, lines and UTF-16 or UTF-8 columns in the protocol of editors."""

from __future__ import annotations

import re
from bisect import bisect_right

from mbdsl.errors import Span

#: ends of lines in the protocol
_END = re.compile(r"\r\n|\n|\r")


class Places:
    """Conversions for one text.

    Parameters
    ----------
    text : str
        The text.
    encoding : str
        Unit of columns, "utf-8", "utf-16" or "utf-32", as the client has chosen.
    """

    def __init__(self, text: str, encoding: str = "utf-16") -> None:
        self.text = text
        self._codec = encoding + ("-le" if encoding != "utf-8" else "")
        self._size = {"utf-8": 1, "utf-16": 2, "utf-32": 4}[encoding]
        ends = [(m.start(), m.end()) for m in _END.finditer(text)]
        self._starts = [0, *(end for _, end in ends)]
        self._ends = [*(start for start, _ in ends), len(text)]

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column, from 0, of an offset; an offset after the text is its end."""
        offset = max(0, min(offset, len(self.text)))
        line = bisect_right(self._starts, offset) - 1
        return line, self._length(self.text[self._starts[line] : offset])

    def offset(self, line: int, column: int) -> int:
        """The offset of a position; a column after the line is its end, a line after the text the end of the text."""
        if line >= len(self._starts):
            return len(self.text)
        start, end = self._starts[max(line, 0)], self._ends[max(line, 0)]
        content = self.text[start:end]
        if self._length(content) <= column:
            return end
        # A column inside a character that has several units is its start.
        units = content.encode(self._codec, "surrogatepass")[: max(column, 0) * self._size]
        return start + len(units.decode(self._codec, "ignore"))

    def _length(self, part: str) -> int:
        if part.isascii():
            return len(part)
        return len(part.encode(self._codec, "surrogatepass")) // self._size

    def of_span(self, span: Span) -> tuple[int, int]:
        """Start and end offsets of a place in a message, whose lines end with a line feed only."""
        start = -1
        for _ in range(span.line - 1):
            start = self.text.find("\n", start + 1)
            if start < 0:
                return len(self.text), len(self.text)
        start = min(start + span.column, len(self.text))
        return start, min(start + span.length, len(self.text))
