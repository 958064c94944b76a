"""Files made from declarations are those that the present declarations give: ``python .ci/generated_files.py``."""

import re
import runpy
import shutil
import sys
from pathlib import Path

import mbdsl
from mbdsl.elements import kinds
from mbdsl.elements.kind import JointKind
from mbdsl.lang import kind_reference

ROOT = Path(__file__).parents[3]
PROGRAM = ROOT / ".ci" / "generated_files.py"


NAMES = (
    *("docs/language.md", "docs/space.md", "docs/methods.md", "docs/command-line.md"),
    "editors/vscode/syntaxes/mbd.tmLanguage.json",
)


def loaded(program):
    """The names of the program, which puts its project into the path of modules."""
    path = list(sys.path)
    found = runpy.run_path(str(program))
    sys.path[:] = path
    return found


def test_all_are_up_to_date():
    program = loaded(PROGRAM)
    assert {*program["generated"]()} == {*NAMES}
    assert [*program["outdated"]()] == [], "run `python .ci/generated_files.py`"


def test_every_module_that_writes_a_file_of_the_project_is_listed():
    """A generator is a module with a main program that writes a file."""
    package, listed = Path(mbdsl.__file__).parent, PROGRAM.read_text(encoding="utf-8")
    writes = re.compile(r'^if __name__ == "__main__":(\n .*)*\bwrite_(text|bytes)\(', re.MULTILINE)
    found = [path.stem for path in package.rglob("*.py") if writes.search(path.read_text(encoding="utf-8"))]
    assert {"kind_reference", "method_reference", "textmate"} <= set(found)
    assert not [name for name in found if not re.search(rf"\b{name}\.\w+\(", listed)]


def test_a_stale_file_is_named_and_written_again(tmp_path, capsys):
    """In copies of the files, one of them damaged: --check leaves it, and the program writes it."""
    (tmp_path / ".ci").mkdir()
    program = loaded(shutil.copy(PROGRAM, tmp_path / ".ci"))
    for name in NAMES:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    page = tmp_path / "docs" / "language.md"
    right = page.read_bytes()
    damaged = right.replace(b"\n### Bodies\n", b"\n### Bodyes\n")
    assert damaged != right
    page.write_bytes(damaged)

    assert program["main"](["--check"]) == 1
    assert capsys.readouterr().out == "docs/language.md is out of date: run `python .ci/generated_files.py`\n"
    assert page.read_bytes() == damaged
    assert program["main"]([]) == 1
    assert capsys.readouterr().out == "docs/language.md was out of date and is written again: add it to the commit\n"
    assert page.read_bytes() == right
    assert program["main"](["--check"]) == 0


def test_tables_of_kinds_have_all_signals():
    for kind in (*kinds(False).values(), *kinds(True).values()):
        text = kind_reference.of_kind(kind)
        formulas = kind.formulas if isinstance(kind, JointKind) else {}
        assert not [name for name in formulas if f"`{name}`" not in text], kind.name
