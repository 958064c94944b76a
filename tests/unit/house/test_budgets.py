"""No room of the package has more lines than its budget, and the program that adds them up sees all of them."""

import json
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).parents[3] / ".ci" / "line_budgets.py"
BUDGETS = runpy.run_path(str(PROGRAM))


def test_no_room_is_above_its_budget():
    messages = BUDGETS["violations"](BUDGETS["lines"](), json.loads(BUDGETS["TABLE"].read_text(encoding="utf-8")))
    assert not messages, "\n" + "\n".join(messages)


def test_every_line_of_the_package_is_counted_once():
    """Compared with a count of line ends over all files, which knows no rooms."""
    files = BUDGETS["PACKAGE"].glob("**/*.py")
    assert sum(BUDGETS["lines"]().values()) == sum(file.read_bytes().count(b"\n") for file in files) > 50_000


@pytest.fixture
def package(tmp_path):
    """A package with two lines in its own folder, three in the room ``a`` and its folder, and a stub."""
    texts = {"__init__.py": "x = 1\n", "api.py": "y = 2\n", "a/b.py": "1\n2\n", "a/c/d.py": "3\n", "a/b.pyi": "4\n5\n"}
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def test_folders_belong_to_their_room_and_stubs_do_not_count(package):
    assert BUDGETS["lines"](package) == {"a": 3, "root": 2}


def test_the_message_says_what_to_do(package):
    violations = BUDGETS["violations"]
    assert violations(BUDGETS["lines"](package), {"a": 3, "root": 2}) == []
    (message,) = violations(BUDGETS["lines"](package), {"a": 2, "root": 2})
    assert message == (
        "a: 3 lines, 1 above its budget of 2. Remove lines, or raise the number in .ci/line_budgets.json in the same "
        "commit and give the reason in the commit message"
    )
    unknown, empty = violations({"a": 3}, {"b": 2})
    assert unknown.startswith("a: 3 lines and no budget")
    assert empty.startswith("b: a budget of 2 lines, but no files")


def test_the_program_fails_above_a_budget(tmp_path):
    """As pre-commit runs it: a copy beside a package of three lines, with a table that allows three, then two."""
    home = tmp_path / "project"
    (home / ".ci").mkdir(parents=True)
    (home / "mbdsl").mkdir()
    (home / "mbdsl" / "api.py").write_text("1\n2\n3\n", encoding="utf-8")
    (home / ".ci" / PROGRAM.name).write_bytes(PROGRAM.read_bytes())
    for budget, code in ((3, 0), (2, 1)):
        (home / ".ci" / "line_budgets.json").write_text(json.dumps({"root": budget}), encoding="utf-8")
        done = subprocess.run(
            [sys.executable, home / ".ci" / PROGRAM.name], capture_output=True, text=True, encoding="utf-8"
        )
        assert done.returncode == code, done.stderr
    assert done.stdout.startswith("root: 3 lines, 1 above its budget of 2.")
