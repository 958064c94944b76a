"""docs/reference.md lists all public names, their docstrings are complete, and the site builds without a warning."""

import ast
import dataclasses
import inspect
import re
import subprocess
import sys
import textwrap
from functools import cached_property
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import FunctionType

import pytest

import mbdsl

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "reference.md").read_text(encoding="utf-8")
NAMES = re.findall(r"^::: ([\w.]+)$", PAGE, re.MULTILINE)
HEADING = re.compile(r"^(\w+)\n-{3,}\n", re.MULTILINE)


def resolved(name):
    """The object with a dotted name, which begins with modules."""
    module, _, attribute = name.rpartition(".")
    try:
        return import_module(name)
    except ModuleNotFoundError:
        return getattr(import_module(module), attribute)


def documented():
    """(name, object) of every public name of the page: functions, classes and their own methods."""
    for name in NAMES:
        found = resolved(name)
        if inspect.ismodule(found):
            own = {key: x for key, x in vars(found).items() if getattr(x, "__module__", None) == name and key[0] != "_"}
        else:
            own = {name.rpartition(".")[2]: found}
        for key, thing in own.items():
            yield f"{name}.{key}" if inspect.ismodule(found) else name, thing
            if inspect.isclass(thing):
                own_bases = [base for base in reversed(thing.__mro__) if base.__module__.startswith("mbdsl.")]
                for method, member in (item for base in own_bases for item in vars(base).items()):
                    if method[0] != "_" and isinstance(member, FunctionType | property | cached_property):
                        yield f"{name}.{method}", member


def sections(thing):
    """Heading -> names of the entries below it."""
    _, *parts = HEADING.split(inspect.getdoc(thing) or "")
    entries = [re.findall(r"^\S.*", text, re.MULTILINE) for text in parts[1::2]]
    return {
        heading: {name.strip(" *") for line in lines for name in line.split(" : ")[0].split(",")}
        for heading, lines in zip(parts[::2], entries, strict=True)
    }


def raised(function):
    """Names of the exceptions in the ``raise`` statements of a function."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    calls = [node.exc for node in ast.walk(tree) if isinstance(node, ast.Raise)]
    names = [call.func.id for call in calls if isinstance(call, ast.Call) and isinstance(call.func, ast.Name)]
    return {name for name in names if name[0].isupper()}  # others are functions that make exceptions


def missing(thing):
    """What the signature and the body of a public object demand and its docstring lacks."""
    found = sections(thing)
    if not inspect.getdoc(thing):
        return ["a docstring"]
    if isinstance(thing, property | cached_property):
        return []
    if inspect.isclass(thing):
        known = found.get("Parameters", set()) | found.get("Attributes", set())
        fields = [f.name for f in dataclasses.fields(thing)] if dataclasses.is_dataclass(thing) else []
        if not fields and "__init__" in vars(thing):
            fields = [*inspect.signature(thing.__init__).parameters][1:]
        return [name for name in fields if name[0] != "_" and name not in known]
    function = inspect.unwrap(thing)
    signature = inspect.signature(function)
    lacking = [name for name in signature.parameters if name != "self" and name not in found.get("Parameters", set())]
    if signature.return_annotation not in ("None", None, inspect.Signature.empty) and "Returns" not in found:
        lacking.append("Returns")
    return lacking + [f"Raises {name}" for name in raised(function) if name not in found.get("Raises", set())]


def test_every_public_name_is_on_the_page():
    here = {*NAMES, *(f"mbdsl.{name}" for name, thing in vars(mbdsl.errors).items() if inspect.isclass(thing))}
    assert not {f"mbdsl.{name}" for name in mbdsl.__all__ if name != "__version__"} - here
    assert len(NAMES) == len(set(NAMES)) > 30


def test_every_docstring_is_complete():
    found = {name: missing(thing) for name, thing in documented()}
    assert len(found) > 100
    assert {name: lacking for name, lacking in found.items() if lacking} == {}


def test_the_check_of_docstrings():
    def bare(model: str, step: float) -> int:
        """Do it.

        Parameters
        ----------
        model, other : str
        """
        if model:
            raise KeyError(model)
        return 1

    assert missing(bare) == ["step", "Returns", "Raises KeyError"]


@pytest.mark.skipif(
    not (find_spec("mkdocs") and find_spec("mkdocstrings")), reason="mkdocs is not installed: pip install '.[docs]'"
)
def test_the_site_builds_without_a_warning(tmp_path):
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path)]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    page = (tmp_path / "reference" / "index.html").read_text(encoding="utf-8")
    assert not [name for name in NAMES if f'id="{name}"' not in page]
    assert not re.findall(r":(?:class|func|meth|mod):", page)  # Markdown has no roles: ``name`` is shown as code
