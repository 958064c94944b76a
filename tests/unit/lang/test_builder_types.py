"""The methods of kinds as editors, type checkers and ``help`` see them."""

import inspect
import pydoc
import shutil
from importlib.util import find_spec
from pathlib import Path

import pytest

from mbdsl import Builder
from mbdsl.elements import kinds
from mbdsl.elements.declaration import REQUIRED
from mbdsl.lang.builder import kind_stub

FOLDER = Path(kind_stub.__file__).parent
SNIPPET = """\
from mbdsl.lang.builder import Builder

b = Builder("M")
g = b.Ground("g", g="9.8 m/s2", n=(0, -1))
rod = b.Rod("rod", m="2 kg", length=1, frames={"tip": (0.1, "2 cm")}, phi={"start": 0.1, "fixed": True})
pin = b.Revolute("pin", g, rod.a, mu_s=0.1, radius=0.1)
pin = b.Revolute("pin", g, frame_b="rod.a", replace=True)
b.Torque("t", pin, tau="1 N.m*time")
b.Rod("r", m=1, lenght=1, length=1)  # 9
b.Revolut("r", g, rod.b)  # 10
b.Rod("r", m=1)  # 11
b.Rod("r", m=[1], length=1)  # 12
b.FlexibleBeam("f", length=1, density=1, S=1, I=1, E=1, formulation="ancff")  # 13
b.Body("c", m=1, phi={"begin": 1})  # 14
b.Body("c", rod.a, length=1)  # 15
"""


@pytest.mark.skipif(not find_spec("mypy"), reason="mypy is not installed: pip install '.[test]'")
def test_mypy_refuses_what_the_kinds_do_not_have(tmp_path):
    """Exactly the lines with a number; other modules are skipped, so that no cache is needed."""
    from mypy import api

    file = tmp_path / "snippet.py"
    file.write_text(SNIPPET, encoding="utf-8")
    options = ["--config-file=", f"--cache-dir={tmp_path / 'cache'}", "--follow-imports=skip", "--hide-error-context"]
    copies = tmp_path / "mbdsl" / "lang" / "builder"  # mypy refuses files of site-packages
    copies.mkdir(parents=True)
    for folder in (copies.parents[1], copies.parent):
        (folder / "__init__.py").touch()
    names = ("__init__.py", "builder.py", "named_values.py", "declaring.py", "handles.py")
    modules = [shutil.copy(FOLDER / name, copies) for name in names]
    modules.append(copies / "kind_methods.pyi")
    modules[-1].write_text(kind_stub.stub(), encoding="utf-8")
    out, err, code = api.run([*options, str(file), *map(str, modules)])
    assert err == "" and code == 1, out
    errors = [line for line in out.splitlines() if ": error: " in line]
    numbers = [int(line.partition("snippet.py:")[2].partition(":")[0]) for line in errors]
    marked = [int(line.rpartition("# ")[2]) for line in SNIPPET.splitlines() if "  # " in line]
    assert sorted(set(numbers)) == marked == [k for k, line in enumerate(SNIPPET.splitlines(), 1) if "  # " in line]
    assert 'Unexpected keyword argument "lenght" for "Rod" of "KindMethods"; did you mean "length"?' in out
    assert '"Builder" has no attribute "Revolut"' in out


def test_every_kind_has_a_method_with_its_parameters():
    b = Builder("M")
    for name, kind in kinds().items():
        given = inspect.signature(getattr(b, name)).parameters
        required = {key for key, p in given.items() if p.default is p.empty and p.kind is not p.VAR_POSITIONAL}
        assert required == {"name", *(p.name for p in kind.parameters if p.default is REQUIRED)}
        assert {p.name for p in kind.parameters} | {x.name for x in kind.signals} | {*kind.ports} <= set(given)
        assert ("frames" in given and given["frames"].kind is inspect.Parameter.VAR_POSITIONAL) == bool(kind.ports)
    assert inspect.signature(b.World).parameters.keys() == inspect.signature(b.Ground).parameters.keys()
    assert {*kinds(), "World"} <= set(dir(Builder))


def test_help_shows_parameters_units_and_meanings():
    text = pydoc.render_doc(Builder("M").Rod, renderer=pydoc.plaintext)
    words = " ".join(text.split())
    assert "Rod(name: 'str', *, m: 'Number', length: 'Number'" in words
    assert "m : number or str [kg] Mass" in words and "``w`` [rad/s]" in words
    assert "length : number or str [m] Distance of the frames a and b" in words
    assert max(len(line) for line in text.splitlines() if not line.startswith("Rod(")) <= 80
