"""The rows of the gradient table in the flat buffers: joints, springs and laws, each between two frames."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any, NamedTuple

from mbdsl.elements.kind import ForceKind, JointKind
from mbdsl.expressions.derivatives import der, diff
from mbdsl.expressions.frame_derivatives import by_motion, by_rate, frames_in
from mbdsl.expressions.symbolic import Expr, expr, leaves
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import columns_of
from mbdsl.mechanism.scene import Component
from mbdsl.system.expression_tape import Tape
from mbdsl.system.structure import Block, law_expressions
from mbdsl.system.tables import Buffers, Tables


class _Laws(NamedTuple):
    """What laws are written to."""

    tables: Tables
    buffers: Buffers
    dofs: Any
    tape: Tape
    later: list[Callable[[], None]]
    slopes: dict[tuple[Expr, str], list[Expr]]  #: the expressions ds/dz of laws that several rows have


def tabulate(tables: Tables, buffers: Buffers, dofs, tape: Tape, later: list[Callable[[], None]]) -> None:
    """Write the record of each row of the gradient table: a, b, first slot, second derivative, detail (see
    :mod:`mbdsl.kernels.buffer_layout`)."""
    n, ints, row = tables.n, [], 0
    counts = {"joint": 0, "spring": 0, "law": 0}
    details: list[tuple[int, list[int]]] = []
    couplings: list[list[int]] = []
    laws = _Laws(tables, buffers, dofs, tape, later, {})
    no_hessian = [0.0] * columns_of(tables.scene.spatial).SQUARE
    for k, block in enumerate(tables.blocks):
        if block.role not in counts:
            continue
        rows, role, curved, coupled = block.rows, block.role, block.curved, block.coupled
        full = curved or role == "spring"
        header = L.BLOCKS + L.BLOCK * k
        parameters = _parameters(block)
        buffers.layout[header : header + 4] = [
            len(block.components),
            row,
            buffers.floats(v for p in parameters for v in p),
            len(parameters[0]) if parameters else 0,
        ]
        if block.module.KIND.counts_turns:
            _note_angles(tables, block, buffers.layout[header + 2], buffers.layout[header + 3])
        for e, c in enumerate(block.components):
            if coupled:
                first = buffers.layout[header + 2] + buffers.layout[header + 3] * e
                later.append(_coupling(tables, c, first, couplings, tape))
            a, b = (tables.frames[c.ports[port]] for port in c.kind.ports) if c.ports else (0, 0)
            for j in range(rows):
                first, detail = buffers.requested, -1
                _request_slots(buffers, c, (dofs[a], dofs[b]), n + row if role == "joint" else None, full)
                if role == "joint":
                    if isinstance(c.kind, JointKind) and c.kind.driver and j == rows - 1:
                        u = expr(c.values[c.kind.driver])
                        rate = der(u)
                        registers = [tape.add(u), tape.add(rate), 0]
                        details.append((len(ints) + 4, registers))
                        later.append(_second_rate(rate, registers, tape))
                elif role == "spring" and isinstance(c.kind, ForceKind) and c.kind.springs:
                    detail = buffers.floats(c.kind.springs(c.values)[j])
                else:
                    leaf = _law(laws, c, j, (a, b))
                    details.append((len(ints) + L.DETAIL, leaf))
                hessian = buffers.floats(no_hessian) if curved else -1
                ints += [a, b, first, hessian, detail, int(role == "joint" and c.name in tables.holding)]
                row += 1
            counts[role] += rows
    layout = buffers.layout
    layout[L.N_SPRINGS], layout[L.N_LAWS] = counts["spring"], counts["law"]
    layout[L.PAIRS] = offset = buffers.ints(ints)

    def place_details() -> None:
        for position, values in details:
            layout[offset + position] = buffers.ints(values)
        layout[L.COUPLED] = buffers.ints(x for record in couplings for x in record)

    layout[L.N_COUPLED] = len(couplings)
    later.append(place_details)


def _parameters(block: Block) -> list[tuple[float, ...]]:
    """The numbers of each component of a block that its kernels read."""
    known: dict[tuple[int, int], tuple[float, ...]] = {}  # components of an array share their values
    found = []
    for c in block.components:
        key = id(c.kind), id(c.values)
        if key not in known:
            friction = isinstance(c.kind, JointKind) and block.role == "law"  # which has no parameters
            known[key] = () if friction else tuple(c.kind.table(c.values))
        found.append(known[key])
    return found


def _note_angles(tables: Tables, block: Block, first: int, stride: int) -> None:
    """Note where the kernels of a block count the turns of angles."""
    for e, c in enumerate(block.components):
        for i, name in enumerate(c.kind.counted):
            node = tables.scene.signal_of(c, name)
            assert node is not None
            tables.angles.setdefault(node, []).append(first + stride * e + 2 * i)


def _request_slots(buffers: Buffers, c: Component, ends, row: int | None, full: bool) -> None:
    """Request the entries of the matrix that a component writes: of the coordinates of its ``ends``, if it is ``full``,
    and those of the row of a joint."""
    slots = buffers.slots
    if row is not None:
        slots((row,), (row,))  # used if the row is left out
    for own, other in product(ends, repeat=2) if full else ():
        if row is not None and c.kind.curved_by_rotations:
            buffers.rotation_slots(own, other, row)
        else:
            slots(own, other)
    if row is not None:
        for own in ends:
            slots(own, (row,))
            slots((row,), own)


def _coupling(tables: Tables, c, first: int, records: list[list[int]], tape: Tape) -> Callable[[], None]:
    """Append records of the functions in a joint, whose parameters begin at ``first``, and of their derivatives: offset
    in numbers and register. Second derivatives are needed for the tangent only."""
    second: list[tuple[list[int], Expr]] = []
    for law, signals in c.kind.functions:
        arguments = [x for x in (tables.scene.signal_of(c, name) for name in signals) if x is not None]
        f = expr(c.values[law])
        slopes = diff(f, *arguments)
        for root in (f, *slopes):
            records.append([first, tape.add(root)])
            first += 1
        for i, slope in enumerate(slopes):
            for root in diff(slope, *arguments[i:]):
                records.append([first, 0])
                second.append((records[-1], root))
                first += 1

    def fill() -> None:
        for record, root in second:
            record[1] = tape.add(root)

    return fill


def _second_rate(rate: Expr, registers: list[int], tape: Tape) -> Callable[[], None]:
    """u'' is needed for accelerations only, and therefore belongs to the gradient tape."""

    def fill() -> None:
        registers[2] = tape.add(der(rate))

    return fill


def _law(to: _Laws, c: Component, j: int, pair: tuple[int, int]) -> list[int]:
    """Record of a law: register of s, sign, number of frames that s depends on; per frame its row and the registers of
    ds/dz; number of multipliers that s depends on, and the registers of ds/dlam."""
    tables, buffers, dofs, tape, slopes = to.tables, to.buffers, to.dofs, to.tape, to.slopes
    law = law_expressions(c)[j]
    used = frames_in(law)
    reactions = [x for x in leaves(law) if x.op == "multiplier"]
    sign = int(c.kind.sign) if isinstance(c.kind, ForceKind) else -1  # friction resists
    leaf = [tape.add(law), sign, len(used)]
    for name in used:
        for f in pair:
            buffers.slots(dofs[f], dofs[tables.frames[name]])
    for x in reactions:
        for f in pair:
            buffers.slots(dofs[f], (tape.multipliers[x.value],))

    def fill() -> None:
        for name in used:
            if (law, name) not in slopes:
                spatial = tables.scene.spatial
                slopes[law, name] = [*by_motion(law, name, spatial), *by_rate(law, name, spatial)]
            leaf.extend([tables.frames[name], *(tape.add(g) for g in slopes[law, name])])
        leaf.extend([len(reactions), *(tape.add(diff(law, x)[0]) for x in reactions)])

    to.later.append(fill)
    return leaf
