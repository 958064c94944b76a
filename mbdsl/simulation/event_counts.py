"""How often the events of a run acted, for its statistics."""

from __future__ import annotations

from collections import Counter
from typing import Any

from mbdsl.integrators.event_set import EventSet


def of_events(events: EventSet) -> dict[str, Any]:
    """The text of `terminate`, the counts by place in the text and by kind, the most frequent first."""
    lines = Counter[str]()
    for x, n in events.counts().items():
        lines[f"{x.file}:{x.line}" if x is not None else "an event of a Builder"] += n
    kinds = dict(events.kinds().most_common())
    return {"terminated": events.ended, "acted": dict(lines.most_common()), "kinds of events": kinds}
