"""The pages are true: every ``mbd`` snippet is parsed.

A snippet that contains a whole model is read as it is; any other stands, as docs/language.md says, for a part of a
model with a ground, two rods and two joints.
"""

import re
from pathlib import Path

import pytest

from mbdsl.lang.load import parse_text
from mbdsl.lang.quantities import TYPES

ROOT = Path(__file__).parents[3]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
FENCE = re.compile(r"^```mbd[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)
BEFORE = (
    "model Snippet Ground ground; Rod crank(m = 1 kg, length = 0.3 m); Rod rod(m = 1 kg, length = 0.6 m); "
    "Revolute O(ground, crank.a); Revolute A(crank.b, rod.a); "
)


def snippets():
    for page in PAGES:
        if page.exists():
            text = page.read_text(encoding="utf-8")
            for match in FENCE.finditer(text):
                line = text.count("\n", 0, match.start()) + 2
                yield pytest.param(match.group(1), id=f"{page.name}:{line}")


@pytest.mark.parametrize("text", list(snippets()))
def test_snippet(text):
    whole = re.search(r"^\s*(spatial\s+)?(partial\s+)?model\s", text, re.MULTILINE)
    scene = parse_text(text if whole else f"{BEFORE}\n{text}\nend Snippet;")
    assert scene.components


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_no_line_of_text_begins_with_a_comment(page):
    """In Markdown such a line ends the paragraph, and is taken as HTML."""
    assert not re.findall(r"^\s*<!--.*?--> *[^\s<].*", page.read_text(encoding="utf-8"), re.MULTILINE)


def test_there_are_snippets():
    assert len(list(snippets())) > 15


def test_every_promise_names_a_test_that_exists():
    """``FILE::test``, or ``::test`` in the file named before."""
    text, file, found = (ROOT / "docs" / "reliability.md").read_text(encoding="utf-8"), None, 0
    for name, test in re.findall(r"`([\w/]+\.py)?::(\w+)`", text):
        file = name or file
        assert f"def {test}(" in (ROOT / file).read_text(encoding="utf-8"), f"{file}::{test}"
        found += 1
    assert found > 20
    promises = re.split(r"^\*\*", text, flags=re.MULTILINE)[1:]  # each paragraph begins in bold, and names its tests
    assert len(promises) > 15
    assert not [promise.splitlines()[0] for promise in promises if not re.search(r"`(tests/|::)", promise)]


def test_every_type_and_function_is_in_the_page():
    from mbdsl.lang.functions import FUNCTIONS
    from mbdsl.lang.units import _PLAIN, _PREFIXED

    words = set(re.findall(r"[A-Za-z][A-Za-z0-9_]*", (ROOT / "docs" / "language.md").read_text(encoding="utf-8")))
    assert {*TYPES, *FUNCTIONS, *_PLAIN, *_PREFIXED} <= words


def test_files_that_the_first_commands_write_are_ignored():
    """The commands of README.md run in the checkout: what they write is not a change of the project."""
    ignored = ROOT.joinpath(".gitignore").read_text(encoding="utf-8").splitlines()
    assert {"/*.csv", "/*.csv.events", "/*.html"} <= set(ignored)
