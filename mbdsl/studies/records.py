"""The runs of a study as flat records and as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

import numpy as np

from mbdsl.studies.survey import Row


def record(row: Row) -> dict:
    """A run: its settings, costs and errors."""
    case, stats = row.case, row.run.stats
    found = {
        "method": case.method,
        **{f"option {name}": value for name, value in case.options},
        "step": case.step,
        "tol": case.tol,
        "outcome": row.run.problem or "done",
        **{key: stats.get(key) for key in ("steps", "rejected", "iterations", "matrix_evaluations", "factorisations")},
    }
    if row.seconds:
        found |= {
            "rounds": " ".join(f"{x:.6g}" for x in row.seconds),
            "seconds": float(np.median(row.seconds)),
            "seconds least": min(row.seconds),
            "seconds most": max(row.seconds),
            "timed runs": len(row.seconds),
        }
    for key, e in row.errors.items():
        found |= {
            key: e.largest,
            f"{key} scaled": e.scaled,
            f"{key} at end": e.end,
            f"{key} at end scaled": e.scaled_end,
        }
    return found


def as_csv(records: Sequence[dict]) -> str:
    """Records as CSV; a column for every name in any of them."""
    names = list(dict.fromkeys(name for record in records for name in record))
    text = io.StringIO()
    writer = csv.DictWriter(text, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows({k: repr(v) if isinstance(v, float) else v for k, v in record.items()} for record in records)
    return text.getvalue()
