"""Holonomic constraints by expression, g(z) = u(t), in the flat buffers: g over frames, differentiated exactly.

Record of one, at layout[layout[RELATIONS] + k]: its row of Phi, register of g, first slot, offset in numbers of G at
the start of the step, number of frames that g depends on; per frame its row and the registers of G = dg/dz; per pair of
frames (r, c) the registers of dG_r/dz_c. u(t) belongs to the row, as that of a driver.
"""

from __future__ import annotations

from collections.abc import Callable

from mbdsl.expressions.frame_derivatives import by_motion, frames_in
from mbdsl.expressions.symbolic import Expr
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import columns_of
from mbdsl.system.expression_tape import Tape
from mbdsl.system.tables import Buffers, Tables


def tabulate(tables: Tables, buffers: Buffers, dofs, tape: Tape, later: list[Callable[[], None]]) -> None:
    """Write the records of all constraints by expression."""
    records: list[list[int]] = []
    for block in tables.blocks:
        for c in block.components if block.related else ():
            for k, g in enumerate(c.relations):
                records.append(_record(g, tables, tables.rows[c.name] + k, buffers, dofs, tape, later))

    def place() -> None:
        buffers.layout[L.RELATIONS] = buffers.ints([buffers.ints(record) for record in records])

    later.append(place)
    buffers.layout[L.N_RELATIONS] = len(records)


def _record(
    g: Expr, tables: Tables, row: int, buffers: Buffers, dofs, tape: Tape, later: list[Callable[[], None]]
) -> list[int]:
    used = frames_in(g)
    own = [dofs[tables.frames[name]] for name in used]
    slot, entry = buffers.requested, (tables.n + row,)
    for coordinates in own:
        buffers.slots(coordinates, entry)
        buffers.slots(entry, coordinates)
    for r in own:
        for c in own:
            buffers.slots(r, c)
    gradients = [by_motion(g, name, tape.spatial) for name in used]
    past = buffers.floats([0.0] * (columns_of(tape.spatial).POSE * len(used)))
    record = [row, tape.add(g), slot, past, len(used)]
    for name, G in zip(used, gradients, strict=True):
        record += [tables.frames[name], *(tape.add(x) for x in G)]

    def fill() -> None:
        for G in gradients:
            for c in used:
                record.extend(tape.add(h) for x in G for h in by_motion(x, c, tape.spatial))

    later.append(fill)
    return record
