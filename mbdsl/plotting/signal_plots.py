"""Plots of the signals of results: over the time, against a signal, as differences and as spectra."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.messages import count, few
from mbdsl.plotting import curves
from mbdsl.plotting.curves import Curve
from mbdsl.plotting.differences import Difference
from mbdsl.plotting.figures import Figure, Page, Panels, Series
from mbdsl.plotting.series_styles import DASHES, OTHERS, Look
from mbdsl.results.selection import select, unknown
from mbdsl.results.stored import Result

SUFFIXES = (".png", ".svg", ".pdf", ".html")
BODIES = 3  #: number of bodies of which the default signals are
FEW = 6  #: number of default signals if no name is that of a coordinate
COORDINATES = ("x", "y", "phi")
CONSTANT = 1e-9  #: default signals that vary by less than this part of the largest value of their unit are left out
QUANTITIES = {
    "m": "length",
    "rad": "angle",
    "m/s": "velocity",
    "rad/s": "angular velocity",
    "m/s2": "acceleration",
    "rad/s2": "angular acceleration",
    "N": "force",
    "N.m": "torque",
    "J": "energy",
    "W": "power",
    "s": "duration",
}
ASPECTS = {1: 0.5, 2: 0.34}  #: number of panels -> height of a panel over its width
FLOOR = 1e-4  #: lowest amplitude of a spectrum that is shown, over the largest of its panel
FLAT = 0.26  #: the same for more panels


class Plot(Panels):
    """A plot: panels with a shared axis, one below the other.

    ``print(plot)`` shows it in characters, a notebook as a picture.

    Attributes
    ----------
    title : str
    panels : tuple of Figure
        One for each unit, from the top.
    looks : mapping
        Name of a series -> its look.
    notes : tuple of str
        Sentences on what is shown: decimation, interpolation, omitted signals.
    """

    def save(self, path: str | os.PathLike) -> None:
        """Write the plot to a file.

        Parameters
        ----------
        path : path
            The file. Its suffix selects the format: .svg, .html, or .png and .pdf, which require matplotlib.

        Raises
        ------
        UsageError
            If the suffix is unknown, the file cannot be written, or matplotlib is not installed.
        """
        suffix = suffix_of(path)
        if suffix == ".html":
            from mbdsl.plotting.pages import write

            write(self.page(), path)
        elif suffix == ".svg":
            from mbdsl.plotting.panels_svg import svg
            from mbdsl.storage.output_files import write_text

            write_text(path, svg(self))
        else:
            from mbdsl.plotting.panels_picture import draw

            draw(self, path)

    def page(self) -> Page:
        """Return the plot as a page.

        Returns
        -------
        Page
        """
        return Page(self.title, self.notes, self.panels, looks=self.looks)

    def __str__(self) -> str:
        from mbdsl.plotting.characters import text

        return text(self)

    def _repr_svg_(self) -> str:
        from mbdsl.plotting.panels_svg import svg

        return svg(self)


def suffix_of(path: str | os.PathLike) -> str:
    """The suffix of an output file.

    Raises
    ------
    UsageError
        If it is unknown.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise UsageError(f"unknown suffix `{Path(path).suffix}` of `{path!s}`", hint=f"known are {', '.join(SUFFIXES)}")
    return suffix


def plot(
    results: Sequence[Result],
    patterns: Sequence[str] | None = None,
    *,
    against: str | None = None,
    difference: bool = False,
    spectrum: bool = False,
) -> Plot:
    """Plot signals of one or more results.

    Parameters
    ----------
    results : sequence of Result
        The results.
    patterns : sequence of str, optional
        Names and glob patterns of signals. Default: the coordinates of the first three bodies, without constant ones;
        if no signal is named as a coordinate, the first six signals.
    against : str, optional
        Name of the signal on the horizontal axis. Default: the time.
    difference : bool, optional
        Plot the second and further results minus the first one.
    spectrum : bool, optional
        Plot amplitude spectra.

    Returns
    -------
    Plot

    Raises
    ------
    UsageError
        If a pattern matches no signal, a result is empty or damaged, results do not fit together, or a signal has no
        spectrum.
    """
    results = _compared(results) if difference else list(results)
    labels = _short([result.label for result in results])
    known = list(dict.fromkeys(name for result in results for name in result.names))
    where = few(labels)
    against = None if against is not None and against.lower() == "time" else against
    if against is not None and (spectrum or not all(against in result.names for result in results)):
        if spectrum:
            raise UsageError("a spectrum is plotted against the frequency", hint="omit --against or --spectrum")
        lacking = [label for label, result in zip(labels, results, strict=True) if against not in result.names]
        raise unknown(against, known, few(lacking))
    chosen = (
        select(patterns, known, where)
        if patterns
        else default_signals([name for result in results for name in result.defaults])
    )
    chosen = [name for name in chosen if name not in (against, "time")]
    if not chosen:
        raise UsageError("there is no signal to plot", hint="`--signals '*'` chooses all; `--list` lists them")
    units = {name: _unit(name, results) for name in chosen}
    found = list(_curves(results, labels, chosen, against, spectrum))
    if not any(len(curve.x) for curve in found):
        raise UsageError(f"{where} has no rows" if len(results) == 1 else f"{where} have no rows")
    constant = [] if patterns else _constant(found, units)
    notes = _notes(results, labels, found, chosen, constant, known, bool(patterns), spectrum)
    if against is None:
        x_label = "frequency [Hz]" if spectrum else "time [s]"
    else:
        x_label = _labelled(against, _unit(against, results))
    kept = [curve for curve in found if curve.name not in constant]
    return _panels(kept, units, x_label, labels, notes, against, results)


