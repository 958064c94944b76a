"""Expressions of the signals of a result file, such as ``hypot(A.fx, A.fy)``, as further columns of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.expressions.array_operations import ARRAY_OPERATIONS, table_value
from mbdsl.expressions.symbolic import Expr, evaluate, input_signal, leaves
from mbdsl.integrators.event_list import times
from mbdsl.kernels.arrays import Array
from mbdsl.lang.asked_signals import Operand, read
from mbdsl.results.selection import matching
from mbdsl.simulation.event_marks import marks
from mbdsl.simulation.result_units import in_si
from mbdsl.simulation.stored_events import EVENTS, of_meta
from mbdsl.simulation.stored_extremes import KEY, cut_in_file

if TYPE_CHECKING:
    from mbdsl.results.stored import Made, Result


def with_expressions(result: Result, patterns: Iterable[str] | None) -> Result:
    """A result with the expressions among the names and patterns of signals that are asked for.

    Returns
    -------
    Result
        In SI units; the same one if its file has these, and there is no expression among them.

    Raises
    ------
    UsageError
        If an expression is invalid, or contains a signal that the result lacks.
    """
    from mbdsl.results.stored import with_columns

    result = in_si(result) if result.is_file else result
    known = set(result.names)
    if result.is_file and KEY in result.layout.meta:
        result.cut_peaks = partial(cut_in_file, result)
    if result.is_file and EVENTS in result.layout.meta:
        events = of_meta(result.layout.meta)
        result.events, result.jumps = partial(marks, events), partial(times, events)

    def operand(name: str) -> Operand | None:
        return (input_signal(name), result.unit(name)) if name in known else None

    made = {}
    for text in patterns or ():
        if not matching(text, result.names) and (found := read(text, operand, result.names, result.label)) is not None:
            made[text] = _made(*found, result.time)
    return with_columns(result, made) if made else result


def _made(root: Expr, unit: str, time: str) -> Made:
    from mbdsl.results.stored import Made

    def name_of(leaf: Expr) -> str:
        return time if leaf.op == "time" else str(leaf.value)

    def values(columns: Mapping[str, Array], rows: int) -> Array:
        with np.errstate(all="ignore"):
            (found,) = evaluate([root], lambda leaf: columns[name_of(leaf)], ARRAY_OPERATIONS, table_value)
        return np.broadcast_to(np.asarray(found, float), (rows,))

    return Made(unit, [name_of(leaf) for leaf in leaves(root)], values)
