"""The receipt of a scene as text: a table of its effects, the code, the reductions, and the outputs."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from mbdsl.messages import count, few
from mbdsl.plotting.terminal_text import columns, fitted

if TYPE_CHECKING:
    from mbdsl.explanation.receipt import Receipt

#: columns for the reasons, below which each effect is a line instead of the row of a table
LEAST_REASON = 24


def text(r: Receipt) -> str:
    """The receipt as text; if it is wider than the terminal, with shorter places and wrapped reasons."""
    rows, size = cells(r), columns(sys.stdout)
    widths = [max(len(row[k]) for row in rows) for k in range(5)]
    total, others = sum(widths) + 8, sum(widths) - widths[2] + 8
    if size is None or total <= size:
        return "\n".join([*head(r), "", *_aligned(rows), *remarks(r)])
    file = next((e.span.file for e in r.entries if e.span is not None), "")
    title, *lines = head(r)
    title = title.replace(":", f" ({file}):", 1) if file else title
    rows = cells(r, file)
    if size - others >= LEAST_REASON:
        table = _aligned(fitted([list(row) for row in rows], size, 2))
    else:
        table = [_record(*row) for row in rows[1:]]
    return "\n".join([title, *lines, "", *table, *remarks(r)])


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(len(row[k]) for row in rows) for k in range(5)]
    padded = [[row[k].ljust(widths[k]) if k != 4 else row[k].rjust(widths[k]) for k in range(5)] for row in rows]
    return ["  ".join(row).rstrip() for row in padded]


def _record(effect: str, present: str, why: str, unknowns: str, time: str) -> str:
    """A row of the table as a line."""
    costs = [f"{unknowns} unknowns"] if unknowns else []
    costs += [f"{time} of the time"] if time else []
    return "; ".join([f"{effect}: {present}, {why}", *costs])


def head(r: Receipt) -> list[str]:
    """The lines above the table."""
    return [f"{r.scene.name}: {as_written(r)}", f"solved for: {solved_for(r)}"]


def remarks(r: Receipt) -> list[str]:
    """The lines below the table."""
    lines = ["", said] if (said := of_step(r)) else []
    lines += ["", "code"]
    lines += [f"  {e.effect}: {few_kernels(e.kernels)}" for e in r.entries if e.kernels]
    lines += ["", "before the first step"]
    lines += [f"  {line}" for line in before(r)]
    if r.outputs:
        lines += ["", "outputs, computed on access"]
        lines += [f"  {name}: {text}" for name, text in r.outputs]
    return lines


def as_written(r: Receipt) -> str:
    names = {"n": "coordinate", "m": "constraint", "p": "nonholonomic constraint"}
    return ", ".join(count(r.sizes[key][0], names[key]) for key in names if key != "p" or r.sizes[key][0])


def solved_for(r: Receipt) -> str:
    return f"{', '.join(f'{key} = {after}' for key, (_, after) in r.sizes.items())}, in {count(r.parts, 'part')}"


def cells(r: Receipt, file: str | None = None) -> list[tuple[str, str, str, str, str]]:
    """Heading and rows: effect, whether it is in the model, why, unknowns, share of the time of a step.

    Places in ``file`` are given by their line only.
    """
    total = sum(after for _, after in r.sizes.values())
    rows = [("effect", "in", "why", "unknowns", "time")]
    for e in r.entries:
        where = ""
        if e.span is not None:
            where = f", line {e.span.line}" if e.span.file == file else f" ({e.span})"
        unknowns = f"{e.unknowns} of {total}" if e.unknowns else ""
        time = "" if e.share is None else f"{100.0 * e.share:.0f} %" if e.share >= 0.005 else "< 1 %"
        rows.append((e.effect, "yes" if e.present else "no", e.why + where, unknowns, time))
    return rows


def of_step(r: Receipt) -> str:
    """The time of a step, "" if it was not measured."""
    if r.step is None:
        return ""
    own = "the method's own formulas and its linear algebra"
    rest = f"the share of {own} cannot be measured; the other shares are relative to their sum"
    if r.remainder is not None:
        rest = f"{100 * r.remainder:.0f} % of it is spent on {own}"
    return f"a step takes {1e6 * r.step:.3g} us ({', '.join(r.methods)}, h = {r.plan.h:g} s); {rest}"


def before(r: Receipt) -> list[str]:
    """What is done before the first step, and what is left out, one line each."""
    lines = [str(note) for note in r.notes] or ["merged, moved, split: nothing"]
    lines += [f"hoisted: {text}" for text in r.hoisted]
    for effect, components in r.scene.without.items():
        lines.append(f"left out on request: {effect}, of {few(components) if components else 'nothing: it has none'}")
    return lines


def split(line: str) -> tuple[str, str]:
    what, _, rest = line.partition(": ")
    return what, rest


def few_kernels(names: tuple[str, ...]) -> str:
    """``revolute.fill, .curve; loops.drive``"""
    by_module: dict[str, list[str]] = {}
    for name in names:
        module, dot, function = name.partition(".")
        by_module.setdefault(module, []).append(f".{function}" if dot else "")
    return "; ".join(module + ", ".join(functions) for module, functions in by_module.items())
