"""The page of the hard cases, and the program that makes it by runs of every case with every method, in an hour.

``python tests/verification/hard/hard_page.py --output docs/hard-cases.md``; without ``--output`` it prints the tables.
Its exit code is 4 if a run was wrong without an error message.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from hard_case import Case, Cell
from hard_runs import BUDGET, measure, read

from mbdsl.integrators import compiled

ROOT = Path(__file__).parents[3]

HEAD = """# Hard cases

Models chosen to break an integrator (`models/hard/`), each with an independent answer: a closed form, equations in
minimal coordinates solved by SciPy to 1e-13, published data, or the expected reason to stop.
`tests/verification/hard/hard_page.py` runs them, at the step and with the tolerance of each case, and prints this page,
with a column for each method that was run. It ends with exit code 4 if a run was wrong without an error message.
`tests/verification/hard/answers.py` computes the answers without mbdsl.

A cell shows the largest error, scaled: angles in radians, lengths relative to the mechanism's size, velocities relative
to the largest one. `E` is the change of the total energy relative to the energy exchanged. An error in parentheses is
above 1e-3 (1e-2 for energy) because the step is too long: a run with half the step, or with a 64th, differs by a tenth
of the error or more. `exit 4 at 1 s` is a run that stopped at that time; the number refers to the reason below the
table. `not done` gives the time that a run reached within its time limit. `WRONG` is a run that reported no error
although it was off by more than three times its tolerance or by more than its step explains, or one that stopped for
the wrong reason.
"""


@dataclass(frozen=True)
class Suite:
    """All results: a row for each case at its step or tolerance, a column for each method."""

    methods: tuple[str, ...]
    rows: tuple[tuple[Case, str, tuple[Cell | None, ...]], ...]

    @property
    def wrong(self) -> list[str]:
        """Runs that were wrong without an error message."""
        return [
            f"{case}, {size}, {method}: {cell.text}"
            for case, size, cells in self.rows
            for method, cell in zip(self.methods, cells, strict=True)
            if cell is not None and cell.verdict == "WRONG"
        ]

    def __str__(self) -> str:
        """A table for each group: sources of the answers, results, reasons."""
        return "\n\n".join(part for group in self.groups() for part in self._group(group)) + "\n\n" + self.count()

    def groups(self) -> list[str]:
        return list(dict.fromkeys(case.group for case, *_ in self.rows))

    def count(self) -> str:
        """Number of runs, by their results."""
        found = [cell.verdict for *_, cells in self.rows for cell in cells if cell is not None]
        texts = {
            "right": "right",
            "step": "inaccurate because of the step",
            "stops": "stopped with a reason",
            "slow": "not done in time",
            "WRONG": "wrong",
        }
        return (
            f"{len(found)} runs of {', '.join(self.methods)}: "
            + ", ".join(f"{found.count(key)} {text}" for key, text in texts.items())
            + "."
        )

    def page(self) -> str:
        """The page of the documentation."""
        return f"{HEAD}\n{self}\n"

    def _group(self, group: str) -> Iterator[str]:
        rows = [row for row in self.rows if row[0].group == group]
        notes: dict[str, int] = {}
        yield f"## {group}"
        models = {case.model.stem: " ".join(case.answer.split()) for case, *_ in rows}
        yield "\n".join(f"- `{name}`: {answer}" for name, answer in models.items())
        lines = [
            f"| case | | {' | '.join(f'`{name}`' for name in self.methods)} |",
            "|---" * (2 + len(self.methods)) + "|",
        ]
        for case, size, cells in rows:
            lines.append(f"| {case} | {size} | {' | '.join(_numbered(cell, notes) for cell in cells)} |")
        yield "\n".join(lines)
        if notes:
            yield "\n".join(f"- [{k}] {reason}" for reason, k in notes.items())


def _numbered(cell: Cell | None, notes: dict[str, int]) -> str:
    """A result, with the number of its reason."""
    if cell is None:
        return ""
    if not cell.reason:
        return str(cell)
    return f"{cell} [{notes.setdefault(cell.reason, len(notes) + 1)}]"


def suite(cases: Sequence[Case], methods: Sequence[str], budget: float, tell: Callable[[str], None]) -> Suite:
    """Run every case by every method, at its step and with its tolerance, within ``budget`` [s] a run."""
    rows = []
    for case in cases:
        for tol, size in ((False, case.step), (True, case.tol)):
            if size is not None:
                tell(str(case))
                cells = tuple(measure(case, method, tol, budget) for method in methods)
                rows.append((case, f"tol {size:g}" if tol else f"h = {size:g} s", cells))
    return Suite(tuple(methods), tuple(rows))


def main(*arguments: str) -> int:
    parser = argparse.ArgumentParser(description="Run the hard cases by every method.")
    parser.add_argument("folder", nargs="?", default=ROOT / "models" / "hard", help="models and answers, or one model")
    parser.add_argument("--cases", default="*", help="glob of the cases")
    parser.add_argument("--methods", nargs="+", default=list(compiled()))
    parser.add_argument("--budget", type=float, default=BUDGET, help="time limit of a run [s]")
    parser.add_argument("--output", type=Path, help="file for the page")
    asked = parser.parse_args(arguments)
    found = suite(
        read(asked.folder, asked.cases), asked.methods, asked.budget, lambda text: print(text, file=sys.stderr)
    )
    if asked.output:
        asked.output.write_text(found.page(), encoding="utf-8")
    else:
        print(found)
    for run in found.wrong:
        print(f"wrong without an error message: {run}", file=sys.stderr)
    return 4 if found.wrong else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
