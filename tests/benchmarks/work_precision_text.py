"""The conclusions of docs/work-precision.md, from the numbers in docs/work-precision/."""

from __future__ import annotations

import math
from collections.abc import Sequence

from doc_parts import filled, rounded, spread
from work_precision import DECADES, at

from mbdsl.integrators import Method, available, compiled


def of_points(points: Sequence[dict], error: float) -> float:
    """Seconds of a series at an error within its range; not a number outside."""
    kept: list[dict] = []
    for point in sorted(points, key=lambda p: (p["seconds"], p["error"])):
        if not kept or point["error"] < kept[-1]["error"]:
            kept.append(point)
    if not kept or error > kept[0]["error"]:
        return math.nan
    return at(error, [p["error"] for p in kept], [p["seconds"] for p in kept])


def declaration(series: str) -> Method | None:
    """The method of a series; None for Exudyn's."""
    return available().get(series.split(" ")[0])


def order(series: str) -> int:
    found = declaration(series)
    return found.order if found is not None else 0


def is_external(series: str) -> bool:
    """Whether the method of a series is a third-party integrator."""
    return declaration(series) is not None and series.split(" ")[0] not in compiled()


def conclusions(known: dict[str, list[dict]]) -> str:
    """The sentences that follow from the numbers of docs/work-precision/, by model."""
    found: dict[str, list[tuple[int, float]]] = {}

    def add(name: str, k: int, ratio: float) -> None:
        if math.isfinite(ratio):
            found.setdefault(name, []).append((k, ratio))

    for points in known.values():
        series: dict[str, list[dict]] = {}
        for point in points:
            series.setdefault(point["series"], []).append(point)
        second = [name for name in series if order(name) == 2]
        for k in DECADES:
            times = {name: of_points(own, 10.0**-k) for name, own in series.items()}
            times = {name: seconds for name, seconds in times.items() if math.isfinite(seconds)}
            ours = {name: seconds for name, seconds in times.items() if name != "Exudyn"}
            if not ours:
                continue
            best, theirs = min(ours.values()), times.get("Exudyn", math.nan)
            like = {name: ours[name] for name in second if name in ours}
            fixed = {name: seconds for name, seconds in like.items() if "--tol" not in name}
            add("Exudyn", k, theirs / best)
            if like:
                add("second order", k, min(like.values()) / best)
                add("Exudyn of second order", k, theirs / min(like.values()))
            if len(fixed) > 1:
                add("methods of second order", k, max(fixed.values()) / min(fixed.values()))
            for name, seconds in fixed.items():
                add("controlled steps", k, times.get(f"{name} --tol", math.nan) / seconds)
            for name, seconds in ours.items():
                if is_external(name):
                    add("third-party integrators", k, seconds / best)

    def of(name: str, digits: int = 2) -> str:
        return spread([ratio for _, ratio in found[name]], digits)

    said = []
    if "second order" in found:
        said.append(f"- Methods of second order take {of('second order')} times as long as the fastest method.")
    if "methods of second order" in found:
        span = of("methods of second order")
        said.append(
            f"- At equal error, the slowest of the methods of second order takes {span} times as long as the fastest, "
            "with fixed steps, mostly because of their damping."
        )
    if "controlled steps" in found:
        said.append(
            f"- With `--tol`, methods of second order take {of('controlled steps')} times as long as with the fixed "
            "step of the same error, because of the calibration runs and estimates; on the other hand, the right step "
            "need not be found by trial."
        )
    if "third-party integrators" in found:
        span = of("third-party integrators")
        said.append(
            f"- Third-party integrators take {span} times as long as the fastest method, because every evaluation "
            "passes through Python."
        )
    if "Exudyn" in found:
        least, most = (f(found["Exudyn"], key=lambda pair: pair[1]) for f in (min, max))
        said.append(
            f"- Exudyn, with its best settings for every error, takes {rounded(least[1])} times (at 1e-{least[0]}) to "
            f"{rounded(most[1])} times (at 1e-{most[0]}) as long as the fastest method of mbdsl, and "
            f"{of('Exudyn of second order')} times as long as the fastest one of the same order, 2."
        )
    return "\n".join(map(filled, said))
