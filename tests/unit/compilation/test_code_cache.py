"""Machine code: compiled, stored as objects, loaded again, and refused where a kernel cannot be translated."""

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
from mbdsl.errors import UsageError
from mbdsl.storage import cache_folder

MODEL = Path(__file__).parents[3] / "models" / "pendulum.mbd"
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
needs_compiler = pytest.mark.skipif(not code_cache.enabled(), reason="MBDSL_NO_COMPILE=1: nothing is compiled")


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
def test_other_types_of_the_arguments_are_compiled_again(fresh):
    """The text of a module contains no types; code for others would read arguments from wrong places."""
    text = "def fill(x, v):\n    v[0] = x\n"
    for kind, x in (("float", 2.5), ("int", 3), ("float", 1.5)):
        code_cache._functions.clear()
        sys.modules.pop("filling", None)
        (fill,) = code_cache.functions("filling", text, {"fill": code_cache.Signature((kind, "vector"))}, list)
        v = np.zeros(1)
        fill(x, v)
        assert v[0] == x


@needs_compiler
def test_an_object_whose_sources_have_changed_is_compiled_again(fresh, tmp_path, monkeypatch):
    """Kernels of a module outside of the package; they do not depend on edits of other modules."""
    library = tmp_path / "library"
    library.mkdir()
    source = library / "threefold.py"
    source.write_text("from mbdsl.kernels.marks import kernel\n@kernel\ndef scale(x):\n    return 3 * x\n")
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


#: files of a user's package: kernels that call kernels of other files and read constants
HELPERS = {
    "helpers_of_a_user/__init__.py": "from .lengths import SHORT\n",
    "helpers_of_a_user/lengths.py": "SHORT = 1\n",
    "helpers_of_a_user/scaling.py": """
from mbdsl.kernels.marks import kernel
from . import factors

@kernel
def scale(x):
    return factors.three() * x
""",
    "helpers_of_a_user/factors.py": """
import math
from mbdsl.kernels.marks import kernel
try:
    from more_helpers_of_a_user import TWO
except ImportError:
    TWO = 2

@kernel
def three():
    return 1 + TWO
""",
    "more_helpers_of_a_user.py": "from basic_helpers_of_a_user import ONE\nTWO = ONE + 1\n",
    "basic_helpers_of_a_user.py": "ONE = 1\n",
    "kernels_of_a_user.py": """
import helpers_of_a_user.scaling
from mbdsl.kernels.marks import kernel

@kernel
def scale(x):
    return helpers_of_a_user.scaling.scale(x) * helpers_of_a_user.SHORT
""",
}
SCALED = """
import sys
sys.path.insert(0, sys.argv[1])
import kernels_of_a_user
from mbdsl.compilation import code_cache
text = "import kernels_of_a_user\\ndef scaled(x):\\n    return kernels_of_a_user.scale(x)\\n"
before = code_cache.is_compiled("scaled")
signatures = {"scaled": code_cache.Signature(("int",), gives="int")}
(scaled,) = code_cache.functions("scaled", text, signatures, lambda: [kernels_of_a_user])
print(before, scaled(2))
"""


@needs_compiler
def test_machine_code_is_made_again_after_an_edit_of_any_file_that_kernels_read(tmp_path):
    """Files of users: kernels and constants that are imported, directly or not, by name or within a package."""
    for name, text in HELPERS.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "unused.py").write_text("x = 1\n")

    def scaled():
        return run(SCALED, tmp_path / "cache", arguments=[str(tmp_path)], PYTHONDONTWRITEBYTECODE="1")

    assert scaled() == ["False", "6"]
    (tmp_path / "unused.py").write_text("x = 2\n")
    assert scaled() == ["True", "6"]
    edits = {"helpers_of_a_user/lengths.py": ("= 1", "= 10", 60), "basic_helpers_of_a_user.py": ("= 1", "= 4", 120)}
    edits["helpers_of_a_user/factors.py"] = ("1 + TWO", "2 + TWO", 140)
    for name, (before, after, result) in edits.items():
        (tmp_path / name).write_text(HELPERS[name].replace(before, after))
        assert scaled() == ["False", str(result)], name
        assert scaled() == ["True", str(result)], name


def test_libraries_are_no_sources_of_machine_code(tmp_path, monkeypatch):
    """Their versions are part of the key, or kernels cannot call them; only their files with kernels are read."""
    (tmp_path / "site-packages").mkdir()
    for name, text in {
        "plain_library": "import inner_of_a_library\n",
        "inner_of_a_library": "",
        "library_of_kernels": "import mbdsl.kernels.marks, with_constants\n",
        "with_constants": "",
    }.items():
        (tmp_path / "site-packages" / f"{name}.py").write_text(text)
    (tmp_path / "of_a_user.py").write_text("import math, numpy, scipy.linalg, plain_library, library_of_kernels\n")
    monkeypatch.syspath_prepend(tmp_path / "site-packages")
    monkeypatch.syspath_prepend(tmp_path)
    found = set(kernel_sources.names_of([import_module("of_a_user")])) - {"mbdsl.system.emit"}
    assert {name for name in found if not name.startswith("mbdsl.")} == {
        *("of_a_user", "plain_library", "library_of_kernels", "with_constants")
    }


