"""mbdsl info: the content of a result file."""

from __future__ import annotations

import argparse
import os
from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.messages import count, duration, few, visible
from mbdsl.plotting.terminal_text import text_width
from mbdsl.results.selection import select

if TYPE_CHECKING:
    import numpy as np

    from mbdsl.results.stored import Result

MOST = 30  #: signals that are listed without --signals
WIDTH = 80  #: columns where the width of the terminal is not known
ABOUT = ("model", "method", "options", "step", "tolerance", "error", "horizon", "steps", "iterations", "version")


COMMAND = Command(
    "show the content of a result file",
    "Print model, method, times and rows of a result file, and the unit, the first, the last, the least and the "
    "largest value of its signals.",
    f"""
    result RESULT  result file
    --signals PATTERN,...  signals to list (globs, expressions); default: the first {MOST}; '*' lists all
    @units
    """,
)


@dataclass
class ValueRange:
    """first, last, least and largest value of a signal, and the number of values that are not finite."""

    first: float = float("nan")
    last: float = float("nan")
    least: float = float("inf")
    largest: float = float("-inf")
    missing: int = 0


@dataclass
class Content:
    """Ranges of signals, and of the times with their least and largest difference."""

    rows: int = 0
    shortest: float = float("inf")
    longest: float = 0.0
    time: ValueRange = field(default_factory=ValueRange)
    signals: dict[str, ValueRange] = field(default_factory=dict)


def run(args: argparse.Namespace) -> int:
    from mbdsl.lang.display_units import asked
    from mbdsl.results.stored import open_result
    from mbdsl.simulation.extremes import Extremes
    from mbdsl.simulation.result_expressions import with_expressions
    from mbdsl.simulation.stored_extremes import of_result

    patterns = values.signals(args) or []
    opened = open_result(args.result)
    result = with_expressions(opened, patterns)
    chosen = result.names[:MOST]
    if args.signals:
        chosen = [x for x in select(patterns, result.names, args.result, of_file=True) if x != result.time]
    result.display = asked(args.units, result.display)
    content = _content(result, chosen)
    stored = of_result(result)
    kept = Extremes((stored[name] for name in chosen if name in stored), result.display)
    for line in [*_head(args.result, result, content, _units(opened)), *_table(result, content)]:
        print(line)
    if kept:
        print(f"over all steps of the run:\n{kept}")
    elif content.signals:
        print("least and largest are of the outputs; the file has no extremes of all steps")
    if not args.signals and len(result.names) > MOST:
        print(f"... {len(result.names) - MOST} more; --signals '*' lists all")
    return 0


def _content(result: Result, names: list[str]) -> Content:
    import numpy as np

    found = Content(signals={name: ValueRange() for name in names})
    for times, columns in result.chunks(names):
        if not len(times):
            continue
        steps = np.diff(times, prepend=found.time.last) if found.rows else np.diff(times)
        if len(steps):
            found.shortest = min(found.shortest, float(steps.min()))
            found.longest = max(found.longest, float(steps.max()))
        _add(found.time, times, not found.rows)
        for name in names:
            _add(found.signals[name], columns[name], not found.rows)
        found.rows += len(times)
    return found


def _add(known: ValueRange, values: np.ndarray, first: bool) -> None:
    import numpy as np

    if first:
        known.first = float(values[0])
    known.last = float(values[-1])
    finite = np.isfinite(values)
    if not finite.all():
        known.missing += int((~finite).sum())
        values = values[finite]
    known.least = min(known.least, float(values.min(initial=np.inf)))
    known.largest = max(known.largest, float(values.max(initial=-np.inf)))


def _head(path: str, result: Result, content: Content, units: str) -> list[str]:
    from mbdsl.simulation.stored_events import of_meta

    meta = result.layout.meta
    status = "complete" if meta.get("complete", True) else f"incomplete: {meta.get('status', 'the run has not ended')}"
    lines = [values.written(path, f"{_bytes(os.path.getsize(path))}, {status}")]
    for key in ABOUT:
        if (value := meta.get(key)) not in (None, ""):
            text = f"mbdsl {value}" if key == "version" else _value(key, value)
            text += ", its text is in the file" if key == "model" and meta.get("source") else ""
            lines += _wrapped(key, text)
    if content.rows:
        unit = result.display.of("s", result.time)
        first, last = content.time.first / unit.factor, content.time.last / unit.factor
        span = f"{first:.9g} ... {last:.9g} {unit.symbol}, {count(content.rows, 'row')}"
        lines.append(f"{'time':<12}{span}{_steps(content)}")
    else:
        lines.append(f"{'time':<12}no rows")
    kinds = Counter[str]()
    for group in of_meta(meta):
        kinds[group.kind] += len(group.times)
    if kinds:
        said = ", ".join(f"{n} {kind}" for kind, n in kinds.most_common())
        lines += _wrapped("events", f"{kinds.total()} ({said})")
    lines.append(f"{'signals':<12}{len(result.names)}, {units}")
    return lines


def _units(file: Result) -> str:
    """The units of the numbers in a file."""
    from mbdsl.lang import units

    own = dict.fromkeys(unit for unit in file.layout.units.values() if unit not in ("", "1"))
    others = [unit for unit in own if (found := units.parse(unit)) is not None and found.factor != 1.0]
    said = "in SI units" if own else "in SI units if mbdsl has written them; the file names none"
    return f"in {few(others)}, others in SI units" if others else said


def _steps(content: Content) -> str:
    """The differences of the times, if there are some."""
    if content.rows < 2:
        return ""
    if content.longest - content.shortest <= 1e-6 * content.longest:
        return f" every {duration(content.longest)}"
    return f", {duration(content.shortest)} to {duration(content.longest)} apart"


def _value(key: str, value: object) -> str:
    if not isinstance(value, float):
        return visible(str(value), line=True)
    if key in ("step", "horizon"):
        return duration(value)
    return f"{value:.0f}" if value.is_integer() and abs(value) < 1e15 else f"{value:.6g}"


def _wrapped(key: str, text: str) -> list[str]:
    import textwrap

    lines = textwrap.wrap(text, text_width(WIDTH) - 12) or [""]
    return [f"{key if k == 0 else '':<12}{line}" for k, line in enumerate(lines)]


def _bytes(size: int) -> str:
    for unit, factor in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= factor:
            return f"{size / factor:.3g} {unit}"
    return f"{size} bytes"


def _table(result: Result, content: Content) -> list[str]:
    if not content.signals:
        return []
    names = {name: visible(name, line=True) for name in content.signals}
    wide = min(max(7, *map(len, names.values())), max(7, text_width(WIDTH) - 55))
    lines = [
        f"{'outputs':<{wide}}  {'unit':<7}" + "".join(f"{title:>11}" for title in ("first", "last", "least", "largest"))
    ]
    for name, known in content.signals.items():
        text = names[name]
        if len(text) > wide:
            lines.append(text)
            text = ""
        empty = known.least > known.largest
        numbers = (known.first, known.last, *((float("nan"),) * 2 if empty else (known.least, known.largest)))
        unit = result.display.of(result.unit(name), name)
        row = f"{text:<{wide}}  {unit.symbol[:7]:<7}" + "".join(f"{x / unit.factor:>11.4g}" for x in numbers)
        lines.append(f"{row} *" if known.missing else row)
    if any(known.missing for known in content.signals.values()):
        lines.append("* has values that are not finite; least and largest are those of the others")
    return lines
