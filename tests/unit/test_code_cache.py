"""Machine code: stored as objects, and compiled by numba where the translation fails."""

import ast
import importlib.metadata
import importlib.util
import os
import re
import subprocess
import sys
import warnings
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from mbdsl.compilation import code_cache, kernel_sources
from mbdsl.storage import cache_folder

MODEL = Path(__file__).parents[2] / "models" / "pendulum.mbd"
VECTOR = code_cache.Signature(("float", "vector", "ints"))
TEXT = """
from math import hypot


def scale(x, v, k):
    for i in range(k.size):
        v[k[i]] *= hypot(x, 0.0)


def twice(scale, count, x, v, k, M, N):
    for _ in range(count):
        scale(x, v, k)
    M[1, 0] += N[0, 1]
    return v.size
"""
SIGNATURES = {
    "scale": VECTOR,
    "twice": code_cache.Signature((VECTOR, "int", "float", "vector", "ints", "matrix", "int matrix"), "int"),
}
needs_compiler = pytest.mark.skipif(not code_cache.enabled(), reason="nothing is compiled")


@pytest.fixture
def fresh(tmp_path, monkeypatch):
    """Nothing is stored or loaded; returns the folder of the objects."""
    monkeypatch.setenv("MBDSL_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(cache_folder, "_said", [])
    monkeypatch.setattr(code_cache, "_functions", {})
    monkeypatch.delitem(sys.modules, "scales", raising=False)
    yield tmp_path / "cache" / code_cache.version()
    sys.modules.pop("scales", None)


def functions():
    """The functions of TEXT, as if nothing had been loaded before."""
    code_cache._functions.clear()
    sys.modules.pop("scales", None)
    return code_cache.functions("scales", TEXT, SIGNATURES, list)


def check(scale, twice):
    v, k = np.ones(4), np.array([3, 1])
    M, N = np.zeros((2, 3)), np.arange(6).reshape(2, 3)
    assert scale(-2.0, v, k) is None
    assert v.tolist() == [1.0, 2.0, 1.0, 2.0]
    assert twice(scale, 2, 3.0, v, k, M, N) == 4
    assert v.tolist() == [1.0, 18.0, 1.0, 18.0]
    assert M.tolist() == [[0, 0, 0], [1, 0, 0]]


def no_compiler(monkeypatch):
    monkeypatch.setattr(code_cache, "_compiled", lambda *arguments: pytest.fail("compiled again"))


@needs_compiler
def test_compiled_and_kept(fresh, monkeypatch):
    assert not code_cache.is_compiled("scales")
    check(*functions())
    assert code_cache.is_compiled("scales")
    assert [path.name for path in fresh.glob("*.part")] == []
    no_compiler(monkeypatch)
    check(*functions())


@needs_compiler
@pytest.mark.parametrize(
    "damage",
    [lambda data: b"", lambda data: data[: len(data) // 2], lambda data: data[:-9] + bytes([data[-9] ^ 1]) + data[-8:]],
    ids=["empty", "truncated", "changed"],
)
def test_a_damaged_object_is_compiled_again(fresh, damage):
    functions()
    path = fresh / "scales.o"
    whole = path.read_bytes()
    path.write_bytes(damage(whole))
    check(*functions())
    assert path.read_bytes().split(b"\n")[1:2] == whole.split(b"\n")[1:2]


@needs_compiler
def test_an_object_that_needs_what_is_not_there_is_not_linked(fresh):
    functions()
    *head, needs, code = code_cache._body("scales").split(b"\n", 4)
    assert b"hypot" in needs
    assert code_cache._linked("scales", b"\n".join([*head, needs, code]), SIGNATURES) is not None
    assert code_cache._linked("scales", b"\n".join([*head, b"no_such_function_anywhere", code]), SIGNATURES) is None


@needs_compiler
def test_another_text_of_the_same_name_is_compiled_again(fresh):
    signatures = {"scaled": code_cache.Signature(("int",), gives="int")}
    for factor in (3, 4, 4):
        code_cache._functions.clear()
        sys.modules.pop("scaled", None)
        (scaled,) = code_cache.functions("scaled", f"def scaled(x):\n    return {factor} * x\n", signatures, list)
        assert scaled(2) == 2 * factor


@needs_compiler
def test_an_object_whose_sources_have_changed_is_compiled_again(fresh, tmp_path, monkeypatch):
    """Kernels of a module outside of the package; they do not depend on edits of other modules."""
    library = tmp_path / "library"
    library.mkdir()
    source = library / "threefold.py"
    source.write_text("from mbdsl.compilation.marks import kernel\n@kernel\ndef scale(x):\n    return 3 * x\n")
    monkeypatch.syspath_prepend(library)
    import threefold

    text = "import threefold\ndef scaled(x):\n    return threefold.scale(x)\n"
    signatures = {"scaled": code_cache.Signature(("int",), gives="int")}
    (scaled,) = code_cache.functions("scaled", text, signatures, lambda: [threefold])
    assert scaled(2) == 6
    assert code_cache.is_compiled("scaled")
    (library / "another.py").write_text("x = 1\n")
    assert code_cache.is_compiled("scaled")
    source.write_text(source.read_text().replace("3", "4"))
    assert not code_cache.is_compiled("scaled")


@needs_compiler
def test_constants_from_other_files_of_a_user_are_part_of_the_digest(fresh, tmp_path, monkeypatch):
    """Machine code contains their values, which the source of the kernels does not show."""
    (tmp_path / "user_constants.py").write_text("FACTOR, TABLE = 3, (1, (2, 5))\n")
    source = "import user_constants\nfrom user_constants import TABLE\nfrom mbdsl.compilation.marks import kernel\n"
    source += "@kernel\ndef scale(x):\n    return user_constants.FACTOR * x + TABLE[1][1]\n"
    (tmp_path / "user_kernels.py").write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    import user_constants
    import user_kernels

    text = "import user_kernels\ndef of_constants(x):\n    return user_kernels.scale(x)\n"
    signatures = {"of_constants": code_cache.Signature(("int",), gives="int")}
    (of_constants,) = code_cache.functions("of_constants", text, signatures, lambda: [user_kernels])
    assert of_constants(2) == 11
    for module, name, value in ((user_constants, "FACTOR", 4), (user_kernels, "TABLE", (1, (2, 6)))):
        assert code_cache.is_compiled("of_constants")
        with monkeypatch.context() as changed:
            changed.setattr(module, name, value)
            assert not code_cache.is_compiled("of_constants")


def test_kernels_are_found_however_they_are_imported():
    text = """
import math
import mbdsl.system.loops as loops
from mbdsl.integrators.loop import linear_solve as linear, newton
from mbdsl.numerics.banded import (  # with a comment
    cholesky_solve,
    cholesky_solve_pairs as pairs,
)
from mbdsl.errors import UsageError
text = "from mbdsl.system import emit"
"""
    found = {name for name in kernel_sources.imported_kernels(text) if kernel_sources.file_of(name)}
    loop = {f"mbdsl.integrators.loop.{name}" for name in ("linear_solve", "newton")}
    assert found == {"mbdsl.system.loops", "mbdsl.numerics.banded"} | loop


@pytest.mark.parametrize(
    ("of", "imported"),
    [
        ("mbdsl.integrators.loop.driver", "mbdsl.integrators.loop.loop_state"),
        ("mbdsl.integrators.methods.radau5", "mbdsl.integrators.methods.radau5_coefficients"),
        ("mbdsl.integrators.methods.hht_si2", "mbdsl.integrators.loop.sparse_lu"),
        ("mbdsl.bodies.ancf_cable_kernels", "mbdsl.numerics.banded"),
    ],
)
def test_sources_of_machine_code(of, imported):
    """Also indirect imports, with or without parentheses; but no declarations."""
    found = kernel_sources.names_of([import_module(of)])
    assert of in found and imported in found
    assert not {"mbdsl.elements.kind", "mbdsl.integrators.method"} & set(found)


@needs_compiler
def test_where_llvm_code_cannot_be_compiled_numba_compiles(fresh, monkeypatch):
    from mbdsl.compilation import object_code

    def fail(wanted):
        raise AttributeError("not what it was")

    monkeypatch.setattr(object_code, "compile_object", fail)
    with pytest.warns(UserWarning, match="numba's cfunc, which is slower: AttributeError: not what it was"):
        check(*functions())
    assert (fresh / "scales.ordinary").read_text().endswith("\nAttributeError: not what it was")
    assert code_cache.is_compiled("scales")
    check(*functions())


#: modules that numba's manual describes for extensions
PUBLIC_PARTS = ("numba.extending", "numba.np.arrayobj")


def modules_with_private_parts():
    """Files of mbdsl that import modules of numba that its manual does not describe."""
    found = set()
    for path in (Path(code_cache.__file__).parents[1]).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            if any(name.startswith("numba.") and name not in PUBLIC_PARTS for name in names):
                found.add(path.name)
    return found


def test_no_module_uses_private_parts_of_numba():
    assert modules_with_private_parts() == set()


@needs_compiler
def test_the_installed_llvmlite_compiles(fresh):
    """A new version may lack what :mod:`mbdsl.compilation.object_code` uses; numba then replaces it with a warning."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check(*functions())
    slower = [str(warning.message) for warning in caught if "slower" in str(warning.message)]
    assert not slower, (
        f"mbdsl/compilation cannot use llvmlite {importlib.metadata.version('llvmlite')}: {slower[0]}. Adapt it, or "
        "lower the bound of llvmlite in pyproject.toml; until then models run with code that takes longer to compile."
    )


@needs_compiler
@pytest.mark.parametrize("package", ["numba", "llvmlite"])
def test_the_tested_versions_are_the_upper_bound(package):
    """pyproject.toml allows no version beyond the one that these tests run with."""
    text = (Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8")
    lower, upper = re.search(rf'"{package}>=0\.(\d+),<0\.(\d+)"', text).groups()
    minor = int(importlib.metadata.version(package).split(".")[1])
    assert int(lower) <= minor < int(upper), f"{package} 0.{minor} is installed"


@needs_compiler
def test_only_arrays_of_the_right_kind_are_handed_over(fresh):
    scale, _ = functions()
    v, k = np.ones(4), np.array([0])
    scale(1.0, v, k)
    for wrong in (v.astype(np.float32), v[::2], k, np.ones((2, 2))):
        with pytest.raises(TypeError, match="C-contiguous arrays of float64"):
            scale(1.0, wrong, k)
    with pytest.raises(ValueError, match="argument"):
        scale(1.0, v)


@needs_compiler
def test_other_arrays_are_not_taken_for_the_last_ones(fresh):
    scale, _ = functions()
    k = np.array([0])
    for n in range(1, 6):
        v = np.ones(n)
        scale(2.0, v, k)
        scale(float(n), v, k)
        assert v[0] == 2.0 * n
        other = np.ones(n)
        scale(5.0, other, k)
        assert (v[0], other[0]) == (2.0 * n, 5.0)


def test_plain_python_without_numba(fresh, monkeypatch):
    monkeypatch.setattr(code_cache, "enabled", lambda: False)
    assert code_cache.is_compiled("scales")
    check(*functions())
    assert not (fresh / "scales.o").exists()


def run(code, cache, **environment):
    environment = {**os.environ, "MBDSL_CACHE_DIR": str(cache), "PYTHONPATH": os.pathsep.join(sys.path), **environment}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True)
    return done.stdout.split()


SIMULATE = f"""
import sys, mbdsl
r = mbdsl.simulate({str(MODEL)!r}, method='newmark', stop=0.02)
print(repr(float(r.q.sum())), "numba" in sys.modules)
"""


@needs_compiler
def test_numba_is_not_loaded(tmp_path):
    cold, loaded = run(SIMULATE, tmp_path)
    assert loaded == "False"
    assert run(SIMULATE, tmp_path) == [cold, "False"]
    plain, loaded = run(SIMULATE, tmp_path, NUMBA_DISABLE_JIT="1")
    assert loaded == "False"
    assert float(plain) == pytest.approx(float(cold), rel=1e-12)


PUBLIC = """
import warnings
from mbdsl.compilation import code_cache, object_code

def fail(*given):
    raise AttributeError("forced")

def compiled(name, *given):  # numba takes 20 s for the loop of a method, which runs as plain Python here
    return (code_cache._plain if name.startswith("mbdsl_method_") else as_usual)(name, *given)

object_code.compile_object = fail
as_usual, code_cache._compiled = code_cache._compiled, compiled
code_cache.beside = lambda *given: None  # no other process, which would compile as usual
warnings.simplefilter("ignore")
"""


@needs_compiler
def test_a_simulation_by_the_public_interface_of_numba_only(tmp_path):
    """The same results, except for the rounding of mathematical functions."""
    found, loaded = run(PUBLIC + SIMULATE, tmp_path, NUMBA_OPT="0")
    assert loaded == "True"
    assert list(tmp_path.glob("*/mbdsl_emitted_*.ordinary")), "the equations"
    assert not list(tmp_path.glob("*/*.o"))
    plain, _ = run(SIMULATE, tmp_path, NUMBA_DISABLE_JIT="1")
    assert float(found) == pytest.approx(float(plain), rel=1e-12)


@needs_compiler
def test_a_broken_numba_does_no_harm(tmp_path):
    (tmp_path / "numba").mkdir()
    (tmp_path / "numba" / "__init__.py").write_text("raise ImportError('made for another numpy')")
    code = f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n" + "import warnings\nwarnings.simplefilter('ignore')\n"
    assert run(code + SIMULATE, tmp_path)[1] == "False"


def test_settings_of_numba_and_the_processor_are_part_of_the_digest(monkeypatch):
    before = code_cache.version()
    assert code_cache.version() == before
    monkeypatch.setenv("NUMBA_OPT", "1")
    assert code_cache.version() != before


@pytest.mark.parametrize("package", ["numba", "llvmlite", "numpy"])
def test_a_version_is_part_of_the_digest(monkeypatch, tmp_path, package):
    """As after an update: the file with the version has another content."""
    before = code_cache.version()
    there = Path(importlib.util.find_spec(package).origin).parent
    (tmp_path / package).mkdir()
    for name in ("__init__.py", "_version.py", "version.py"):
        if (there / name).exists():
            (tmp_path / package / name).write_text((there / name).read_text() + "\n# another one\n")
    find = importlib.util.find_spec
    other = importlib.util.spec_from_file_location(package, tmp_path / package / "__init__.py")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: other if name == package else find(name))
    code_cache._digest.cache_clear()
    changed = code_cache.version()
    code_cache._digest.cache_clear()
    assert changed != before


THREADS = """
import threading
import numpy as np
from mbdsl.compilation import code_cache, kernel_sources

failures = []

def work(k):
    try:
        text, signatures = f"def f(v):\\n    v[0] = {k}\\n", {"f": code_cache.Signature(("vector",))}
        (f,), v = code_cache.functions(f"thread{k}", text, signatures, list), np.full(1, np.nan)
        f(v)
        assert v[0] == k
    except BaseException as problem:
        failures.append(repr(problem))

threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
print(len(failures), *failures)
"""


@needs_compiler
def test_threads_share_a_cold_start(tmp_path):
    assert run(THREADS, tmp_path) == ["0"]
