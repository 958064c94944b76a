"""The output of a study: text, CSV, JSON, figures and a page, with all data that are required to repeat it."""

from __future__ import annotations

import json
import math
import os
import shlex
import textwrap
from collections.abc import Iterable, Sequence
from datetime import datetime, timezone
from pathlib import Path

from mbdsl.errors import UsageError
from mbdsl.integrators.method_files import spelled
from mbdsl.messages import count, duration
from mbdsl.plotting.figure_layout import looks_of
from mbdsl.plotting.figures import Bars, Figure, Outcome, Page, TextTable
from mbdsl.plotting.series_styles import Look
from mbdsl.plotting.table_files import as_csv
from mbdsl.plotting.terminal_text import text_width
from mbdsl.simulation.provenance import machine, versions
from mbdsl.storage.output_files import write_text
from mbdsl.studies.cases import reaches
from mbdsl.studies.figure_parts import Score, method_looks, parts
from mbdsl.studies.survey import Survey, SurveyRow

PICTURES = ("png", "svg")
TROUBLES = 12  #: failed cases that are listed one by one
LONG = 40  #: largest number of rows of a table in a terminal
WIDTH = 100  #: characters of a line where the width of the terminal is not known
HEIGHT = 640  #: of the page in a notebook [px]


class Study:
    """Base class of the studies of methods, which define ``tables``, ``figures`` and ``summary``.

    ``str()`` returns the report for a terminal.

    Parameters
    ----------
    survey : Survey
        The runs and their errors.
    """

    kind = "study"
    timed = False  #: whether the option ``repeats`` applies

    def __init__(self, survey: Survey) -> None:
        self.survey = survey
        self.when = datetime.now(timezone.utc).isoformat(timespec="seconds")

    # -- defined by each study -------------------------------------------------------------------------------
    @property
    def title(self) -> str:
        """Model and kind of study."""
        return f"{self.survey.scene.name}: {self.kind}"

    def summary(self) -> list[str]:
        """Return the results in words.

        Returns
        -------
        list of str
            Sentences, the most important first.
        """
        return []

    def tables(self) -> list[TextTable]:
        """Return the results as tables.

        Returns
        -------
        list of Table
        """
        return []

    def figures(self) -> Sequence[Figure | Bars]:
        """Return the results as figures.

        Returns
        -------
        sequence of Figure or Bars
        """
        return []

    def answers(self) -> int:
        """Return the number of tables that come before the figures on the page.

        Returns
        -------
        int
        """
        return 0

    score: Score | None = None  #: the smaller, the better is a series of a figure

    # -- common to all studies -------------------------------------------------------------------------------
    def pictures(self) -> list[Figure | Bars]:
        """Return the figures in parts with few series each.

        Returns
        -------
        list of Figure or Bars
        """
        return [part for figure in self.figures() for part in parts(figure, type(self).score)]

    def looks(self) -> dict[str, Look]:
        """Return the look of every series: the same for a method in all figures.

        Returns
        -------
        dict
        """
        return looks_of(self.figures(), method_looks())

    def records(self) -> list[dict]:
        """Return one flat record a run: its settings, costs and errors.

        Returns
        -------
        list of dict
        """
        return [row.record() for row in self.survey.rows]

    def command(self) -> str:
        """Return the shell command that repeats the study with the same options and methods.

        Returns
        -------
        str
        """
        s, of = self.survey, self.survey.setting
        if of.path is None:
            return "none: the model is not from a file"
        said = ["mbdsl", "study", self.kind, of.path, "--methods", ",".join(map(spelled, self._methods()))]
        said += ["--model", of.model_name] if of.model_name else []
        for option, sizes in (("--steps", s.asked.steps), ("--tols", s.asked.tols)):
            said += [option, ",".join(repr(float(x)) for x in sizes)] if sizes is not None else []
        said += ["--stop", repr(of.stop)]
        for name, value in of.parameters.items():
            said += ["--set", f"{name}={value}"]
        said += ["--without", ",".join(of.without)] if of.without else []
        said += ["--allow-imports"] if of.allow_imports else []
        said += ["--signals", ",".join(s.asked.signals)] if s.asked.signals else []
        said += ["--reference", str(s.asked.reference)] if s.asked.reference != "auto" else []
        said += ["--repeats", str(s.asked.repeats)] if self.timed else []
        said += ["--budget", repr(float(s.asked.budget))]
        return shlex.join(said)

    def _methods(self) -> list[str]:
        """The requested methods; without a request, all methods that were run."""
        return list(self.survey.asked.methods or dict.fromkeys(row.case.method for row in self.survey.rows))

    def facts(self) -> dict:
        """Return the settings, versions and machine, as required to repeat the study.

        Returns
        -------
        dict
        """
        s = self.survey
        return {
            "study": self.kind,
            "command": self.command(),
            "model": s.scene.name,
            "when": self.when,
            "versions": versions(),
            "machine": machine(),
            "start": s.setting.start,
            "stop": s.setting.stop,
            "output points": s.setting.points,
            "methods": list(dict.fromkeys(row.case.method for row in s.rows)),
            "steps": list(dict.fromkeys(row.case.step for row in s.rows if row.case.step is not None)),
            "tolerances": list(dict.fromkeys(row.case.tol for row in s.rows if row.case.tol is not None)),
            "cases": {name: [row.case.size for row in rows] for name, rows in s.series().items()},
            "repeats": s.asked.repeats,
            "budget": s.asked.budget,
            "parameters": dict(s.setting.parameters),
            "without": list(s.setting.without),
            "random numbers": "none",
            "reference": str(s.reference),
            "trusted digits": {q.key: s.reference.digits(q) for q in s.quantities if not q.itself},
            "runs": {"computed": s.runner.computed, "found in the store": s.runner.found},
        }

    def data(self) -> dict:
        """Return the content of the JSON file.

        Returns
        -------
        dict
        """
        model = {"files": self._texts(), "scene": self.survey.scene.fingerprint}
        return {**self.facts(), "model text": model, "summary": self.summary(), "rows": self.records()}

    def page(self) -> Page:
        """Return the content of the HTML page: the answers, the figures, then the other tables.

        Returns
        -------
        Page
        """
        tables, first = self.tables(), self.answers()
        items: list[Figure | Bars | TextTable] = [*tables[:first], *self.pictures(), *tables[first:]]
        small = [(name, _plain(value)) for name, value in self.facts().items()]
        small += [(f"text of {file}", text) for file, text in self._texts().items()]
        return Page(self.title, self.summary(), items, small, self.looks())

    def _texts(self) -> dict[str, str]:
        """The text of the model's files as read, by their path relative to the main file."""
        files = self.survey.scene.files
        folder = os.path.dirname(next(iter(files), "")) or "."
        return {Path(os.path.relpath(file, folder)).as_posix(): text for file, text in files.items()}

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.survey.scene.name}: {count(len(self.survey.rows), 'run')}>"

    def _repr_html_(self) -> str:
        from mbdsl.plotting import html_tables, pages

        return html_tables.frame(pages.html(self.page()), HEIGHT)

    def text(self, most: int = LONG) -> str:
        """Return the report for a terminal.

        Parameters
        ----------
        most : int, optional
            Largest number of rows of a table; of longer tables only the number of rows is given.

        Returns
        -------
        str
        """
        parts = [self.title]
        for table in self.tables():
            rest = f"{table.title}: {len(table.rows)} rows, on the page (--verbose prints them)"
            parts.append(as_text(table) if len(table.rows) <= most else rest)
        lines = [
            line for said in self.summary() for line in textwrap.wrap(said, text_width(WIDTH), break_long_words=False)
        ]
        return "\n\n".join([*parts, "\n".join(lines)])

    def write(self, folder: str | os.PathLike, pictures: Sequence[str] = PICTURES) -> list[Path]:
        """Write the study into a folder: ``KIND.csv``, ``.json``, ``.html`` and ``KIND-FIGURE.png``, ``.svg``.

        Parameters
        ----------
        folder : path
            Made if it does not exist.
        pictures : sequence of {"png", "svg"}, optional
            Formats of the figures.

        Returns
        -------
        list of Path
            The files.

        Raises
        ------
        UsageError
            If the folder cannot be written; or, after everything else is written, if matplotlib is not installed.
        """
        return write(self, folder, pictures)


