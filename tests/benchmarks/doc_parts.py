"""Parts of pages that benchmarks write: in the page they stand between ``<!-- name -->`` and ``<!-- end -->``.

A part is a table or paragraphs in lines of their own, or a number within a sentence.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).parents[2]
WIDTH = 120  #: characters of a line of a page


def parts_of(page: Path) -> list[str]:
    """The names of the parts of a page."""
    return [name for name in re.findall(r"<!-- ([^\n]+?) -->", page.read_text(encoding="utf-8")) if name != "end"]


def put(page: Path, texts: Mapping[str, str]) -> None:
    """Replace parts of a page.

    Raises
    ------
    ValueError
        If the page has no part of that name, or several.
    """
    found = page.read_text(encoding="utf-8")
    for name, text in texts.items():
        start = f"<!-- {name} -->"
        if found.count(start) != 1:
            raise ValueError(f"{page.name} has {found.count(start)} parts `{start}`, expected one")
        before, rest = found.split(start)
        old, end, after = rest.partition("<!-- end -->")
        if not end:
            raise ValueError(f"{page.name}: found no `<!-- end -->` after `{start}`")
        lines = old.startswith("\n")
        found = f"{before}{start}" + (f"\n\n{text}\n\n" if lines else text) + f"{end}{after}"
    page.write_text(found, encoding="utf-8")


def markdown(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of a page."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def filled(text: str) -> str:
    """A paragraph, or an item of a list, in lines of a page."""
    indent = "  " if text.startswith("- ") else ""
    return textwrap.fill(text, WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def spread(values: Sequence[float], digits: int = 1, word: str = "to") -> str:
    """ "0.07 to 0.17": the least and the largest value, rounded to significant digits."""
    low, high = (rounded(f(values), digits) for f in (min, max))
    return low if low == high else f"{low} {word} {high}"


def rounded(x: float, digits: int = 2) -> str:
    """A number with significant digits and without an exponent: 0.07, 3.5, 2,000."""
    return f"{float(f'{x:.{digits}g}'):,.10g}"
