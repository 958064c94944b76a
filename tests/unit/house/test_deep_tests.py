"""The mark ``deep`` and what remains for the default run."""

import re
import runpy
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from mbdsl.elements import modules
from mbdsl.elements.kind import PairKind
from mbdsl.integrators import compiled

TESTS = Path(__file__).parents[2]
CONFTEST = runpy.run_path(str(TESTS / "conftest.py"))


@pytest.mark.parametrize("pattern", CONFTEST["DEEP"])
def test_patterns_match_tests(pattern):
    path, _, rest = pattern.removeprefix("!").partition(".py")
    files = [TESTS / f"{path}.py"] if rest else list((TESTS / path).parent.rglob("*.py"))
    assert files and all(file.exists() for file in files)
    words = re.findall(r"[a-z_0-9-]{4,}", rest.replace("::", " "))
    text = files[0].read_text(encoding="utf-8")
    methods_and_pages = [*compiled(), *(page.stem for page in (TESTS.parent / "docs").rglob("*.md"))]
    known = [*re.findall(r"def (test_\w+)", text), *methods_and_pages, *text.split()]
    assert [word for word in words if not any(word in name for name in known)] == []


def test_the_last_pattern_that_matches_counts():
    is_deep = CONFTEST["is_deep"]
    assert is_deep("gallery/test_space.py::test_top") and is_deep("faults/test_faults.py::test_full_disk")
    assert not is_deep("verification/test_orders.py::test_order[hht-si2]")
    assert not is_deep("unit/lang/test_units.py::test_metres")
    assert is_deep("verification/test_drift.py::test_kept[radau13]")
    assert not is_deep("verification/test_drift.py::test_kept[radau5]")


def test_every_value_of_a_parameter_is_drawn():
    def item(**values):
        return SimpleNamespace(
            nodeid=str(values), callspec=SimpleNamespace(params=values, indices=dict.fromkeys(values, 0))
        )

    items = [item(model=m, method=x, flag=k % 2 == 0) for m in "abcd" for k, x in enumerate("pqrstu")]
    found = CONFTEST["drawn"](items)
    assert len(found) == 6
    for name, values in (("model", "abcd"), ("method", "pqrstu"), ("flag", (True, False))):
        assert {x.callspec.params[name] for x in found} == set(values)
    assert found == CONFTEST["drawn"](items[::-1])
    (only,) = CONFTEST["drawn"]([SimpleNamespace(nodeid="test_x")])
    assert only.nodeid == "test_x"


def test_every_kind_and_method_is_in_the_default_run():
    files = ["verification/test_orders.py", "verification/test_double_pendulum.py", "unit/elements/test_derivatives.py"]
    command = [sys.executable, "-m", "pytest", "-q", "--collect-only", "-m", "not deep", "-p", "no:cacheprovider"]
    done = subprocess.run([*command, *files], cwd=TESTS, capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stdout
    for method in compiled():
        assert re.search(rf"test_(orders|double_pendulum).py::.*order.*\[(.*-)?{method}(-.*)?\]", done.stdout), method
    for name, module in modules().items():
        if isinstance(module.KIND, PairKind) and module.KIND.rows:
            assert f"test_derivatives_of_the_system[{name}" in done.stdout, name
