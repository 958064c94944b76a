"""Text on a terminal: its width, wrapped lines, colours.

Only text that is written to a terminal is wrapped. In a pipe or a file each message remains one line, and each row of
a table has the same form at any width, so that scripts can rely on them. Colours follow https://no-color.org:
``NO_COLOR`` switches them off, ``FORCE_COLOR`` switches them on in pipes as well, and a terminal with ``TERM=dumb`` has
none.
"""

from __future__ import annotations

import os
import re
import sys
from contextlib import suppress
from typing import Protocol

from mbdsl.messages import width

#: columns of a terminal that does not report them, and the smallest number to which text is wrapped
USUAL, LEAST = 80, 40
#: part of the width that the last column of a list must have, so that its text is continued below itself
ROOM = 0.4
RED, YELLOW, CYAN, GREEN, BOLD, PLAIN = ("\x1b[1;31m", "\x1b[33m", "\x1b[36m", "\x1b[1;32m", "\x1b[1m", "\x1b[0m")
SEVERITY = {"error": RED, "warning": YELLOW, "note": CYAN}
#: a command to be copied, which is not wrapped
COMMAND = re.compile(r"  (mbdsl|pip) ")
LAST_COLUMN = re.compile(r".*\S {2,}(?=\S)")
MESSAGE = re.compile(r"(\S.*?:\d+:\d+: )?((?:internal )?(error|warning|note): )")
CARETS = re.compile(r" {4}[ \t]*\^+")
HINT = "  = "


class Output(Protocol):
    """A text stream, as far as it shows whether it writes to a terminal."""

    def isatty(self) -> bool: ...

    def fileno(self) -> int: ...


def columns(stream: Output, least: int = LEAST) -> int | None:
    """The width of the terminal that a stream writes to, at least ``least``; None if it writes to something else."""
    if not stream.isatty():
        return None
    if not os.environ.get("COLUMNS", "").isdecimal():
        with suppress(OSError, ValueError, AttributeError):  # shutil looks at standard output only
            if found := os.get_terminal_size(stream.fileno()).columns:
                return max(least, found)
    import shutil  # the import takes longer than the output of most commands

    return max(least, shutil.get_terminal_size((USUAL, 24)).columns)


def text_width(usual: int) -> int:
    """The width of the terminal to which standard output goes, or ``usual`` if it goes elsewhere."""
    return columns(sys.stdout) or usual


def coloured(stream: Output) -> bool:
    """Whether text on a stream has colours."""
    if os.environ.get("NO_COLOR"):
        return False
    if (forced := os.environ.get("FORCE_COLOR", "")) and forced != "0":
        return True
    known = os.name != "nt" or any(name in os.environ for name in ("WT_SESSION", "ANSICON", "TERM", "TERM_PROGRAM"))
    return known and stream.isatty() and os.environ.get("TERM") != "dumb"


def wrapped(line: str, size: int) -> list[str]:
    """A line in pieces of at most ``size`` columns.

    They are indented by two more than the line or, in a list with several columns, as its last column. Words are not
    broken, and neither are commands, which can then be copied.
    """
    if width(line) <= size or COMMAND.search(line):
        return [line]
    indent = len(line) - len(line.lstrip()) + 2
    if (last := LAST_COLUMN.match(line)) and last.end() <= (1.0 - ROOM) * size:
        indent = last.end()
    more = " " * indent
    import textwrap

    return textwrap.wrap(line, size, subsequent_indent=more, break_long_words=False, break_on_hyphens=False)


def painted(pieces: list[str]) -> list[str]:
    """The pieces of a line of a message with colours: severity and place, carets, remedy."""
    first, *rest = pieces
    if found := MESSAGE.match(first):
        place, severity = found[1] or "", found[2]
        where = f"{BOLD}{place}{PLAIN}" if place else ""
        return [f"{where}{SEVERITY[found[3]]}{severity}{PLAIN}{first[found.end() :]}", *rest]
    if CARETS.fullmatch(first):
        return [f"{GREEN}{first}{PLAIN}"]
    if first.startswith(HINT):
        return [f"{CYAN}{piece}{PLAIN}" for piece in pieces]
    return pieces


def fitted(rows: list[list[str]], size: int, flexible: int) -> list[list[str]]:
    """Rows of a table whose column ``flexible`` is wrapped so that a line has at most ``size`` columns.

    A row becomes as many rows as its text has pieces; the other cells are in the first of them.
    """
    import textwrap

    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    room = size - sum(widths) + widths[flexible] - 2 * (len(widths) - 1)
    found = []
    for row in rows:
        pieces = textwrap.wrap(row[flexible], max(1, room), break_on_hyphens=False) or [""]
        for k, piece in enumerate(pieces):
            found.append([piece if j == flexible else cell if k == 0 else "" for j, cell in enumerate(row)])
    return found
