"""A frequency response as tables and as a plot."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.messages import count, few
from mbdsl.plotting.figures import Figure, Series, TextTable
from mbdsl.plotting.series_styles import OTHERS
from mbdsl.plotting.signal_panels import ASPECTS, FLAT, labelled, look
from mbdsl.plotting.signal_plots import Plot
from mbdsl.plotting.terminal_text import text_width

if TYPE_CHECKING:
    from mbdsl.analysis.response_results import Peak, Response
    from mbdsl.messages import DisplayUnit

WIDTH = 80  #: columns where the width of the terminal is not known
PAIRS = 12  #: largest number of pairs of outputs and inputs whose values are printed
NICE = (1.0, 2.0, 5.0)  #: frequencies of the printed values, times powers of ten
CELL = 13


def text(response: Response, width: int = 0) -> str:
    """Resonances and values for a terminal, of at most ``width`` columns."""
    width = width or text_width(WIDTH)
    lines = [response._head()]
    pairs = [(j, k) for j in range(len(response.outputs)) for k in range(len(response.inputs))]
    for j, k in pairs[:PAIRS]:
        lines += ["", _named(response, j, k), *_peak_lines(response, j, k, width)]
    lines += ["", *_values(response, pairs[:PAIRS], width)]
    if len(pairs) > PAIRS:
        lines.append(f"... {count(len(pairs) - PAIRS, 'further pair')} of outputs and inputs; a .csv file has all")
    return "\n".join([*lines, *(f"note: {note}" for note in response.notes)])


def _named(response: Response, j: int, k: int) -> str:
    return labelled(f"{response.outputs[j]} / {response.inputs[k]}", response.shown(j, k).symbol)


def _of(response: Response, j: int, k: int) -> list[Peak]:
    names = response.outputs[j], response.inputs[k]
    return [peak for peak in response.peaks if (peak.output, peak.input) == names]


def _peak_lines(response: Response, j: int, k: int, width: int) -> list[str]:
    found = _of(response, j, k)
    if not found:
        return ["no resonance in this range" if response.H[:, j, k].any() else "no response"]
    hertz, factor = _hertz(response), response.shown(j, k).factor
    lines = [f"{f'f [{hertz.symbol}]':>23}  amplitude phase [deg] mode damping      Q  moves"]
    for peak in found:
        what = "resonance" if peak.highest else "antiresonance"
        mode, damping, quality, bodies = _mode_cells(response, peak)
        row = f"{what:13} {peak.frequency / hertz.factor:>9.6g} {_size(peak, factor):>10} {_degrees(peak.phase):>11}"
        row += f" {mode:>4} {damping:>7} {quality:>6}  "
        lines.append((row + textwrap.shorten(bodies, max(8, width - len(row)), placeholder="...")).rstrip())
    return lines


def _mode_cells(response: Response, peak: Peak) -> tuple[str, str, str, str]:
    """Number, damping ratio, quality factor and moving bodies of the mode of a peak."""
    if peak.mode is None:
        return "", "", "", ""
    shares = response.modes[peak.mode - 1].bodies.items()
    bodies = few([name for name, part in shares if part >= 0.05], 3)
    return str(peak.mode), f"{peak.damping:.3g}", f"{peak.Q:.3g}", bodies


def _size(peak: Peak, factor: float) -> str:
    return "infinite" if np.isinf(peak.amplitude) else f"{peak.amplitude / factor:.5g}"


def _hertz(response: Response) -> DisplayUnit:
    """The unit in which frequencies are displayed."""
    return response.scene.display.of("Hz")


def _degrees(phase: float) -> str:
    return "" if np.isnan(phase) else f"{round(float(np.degrees(phase)), 9) + 0.0:.4g}"


def peaks(response: Response) -> TextTable:
    """The resonances and antiresonances as a table."""
    hertz, rows = _hertz(response), []
    f = f"f [{hertz.symbol}]"
    heads = ("output", "input", "", f, "amplitude", "phase [deg]", "mode", "damping", "Q", "moving bodies")
    for peak in response.peaks:
        what = "resonance" if peak.highest else "antiresonance"
        unit = response.shown(response.outputs.index(peak.output), response.inputs.index(peak.input))
        cells = f"{peak.frequency / hertz.factor:.6g}", _size(peak, unit.factor), _degrees(peak.phase)
        rows.append((peak.output, peak.input, what, *cells, *_mode_cells(response, peak)))
    return TextTable("Resonances", heads, rows)


def shown_frequencies(response: Response) -> list[float]:
    """Round frequencies within the range, with its ends."""
    low, high = float(response.f[0]), float(response.f[-1])
    decades = range(int(np.floor(np.log10(low))) - 1, int(np.ceil(np.log10(high))) + 1)
    found = [float(f"{x}e{k}") for k in decades for x in NICE]
    return [low, *(x for x in found if low * (1.0 + 1e-9) < x < high * (1.0 - 1e-9)), high]


def values(response: Response, pairs: Sequence[tuple[int, int]]) -> TextTable:
    """Amplitudes and phases at round frequencies."""
    f = shown_frequencies(response)
    H = response.at_frequency(f)
    phase = _along(response, f)
    hertz = _hertz(response)
    heads, columns = [f"f [{hertz.symbol}]"], [[f"{x / hertz.factor:.6g}" for x in f]]
    for j, k in pairs:
        name = _named(response, j, k) if len(pairs) > 1 else labelled("amplitude", response.shown(j, k).symbol)
        heads += [name, "phase [deg]"]
        size = np.abs(H[:, j, k]) / response.shown(j, k).factor
        columns.append([f"{x:.5g}" for x in size])
        columns.append([_degrees(p) if x else "-" for x, p in zip(size, phase[:, j, k], strict=True)])
    return TextTable("Values", heads, list(zip(*columns, strict=True)))


def _along(response: Response, f: Sequence[float]) -> np.ndarray:
    """Phases (N, o, i) [rad] at frequencies, with the turns of the whole response."""
    known, H = response.phase, response.at_frequency(f)
    near = known[np.clip(np.searchsorted(response.f, f), 0, len(response.f) - 1)]
    angle = np.angle(H)
    return np.asarray(angle + 2.0 * np.pi * np.round((near - angle) / (2.0 * np.pi)))


def _values(response: Response, pairs: Sequence[tuple[int, int]], width: int) -> list[str]:
    """The values as lines; pairs that do not fit beside each other are continued below."""
    lines: list[str] = []
    each = max(1, (width - 10) // 26)
    for first in range(0, len(pairs), each):
        part = pairs[first : first + each]
        table = values(response, part)
        one = len(response.inputs) == 1
        full = [response.outputs[j] if one else f"{response.outputs[j]} / {response.inputs[k]}" for j, k in part]
        names = full if len(pairs) > 1 else []
        if names:
            lines.append(f"{'':10}" + "".join(f"{textwrap.shorten(name, 25, placeholder='...'):>26}" for name in names))
        heads = [table.columns[0], *("amplitude", "phase [deg]") * len(part)]
        lines.append(f"{heads[0]:>10}" + "".join(f"{head:>{CELL}}" for head in heads[1:]))
        lines += [f"{row[0]:>10}" + "".join(f"{cell:>{CELL}}" for cell in row[1:]) for row in table.rows]
    return lines


def plot(response: Response) -> Plot:
    """Amplitudes, one panel a unit, and phases over the frequency."""
    hertz, size, phase = _hertz(response), response.amplitude, np.degrees(response.phase)
    f, along = (response.f / hertz.factor).tolist(), f"frequency [{hertz.symbol}]"
    by_unit: dict[str, list[Series]] = {}
    phases, looks = [], {}
    several = len(response.inputs) > 1
    for j, output in enumerate(response.outputs):
        for k, name in enumerate(response.inputs):
            if not size[:, j, k].any():
                continue
            label = f"{output} / {name}" if several else output
            looks[label] = look(len(looks) % len(OTHERS), len(looks) // len(OTHERS))
            unit = response.shown(j, k)
            shown = np.where(size[:, j, k] > 0.0, size[:, j, k] / unit.factor, np.nan).tolist()
            by_unit.setdefault(unit.symbol, []).append(Series(label, f, shown, style="line"))
            phases.append(Series(label, f, phase[:, j, k].tolist(), style="line"))
    ends, aspect = (f[0], f[-1]), ASPECTS.get(len(by_unit) + 1, FLAT)
    per = "" if several else f" / {response.inputs[0]}"
    panels = []
    for n, (symbol, series) in enumerate(by_unit.items()):
        label = labelled(f"{series[0].name if len(series) == 1 else 'amplitude'}{per}", symbol)
        panels.append(Figure(f"amplitude-{n}", "", along, label, series, x_ends=ends, aspect=aspect))
    if phases:
        panels.append(Figure("phase", "", along, "phase [deg]", phases, y_log=False, x_ends=ends, aspect=aspect))
    return Plot(response._head(), tuple(panels), looks, (*_resonances(response, several), *response.notes))


def _resonances(response: Response, several: bool) -> list[str]:
    """A sentence about the resonances of each pair, for a plot."""
    found: dict[str, list[str]] = {}
    hertz = _hertz(response)
    for peak in response.peaks:
        mode = f" (mode {peak.mode})" if peak.mode is not None else ""
        if peak.highest:
            name = f"{peak.output} / {peak.input}" if several else peak.output
            found.setdefault(name, []).append(f"{hertz.text(peak.frequency, 4)}{mode}")
    lines = [f"{name}: resonance{'s' * (len(f) > 1)} at {few(f)}" for name, f in found.items()]
    return lines[:PAIRS]
