"""Figures of many methods in parts of at most eight series: the best series of each family, then every family.

All parts have the axes of the whole figure, so that they can be compared.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from statistics import median
from typing import Any

from mbdsl.integrators import available
from mbdsl.plotting.figures import Bars, Figure, Series
from mbdsl.plotting.series_styles import METHODS, Look, method_look
from mbdsl.studies.families import family

MOST = 8  #: series in a picture
BEHIND = ("front", "guide")
Score = Callable[[Figure, Series], Any]


def method_looks() -> dict[str, Look]:
    """The looks of methods that the table of styles does not list, such as third-party ones."""
    every = available().items()
    return {name: method_look(name, "fixed" not in m.steps) for name, m in every if name.lower() not in METHODS}


def parts(figure: Figure | Bars, score: Score | None = None) -> list[Figure | Bars]:
    """The figure itself, or its parts.

    Parameters
    ----------
    figure : Figure or Bars
        Its series are named after methods.
    score : callable, optional
        ``score(figure, series)``: the smaller, the better is a series; default: the median of log(y).
    """
    if isinstance(figure, Bars):
        return [figure]
    plain = [s for s in figure.series if s.style not in BEHIND]
    if len(plain) <= MOST:
        return [figure]
    families: dict[str, list[Series]] = {}
    for series in plain:
        families.setdefault(family(_method(series.name)), []).append(series)
    rank = {series.name: (score or height)(figure, series) for series in plain}
    best = [min(own, key=lambda series: rank[series.name]) for own in families.values()]
    best = sorted(best, key=lambda series: rank[series.name])[:MOST]
    found: list[Figure | Bars] = [_part(figure, "", "the best of each family", best)]
    for title, own in _packed(families):
        found.append(_part(figure, "-" + "-".join(_words(title)), title, own))
    return found


def height(figure: Figure, series: Series) -> float:
    """The median of log|y|; infinite without points."""
    logs = [math.log10(abs(y)) for y in series.y if math.isfinite(y) and y != 0.0]
    return median(logs) if logs else math.inf


def on_front(figure: Figure, series: Series) -> tuple[float, float]:
    """Series with many points on the front come first, then those with a point near the lower left corner."""
    front = {point for s in figure.series if s.style == "front" for point in zip(s.x, s.y, strict=True)}
    points = list(zip(series.x, series.y, strict=True))
    nearest = min((math.log10(x * y) for x, y in points if 0.0 < x * y < math.inf), default=math.inf)
    return -float(sum(point in front for point in points)), nearest


def _packed(families: Mapping[str, Sequence[Series]]) -> Iterable[tuple[str, list[Series]]]:
    """Families by name; large ones by kind of steps, and small ones together."""
    small: list[tuple[str, list[Series]]] = []
    for name, own in families.items():
        if len(own) <= MOST:
            small.append((name, list(own)))
            continue
        kinds: dict[str, list[Series]] = {}
        for series in own:
            kinds.setdefault("controlled steps" if _controlled(series.name) else "fixed steps", []).append(series)
        for kind, some in kinds.items():
            for k in range(0, len(some), MOST):
                more = f", {k // MOST + 1}" if len(some) > MOST else ""
                yield f"{name}, {kind}{more}", some[k : k + MOST]
    names: list[str] = []
    together: list[Series] = []
    for name, own in small:
        if together and len(together) + len(own) > MOST:
            yield " and ".join(names), together
            names, together = [], []
        names.append(name)
        together = [*together, *own]
    if together:
        yield " and ".join(names), together


def _part(figure: Figure, key: str, title: str, own: Sequence[Series]) -> Figure:
    names = {series.name for series in own}
    there = {series.name for series in figure.series}
    families = {family(_method(name)) for name in names}
    series = [s for s in figure.series if s.style in BEHIND or s.name in names]
    outcomes = [
        o
        for o in figure.outcomes
        if o.name in names or (o.name not in there and key and family(_method(o.name)) in families)
    ]
    title = f"{figure.title}: {title}"
    return replace(figure, key=figure.key + key, title=title, series=series, outcomes=outcomes, like=figure)


def _method(name: str) -> str:
    """The method that the name of a series begins with."""
    return name.split(",")[0].split(" ")[0]


def _controlled(name: str) -> bool:
    found = available().get(_method(name))
    return "--tol" in name or (found is not None and "fixed" not in found.steps)


def _words(title: str) -> list[str]:
    return "".join(c if c.isalnum() else " " for c in title.lower()).split()
