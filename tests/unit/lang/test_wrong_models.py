"""Every wrong model of tests/data/wrong gives exactly the message in the file of the same name.

To accept changed messages, after reading them: ``python tests/unit/lang/test_wrong_models.py``.
"""

import os
from pathlib import Path

import pytest

from mbdsl.errors import MbdslError
from mbdsl.lang.load import load

FOLDER = Path(__file__).parents[2] / "data" / "wrong"
MODELS = sorted(p.stem for p in FOLDER.glob("*.mbd"))


def message(name: str) -> str:
    """The messages about a model, with paths relative to its folder."""
    before = os.getcwd()
    os.chdir(FOLDER)
    try:
        load(f"{name}.mbd")
    except MbdslError as problem:
        return problem.render() + "\n"
    finally:
        os.chdir(before)
    return "no error\n"


@pytest.mark.parametrize("name", MODELS)
def test_message_is_the_golden_one(name):
    assert message(name) == (FOLDER / f"{name}.txt").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", MODELS)
def test_message_says_where_and_what(name):
    first, *rest = (FOLDER / f"{name}.txt").read_text(encoding="utf-8").splitlines()
    place, _, what = first.partition(": error: ")
    file, line, column = place.split(":")
    assert file == f"{name}.mbd" and int(line) > 0 and int(column) > 0
    assert len(what) > 10 and not what.endswith(".")
    lines = (FOLDER / file).read_text(encoding="utf-8").splitlines()
    if int(line) <= len(lines) and len(lines[int(line) - 1]) < 80:
        assert rest[0] == "    " + lines[int(line) - 1]
        assert rest[1].index("^") == 4 + int(column) - 1


def test_there_are_many_and_none_is_without_its_message():
    assert len(MODELS) >= 60
    assert {p.stem for p in FOLDER.glob("*.txt")} == set(MODELS)


def test_messages_differ():
    """Each mistake has a message of its own."""
    said = {}
    for name in MODELS:
        first, *rest = (FOLDER / f"{name}.txt").read_text(encoding="utf-8").splitlines()
        text = first.partition(": error: ")[2] + "".join(line for line in rest if line.startswith("  = "))
        assert text not in said, f"{name} and {said[text]} say the same"
        said[text] = name


if __name__ == "__main__":
    for model in MODELS:
        (FOLDER / f"{model}.txt").write_text(message(model), encoding="utf-8")