def default_signals(names: Sequence[str]) -> list[str]:
    """The coordinates of the first bodies; if no name is that of a coordinate, the first few names."""
    owners: dict[str, list[str]] = {}
    known = dict.fromkeys(names)
    for name in known:
        owner, _, key = name.rpartition(".")
        if key in COORDINATES and owner and "." not in owner:
            owners.setdefault(owner, []).append(name)
    # Bodies have accelerations; frames have none, and joints only an angle.
    bodies = [owned for owner, owned in owners.items() if f"{owner}.ax" in known]
    bodies = bodies or [owned for owned in owners.values() if len(owned) > 1] or list(owners.values())
    return [name for owned in bodies[:BODIES] for name in owned] or list(known)[:FEW]


def _compared(results: Sequence[Result]) -> list[Result]:
    if len(results) < 2:
        raise UsageError("a difference needs two results", hint="give both: mbdsl plot a.csv b.csv --difference")
    return [Difference(result, results[0]) for result in results[1:]]


def _short(labels: Sequence[str]) -> list[str]:
    """The files' names without folders, if these differ."""
    short = [" − ".join(Path(part).name for part in label.split(" − ")) for label in labels]
    if len(set(short)) == len(short):
        return short
    return [label if labels.count(label) == 1 else f"{label} ({k + 1})" for k, label in enumerate(labels)]


def _unit(name: str, results: Sequence[Result]) -> str:
    units = {result.unit(name): result for result in results if name in result.names}
    units.pop("", None)
    if len(units) > 1:
        pairs = [f"{unit} in {result.label}" for unit, result in units.items()]
        raise UsageError(f"`{name}` has the unit {' and '.join(pairs)}", hint="plot the results one by one")
    return next(iter(units), "")


def _curves(
    results: Sequence[Result], labels: Sequence[str], chosen: Sequence[str], against: str | None, spectrum: bool
) -> Iterator[Curve]:
    for k, (result, label) in enumerate(zip(results, labels, strict=True)):
        have = set(result.names)
        names = [name for name in chosen if name in have]
        if spectrum:
            found = curves.of_frequency(result, names)
        elif against is None:
            found = curves.over_time(result, names)
        else:
            found = curves.in_plane(result, against, names)
        yield from (replace(curve, result=k, label=label) for curve in found)


def _constant(found: Sequence[Curve], units: Mapping[str, str]) -> list[str]:
    """Default signals that are constant in all results; none if all are."""
    size: dict[str, float] = {}
    for curve in found:
        size[units[curve.name]] = max(size.get(units[curve.name], 0.0), curve.largest)
    moves = {c.name for c in found if c.spread > CONSTANT * size[units[c.name]]}
    return [name for name in units if name not in moves] if moves else []


