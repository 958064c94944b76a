"""The events of a run as marks of plots and of time lines, of which those that are close to each other are one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from mbdsl.integrators.event_list import EventGroup, place

#: ticks of clocks that are marked: more of them are left out, because they are a grid
TICKS = 20
#: marks closer to each other than this part of the time axis are one
APART = 1 / 400


class Mark(NamedTuple):
    """An event, or ``events`` close to each other: time [s], kind, what has acted, and the number of its line."""

    t: float
    kind: str
    events: int
    text: str
    line: str = ""


def marks(groups: Iterable[EventGroup], start: float, stop: float) -> tuple[list[Mark], int]:
    """Marks between two times [s] in the order of time, and the number of ticks that are not marked."""
    found, left_out = list[Mark](), 0
    apart = APART * (stop - start)
    for kind, span, times, name in groups:
        own = times[(times >= start - apart) & (times <= stop + apart)]
        if kind == "sample" and len(own) > TICKS:
            left_out += len(own)
            continue
        where, line = place(span), ""
        if where.startswith("line"):
            line = where.rpartition(":")[2]
            where = f"line {line}"
        text = f"{kind} of {name}" if name else kind
        last = -1
        for t in own.tolist():
            if last >= 0 and t - found[last].t < apart:
                found[last] = found[last]._replace(events=found[last].events + 1)
                continue
            last = len(found)
            found.append(Mark(t, kind, 1, f"{text}, {where}" if where else text, line))
    return sorted((_counted(x) for x in found), key=lambda x: x.t), left_out


def _counted(mark: Mark) -> Mark:
    return mark if mark.events == 1 else mark._replace(text=f"{mark.events} × {mark.text}")
