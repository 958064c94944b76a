"""README and docs are true: their commands and Python snippets run, and print the output that is shown.

In order of the page, in one folder that has the models: ``mbd`` fences whose first line is ``// NAME.mbd`` become that
file, as do ``python`` fences whose docstring is ``NAME.py``; in ``bash`` and ``console`` fences every ``mbdsl`` command
runs; the text of a ``console`` fence below ``$ ...`` has to be the printed output, where "..." stands for any text or,
in a line of its own, for any lines; ``python`` fences run one after the other.
"""

import contextlib
import io
import re
import runpy
import shlex
import shutil
import sys
from pathlib import Path

import pytest

from mbdsl import cli

ROOT = Path(__file__).parents[3]
FENCE = re.compile(r"^```(\w+)[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)


def in_tests(path):
    """Films of docs/gallery/ have their own tests, tests/gallery/test_every_model.py; commands with output run here."""
    return path.parent.name != "gallery" or "```console" in path.read_text(encoding="utf-8")


PAGES = [ROOT / "README.md", *sorted(path for path in (ROOT / "docs").rglob("*.md") if in_tests(path))]


def run(command):
    """Exit code and everything printed by the ``mbdsl`` commands in a line of shell."""
    code, printed = 0, io.StringIO()
    for part in command.split("&&"):
        words = shlex.split(part, comments=True)
        if words and Path(words[0]).name == "mbdsl":
            with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
                code = cli.main(words[1:])
    # output that depends on the machine or on earlier runs: progress of runs of more than a second, and compiling
    lines = printed.getvalue().splitlines(keepends=True)
    return code, "".join(line for line in lines if not re.match(r" *\d+%  t = |compiling for the first time", line))


def commands(body, console):
    """(command, output shown or None) of a fence."""
    if not console:
        return [(line, None) for line in body.replace("\\\n", " ").splitlines()]
    blocks = re.split(r"^\$ ", body.replace("\\\n", " "), flags=re.MULTILINE)[1:]
    return [(command, shown) for command, _, shown in (block.partition("\n") for block in blocks)]


def matches(shown, printed):
    """Whether ``shown`` is ``printed``; "..." is any part of a line, or any number of lines where it has its own."""
    pattern = "".join(
        r"(?:.*\n)*" if line == "..." else ".*".join(re.escape(part) for part in line.split("...")) + r"\n"
        for line in shown.strip().splitlines()
    )
    return re.fullmatch(pattern, "".join(line + "\n" for line in printed.strip().splitlines())) is not None


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_page(page, tmp_path, monkeypatch):
    shutil.copytree(ROOT / "models", tmp_path / "models")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.setattr(sys, "argv", ["mbdsl"])
    monkeypatch.setattr("mbdsl.integrators._given", {})  # registrations by a page
    names = {"__name__": "__main__"}
    for language, body in FENCE.findall(page.read_text(encoding="utf-8")):
        if language == "mbd" and (name := re.match(r"// (\w+\.mbd)\n", body)):
            Path(name[1]).write_text(body, encoding="utf-8")
        elif language == "python":
            if name := re.match(r'"""(\w+\.py)"""\n', body):
                Path(name[1]).write_text(body, encoding="utf-8")
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(body, f"{page.name}: python", "exec"), names)
        elif language == "console" or (language == "bash" and page.parent.name != "gallery"):
            for command, shown in commands(body, language == "console"):
                code, printed = run(command)
                assert code == 0 or (shown and "error: " in shown), f"{command}\n{printed}"
                assert shown is None or matches(shown, printed), f"{command}\n{printed}"


def test_the_picture_can_be_drawn(tmp_path, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "Agg")
    runpy.run_path(str(ROOT / "docs" / "draw_seven_body.py"))["main"](tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 10_000


def test_readme_begins_with_the_two_commands():
    first_screen = ROOT.joinpath("README.md").read_text(encoding="utf-8").splitlines()[:30]
    shell = [line for line in first_screen if "pip install" in line]
    assert len(shell) == 2
    assert "mbdsl simulate" in shell[0]
    assert "pytest" in shell[1]


def test_the_reader_of_fences():
    page = "```console\n$ mbdsl a \\\n  -b\nout\nmore\n$ mbdsl c\n```\n```bash\nmbdsl d\n```\n"
    (console, first), (bash, second) = FENCE.findall(page)
    assert (console, bash) == ("console", "bash")
    assert commands(first, True) == [("mbdsl a    -b", "out\nmore\n"), ("mbdsl c", "")]
    assert commands(second, False) == [("mbdsl d", None)]


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        ("a\n", "a", True),
        ("a\n", "b", False),
        ("a ... c\n", "a 1 c", True),
        ("a\n", "a\nb", False),
        ("", "a", False),
        ("...\na\n", "a\n", True),
        ("...\na\n", "x\ny\na", True),
        ("a...\n", "a\nb", False),
    ],
)
def test_what_is_shown_is_compared(shown, printed, same):
    assert matches(shown, printed) is same
