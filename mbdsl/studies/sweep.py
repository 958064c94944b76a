"""Sweep: a run for each combination of values of parameters, and measures of the signals of each run."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import product
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import MbdslError, UsageError
from mbdsl.lang.library import allowed_now
from mbdsl.lang.load import load
from mbdsl.mechanism.scene import ParameterValue, Scene
from mbdsl.mechanism.signal_names import SignalNames
from mbdsl.messages import count, did_you_mean, few
from mbdsl.plotting.figures import Table
from mbdsl.simulation.plan import DEFAULT_METHOD, plan
from mbdsl.studies import measures as measuring
from mbdsl.studies.cases import chosen
from mbdsl.studies.measures import Measure
from mbdsl.studies.report import LONG, WIDTH, as_text
from mbdsl.studies.runner import Runner, StudyProgress
from mbdsl.studies.store import CHANGED, Computed, Store
from mbdsl.studies.sweep_runs import Point, SweepSetting, times
from mbdsl.studies.sweep_values import FORMS, MOST, Varied, varied

if TYPE_CHECKING:
    import pandas

    from mbdsl.studies.sweep_figures import SweepPlot

Array = NDArray[np.float64]
TROUBLES = 8  #: reasons of failures that are listed
DONE, FAILED, LATE = "done", "failed", "not finished"


class Sweep:
    """The runs of a sweep. ``print(sweep)`` shows a table; notebooks show a page.

    ``sweep["max(pin.fx)"]`` is the column (N,) of a measure and ``sweep["L"]`` that of a parameter, in the units of
    ``sweep.unit(name)``; N is the number of runs.

    Attributes
    ----------
    parameters : tuple of Varied
        Parameters and their values.
    measures : tuple of Measure
        Measures.
    runs : tuple of Computed
        Runs in the order of the rows; the last parameter changes fastest.
    paired : bool
        Whether row k has value k of each parameter; otherwise the rows are all combinations.
    limit : float [s]
        Time limit of a run.
    """

    def __init__(
        self,
        name: str,
        parameters: Sequence[Varied],
        measures: Sequence[Measure],
        indices: Sequence[tuple[int, ...]],
        runs: Sequence[Computed],
        paired: bool = False,
        limit: float = math.inf,
        found: int = 0,
    ) -> None:
        self.name, self.parameters, self.measures = name, tuple(parameters), tuple(measures)
        self.indices, self.runs, self.paired, self.limit = list(indices), tuple(runs), paired, limit
        self.found = found  #: number of runs that were taken from the store

    def __len__(self) -> int:
        return len(self.runs)

    def __repr__(self) -> str:
        return f"<Sweep of {self.name} over {few([p.name for p in self.parameters])}: {count(len(self), 'run')}>"

    def __str__(self) -> str:
        return self.text()

    def _repr_html_(self) -> str:
        from mbdsl.plotting.html_tables import fragment

        title, *notes = self.summary()
        return fragment(title, (), [self.table()], notes)

    # -- values ------------------------------------------------------------------------------------------------
    @property
    def names(self) -> list[str]:
        """Names of the columns: parameters, then measures."""
        return [p.name for p in self.parameters] + [str(m) for m in self.measures]

    def unit(self, name: str) -> str:
        """Return the unit of a column.

        Parameters
        ----------
        name : str
            A parameter or a measure.

        Returns
        -------
        str
            "" if it has none. Parameters are in the unit in which they were given, measures in SI units.
        """
        self._known(name)
        return next((x.unit for x in (*self.parameters, *self.measures) if name in (str(x), getattr(x, "name", ""))), "")

    def __getitem__(self, name: str) -> Array:
        self._known(name)
        for k, p in enumerate(self.parameters):
            if p.name == name:
                if p.numbers is None:
                    raise UsageError(f"the values of {name} are no numbers", hint="sweep.table() has them as texts")
                return np.array([p.numbers[row[k]] for row in self.indices])
        return np.array([run.stats["values"][name] if run.done else math.nan for run in self.runs])

    def _known(self, name: str) -> None:
        if name not in self.names:
            hint = did_you_mean(name, self.names) or f"it has {few(self.names)}"
            raise UsageError(f"the sweep has no column `{name}`", hint=hint)

    def grid(self, measure: str) -> Array:
        """Return a measure over all combinations.

        Parameters
        ----------
        measure : str
            A measure.

        Returns
        -------
        (n1, n2, ...) array
            One axis a parameter; nan where a run failed.

        Raises
        ------
        UsageError
            If there is no such measure, or the parameters are paired.
        """
        if self.paired:
            raise UsageError("paired parameters have no grid", hint=f'use sweep["{measure}"]')
        return self[measure].reshape([len(p) for p in self.parameters])

    @property
    def failed(self) -> list[int]:
        """Rows without values, because their runs failed or were not finished."""
        return [k for k, run in enumerate(self.runs) if not run.done]

    def reason(self, k: int) -> str:
        """Why row ``k`` has no values; "" if it has.

        Parameters
        ----------
        k : int
            Number of the row, from 0.

        Returns
        -------
        str
        """
        run = self.runs[k]
        return f"not finished within {self.limit:g} s" if run.late else run.problem

    def point(self, k: int) -> str:
        """The values of the parameters of row ``k``: ``L = 1.2 m, k = 5 N/mm``.

        Parameters
        ----------
        k : int
            Number of the row, from 0.

        Returns
        -------
        str
        """
        return ", ".join(p.said(j) for p, j in zip(self.parameters, self.indices[k], strict=True))

    def to_pandas(self) -> pandas.DataFrame:
        """Return parameters, measures and outcomes as a data frame; requires pandas.

        Returns
        -------
        pandas.DataFrame
            One row a run. The column "outcome" is "done" or the reason of the failure.
        """
        import pandas

        return pandas.DataFrame(self.records())

    # -- as text and files ---------------------------------------------------------------------------------------
    def table(self, digits: int = 6) -> Table:
        """Return the table of all runs.

        Parameters
        ----------
        digits : int, optional
            Significant digits.

        Returns
        -------
        Table
            With a column "outcome" if a run failed.
        """
        failed = bool(self.failed)
        heads = [*(p.head for p in self.parameters), *(m.head for m in self.measures), *(["outcome"] if failed else [])]
        columns = {str(m): self[str(m)] for m in self.measures}
        rows = []
        for k, run in enumerate(self.runs):
            row = [p.shown(j, digits) for p, j in zip(self.parameters, self.indices[k], strict=True)]
            row += [number(column[k], digits) for column in columns.values()]
            rows.append([*row, *([DONE if run.done else LATE if run.late else FAILED] if failed else [])])
        return Table("", heads, rows)

    def summary(self) -> list[str]:
        """Return what was run, and which runs failed or have warnings.

        Returns
        -------
        list of str
            Sentences; the first one is a title.
        """
        how = "paired" if self.paired and len(self.parameters) > 1 else ""
        over = (" and " if how else " x ").join(f"{p.name} ({len(p)})" for p in self.parameters)
        lines = [f"{self.name}: {count(len(self), 'run')} over {over}{f', {how}' if how else ''}"]
        reasons: dict[str, list[int]] = {}
        for k in self.failed:
            reasons.setdefault(self.reason(k), []).append(k)
        if reasons:
            lines.append(f"{len(self.failed)} of {count(len(self), 'run')} failed:")
            lines += [f"  {self._where(rows)}: {reason}" for reason, rows in list(reasons.items())[:TROUBLES]]
            lines += [f"  and {len(reasons) - TROUBLES} other reasons"] if len(reasons) > TROUBLES else []
        said: dict[str, list[int]] = {}
        for k, run in enumerate(self.runs):
            for line in run.stats.get("warnings", ()) if run.done else ():
                said.setdefault(line, []).append(k)
        warned = sorted({k for rows in said.values() for k in rows})
        if warned:
            line, rows = next(iter(said.items()))
            lines.append(f"{count(len(warned), 'run has', 'runs have')} warnings, the first ({self._where(rows)}): {line}")
        return lines

    def _where(self, rows: Sequence[int]) -> str:
        first = self.point(rows[0])
        return first if len(rows) == 1 else f"{first} and {len(rows) - 1} more"

    def text(self, width: int = WIDTH, most: int = LONG) -> str:
        """Return the table for a terminal.

        Parameters
        ----------
        width : int, optional
            Largest number of characters of a line; further columns are continued below.
        most : int, optional
            Largest number of rows; of a longer table the first and the last rows are shown.

        Returns
        -------
        str
        """
        table = self.table()
        rows = list(table.rows)
        if len(rows) > most:
            half = most // 2
            left = f"... {len(rows) - 2 * half} rows"
            rows = [*rows[:half], [left, *[""] * (len(table.columns) - 1)], *rows[-half:]]
        shown = as_text(Table("", table.columns, rows), width, len(self.parameters))
        title, *notes = self.summary()
        title += f" ({self.found} of them stored before)" if self.found else ""
        return "\n".join([title, "", shown, *([""] if notes else []), *wrapped(notes, width)])

    def save(self, path: str | os.PathLike) -> None:
        """Write the table or the picture.

        Parameters
        ----------
        path : path
            The file. Its suffix selects the content: .csv (all digits), .md, .tex (tables), .html (a page with table
            and pictures), .svg, .png, .pdf (pictures; the last two require matplotlib).

        Raises
        ------
        UsageError
            If the suffix is unknown, the file cannot be written, or matplotlib is not installed.
        """
        from mbdsl.studies.sweep_files import save

        save(self, path)

    def plot(self) -> SweepPlot:
        """Return the measures as curves over the parameter with the most values, or as maps over two.

        Returns
        -------
        SweepPlot
            ``plot.save(path)`` writes it.
        """
        from mbdsl.studies.sweep_figures import plot

        return plot(self)

    def records(self) -> list[dict]:
        """Return one record a run, with all digits.

        Returns
        -------
        list of dict
            Column with its unit -> number or text. The column "outcome" is "done" or the reason of the failure.
        """
        columns = {m.head: self[str(m)].tolist() for m in self.measures}
        found = []
        for k, row in enumerate(self.indices):
            record: dict = {
                p.head: p.texts[j] if p.numbers is None else p.numbers[j]
                for p, j in zip(self.parameters, row, strict=True)
            }
            record |= {head: column[k] for head, column in columns.items()}
            found.append(record | {"outcome": self.reason(k) or DONE})
        return found


def number(x: float, digits: int = 6) -> str:
    """A value of a table; "-" if there is none."""
    return f"{x:.{digits}g}" if math.isfinite(x) else "-"


def wrapped(lines: Iterable[str], width: int) -> list[str]:
    """Lines of at most ``width`` characters; those that begin with spaces keep them."""
    import textwrap

    found = []
    for line in lines:
        indent = " " * (len(line) - len(line.lstrip()))
        found += textwrap.wrap(line, width, subsequent_indent=indent, break_long_words=False) or [""]
    return found


def sweep(
    model: str | PathLike,
    vary: Mapping[str, str | Iterable],
    measures: str | Sequence[str] | None = None,
    *,
    paired: bool = False,
    after: float | None = None,
    method: str | None = None,
    step: float | None = None,
    tol: float | None = None,
    start: float | None = None,
    stop: float | None = None,
    interval: float | None = None,
    options: Mapping[str, float | None] | None = None,
    parameters: Mapping[str, str | float] | None = None,
    without: Sequence[str] = (),
    limit: float | None = None,
    workers: int | None = None,
    store: str | PathLike | None = None,
    fresh: bool = False,
    tell: Callable[[StudyProgress], None] | None = None,
    announce: Callable[[str], None] | None = None,
) -> Sweep:
    """Run a model with each combination of values of parameters, on all cores, and measure signals of each run.

    Completed runs are stored; a sweep that was interrupted continues when it is called again.

    Parameters
    ----------
    model : path
        A ``.mbd`` file.
    vary : mapping
        Parameter -> its values: a text "start:stop:count" or "start:stop:count:log", with a unit after it ("1:10:5
        N/mm"), a text "1, 2, 5", or a sequence of numbers in SI units, Booleans or texts with units.
    measures : str or sequence of str, optional
        What is recorded of each run: ``max(pin.fx)``; functions are final, min, max, maxabs, mean, rms, amplitude,
        period, time_of_max and time_of_min; glob patterns stand for several signals. Default: least and largest value
        of the coordinates of the first body.
    paired : bool, optional
        Whether the first values of all parameters belong together, then the second, and so on. Default: all
        combinations.
    after : float, optional [s]
        Values before this time do not count.
    method, step, tol, start, stop, options, parameters, without, announce : optional
        As for ``mbdsl.simulate``.
    interval : float, optional [s]
        Output interval. Default: (stop - start)/2000. Measures are those of the output.
    limit : float, optional [s]
        Time limit of a run. A run that exceeds it has no values and is not stored.
    workers : int, optional
        Number of processes. Default: the number of cores.
    store : path, optional
        Folder of stored runs. Default: a subfolder of mbdsl's cache folder.
    fresh : bool, optional
        Whether to ignore stored runs.
    tell : callable, optional
        Called with the progress of the sweep.

    Returns
    -------
    Sweep
        A run that failed has a row with the reason.

    Raises
    ------
    UsageError, ModelError
        If the arguments are invalid, or the model is invalid with all values.
    KeyboardInterrupt
        If it is interrupted; completed runs are stored.
    """
    if not isinstance(model, (str, PathLike)):
        raise UsageError("a sweep needs the path of a model", hint="parameters belong to a .mbd file")
    ranges = [varied(name, values) for name, values in vary.items()]
    indices = _indices(ranges, paired)
    fixed = dict(parameters or {})
    for p in ranges:
        if p.name in fixed:
            raise UsageError(f"`{p.name}` is set and varied", hint="leave one of them out")
    if limit is not None and not limit > 0.0:
        raise UsageError(f"a time limit of {limit:g} s leaves no time for a run")
    points = [tuple((p.name, p.texts[j]) for p, j in zip(ranges, row, strict=True)) for row in indices]
    scene = _readable(model, fixed, without, points)
    ranges = [_with_unit(p, scene) for p in ranges]
    names = SignalNames(scene)
    asked = measuring.split(measures) if isinstance(measures, str) else measures
    chosen_measures = measuring.read(asked or measuring.usual(names), names)
    name = chosen([method])[0] if method is not None else scene.experiment.method or DEFAULT_METHOD
    of = SweepSetting(
        scene,
        scene.experiment.start if start is None else start,
        math.nan,
        0,
        os.fspath(model),
        fixed,
        tuple(without),
        allowed_now(),
        times_asked={"start": start, "stop": stop, "interval": interval},
        measures=tuple(chosen_measures),
        after=-math.inf if after is None else after,
    )
    run = plan(scene, name, step, tol, options=options, **times(of, scene))
    if after is not None and not after < run.stop:
        raise UsageError(f"no values after {after:g} s: the runs end at {run.stop:g} s", hint="give an earlier time")
    runner = Runner(of, Store(store, fresh), workers=workers, tell=tell, announce=announce)
    given = tuple(sorted((key, float(x)) for key, x in (options or {}).items() if x is not None))
    cases = [Point(name, step, tol, given, values=values) for values in points]
    runs = runner.compute(cases, limit=math.inf if limit is None else limit)
    if any(found.problem == CHANGED for found in runs.values()):
        raise UsageError(f"{CHANGED}, so that its runs do not belong together", hint="run it again")
    return Sweep(
        scene.name,
        ranges,
        chosen_measures,
        indices,
        [runs[case] for case in cases],
        paired,
        math.inf if limit is None else limit,
        runner.found,
    )


def _indices(ranges: Sequence[Varied], paired: bool) -> list[tuple[int, ...]]:
    """Indices of the values of each row."""
    if not ranges:
        raise UsageError("a sweep varies a parameter", hint=f"give --vary, such as {FORMS}")
    sizes = [len(p) for p in ranges]
    if paired:
        if len(set(sizes)) > 1:
            said = ", ".join(f"{p.name} has {len(p)}" for p in ranges)
            raise UsageError(f"paired parameters have the same number of values: {said}")
        return [(k,) * len(ranges) for k in range(sizes[0])]
    if math.prod(sizes) > MOST:
        said = " x ".join(map(str, sizes))
        raise UsageError(
            f"{said} = {math.prod(sizes)} runs are too many: a sweep has at most {MOST}",
            hint="give fewer values, or several sweeps",
        )
    return list(product(*map(range, sizes)))


def _readable(
    model: str | PathLike, fixed: Mapping, without: Sequence[str], points: Sequence[tuple[tuple[str, str], ...]]
) -> Scene:
    """The model at the first, the last or the middle point at which it is valid.

    Raises
    ------
    MbdslError
        If it is valid at none of them: that of the first.
    """
    first: MbdslError | None = None
    for values in dict.fromkeys((points[0], points[-1], points[len(points) // 2])):
        try:
            return load(model, {**fixed, **dict(values)}, without=without)
        except MbdslError as problem:
            first = first or problem
    assert first is not None
    raise first


def _with_unit(p: Varied, scene: Scene) -> Varied:
    """The parameter with the unit of its declaration, if its values have none."""
    owner, _, name = p.name.rpartition(".")
    declared = scene.parameters.get(p.name, ParameterValue("", None)).unit
    if owner in scene.components:
        declared = next((x.unit for x in scene.components[owner].kind.parameters if x.name == name), "")
    if p.unit or p.numbers is None or declared in ("", "1"):
        return p
    return Varied(p.name, p.texts, p.numbers, declared, p.log)
