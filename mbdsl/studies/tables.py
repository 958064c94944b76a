"""The tables of studies as files: Markdown, LaTeX and CSV."""

from __future__ import annotations

import os
from collections.abc import Sequence

from mbdsl.plotting import table_files
from mbdsl.plotting.figures import TextTable
from mbdsl.storage.output_files import suffix_of
from mbdsl.studies.effects import EffectsStudy, Without
from mbdsl.studies.recommendation import Recommendation
from mbdsl.studies.report import Study


def write(study: Study | EffectsStudy | Recommendation, path: str | os.PathLike) -> None:
    """Write the tables of a study to a file.

    Parameters
    ----------
    study : Study, EffectsStudy or Recommendation
        The result of a study, such as ``convergence``, ``effects`` or ``recommend``.
    path : path
        The file. Its suffix selects the format: .md or .tex for the tables as printed, .csv for one row per run
        with all digits.

    Raises
    ------
    UsageError
        If the suffix is unknown, or the file cannot be written.
    """
    suffix_of(path, table_files.SUFFIXES)
    if isinstance(study, Study):
        table_files.write(path, study.tables(), study.records(), study.title, study.summary())
    elif isinstance(study, EffectsStudy):
        title = f"{study.scene.name}: {study.signal} without effects"
        table_files.write(path, [_of_effects(study)], _records(study), title, _notes(study))
    else:
        table_files.write(path, [study._table()], _choices(study), study._head(), [*study._answer(), *study._rest()])


def _of_effects(s: EffectsStudy) -> TextTable:
    columns = ("without", f"change of {s.signal}{f' [{s.unit}]' if s.unit else ''}", "run time [%]", "")
    rows = []
    for r in _rows(s):
        doubt = "less than the error of the step" if r.change is not None and r.change <= s.error else ""
        change = "" if r.change is None else f"{r.change:.3e}"
        time = "" if r.time is None else f"{100 * r.time:.0f}"
        rows.append((", ".join(r.effects), change, time, r.problem or doubt))
    return TextTable("", columns, rows)


def _choices(found: Recommendation) -> list[dict]:
    unit = f" [{found.unit}]" if found.unit else ""
    return [
        {
            "method": c.case.method,
            "series": c.case.series,
            "step [s]": c.case.step,
            "tol": c.case.tol,
            f"error{unit}": float(c.error),
            "time [s]": float(c.time),
        }
        for c in found.choices
    ]


def _rows(s: EffectsStudy) -> list[Without]:
    together = [s.together] if s.together is not None and len(s.together.effects) > 1 else []
    return [*s.rows, *together]


def _records(s: EffectsStudy) -> list[dict]:
    unit = f" [{s.unit}]" if s.unit else ""
    return [
        {
            "without": " ".join(r.effects),
            f"change{unit}": r.change,
            f"error of the step{unit}": s.error,
            "relative run time": r.time,
            "outcome": r.problem or "done",
        }
        for r in _rows(s)
    ]


def _notes(s: EffectsStudy) -> Sequence[str]:
    unit = f" {s.unit}" if s.unit else ""
    found = [f"{s.signal} is between {s.low:.6g} and {s.high:.6g}{unit}; the error of the step is {s.error:.1e}{unit}."]
    return [*found, f"Not in the model: {', '.join(s.absent)}."] if s.absent else found