def write(study: Study, folder: str | os.PathLike, pictures: Sequence[str]) -> list[Path]:
    where, stem = Path(folder), study.kind
    try:
        where.mkdir(parents=True, exist_ok=True)
        paths = [where / f"{stem}.csv", where / f"{stem}.json"]
        write_text(paths[0], as_csv(study.records()))
        write_text(paths[1], json.dumps(_finite(study.data()), indent=2) + "\n")
        page = where / f"{stem}.html"
        from mbdsl.plotting import pages

        pages.write(study.page(), page)
        paths.append(page)
    except OSError as problem:
        raise UsageError(f"cannot write into `{where}`: {problem.strerror or problem}") from problem
    return paths + draw(study, where, pictures)


def draw(study: Study, folder: str | os.PathLike, pictures: Sequence[str] = PICTURES) -> list[Path]:
    """Write ``KIND-FIGURE.png``, ``.svg`` and return their paths.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    # the page has the parts of all families; as files they would take longer to draw than many studies to run
    each = [(parts(figure, type(study).score)[0], suffix) for figure in study.figures() for suffix in pictures]
    paths = [Path(folder) / f"{study.kind}-{figure.key}.{suffix}" for figure, suffix in each]
    if paths:
        from mbdsl.plotting import pictures as drawing
        from mbdsl.plotting.sheets import sheet

        known = study.looks()
        for (figure, _), path in zip(each, paths, strict=True):
            drawing.draw(sheet(figure.title, [figure], known), path)
    return paths


def as_text(table: TextTable, width: int | None = None, lead: int = 2) -> str:
    """A table as text for a terminal, with numbers aligned to the right; the default ``width`` is that of the terminal.

    Columns that do not fit are continued below, with the first ``lead`` columns repeated.
    """
    width = text_width(WIDTH) if width is None else width
    rows = [list(table.columns), *map(list, table.rows)]
    widths = [max(len(row[k]) for row in rows) for k in range(len(table.columns))]
    right = [_numbers(row[k] for row in table.rows) for k in range(len(table.columns))]
    blocks = [list(range(min(lead, len(widths))))]
    for k in range(lead, len(widths)):
        if len(blocks[-1]) > lead and sum(widths[j] + 2 for j in blocks[-1]) + widths[k] > width:
            blocks.append(list(range(lead)))
        blocks[-1].append(k)
    lines = [table.title] if table.title else []
    for block in blocks:
        lines += [""] if block is not blocks[0] else []
        for row in rows:
            cells = (row[k].rjust(widths[k]) if right[k] else row[k].ljust(widths[k]) for k in block)
            lines.append("  ".join(cells).rstrip())
    return "\n".join([*lines, *([table.note] if table.note else [])])


def _numbers(cells: Iterable[str]) -> bool:
    kinds = {"number" if c[0] in "0123456789-.+(" else c for c in cells if c}
    return "number" in kinds and kinds <= {"number", "failed", "not run", "not timed"}


def outcomes(rows: Iterable[SurveyRow]) -> list[Outcome]:
    """Rows without a point because they failed."""
    return [Outcome(r.case.series, r.case.size, r.run.problem) for r in rows if r.run.problem and not r.run.late]


def troubles(s: Survey) -> list[str]:
    """Sentences on cases that were not run or failed."""
    late = [row for row in s.rows if row.run.late]
    failed: dict[tuple[str, str], list[SurveyRow]] = {}
    for row in s.rows:
        if row.run.problem and not row.run.late:
            failed.setdefault((row.case.series, row.run.problem), []).append(row)
    lines = [
        f"{rows[0].case if len(rows) == 1 else f'{series}, {len(rows)} cases'}: {problem}"
        for (series, problem), rows in failed.items()
    ]
    if len(lines) > TROUBLES:
        lines = [*lines[:TROUBLES], f"... and {len(lines) - TROUBLES} more"]
    if late:
        which = f"{len(late)} of {len(s.rows)} cases were not run, as the budget of {s.asked.budget:g} s was spent"
        lines.append(f"{which}; run the same command again to continue.")
    between = [row for row in s.rows if row.run.done and s.quantities and not reaches(s.setting, row.case)]
    if any(row.case.step is not None for row in between) and not all(q.itself for q in s.quantities):
        lines.append("Not all steps end at output times: values there are interpolated between steps.")
    if alike := [row for row in between if row.own is row.trajectory]:
        which = "1 case" if len(alike) == 1 else f"{len(alike)} cases"
        lines.append(f"Constraints and energy of {which} are those of output interpolated between steps.")
    return lines + [f"{name} is left out: {why}." for name, why in s.refused]


def number(x: float | None, digits: int = 2) -> str:
    """An error with few digits."""
    return "" if x is None or not math.isfinite(x) else "0" if x == 0.0 else f"{x:.{digits - 1}e}".replace("e-0", "e-")


def ratio(one: float, other: float) -> str:
    """A ratio with two digits, without an exponent."""
    return f"{float(f'{one / other:.2g}'):,.12g}"


def size(row_or_case) -> str:
    """The step or tolerance of a case as text."""
    case = getattr(row_or_case, "case", row_or_case)
    return duration(case.step) if case.tol is None else f"{case.tol:.0e}".replace("e-0", "e-")


def _plain(value) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{k}: {_plain(v)}" for k, v in value.items())
    if isinstance(value, list):
        return ", ".join(map(_plain, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _finite(value):
    """``x`` for JSON, which has no infinities and no nan."""
    if isinstance(value, dict):
        return {k: _finite(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
