"""Vectors and matrices with names as text, for linear state-space models."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbdsl.messages import few
from mbdsl.plotting.terminal_text import text_width

WIDTH = 80  #: columns where the width of the terminal is not known
LARGEST = 12  #: largest matrix that is printed
CELL = 12  #: columns of a number
TINY = 1e-30  #: values below this are residues of the iteration for the equilibrium, in any SI unit


def listed(what: str, names: Sequence[str], units: Sequence[str], now: np.ndarray) -> list[str]:
    """The names of a vector called ``what``, with values and units."""
    if not names:
        return [f"  {what}: none"]
    if len(names) > LARGEST:
        return [f"  {what}: {len(names)} ({few(list(names), 4)})"]
    width = max(map(len, names))
    return [
        f"  {what}{k}  {name:{width}} {_number(x if abs(x) > TINY else 0.0)} {unit}".rstrip()
        for k, (name, unit, x) in enumerate(zip(names, units, now, strict=True), 1)
    ]


def matrix_rows(letter: str, matrix: np.ndarray, left: Sequence[str], above: Sequence[str]) -> list[str]:
    """A matrix with the names of its rows and columns, in as many blocks of columns as the width requires."""
    if not matrix.size:
        return []
    if max(matrix.shape) > LARGEST:
        return [f"{letter}: {matrix.shape[0]} x {matrix.shape[1]}"]
    side = max(map(len, [letter, *left]))
    cell = max(CELL, *(len(name) + 1 for name in above))
    each = max(1, (text_width(WIDTH) - side) // cell)
    lines = []
    for first in range(0, len(above), each):
        columns = range(first, min(first + each, len(above)))
        lines.append(f"{letter:{side}}" + "".join(f"{above[k]:>{cell}}" for k in columns))
        lines += [
            f"{name:{side}}" + "".join(f"{_number(row[k]):>{cell}}" for k in columns)
            for name, row in zip(left, clean(matrix), strict=True)
        ]
    return lines


def clean(matrix: np.ndarray) -> np.ndarray:
    """Without the rounding residue of entries that are zero; files have all digits."""
    largest = np.abs(matrix).max(axis=1, keepdims=True, initial=0.0)
    return np.where(np.abs(matrix) > 1e-13 * largest, matrix, 0.0)


def _number(x: float) -> str:
    return f"{x:>11.5g}"
