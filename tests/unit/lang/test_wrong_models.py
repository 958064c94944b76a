"""Every wrong model of tests/data/wrong gives exactly the message in the file of the same name, and every wrong input
of tests/data/wrong_inputs.txt the message below it.

To accept changed messages, after reading them: ``python tests/unit/lang/test_wrong_models.py``.
"""

import os
import re
from pathlib import Path

import pytest

from mbdsl.errors import MbdslError
from mbdsl.lang.load import load, parse_text

FOLDER = Path(__file__).parents[2] / "data" / "wrong"
INPUTS = FOLDER.parent / "wrong_inputs.txt"
WHOLE = re.compile(r"(import|model|package|within|record|function)\b")  #: how an input begins that is a whole text
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


# -- inputs in one model ------------------------------------------------------------------------------------------


def read_inputs():
    """The head of the file with the model around the inputs; title -> (input, message)."""
    head, *entries = re.split(r"^## ", INPUTS.read_text(encoding="utf-8"), flags=re.MULTILINE)
    found = {}
    for title, typed, expected in (re.fullmatch(r"(.*)\n((?s:.*))----\n((?s:.*))\n\n", e).groups() for e in entries):
        assert title not in found
        found[title] = typed, expected
    return head, found


HEAD, TYPED = read_inputs()
AROUND = HEAD[HEAD.index("model ") : HEAD.index("end Cart;")]


def message_about(typed: str) -> str:
    """The error about an input, else the warnings."""
    text = typed if WHOLE.match(typed) else f"{AROUND}{typed}end Cart;\n"
    try:
        return "\n".join(warning.render() for warning in parse_text(text, "cart.mbd").warnings) or "no error"
    except MbdslError as problem:
        return problem.render()


@pytest.mark.parametrize("title", TYPED)
def test_message_about_an_input(title):
    typed, expected = TYPED[title]
    assert message_about(typed) == expected


@pytest.mark.parametrize("title", TYPED)
def test_message_shows_the_place_and_what_is_right(title):
    _, expected = TYPED[title]
    first, line, caret, *rest = expected.splitlines()
    assert re.match(r"cart\.mbd:[0-9]+:[0-9]+: (error|warning|note): ", first)
    assert caret.strip().strip("^") == ""
    assert rest or re.search("expected|missing|must|has elements|already|takes|is false", first)
    marked = line[caret.index("^") : caret.rindex("^") + 1]
    assert not marked or marked.strip() or caret.strip() == "^"  # a caret behind the last word marks what is missing


def test_inputs_of_all_people():
    people = {title.partition(":")[0] for title in TYPED}
    assert people == {"Modelica user", "Adams engineer", "teacher", "researcher", "impatient person"}
    assert len(TYPED) >= 105


REMEDY = re.compile(r"`((?:Frame|Body|Rod|SpringDamper|Rotational\w+|Prismatic|Revolute|Fixed|Force|Bushing) [^`]*;)`")
REMEDIES = {
    title: REMEDY.findall(expected.splitlines()[-1])
    for title, (_, expected) in TYPED.items()
    if REMEDY.search(expected.splitlines()[-1])
}


@pytest.mark.parametrize("title", REMEDIES)
def test_remedies_are_text_of_the_language(title):
    """Declarations in remedies are accepted as they are, where they hold all values."""
    code = " ".join(REMEDIES[title])
    if "..." in code or "x, y" in code or "body.c" in code:
        return
    if code.startswith(("SpringDamper s(k", "RotationalSpringDamper friction(c", "Bushing")):  # connected by `connect`
        code = code.replace("(", "(world, rod.b, ", 1)
    typed = "" if title != "Modelica user: an axis of a prismatic joint" else "Body slider(m = 1, I = 1);"
    assert parse_text(f"{AROUND}{typed}{code}\nend Cart;\n").components


def test_there_are_remedies_with_declarations():
    assert len(REMEDIES) > 15


def write_inputs() -> None:
    texts = [f"## {title}\n{typed}----\n{message_about(typed)}\n\n" for title, (typed, _) in TYPED.items()]
    INPUTS.write_text(HEAD + "".join(texts), encoding="utf-8")


if __name__ == "__main__":
    write_inputs()
    for model in MODELS:
        (FOLDER / f"{model}.txt").write_text(message(model), encoding="utf-8")
