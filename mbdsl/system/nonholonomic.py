"""Nonholonomic constraints Gam(v, q, t) = 0 in the flat buffers: expressions over frames, differentiated exactly.

Record of one, at layout[layout[GAMMAS] + k]: registers of Gam and Gam_t, first slot, whether it is left out, number of
frames that it depends on; per frame its row and the registers of dGam/dw (3, w = its velocities) and dGam/dz (3); per
pair of frames (r, c) the registers of d^2Gam/dw_r dz_c (9) and d^2Gam/dw_r dw_c (9).
"""

from __future__ import annotations

from collections.abc import Callable

from mbdsl.expressions.derivatives import diff
from mbdsl.expressions.frame_derivatives import by_motion, by_rate, frames_in
from mbdsl.expressions.symbolic import TIME, Expr
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import columns_of
from mbdsl.system.expression_tape import Tape


def tabulate(
    gammas: list[Expr], frames: dict[str, int], dofs, first_row: int, buffers, tape: Tape, later: list[Callable]
) -> None:
    """Records of ``gammas``; their rows in the iteration matrix start at ``first_row``."""
    records: list[list[int]] = []
    for k, gamma in enumerate(gammas):
        row = first_row + k
        used = frames_in(gamma)
        slot = buffers.slots((row,), (row,))  # used where the row is left out
        for name in used:
            buffers.slots(dofs[frames[name]], (row,))
            buffers.slots((row,), dofs[frames[name]])
        for r in used:
            for c in used:
                buffers.slots(dofs[frames[r]], dofs[frames[c]])
        rates = {name: by_rate(gamma, name, tape.spatial) for name in used}
        record = [tape.add(gamma), 0, slot, 0, len(used)]
        for name in used:
            record += [frames[name], *(tape.add(g) for g in rates[name]), *[0] * len(rates[name])]
        records.append(record)
        later.append(_derivatives(gamma, used, rates, record, tape))

    def place() -> None:
        buffers.layout[L.GAMMAS] = buffers.ints([buffers.ints(record) for record in records])

    later.append(place)
    buffers.layout[L.N_GAM] = len(gammas)


def _derivatives(gamma: Expr, used: list[str], rates, record: list[int], tape: Tape) -> Callable[[], None]:
    """Derivatives that only the iteration matrix and accelerations need belong to the gradient tape."""

    def fill() -> None:
        record[1] = tape.add(diff(gamma, TIME)[0])
        for l, name in enumerate(used):
            sizes = columns_of(tape.spatial)
            at = L.GAMMA + sizes.LEAF * l + 1 + sizes.POSE
            record[at : at + sizes.POSE] = [tape.add(g) for g in by_motion(gamma, name, tape.spatial)]
        for r in used:
            for c in used:
                for derivatives in (by_motion, by_rate):
                    record.extend(tape.add(g) for rate in rates[r] for g in derivatives(rate, c, tape.spatial))

    return fill
