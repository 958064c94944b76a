"""Text from models, names and arguments as a terminal or a page can show it safely.

A model may hold escape sequences that clear a screen or write into a clipboard, overrides of the writing direction
that make a line read as another one, and characters without a width. All of them are shown by their escapes, ``\\x1b``
or ``\\u202e``; everything else stays as it is.
"""

from __future__ import annotations

import unicodedata


def visible(text: str, line: bool = False) -> str:
    """``text`` with every control and format character escaped; line ends and tabs stay unless it is to be one line."""
    if text.isprintable():
        return text
    kept = "" if line else "\n\t"
    return "".join(c if c.isprintable() or c in kept or _blank(c) else escape(c) for c in text)


def escape(c: str) -> str:
    """One character by its escape."""
    return c.encode("unicode_escape").decode()


def width(text: str) -> int:
    """Columns that a text takes on a terminal."""
    if text.isascii():
        return len(text)
    return sum(0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in text)


def _blank(c: str) -> bool:
    """Spaces of all widths, which str.isprintable() does not count in; no line ends, no control characters."""
    return unicodedata.category(c) == "Zs"
