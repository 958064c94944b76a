"""A linear state-space model as text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.messages import few

if TYPE_CHECKING:
    from mbdsl.analysis.linearisation import Linearisation

WIDTH = 80  #: columns of the terminal
LARGEST = 12  #: largest matrix that is printed
CELL = 12  #: columns of a number


def text(found: Linearisation) -> str:
    """States, inputs and outputs with their units and values, and the matrices of small models."""
    where = {"static": "its static equilibrium", "start": f"its state at t = {found.t:g} s"}
    head = f"{found.scene.name}: x' = A x + B u, y = C x + D u about {where.get(found.at, f'its state at {found.at}')}"
    lines = [head]
    for what, names, units, now in (
        ("x", found.states, found.state_units, found.x0),
        ("u", found.inputs, found.input_units, found.u0),
        ("y", found.outputs, found.output_units, found.y0),
    ):
        lines += _listed(what, names, units, now)
    rows = [f"{name}'" for name in found.states]
    for letter, matrix, left, above in (
        ("A", found.A, rows, found.states),
        ("B", found.B, rows, found.inputs),
        ("C", found.C, found.outputs, found.states),
        ("D", found.D, found.outputs, found.inputs),
    ):
        lines += _matrix(letter, matrix, left, above)
    return "\n".join([*lines, *(f"note: {note}" for note in found.notes)])


def _listed(what: str, names: Sequence[str], units: Sequence[str], now: np.ndarray) -> list[str]:
    if not names:
        return [f"  {what}: none"]
    if len(names) > LARGEST:
        return [f"  {what}: {len(names)} ({few(list(names), 4)})"]
    width = max(map(len, names))
    return [
        f"  {what}{k}  {name:{width}} {_number(x)} {unit}".rstrip()
        for k, (name, unit, x) in enumerate(zip(names, units, now, strict=True), 1)
    ]


def _matrix(letter: str, matrix: np.ndarray, left: Sequence[str], above: Sequence[str]) -> list[str]:
    """A matrix with the names of its rows and columns, in as many blocks of columns as the width requires."""
    if not matrix.size:
        return []
    if max(matrix.shape) > LARGEST:
        return [f"{letter}: {matrix.shape[0]} x {matrix.shape[1]}"]
    side = max(map(len, [letter, *left]))
    cell = max(CELL, *(len(name) + 1 for name in above))
    each = max(1, (WIDTH - side) // cell)
    lines = []
    for first in range(0, len(above), each):
        columns = range(first, min(first + each, len(above)))
        lines.append(f"{letter:{side}}" + "".join(f"{above[k]:>{cell}}" for k in columns))
        lines += [
            f"{name:{side}}" + "".join(f"{_number(row[k]):>{cell}}" for k in columns)
            for name, row in zip(left, _clean(matrix), strict=True)
        ]
    return lines


def _clean(matrix: np.ndarray) -> np.ndarray:
    """Without the rounding residue of entries that are zero; files have all digits."""
    largest = np.abs(matrix).max(axis=1, keepdims=True, initial=0.0)
    return np.where(np.abs(matrix) > 1e-13 * largest, matrix, 0.0)


def _number(x: float) -> str:
    return f"{x:>11.5g}"
