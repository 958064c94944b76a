"""The public names of the package: what `dir`, editors and type checkers see, and the functions that only list."""

import ast
import inspect
from pathlib import Path

import pytest

import mbdsl
from mbdsl.errors import UsageError
from mbdsl.integrators import available

SOURCE = Path(mbdsl.__file__).read_text(encoding="utf-8")


def test_dir_lists_public_names_only():
    listed = [name for name in dir(mbdsl) if not name.startswith("__")]
    assert listed == [name for name in sorted(mbdsl.__all__) if not name.startswith("__")]
    assert {"methods", "recommend", "study", "results", "simulate"} <= set(listed)
    assert not {"TYPE_CHECKING", "Any", "annotations"} & set(listed)
    for module in (mbdsl.study, mbdsl.results):
        assert sorted(dir(module)) == sorted(module.__all__)


def test_type_checkers_see_every_name():
    """They execute nothing: each name is in a literal `__all__` and in an import for type checkers."""
    tree = ast.parse(SOURCE)
    literal = [ast.literal_eval(n.value) for n in tree.body if isinstance(n, ast.Assign) and "__all__" in ast.dump(n)]
    (block,) = [n for n in tree.body if isinstance(n, ast.If) and ast.unparse(n.test) == "TYPE_CHECKING"]
    imported = {a.asname or a.name: (n.module, a.name) for n in block.body for a in n.names}
    assert literal == [mbdsl.__all__]
    assert set(imported) == set(mbdsl.__all__)
    for name, (module, attribute) in imported.items():  # and it is the object that the program gets
        where = f"{module}.{attribute}"
        found = getattr(mbdsl, name)
        assert where == found.__name__ if inspect.ismodule(found) else mbdsl._PUBLIC[name] == (module, attribute)


def test_every_name_has_a_docstring():
    for name in mbdsl.__all__:
        if name != "__version__":
            assert len(inspect.getdoc(getattr(mbdsl, name))) > 20, name


def test_methods():
    found = mbdsl.methods()
    assert dict(found) == available()
    lines = str(found).splitlines()
    assert [line.split()[0] for line in lines] == ["method", *found]
    assert max(map(len, lines)) <= 80
    assert found["radau5"].order == 5  # Hairer and Wanner, Solving ODEs II, IV.8
    for name in found:
        assert f">{name}<" in found._repr_html_()
    assert repr(found).startswith(f"<{len(found)} methods: dop853, ")
    with pytest.raises(UsageError, match="there is no method `hht-si3`") as caught:
        found["hht-si3"]
    assert "hht-si2" in caught.value.hint
    assert "hht-si3" not in found and found.get("hht-si3") is None
