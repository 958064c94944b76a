"""docs/architecture.md agrees with the package: its rooms, modules and functions, and the order of its arrows."""

import ast
import re
import sys
from functools import reduce
from importlib import import_module
from inspect import unwrap
from pathlib import Path

import pytest

import mbdsl
from mbdsl.cli.show import COMMAND
from mbdsl.compilation import code_cache
from mbdsl.lang import parser

ROOT = Path(__file__).parents[3]
PACKAGE = Path(mbdsl.__file__).parent
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
PICTURE = PAGE.partition("```text\n")[2].partition("```")[0]
#: a file and, behind a colon, names in it
REFERENCE = re.compile(r"((?:[\w.]+/)*\w+\.py|\.ci/\w+\.json)\b(?::\s+([\w.]+(?:,\s\w+(?![\w/]*\.))*))?")


def references(text):
    """(File, names) of all files in a text."""
    for file, names in REFERENCE.findall(text):
        yield file, tuple(name for name in re.split(r",\s", names.rstrip(".")) if name)


def module_of(file):
    name = file.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    return import_module(f"mbdsl.{name}")


def code_of(file, name):
    """The code of a function, which identifies its calls."""
    return unwrap(reduce(getattr, name.split("."), module_of(file))).__code__


def test_the_table_lists_the_rooms_from_the_top_down():
    rows = re.findall(r"^\| (`.*?) \|", PAGE.partition("## Rooms")[2].partition("\n## ")[0], re.MULTILINE)
    listed = [name.removesuffix("/").removesuffix(".py") for row in rows for name in re.findall(r"`(.*?)`", row)]
    folders = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    files = {path.stem for path in PACKAGE.glob("*.py")} - {"__init__", "__main__"}
    assert set(listed) == folders | files
    rules = ast.parse(Path(__file__).with_name("test_import_rules.py").read_text(encoding="utf-8"))
    (order,) = [x.value for x in rules.body if isinstance(x, ast.Assign) and ast.unparse(x.targets[0]) == "ROOMS"]
    rooms = eval(compile(ast.Expression(order), "ROOMS", "eval"))
    assert listed == [name for name in rooms if name not in ("__init__", "__main__")]


def test_folders_in_the_table_exist():
    """``methods/`` and others, of the room in the first column."""
    for room, text in re.findall(r"^\| `(\w+)/` \| (.*) \|$", PAGE, re.MULTILINE):
        for folder in re.findall(r"`(\w+)/`", text):
            assert (PACKAGE / room / folder).is_dir(), f"{room}/{folder}"


def test_every_file_and_every_name_exists():
    found = list(references(PAGE))
    for file, names in found:
        home = ROOT if file.startswith(("tests/", ".ci/")) else PACKAGE
        assert (home / file).is_file(), file
        for name in names:
            assert reduce(getattr, name.split("."), module_of(file)), f"{file}: {name}"
    assert len(found) > 60
    assert sum(len(names) for _, names in found) > 50


def test_the_reader_of_references():
    text = "`a/b.py: f`, `c.py:\n g.h`. x/y.py: p, q\n (z.py) `d.py` and .ci/e.json; f.py: k, i/j.py: l."
    assert list(references(text)) == [
        *(("a/b.py", ("f",)), ("c.py", ("g.h",)), ("x/y.py", ("p", "q")), ("z.py", ()), ("d.py", ())),
        *((".ci/e.json", ()), ("f.py", ("k",)), ("i/j.py", ("l",))),
    ]


def test_every_arrow_of_the_picture_has_a_function():
    """Between a line of the arrow's stem and its head; values are not behind a stem."""
    arrows = re.findall(r"│ ([\w/]+\.py: [\w.]+(?:, \w+)*)", PICTURE)
    assert len(arrows) >= 14
    heads = len(re.findall(r"(?<= )v(?=\s)", PICTURE))
    assert heads >= 9 and len(arrows) >= heads


@pytest.fixture(scope="module")
def calls():
    """All functions called in a run of a text, and then in one of a Builder, in order; kernels run as Python."""
    found = []

    def see(frame, event, argument):
        if event == "call":
            found.append(frame.f_code)

    kept = dict(code_cache._functions)
    code_cache._functions.clear()  # compiled functions of other tests, whose calls Python does not see
    parser._parsed.cache_clear()  # syntax trees of other tests
    builder = mbdsl.Builder("Pendulum")
    ground = builder.Ground("ground")
    rod = builder.Rod("rod", m="1 kg", length="1 m")
    builder.Revolute("pin", ground, rod.a)
    try:
        with code_cache.uncompiled():
            sys.setprofile(see)
            mbdsl.simulate(ROOT / "models" / "pendulum.mbd", step=1e-3, stop=3e-3)
            of_text = len(found)
            mbdsl.simulate(builder, step=1e-3, stop=1e-3)
    finally:
        sys.setprofile(None)
        code_cache._functions.update(kept)
    return found[:of_text], found[of_text:]


def test_the_arrows_have_the_order_of_a_run(calls):
    """From the top down. Systems are built again and again, of the whole Scene before that of a part: for these the
    order holds for one of the calls, else for the first ones. This run calls no function of the compiler."""
    of_text, of_builder = calls
    right = {"compilation/translation.py", "compilation/object_code.py", "lang/builder/draft.py"}
    stops = [(file, name) for file, names in references(PICTURE) for name in names if file not in right]
    assert len(stops) == 13
    later = iter(of_text)
    for stop in stops:
        assert code_of(*stop) in later, stop
    first = [of_text.index(code_of(*stop)) for stop in stops if not stop[0].startswith("system/")]
    assert first == sorted(first)
    assert code_of("lang/builder/draft.py", "Draft.scene") in of_builder
    assert code_of("lang/parser.py", "parse") not in of_builder


def test_a_step_calls_the_functions_of_its_list(calls):
    """But for those that need a tolerance, a peak of a law, a switch or a method with stages."""
    section = PAGE.partition("## One step")[2].partition("\n## ")[0]
    called = set(calls[0])
    absent = {
        (file, name) for file, names in references(section) for name in names if code_of(file, name) not in called
    }
    loop = "integrators/loop"
    assert absent == {
        *((f"{loop}/zone_landing.py", "until_zone"), (f"{loop}/multistep.py", "reject")),
        *((f"{loop}/switch_location.py", "until_switch"), ("integrators/methods/radau5.py", "take")),
    }


def test_stages_are_those_of_show():
    (named,) = re.findall(r"--stage\s+(\w+\|[\w|]+)", PAGE)
    assert f"--stage {{{named.replace('|', ',')}}}  " in COMMAND.table
