"""The notes of a plot: what it omits, interpolates and decimates."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from pathlib import Path

from mbdsl.messages import UnitsOfSignals, count, few
from mbdsl.plotting.curves import SignalCurve
from mbdsl.plotting.differences import Difference
from mbdsl.results.stored import Result

MOST = 3  #: number of peaks between outputs that are named
NARROW_SPACE = "\u202f"  #: between groups of three digits


def short_labels(labels: Sequence[str]) -> list[str]:
    """The files' names without folders, if these differ."""
    short = [" − ".join(Path(part).name for part in label.split(" − ")) for label in labels]
    if len(set(short)) == len(short):
        return short
    return [label if labels.count(label) == 1 else f"{label} ({k + 1})" for k, label in enumerate(labels)]


def of_choice(
    shown: Sequence[str], constant: Sequence[str], same: Sequence[str], known: Collection[str]
) -> Iterator[str]:
    """How the default signals were chosen from the ``known`` ones."""
    if len(shown) < len(known):
        yield f"{count(len(shown), 'signal')} of {len(known)}; --signals chooses others, --list lists them."
    if constant:
        yield f"Constant, and left out: {few(constant)}."
    if same:
        yield f"Equal to others, and left out: {few(same)}."


def of_variables(results: Sequence[Result], chosen: Sequence[str]) -> Iterator[str]:
    """The descriptions of variables, as the model declares them."""
    for name in chosen:
        if said := next((result.descriptions[name] for result in results if name in result.descriptions), ""):
            yield f"{name}: {said}."


def of_results(
    results: Sequence[Result], labels: Sequence[str], chosen: Sequence[str], display: UnitsOfSignals
) -> Iterator[str]:
    """Missing signals, interpolation, and marks of results."""
    for result, label in zip(results, labels, strict=True):
        have = set(result.names)
        missing = [name for name in chosen if name not in have]
        if missing and len(results) > 1:
            yield f"Not in {label}: {few(missing)}."
        if isinstance(result, Difference):
            if result.interpolated:
                yield _interpolation(result, [name for name in chosen if name in have])
            for source in (result.result, result.base):
                yield from _mark(source, short_labels([source.label])[0])
        else:
            yield from _mark(result, label)
            yield from (
                f"Between outputs: {peak.text(display)}."
                for peak in result.cut_peaks([x for x in chosen if x in have])[:MOST]
            )


def of_curves(curves: Sequence[SignalCurve]) -> Iterator[str]:
    """Decimation, and details of spectra."""
    long = max((curve for curve in curves if curve.reduced), key=lambda c: c.count, default=None)
    if long is not None:
        rows = f"{long.count:,}".replace(",", NARROW_SPACE)
        yield f"{rows} rows: {long.reduced}"
    if any(curve.frequency for curve in curves):
        yield "Amplitude spectrum with a Hann window, mean removed: a sine of amplitude A shows A."
    yield from dict.fromkeys(curve.remark for curve in curves if curve.remark)


def _mark(result: Result, label: str) -> Iterator[str]:
    meta = result.layout.meta
    if not meta.get("complete", True):
        reason = "its accuracy was not reached" if meta.get("status") == "inaccurate" else "its run was not completed"
        yield f"{label} is marked: {reason}."


def _interpolation(result: Difference, names: Sequence[str]) -> str:
    cubic = result.rates(names)
    linear = [name for name in names if name not in cubic]
    ways = [
        f"by cubic Hermite polynomials ({few(cubic)})" if cubic else "",
        f"linearly ({few(linear)})" if linear else "",
    ]
    source, target = short_labels([result.result.label, result.base.label])
    return f"{source} is interpolated to the times of {target} {' and '.join(filter(None, ways))}."
