"""Events in result files: one text among the data that describe the run."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import Span
from mbdsl.integrators.event_list import EventGroup
from mbdsl.results.csv_file import EVENTS

ROUNDING = 1e-14  #: part of a time by which it may differ from that of a clock
MOST = 10**8  #: events of one group; more of them are those of a damaged file


def text_of(groups: Iterable[EventGroup]) -> str:
    """Events as a text: kind, name, file, line and text of each group, and its times; "" without events.

    Equidistant times, as those of a clock, are their number, the first and the last.
    """
    rows = []
    for kind, span, times, name in groups:
        place = None if span is None else [span.file, span.line, span.text.strip()]
        rows.append([kind, name, place, _packed(times)])
    return json.dumps(rows) if rows else ""


def _packed(times: NDArray[np.float64]) -> list[Any]:
    ends = [len(times), float(times[0]), float(times[-1])]
    return [ends] if len(times) > 3 and np.allclose(_between(*ends), times, ROUNDING, 0.0) else times.tolist()


def _between(count: float, first: float, last: float) -> NDArray[np.float64]:
    return np.linspace(first, last, int(count))


def of_meta(meta: Mapping[str, Any]) -> list[EventGroup]:
    """The events that a result file, perhaps of another author, contains."""
    try:
        return [_group(*row) for row in json.loads(str(meta.get(EVENTS) or "[]"))]
    except (ValueError, TypeError, LookupError):
        return []


def _group(kind: str, name: str, place: list[Any] | None, times: list[Any]) -> EventGroup:
    span = None if place is None else Span(str(place[0]), int(place[1]), 1, 1, str(place[2]))
    packed = len(times) == 1 and isinstance(times[0], list)
    if packed and times[0][0] > MOST:
        raise ValueError("too many events")
    found = _between(*times[0]) if packed else np.array(times, float)
    return EventGroup(str(kind), span, np.sort(found), str(name))
