"""The record of clocks that set discrete variables, for the compiled step loop (:mod:`mbdsl.integrators.loop.ticks`).

At o = layout[TICKS]: first instruction and number of instructions of the right-hand sides on the tape; number of clocks
and of actions; offset in numbers of the counts and of the log; rows of the log. Per clock: a, b, c of its ticks
(a + k b)/c, k = 0, 1, ..., exact but for one rounding. Per action: its clock, and the offsets in numbers of the
right-hand side, of the variable, and of its value before the event (-1: nothing reads it).

In numbers: k of each clock; the number of rows logged; and rows of time, due clocks as a sum of 2^clock, and the values
of all variables that clocks set.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import lcm

from mbdsl.expressions.symbolic import Expr, input_signal, leaves
from mbdsl.kernels import buffer_layout as L
from mbdsl.mechanism.events import Action, Clock, Events
from mbdsl.system.expression_tape import Tape
from mbdsl.system.tables import Buffers

#: offset in layout of the counts of clocks and actions, of the place in numbers, and of the first clock
CLOCKS, ACTIONS, PLACE, ROOM, FIRST = 2, 3, 4, 5, 6
CLOCK, ACTION = 3, 4  #: ints of a clock and of an action
ROWS = 2048  #: rows of the log
#: integers up to which doubles are exact; number of clocks whose sum of powers of two is one
EXACT, MOST_CLOCKS = 2**53, 50


def compilable(events: Events, spatial: bool, others: Sequence[Expr]) -> tuple[tuple[int, Action], ...]:
    """The actions of clocks that the compiled loop does; none in space, where history is in axes of bodies, nor if one
    of the conditions ``others`` of contacts or friction reads what they set."""
    read = {str(leaf.value) for leaf in leaves(*others) if leaf.op == "input"}
    ticks = [_integers(clock) for clock in events.clocks]
    fits = len(ticks) <= MOST_CLOCKS and all(max(abs(x) for x in each) < EXACT for each in ticks)
    found = (events.of_clocks or ()) if fits and not spatial else ()
    return () if any(action.target in read for _, action in found) else found


def _integers(clock: Clock) -> tuple[int, int, int]:
    c = lcm(clock.start.denominator, clock.period.denominator)
    return int(clock.start * c), int(clock.period * c), c


def declare(events: Events, actions: tuple[tuple[int, Action], ...], tape: Tape) -> None:
    """Registers of the variables, and of what the right-hand sides read, among the values of the tape."""
    for _, action in actions:
        assert action.value is not None
        names = (action.target, f"pre({action.target})")
        for leaf in (*leaves(action.value), *(input_signal(x) for x in names if x in events.variables)):
            tape.add(leaf)


def tabulate(
    events: Events, actions: tuple[tuple[int, Action], ...], tape: Tape, known: dict, buffers: Buffers
) -> Callable[[], None]:
    """Append the right-hand sides to the tape, which may share the nodes ``known``; the record is written by the
    function that is returned, once the registers have their place in numbers."""
    if not actions:
        return lambda: None
    first = len(tape.code)
    tape.continue_from(known)
    values = [tape.add(action.value) for _, action in actions]  # type: ignore[arg-type]
    count = len(tape.code) - first

    def write() -> None:
        at = buffers.layout[L.REGISTERS]
        clocks = [x for clock in events.clocks for x in _integers(clock)]
        own: list[int] = []
        for (clock, action), value in zip(actions, values, strict=True):
            before = tape.inputs.get(f"pre({action.target})")
            own += [clock, at + value, at + tape.inputs[action.target], -1 if before is None else at + before]
        place = buffers.floats([0.0] * (len(events.clocks) + 1 + ROWS * (2 + len(actions))))
        head = [first, count, len(events.clocks), len(actions), place, ROWS]
        buffers.layout[L.TICKS] = buffers.ints([*head, *clocks, *own])

    return write