def test_a_source_that_cannot_be_read_is_no_part_of_a_digest(tmp_path, monkeypatch):
    """A module in an archive, or a file that was removed: its code is made again in each process."""
    (tmp_path / "removed_soon.py").write_text("x = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    module = import_module("removed_soon")
    names = kernel_sources.names_of([module])
    assert kernel_sources.digest_of(names) is not None
    (tmp_path / "removed_soon.py").unlink()
    assert kernel_sources.names_of([module]) == names
    assert kernel_sources.digest_of(names) is None


@needs_compiler
def test_constants_from_other_files_of_a_user_are_part_of_the_digest(fresh, tmp_path, monkeypatch):
    """Machine code contains their values, which the source of the kernels does not show."""
    (tmp_path / "user_constants.py").write_text("FACTOR, TABLE = 3, (1, (2, 5))\n")
    source = "import user_constants\nfrom user_constants import TABLE\nfrom mbdsl.kernels.marks import kernel\n"
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
        ("mbdsl.integrators.methods.radau5", "mbdsl.integrators.methods.radau_coefficients"),
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
def test_where_llvmlite_cannot_compile_kernels_run_as_python(fresh, monkeypatch):
    """As with a new version that lacks a function. Nothing is stored, and the next process tries again."""
    from mbdsl.compilation import object_code

    def fail(wanted):
        raise AttributeError("not what it was")

    monkeypatch.setattr(object_code, "compile_object", fail)
    for _ in range(2):
        with pytest.warns(code_cache.Uncompiled, match="llvmlite cannot compile .AttributeError: not what it was"):
            check(*functions())
        assert not code_cache.is_compiled("scales")


@needs_compiler
def test_a_kernel_that_is_not_translated_is_an_error(fresh):
    """With its place, the alternative, and the way to run it nevertheless."""
    text = "def fill(v):\n    v[0] = sum([1.0, 2.0])\n"
    sys.modules.pop("filled", None)
    with pytest.raises(UsageError) as refused:
        code_cache.functions("filled", text, {"fill": code_cache.Signature(("vector",))}, list)
    sys.modules.pop("filled", None)
    assert refused.value.render().splitlines() == [
        f"{fresh}/filled.py:2:5: error: cannot compile the kernel fill: `[1.0, 2.0]`",
        "    v[0] = sum([1.0, 2.0])".replace("    v", "        v"),
        "        ^^^^^^^^^^^^^^^^^^^^^^",
        "  = write a tuple, or fill the entries of an array that is an argument; "
        "MBDSL_NO_COMPILE=1 runs kernels as Python",
    ]


@needs_compiler
def test_the_installed_llvmlite_compiles(fresh):
    """A new version may lack what :mod:`mbdsl.compilation.object_code` uses."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check(*functions())
    slower = [str(warning.message) for warning in caught if issubclass(warning.category, code_cache.Uncompiled)]
    assert not slower, (
        f"mbdsl/compilation cannot use llvmlite {importlib.metadata.version('llvmlite')}: {slower[0]}. Adapt it, or "
        "lower the bound of llvmlite in pyproject.toml; until then models run uncompiled."
    )


@needs_compiler
def test_the_tested_version_is_below_the_upper_bound():
    """pyproject.toml allows no version beyond the one that these tests run with."""
    text = (Path(__file__).parents[3] / "pyproject.toml").read_text(encoding="utf-8")
    lower, upper = re.search(r'"llvmlite>=0\.(\d+),<0\.(\d+)"', text).groups()
    minor = int(importlib.metadata.version("llvmlite").split(".")[1])
    assert int(lower) <= minor < int(upper), f"llvmlite 0.{minor} is installed"


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
    zeros = np.zeros(4)
    with pytest.raises(ValueError, match="arrays that do not overlap"):
        scale(1.0, zeros, zeros[3:].view(np.int64))
    scale(1.0, zeros[:3], zeros[3:].view(np.int64))


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


def test_plain_python(fresh, monkeypatch):
    monkeypatch.setattr(code_cache, "enabled", lambda: False)
    assert code_cache.is_compiled("scales")
    check(*functions())
    assert not (fresh / "scales.o").exists()


def run(code, cache, arguments=(), **environment):
    environment = {**os.environ, "MBDSL_CACHE_DIR": str(cache), "PYTHONPATH": os.pathsep.join(sys.path), **environment}
    command = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
    return done.stdout.split()


SIMULATE = f"""
import sys, mbdsl
r = mbdsl.simulate({str(MODEL)!r}, method='newmark', stop=0.02)
print(repr(float(r.q.sum())), "llvmlite" in sys.modules)
"""


@needs_compiler
def test_a_stored_run_has_the_same_bits_and_a_plain_one_needs_no_compiler(tmp_path):
    cold, loaded = run(SIMULATE, tmp_path)
    assert loaded == "True"
    assert run(SIMULATE, tmp_path) == [cold, "True"]
    plain, loaded = run(SIMULATE, tmp_path, MBDSL_NO_COMPILE="1")
    assert loaded == "False"
    assert float(plain) == pytest.approx(float(cold), rel=1e-12)


def test_settings_of_the_compiler_are_part_of_the_digest(monkeypatch):
    before = code_cache.version()
    assert code_cache.version() == before
    monkeypatch.setenv("MBDSL_CPU_NAME", "generic")
    assert code_cache.version() != before


@needs_compiler
@pytest.mark.parametrize("of", ["get_host_cpu_name", "get_process_triple"])
def test_the_processor_is_part_of_the_digest(monkeypatch, of):
    """As in a folder that several machines share."""
    from llvmlite import binding

    before = code_cache.version()
    monkeypatch.setattr(binding, of, lambda: "another one")
    code_cache._digest.cache_clear()
    changed = code_cache.version()
    code_cache._digest.cache_clear()
    assert changed != before


@pytest.mark.parametrize("package", ["llvmlite", "numpy"])
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
