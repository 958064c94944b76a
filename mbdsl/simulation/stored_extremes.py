"""Extremes of signals in result files: one text among the data that describe the run."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from mbdsl.simulation.cut_peaks import CutPeak, finite_ends, outside
from mbdsl.simulation.extremes import Extreme, Extremes

if TYPE_CHECKING:
    from mbdsl.results.stored import Result

KEY = "extremes"  #: name of the text in the metadata


def text_of(found: Iterable[Extreme]) -> str:
    """Extremes as a text."""
    return json.dumps([list(x) for x in found])


def of_result(result: Result) -> Extremes:
    """The extremes that a result file contains; none if it contains no or other ones.

    Parameters
    ----------
    result : Result
        An opened file, perhaps of another author.

    Returns
    -------
    Extremes
        Of signals that the file has as columns.
    """
    try:
        rows = json.loads(str(result.layout.meta.get(KEY, "[]")))
        found = [_extreme(*row) for row in rows]
    except (ValueError, TypeError, LookupError):
        return Extremes([])
    known = set(result.names)
    return Extremes(x for x in found if x.signal in known)


def _extreme(signal: object, unit: object, *rest: Any) -> Extreme:
    low, low_at, high, high_at, mean, rms = map(float, rest[:-1])
    return Extreme(str(signal), str(unit), low, low_at, high, high_at, mean, rms, str(rest[-1]))


def cut_in_file(result: Result, names: Sequence[str]) -> list[CutPeak]:
    """The peaks, among the extremes in a file, that its outputs cut."""
    stored = of_result(result)
    found = [stored[name] for name in names if name in stored]
    ends = {x.signal: (float("inf"), float("-inf")) for x in found}
    for _, columns in result.chunks([*ends]) if found else ():
        for name, (low, high) in ends.items():
            least, largest = finite_ends(columns[name])
            ends[name] = min(low, least), max(high, largest)
    return outside(found, ends.__getitem__, {})
