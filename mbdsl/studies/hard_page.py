"""What the suite of hard cases found, as tables in Markdown."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mbdsl.studies.hard import Case, Cell

HEAD = """# Hard cases

Models chosen to break an integrator (`models/hard/`), each with an answer from outside: a closed form, equations in
minimal coordinates solved by SciPy to 1e-13, published data, or a reason to stop. `mbdsl study hard` runs them by every
method, at the step and with the tolerance of each case, and prints this page; it ends with exit code 4 where a run was
wrong without a word. The answers are written by `tests/verification/hard/answers.py`, without mbdsl.

A cell is the largest error, scaled: angles in radians, lengths in the mechanism's size, velocities in the largest one.
`E` is what total energy has lost or gained, over the energy exchanged. A cell in parentheses is above a thousandth (a
hundredth of energy), as the step explains: with half of it the run differs by a tenth of the error or more. `exit 4 at
1 s` is a run that stopped then; the number leads to the reason below the table. `not done` says how far a run came in
the time that it had. `WRONG` is a run that ended as if all was well, off by more than three times its tolerance or by
what its step does not explain, or one that stopped with the wrong reason.
"""


@dataclass(frozen=True)
class Suite:
    """All cells: a row for a case at its step or tolerance, in the columns the methods."""

    methods: tuple[str, ...]
    rows: tuple[tuple[Case, str, tuple[Cell | None, ...]], ...]

    @property
    def wrong(self) -> list[str]:
        """Runs that were wrong without a word."""
        return [
            f"{case}, {size}, {method}: {cell.text}"
            for case, size, cells in self.rows
            for method, cell in zip(self.methods, cells, strict=True)
            if cell is not None and cell.verdict == "WRONG"
        ]

    def __str__(self) -> str:
        """A table for each group: where its answers come from, cells, reasons."""
        return "\n\n".join(part for group in self.groups() for part in self._group(group)) + "\n\n" + self.count()

    def groups(self) -> list[str]:
        return list(dict.fromkeys(case.group for case, *_ in self.rows))

    def count(self) -> str:
        """How many runs there were, and how they ended."""
        found = [cell.verdict for *_, cells in self.rows for cell in cells if cell is not None]
        told = {
            "right": "right",
            "step": "off as the step explains",
            "stops": "stopped with a reason",
            "slow": "not done in time",
            "WRONG": "wrong",
        }
        return (
            f"{len(found)} runs of {', '.join(self.methods)}: "
            + ", ".join(f"{found.count(key)} {text}" for key, text in told.items())
            + "."
        )

    def page(self) -> str:
        """The whole page of the documentation."""
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
    """A cell, with the number of its reason."""
    if cell is None:
        return ""
    if not cell.reason:
        return str(cell)
    return f"{cell} [{notes.setdefault(cell.reason, len(notes) + 1)}]"
