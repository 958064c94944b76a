"""A link that leads back to itself, in place of any file argument: one line, exit code 2, and no file is written."""

import os
from pathlib import Path

import pytest

from mbdsl.cli import main

MODEL = Path(__file__).parents[3] / "models" / "pendulum.mbd"


@pytest.mark.parametrize(
    "command",
    [
        ["check", "loop.mbd"],
        ["check", "two.mbd"],
        ["check", "imports.mbd"],
        ["check", "loop/m.mbd"],
        ["simulate", "MODEL", "--output", "loop.csv"],
        ["simulate", "MODEL", "--output", "loop/r.csv"],
        ["simulate", "MODEL", "--output", "r.csv", "--stats", "loop.csv"],
        ["simulate", "MODEL", "--output", "r.csv", "--checkpoint", "loop.csv"],
        ["resume", "loop.csv"],
        ["eigen", "MODEL", "--output", "loop.csv"],
        ["study", "convergence", "MODEL", "--steps", "1ms,2ms", "--output", "loop"],
        ["study", "convergence", "MODEL", "--steps", "1ms,2ms", "--reference", "loop.csv"],
    ],
    ids=" ".join,
)
def test_loops(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("loop", "loop.mbd", "loop.csv"):
        os.symlink(name, name)
    os.symlink("three.mbd", "two.mbd")
    os.symlink("two.mbd", "three.mbd")
    Path("imports.mbd").write_text('import "loop.mbd";\nmodel M Ground ground; end M;\n')
    before = sorted(os.listdir())
    assert main([str(MODEL) if word == "MODEL" else word for word in command]) == 2
    stderr = capsys.readouterr().err
    assert "link" in stderr  # POSIX's text is "Too many levels of symbolic links"
    assert "internal" not in stderr
    assert sorted(os.listdir()) == before
