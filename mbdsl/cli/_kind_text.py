"""A kind of element as text for a terminal: its frames, parameters and signals."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from mbdsl.elements.kind import Kind
from mbdsl.lang.kind_reference import default_of, notes, unit_of
from mbdsl.plotting.terminal_text import text_width

COLUMNS = 80


def kind_text(kind: Kind) -> str:
    """Tables of the parameters and signals of a kind."""
    lines = textwrap.wrap(f"{kind.name}: {kind.doc}", text_width(COLUMNS))
    if kind.ports:
        ports = [f"{p} (may be left out)" if p in kind.optional_ports else p for p in kind.ports]
        lines += ["", f"frames: {', '.join(ports)}"]
    parameters = [(p.name, unit_of(p), default_of(p), notes(kind, p).replace("`", "")) for p in kind.parameters]
    if parameters:
        lines += ["", *_table(("parameter", "unit", "default", ""), parameters)]
    signals = [(x.name, x.unit, x.doc) for x in kind.signals]
    signals += [(x.name, x.unit, x.doc) for x in kind.outputs]
    if signals:
        lines += ["", *_table(("signal", "unit", ""), signals)]
    return "\n".join(lines)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Aligned columns; the last one is wrapped."""
    *wide, _ = (max(map(len, column)) for column in zip(head, *rows, strict=True))
    lines = []
    for row in (head, *rows):
        start = "  " + "".join(f"{text:{width}}  " for text, width in zip(row, wide, strict=False))
        indent = " " * len(start)
        lines += textwrap.wrap(start + row[-1], text_width(COLUMNS), subsequent_indent=indent)
    return lines