def _notes(
    results: Sequence[Result],
    labels: Sequence[str],
    found: Sequence[Curve],
    chosen: Sequence[str],
    constant: Sequence[str],
    known: Sequence[str],
    patterned: bool,
    spectrum: bool,
) -> tuple[str, ...]:
    notes = []
    if not patterned and len(chosen) < len(known):
        shown = count(len(chosen) - len(constant), "signal")
        notes.append(f"{shown} of {len(known)}; --signals chooses others, --list lists them.")
    if constant:
        notes.append(f"Constant, and left out: {few(constant)}.")
    for result, label in zip(results, labels, strict=True):
        missing = [name for name in chosen if name not in set(result.names)]
        if missing and len(results) > 1:
            notes.append(f"Not in {label}: {few(missing)}.")
        if isinstance(result, Difference) and result.interpolated:
            notes.append(_interpolation(result, chosen))
        meta = result.layout.meta
        if not meta.get("complete", True):
            reason = (
                "its accuracy was not reached" if meta.get("status") == "inaccurate" else "its run was not completed"
            )
            notes.append(f"{label} is marked: {reason}.")
    long = max((curve for curve in found if curve.reduced), key=lambda c: c.count, default=None)
    if long is not None:
        rows = f"{long.count:,}".replace(",", "\u202f")
        notes.append(f"{rows} rows: {long.reduced}")
    if spectrum:
        notes.append("Amplitude spectrum with a Hann window, mean removed: a sine of amplitude A shows A.")
        notes += dict.fromkeys(curve.remark for curve in found if curve.remark)
    return tuple(notes)


def _interpolation(result: Difference, chosen: Sequence[str]) -> str:
    names = [name for name in chosen if name in set(result.names)]
    cubic = result.rates(names)
    linear = [name for name in names if name not in cubic]
    ways = [
        f"by cubic Hermite polynomials ({few(cubic)})" if cubic else "",
        f"linearly ({few(linear)})" if linear else "",
    ]
    source, target = _short([result.result.label, result.base.label])
    return f"{source} is interpolated to the times of {target} {' and '.join(filter(None, ways))}."


def _panels(
    kept: Sequence[Curve],
    units: Mapping[str, str],
    x_label: str,
    labels: Sequence[str],
    notes: tuple[str, ...],
    against: str | None,
    results: Sequence[Result],
) -> Plot:
    by_unit: dict[str, list[Curve]] = {}
    for curve in kept:
        by_unit.setdefault(units[curve.name], []).append(curve)
    ends = _ends([curve.x for curve in kept])
    if against is not None:
        ends = ends[0] - 0.04 * (ends[1] - ends[0]), ends[1] + 0.04 * (ends[1] - ends[0])
    frequency = any(curve.frequency for curve in kept)
    if frequency:
        ends = 0.0, max(curve.frequency for curve in kept)
    looks: dict[str, Look] = {}
    panels = []
    equal = against is not None and len(by_unit) == 1 and set(by_unit) == {"m"} == {_unit(against, results)}
    for k, (unit, shown) in enumerate(by_unit.items()):
        order = {name: j for j, name in enumerate(dict.fromkeys(c.name for c in shown))}
        series = []
        for curve in shown:
            name = curve.name if len(labels) == 1 else f"{curve.name}, {curve.label}"
            looks[name] = look(order[curve.name], curve.result)
            style = "line" if len(curve.x) > 1 else "marks"
            series.append(Series(name, curve.x.tolist(), curve.y.tolist(), style=style))
        highest = max((curve.largest for curve in shown), default=0.0) if frequency else 0.0
        panels.append(
            Figure(
                f"panel-{k}",
                "",
                x_label,
                _labelled(_quantity(list(order), unit), unit),
                series,
                x_log=False,
                y_log=highest > 0.0,
                x_ends=None if equal else ends,
                y_ends=(FLOOR * highest, 2.0 * highest) if highest > 0.0 else None,
                aspect=None if equal else ASPECTS.get(len(by_unit), FLAT),
                equal=equal,
            )
        )
    return Plot(", ".join(labels), tuple(panels), looks, notes)


def look(signal: int, result: int) -> Look:
    """Colour and mark of the ``signal``-th signal of a panel, and the dashes of the ``result``-th result."""
    turn, place = divmod(signal, len(OTHERS))
    return replace(OTHERS[place], dash=DASHES[(result + turn) % len(DASHES)])


def _ends(values: Sequence[np.ndarray]) -> tuple[float, float]:
    finite = [v[np.isfinite(v)] for v in values]
    finite = [v for v in finite if len(v)] or [np.array([0.0, 1.0])]
    return float(min(v.min() for v in finite)), float(max(v.max() for v in finite))


def _quantity(names: Sequence[str], unit: str) -> str:
    """A label for several signals: their name, the last part of their names if it is common, or the quantity."""
    if len(names) == 1:
        return names[0]
    keys = {name.rpartition(".")[2] for name in names}
    return keys.pop() if len(keys) == 1 else QUANTITIES.get(unit, "value" if not unit else "")


def _labelled(text: str, unit: str) -> str:
    return f"{text} [{unit}]".strip() if unit else text
