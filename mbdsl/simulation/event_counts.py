"""How often the events of a run acted, for its statistics."""

from __future__ import annotations

from collections import Counter
from typing import Any

from mbdsl.integrators.event_list import groups, place
from mbdsl.integrators.event_set import EventSet


def of_events(events: EventSet) -> dict[str, Any]:
    """The text of `terminate`, the counts by place in the text and by kind, the most frequent first."""
    lines, kinds = Counter[str](), Counter[str]()
    for kind, x, times, _name in groups(events):
        lines[place(x).removeprefix("line ") or "an event of a Builder"] += len(times)
        kinds[kind] += len(times)
    found = {"acted": lines, "kinds of events": kinds}
    return {"terminated": events.ended, **{name: dict(count.most_common()) for name, count in found.items()}}
