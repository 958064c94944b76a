"""Line budgets: ``python .ci/line_budgets.py`` fails if a room of ``mbdsl/`` has more lines of Python than its budget.

The budgets are in ``line_budgets.json``. The modules that lie in ``mbdsl/`` itself are the room ``root``. Stubs
(``.pyi``) are generated and not counted. A commit that needs more lines raises the number of its room in the table, and
gives the reason in its message; a commit that removes many lines lowers it.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "mbdsl"
TABLE = Path(__file__).with_suffix(".json")
ROOT = "root"  #: the room of the modules in the package's own folder


def lines(package: Path = PACKAGE) -> dict[str, int]:
    """Room -> number of lines of its ``.py`` files, in all of its folders."""
    found: Counter[str] = Counter()
    for file in package.rglob("*.py"):
        inside = file.relative_to(package).parts
        found[inside[0] if len(inside) > 1 else ROOT] += len(file.read_text(encoding="utf-8").splitlines())
    return dict(sorted(found.items()))


def violations(found: dict[str, int], budgets: dict[str, int]) -> list[str]:
    """One message for each room above its budget, without a budget, or with a budget but without files."""
    messages = []
    for room in sorted({*found, *budgets}):
        number, budget = found.get(room), budgets.get(room)
        if budget is None:
            messages.append(f"{room}: {number} lines and no budget; add the room to .ci/{TABLE.name}")
        elif number is None:
            messages.append(f"{room}: a budget of {budget} lines, but no files; remove the room from .ci/{TABLE.name}")
        elif number > budget:
            messages.append(
                f"{room}: {number} lines, {number - budget} above its budget of {budget}. Remove lines, or raise the "
                f"number in .ci/{TABLE.name} in the same commit and give the reason in the commit message"
            )
    return messages


def main() -> int:
    found, budgets = lines(), json.loads(TABLE.read_text(encoding="utf-8"))
    messages = violations(found, budgets)
    print("\n".join(messages) or f"{sum(found.values())} lines in {len(found)} rooms, none above its budget")
    return 1 if messages else 0


if __name__ == "__main__":
    sys.exit(main())
