"""Frames that drivers move as functions of time: their poses, rates and accelerations are expressions on the tape.

A record contains the row of a frame, the registers of its pose and rates, and, on the gradient tape, of its
accelerations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from mbdsl.expressions.derivatives import der
from mbdsl.expressions.symbolic import Expr
from mbdsl.kernels import buffer_layout as L
from mbdsl.system.expression_tape import Tape

Motion = tuple[Expr, Expr, Expr]


def tabulate(motions: Mapping[int, Motion | None], buffers, tape: Tape, later: list[Callable[[], None]]) -> None:
    """Records of the moving frames (row -> motion)."""
    records = []
    for row, motion in motions.items():
        if motion is not None:
            rates = [der(x) for x in motion]
            records.append(record := [row, *(tape.add(x) for x in (*motion, *rates)), 0, 0, 0])
            later.append(_accelerations(rates, record, tape))

    def place() -> None:
        buffers.layout[L.MOVING] = buffers.ints([i for record in records for i in record])

    later.append(place)
    buffers.layout[L.N_MOVING] = len(records)


def _accelerations(rates: list[Expr], record: list[int], tape: Tape) -> Callable[[], None]:
    def fill() -> None:
        record[7:] = [tape.add(der(rate)) for rate in rates]

    return fill
