"""docs/paper-space.md: its tables are made from numbers.json, its pictures exist, and its errors are reproduced."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

DOCS = Path(__file__).parents[2] / "docs"
FOLDER = DOCS / "paper-space"
PAGE = (DOCS / "paper-space.md").read_text(encoding="utf-8")
NUMBERS = json.loads((FOLDER / "numbers.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def command():
    """The module of docs/draw_paper_space.py."""
    pytest.importorskip("matplotlib", reason="matplotlib is not installed: pip install 'mbdsl[plot]'")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(DOCS)
        import draw_paper_space

        yield draw_paper_space


def test_tables_are_those_of_the_numbers(command):
    """Run ``python docs/draw_paper_space.py``."""
    assert command.filled(PAGE, NUMBERS) == PAGE
    assert set(command.BLOCKS) == set(re.findall(r"<!-- (?!end)(.+) -->", PAGE))


def test_pictures_are_those_of_the_page(command):
    shown = set(re.findall(r"\(paper-space/(.+?\.png)\)", PAGE))
    drawn = {path.name for path in FOLDER.glob("*.png")}
    assert shown == drawn == {f"{figure.key}.png" for figure in command.figures(NUMBERS)}
    assert all((FOLDER / name).stat().st_size < 100_000 for name in drawn)


def test_errors_are_found_again(command, tmp_path, monkeypatch):
    """Of the longer steps. Numbers of four digits differ by 1e-3 if they are rounded differently, and an iteration more
    or less changes an error by 1e-4 of it, or velocities by 1e-10."""
    monkeypatch.setattr(command, "draw", lambda figure, path, **_: path.touch())
    command.main(["--quick", "--folder", str(tmp_path)])
    found = json.loads((tmp_path / "numbers.json").read_text(encoding="utf-8"))["errors"]
    assert found.keys() == NUMBERS["errors"].keys()
    for name, methods in found.items():
        for method, row in methods.items():
            kept = {h: NUMBERS["errors"][name][method][h] for h in row}
            assert row == pytest.approx(kept, rel=2e-3, abs=1e-10), (name, method)
            order = 1 if (name, method) == ("double pendulum", "newmark") else 2
            assert np.log2(row["0.004"] / row["0.002"]) == pytest.approx(order, abs=0.15)
