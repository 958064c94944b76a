"""Translated kernels do what Python does: results of compiled code against those of the same text, interpreted."""

import math
import re
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import mbdsl
from mbdsl.compilation import code_cache, translation
from mbdsl.compilation.kernel_calls import INTRINSICS, LIBRARY
from mbdsl.compilation.kernel_code import ALTERNATIVES, TRANSLATIONS
from mbdsl.compilation.kernel_types import Untranslatable
from mbdsl.compilation.native_call import Signature
from mbdsl.kernels import marks
from mbdsl.storage import cache_folder

needs_compiler = pytest.mark.skipif(not code_cache.enabled(), reason="MBDSL_NO_COMPILE=1: nothing is compiled")
HEAD = """
import math
from math import atan2, ceil, floor, hypot, log, pi
from numpy import arccos, floor as floored, log10, sin, sinh, sqrt, tan
from typing import Callable, NamedTuple
from mbdsl.kernels.columns import PLANE, SPACE
from mbdsl.kernels.marks import kernel, rare, square

TABLE = ((1.5, 2.5, -3.5), (4.0, 5.0, 6.0))
NODES = (0.25, 0.5, 1.0)


@kernel
def sized(C, x):
    if C is SPACE:
        return x * C.POSE
    return [x]  # not translated for SPACE


class Both(NamedTuple):
    function: Callable
    x: object
    k: object


@kernel
def twice(x):
    return 2 * x


@rare
def ends(x, k, scale=0.5, shift=0):
    return x[0] * scale, x[k - 1] + shift


@kernel
def sign(x):
    if x < 0.0:
        return -1.0
    elif x == 0.0:
        return 0
    return 1.0


@kernel
def apply(function, x):
    return function(x) + function(1)


@kernel
def chosen(function, x):
    if function:
        return function(x)
    return 5.0 if not function and function is None else 7.0


@kernel
def moves(x, y):
    x[0] += 1.0
    return y * x[0]


def twins():
    @kernel
    def twice(x):
        return 3 * x

    return twice


thrice = twins()


@kernel
def itself(x):
    return itself(x)


@kernel
def group(both):
    return both.function(both.x[1]) + both.k[0]


"""
NUMBERS = (-2.75, -1.0, -0.0, 0.0, 0.3, 1.0, 2.0, 1e300, math.inf, math.nan)
X = np.array([0.7, -1.25, 3.5, 0.125])
M = np.arange(12.0).reshape(3, 4) - 4.5
K = np.array([2, -3, 1, 7])


@pytest.fixture
def compiled(tmp_path, monkeypatch):
    """Compiles ``def f(...)`` with the functions of HEAD before it; returns f as compiled and as interpreted."""
    monkeypatch.setenv("MBDSL_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(cache_folder, "_said", [])

    def compiled(body, takes, gives="none"):
        name = f"mbdsl_test_{abs(hash((body, takes))):x}"
        text = f"{HEAD}def f({', '.join('abcdefgh'[: len(takes)])}):\n" + "".join(
            f"    {line}\n" for line in body.splitlines()
        )
        try:
            (f,) = code_cache.functions(name, text, {"f": Signature(takes, gives)}, list)
            assert type(f).__name__ == "Native"  # not the fallback
            return f, sys.modules[name].f
        finally:
            sys.modules.pop(name, None)

    return compiled


def outcome(function, *arguments):
    """Result and changed arrays."""
    copies = [x.copy() if isinstance(x, np.ndarray) else x for x in arguments]
    with np.errstate(all="ignore"):
        result = function(*copies)
    return result, *(x for x in copies if isinstance(x, np.ndarray))


def same(one, other):
    """Equal bit for bit, except that all NaN are alike."""
    for a, b in zip(one, other, strict=True):
        if isinstance(a, np.ndarray):
            assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f")
            assert a.dtype.kind != "f" or np.array_equal(np.signbit(a[~np.isnan(a)]), np.signbit(b[~np.isnan(b)]))
        else:
            assert a == b


@needs_compiler
@pytest.mark.parametrize(
    "body",
    [
        "b[0] = a + 1; b[1] = 3 - a; b[2] = a * a; b[3] = -a",
        "b[0] = a if a > 0.5 else 7\nb[1] = max(a, 0.5, 1)\nb[2] = min(1, a)\nb[3] = abs(a)",
        "b[0] = max(a, b[1]); b[1] = min(a, b[2]); b[2] = max(0.0, a); b[3] = max(-0.0, a)",
        "b[0] = 1.0 if 0 < a <= 1 else 0.0\nb[1] = 1.0 if not a else 0.0\nb[2] = 1.0 if a != a else 0.0",
        "b[0] = 1.0 if a > 0.0 and 1 / a < 2 else 2.0\nb[1] = 1.0 if a < 0.0 or a * a > 1.0 else 2.0",
        "b[0] = floored(a); b[1] = sqrt(abs(a)); b[2] = atan2(a, 2.0); b[3] = hypot(a, 3)",
        "b[0] = a ** 2; b[1] = a ** 3; b[2] = (a * a) ** 0.8; b[3] = 10.0 ** 3",
        "b[0] = twice(a); b[1] = twice(3); b[2] = sign(a); b[3] = apply(sign, a)",
        "x = 1\nfor i in range(4):\n    x = x / 2 + i * a\n    b[i] = x",
        "for i in range(3, -1, -1):\n    if a > i:\n        continue\n    b[i] += i\n    if i == 1:\n        break",
        "i = 0\nwhile i < 4 and b[i] < a:\n    b[i], b[3 - i] = b[3 - i], b[i]\n    i += 1",
        "n = 0\nwhile True:\n    n += 1\n    if n > 3 or n > a:\n        break\nb[0] = n",
        "for i, s in ((0, a), (2, -a)):\n    for j in (0, 1):\n        b[i + j] = s * j",
        "low, high = ends(b, 4, shift=2)\nb[0], b[1] = high, low\npair = (low, high)\nb[2] = pair[1]",
        "for k in range(2):\n    b[k] = TABLE[k][2] + NODES[k + 1] + (a, 2.0)[k]\nb[3] = NODES[-1] + pi + len(NODES)",
        "b[0] = a\nb[0] -= 1\nb[1] *= a\nb[2] /= 4\nc = a > 0\nb[3] = c + 1",
        "x = a % 1.0 if abs(a) < 1e6 else 0.0\nb[0] = x\nb[1] = b[1] % -2.0\nb[2] = -b[2] % 0.75",
        "b[-1] = a\nb[1:3][0] = 5.0\nv = b[1:]\nv[2] = v.size\nb[0] = v[1:2].size + b[3:9].size + b[5:].size",
        "both = Both(twice, b, (a, 1))\nb[2] = group(both) + both.k[1]",
        "b[-9:][0] = a; b[:-9]; b[1] = b[-9:2].size + 10 * b[-2:9].size + 100 * b[:-1].size; b[2] = b[-9:-9].size",
        "b[0] = 1.0 if -1 < a < b[2] else 2.0\nb[1] = 1.0 if 0.0 < a != a < 3 else 2.0",
        "b[0] = chosen(sign, a); b[1] = chosen(None, a); b[2] = 1.0 if sign and not None else 2.0",
        "b[0] = 1.0 if -1 < moves(b, a) < b[0] != moves(b, 2) else 2.0",
        "b[0] += moves(b, a)\nb[1] *= moves(b[1:], 3)",
        "w = tuple(a * x for x in NODES)\nfor x in tuple((y, w[y] + a) for y in (0, 2)):\n    b[x[0]] = x[1]",
        "b[PLANE.LEVERS] = a * SPACE.RATE; b[0] = math.pi; b[1] = sized(SPACE, a)",
        "return",
        "'''A docstring.'''\npass",
    ],
)
def test_numbers(compiled, body):
    f, interpreted = compiled(body, ("float", "vector"))
    for a in NUMBERS:
        try:
            expected = outcome(interpreted, np.float64(a), X)
        except (ZeroDivisionError, OverflowError):
            continue
        same(outcome(f, a, X), expected)


@needs_compiler
@pytest.mark.parametrize(
    "body",
    [
        "b[0] = sin(a) if abs(a) < 10.0 else 0.0\nb[1] = tan(0.7)",
        "b[0] = log10(abs(a) + 1); b[1] = sinh(1 / (1 + a * a)); b[2] = arccos(0.3)",
    ],
)
def test_functions_of_numpy(compiled, body):
    """NumPy's vector instructions, where the processor has them, are exact to 4 units in the last place."""
    f, interpreted = compiled(body, ("float", "vector"))
    for a in NUMBERS:
        (_, found), (_, expected) = outcome(f, a, X), outcome(interpreted, np.float64(a), X)
        known = np.isfinite(expected)
        np.testing.assert_array_max_ulp(found[known], expected[known], maxulp=4)
        assert np.array_equal(found[~known], expected[~known], equal_nan=True)


@needs_compiler
@pytest.mark.parametrize(
    "body",
    [
        "return a // b + 100 * (a % b)",
        "return a // 3 - 10 * (a % 4)",
        "return int(a / b) + int(-2.7 * a)",
        "return floor(a / b) * 10 + ceil(a / 4)",
        "return (a & 6) + (a | b) + (a ^ b) + (a << 2) + (a >> 1)",
        "return abs(a) + max(a, b) - min(a, b, 3)",
        "n = 0\nfor i in range(a):\n    for j in range(i, b, 2):\n        n += i * j + 1\nreturn n",
        "n = a\nfor n in range(3):\n    pass\nreturn n",
        "if a > b:\n    return 1\nelse:\n    return -1",
        "return 1 if a == b or a != -b and not a else 0",
        "return bool(a) + (a > 1) * 2",
        "x = 1 if a and b > 1 or not (a or b) else 0\nwhile x < 3 and (a or x):\n    x += 1\nreturn x",
        "k = 0\nif -2 < a < b <= 3 != a:\n    k = 1\nreturn k + 2 * (a < b)",
        "x = 0\nif a > 2:\n    x = 2.5\nreturn int(x * b)",
        "for i in range(5):\n    if i == a:\n        return i\n    elif i == b:\n        return -i\nreturn 99",
    ],
)
def test_integers(compiled, body):
    f, interpreted = compiled(body, ("int", "int"), "int")
    for a in range(-5, 6):
        for b in (-4, -3, -1, 1, 2, 5):
            assert f(a, b) == int(interpreted(a, b)), (a, b)


@needs_compiler
def test_no_division_of_integers_ends_the_process(compiled):
    """The first quotient is 2**63, which is no 64-bit integer: it wraps. A division by zero gives zero."""
    f, _ = compiled("return a // b + 10 * (a % b) + 100 * (a // -1)", ("int", "int"), "int")
    for a, b in ((-(2**63), -1), (-7, -1), (7, -1), (7, 0)):
        quotient, rest = (a // b, a % b) if b else (0, 0)
        assert f(a, b) == (quotient + 10 * rest - 100 * a + 2**63) % 2**64 - 2**63


@needs_compiler
@pytest.mark.parametrize(
    "body",
    [
        "for i in range(3):\n    for j in range(4):\n        b[i, j] = a[j] * b[i, 3 - j] - c[j]",
        "row = b[1]\nrow[2] = a[0]\nb[2][1] = row.size",
        "rest = b[1:]\nrest[0, 1] = 3.0\nrest[1][2] = rest.size + rest.shape[0] * 10",
        "part = b[c[2], 1:3]\npart[1] = -1\npart[0] = part.size",
        "a[c[0]] += b[c[2], c[0]]\nc[3] = a[1] * 2\nc[c[2]] = len(b) * len(a)",
        "square_of = b[0]\nsquare_of[0] = b.shape[1]\nfor k in range(b.shape[0]):\n    b[k, 0] += k",
        "v = a[1:]\nb[0, 0] = v[0] + v[-1] + a[-2]\nb[-1, -1] = 7",
    ],
)
def test_arrays(compiled, body):
    f, interpreted = compiled(body, ("vector", "matrix", "ints"))
    same(outcome(f, X, M, K), outcome(interpreted, X, M, K))


@needs_compiler
def test_square_is_a_view(compiled):
    f, interpreted = compiled("H = square(a, b, 6)\nH[1, 2] = 5.0\nH[5, 5] += H[0, 0]", ("vector", "int"))
    x = np.arange(50.0)
    same(outcome(f, x, 7), outcome(interpreted, x, 7))


USER = """
from mbdsl.kernels.marks import kernel

@kernel
def last(x, k):
    return x[-k] + 10.0 * (1.0, 2.0, 3.0)[-k] + 100.0 * x[-k:].size + 1000.0 * x[k - 4 : -k].size
"""


@needs_compiler
def test_kernels_of_users_count_from_the_end(compiled, monkeypatch):
    """Any index may be negative, not only literals as in mbdsl's own kernels; slices may begin before the array."""
    module = ModuleType("mbdsl_user_kernels")
    setattr(module, marks.TEXT, USER)
    exec(USER, vars(module))
    monkeypatch.setitem(sys.modules, module.__name__, module)
    name = "mbdsl_test_user"
    monkeypatch.delitem(sys.modules, name, raising=False)
    (f,) = code_cache.functions(
        name,
        "from mbdsl_user_kernels import last\n\ndef f(x, k):\n    x[0] = last(x, k)\n",
        {"f": Signature(("vector", "int"))},
        lambda: [module],
    )
    for k in (1, 2, 3):
        same(outcome(f, X, k), outcome(sys.modules[name].f, X, k))


@needs_compiler
def test_compiled_functions_are_called_by_their_address(compiled):
    inner = Signature(("float", "vector", "matrix", "ints", "int matrix"), "int")
    g, plain = compiled("b[1] = a\nc[1, 1] += a\nd[0] = e[1, 0]\nreturn c.size + 100 * e.size", inner.takes, "int")
    f, interpreted = compiled("return a(b[0] + 1.0, b, c, d, e) + a(2, b, c, d, e)", (inner, *inner.takes[1:]), "int")
    N = np.arange(6).reshape(2, 3)
    same(outcome(f, g, X, M, K, N), outcome(interpreted, plain, X, M, K, N))


@needs_compiler
@pytest.mark.parametrize(
    ("body", "message"),
    [
        (
            "x = [1, 2]",
            r":{line}:5: cannot compile the kernel f: `\[1, 2\]`\n +x = .*\n .*\n  = write a tuple",
        ),
        ("a.sort()", "`a.sort`"),
        ("b = a[::2]", "a slice with a step"),
        ("a[1:] = 0.0", "assign its entries in a loop"),
        ("x = 1\nif a[0] > 0:\n    x = a", "a variable is both int and an array with 1 axes of float"),
        ("x = print(a[0])", "this function is not available in kernels"),
        ("a[0] = len(a) or 2", r"`len\(a\) or 2` gives int; use `... if ... else ...`"),
        ("a[0] = hypot(a[0], a[1], a[2])", "this function is not available in kernels"),
        ("a[0] = thrice(a[0])", "`twice` is not defined at the level of its module"),
        ("a[0] = unknown", "`unknown` is not defined"),
        ("if a[0] > 0:\n    return 1", "one end of the function returns a value, and another does not"),
        ("for x in a:\n    pass", "a loop over an array"),
        ("a[0] = 2 ** len(a)", r"`\*\*` of integers"),
        ("try:\n    pass\nfinally:\n    pass", r"`try:`(\n.*)+return a number that the caller looks at"),
        ("a[0] = sum({1: 2})", "write a tuple"),
        ("a[0] = sum({1, 2})", "write a tuple"),
        ("x = [2*y for y in a]", "write a `for` loop"),
        ("x = {2*y for y in a}", "write a `for` loop"),
        ("x = {y: y for y in a}", "write a `for` loop"),
        ("x = sum(y for y in a)", "write a `for` loop"),
        ("x = tuple(y for y in a)", "a tuple from `for y in a`"),
        ("x = tuple(y for y in NODES if y > 0)", "a tuple from"),
        ("raise ValueError", "return a number"),
        ("assert a[0] > 0", "return a number"),
        ("with a:\n    pass", "return a number"),
        ("x = lambda y: y", "write a kernel at the level of the module"),
        ("def g(x):\n    pass", "write a kernel at the level of the module"),
        ("import math", "import at the level of the module"),
        ("from math import pi", "import at the level of the module"),
        ("match a[0]:\n    case 1.0:\n        pass", "write `if ... elif ...`"),
        ("x = ends(*a)", "write the items of the tuple"),
        ("a[0] = (x := 2)", "write an assignment before the statement"),
        ("global TABLE", "pass the value as an argument"),
        ("x: float = 2.0", "leave out the type"),
        ("x = f'{a}'", "docs/kernels.md lists the part of Python that is compiled; MBDSL_NO_COMPILE=1 runs"),
        ("while a[0] > 0:\n    pass\nelse:\n    pass", "`while ... else`"),
        ("for i in range(2):\n    pass\nelse:\n    pass", "`for ... else`"),
        ("for i in range(0, 3, len(a)):\n    pass", "the step of `range` has to be a literal"),
        ("a[0] = twice()", "TypeError: missing a required argument: 'x'"),
        ("a[0] = NODES[5]", "IndexError"),
        ("a[0] = a // 2.0", "arithmetic with an array"),
        ("a[0] = a[1] // 2.0", "`//` of floats; use floor"),
        ("a[0] = a[1] & 2", "the operator `BitAnd` between float and int"),
        ("a[0] = 1.0 if a < 2 else 0.0", "a comparison of an array"),
        ("a[0] = 1.0 if a else 0.0", "an array with 1 axes of float as a condition"),
        ("a[a[0]] = 1.0", "float as an index"),
        ("a[0] = a.T", "`a.T`"),
        ("x, y = a", "is assigned to"),
        ("a.x = 2.0", "`a.x` is assigned"),
        ("a[0] = a", "in place of a number"),
        ("a[0] = ~2", "`~2`"),
        ("a[0] += x", "`x` is not defined"),
        ("if a[0] > 0:\n    x = 1\nfor i in range(x):\n    y = z\n    z = 1", "`z` is read before it is assigned"),
        ("a[0] = sized(PLANE, a[0])", r"cannot compile the kernel sized: `\[x\]`"),
        ("a[0] = PLANE.third", "AttributeError"),
        ("a[0] = itself(3)", "`itself` calls itself"),
        ("a[0] = math.tau2", "AttributeError"),
    ],
)
def test_what_is_not_translated_is_named(body, message, monkeypatch):
    text = HEAD + "def f(a):\n" + "".join(f"    {line}\n" for line in body.splitlines())
    try:
        module = code_cache.import_text("mbdsl_test_refused", text)
        with pytest.raises(Untranslatable, match=message.replace("{line}", str(HEAD.count("\n") + 2))):
            translation.translate("refused", {"f": module.f}, {"f": Signature(("vector",))})
    finally:
        sys.modules.pop("mbdsl_test_refused", None)


PAGE = Path(__file__).parents[3] / "docs" / "kernels.md"


def test_the_page_names_all_that_is_translated_and_all_alternatives():
    text = PAGE.read_text(encoding="utf-8")
    for kind in TRANSLATIONS:
        assert f"`{kind.__name__}`" in text, kind
    for kind, remedy in ALTERNATIVES.items():
        assert f"`{kind.__name__}`" in text and remedy in text, kind
    for name in (*INTRINSICS, *LIBRARY):
        assert re.search(rf"\b{name}\b", text), name


@needs_compiler
def test_all_step_loops_are_translated(monkeypatch):
    """The loops of all methods, and the code of a model with kinds that other tests compile, are translated."""
    from mbdsl.integrators import modules
    from mbdsl.integrators.loop import compiled_loop

    seen = []

    def functions(name, text, signatures, called):
        called()
        module = code_cache.import_text(name, text)
        seen.append(translation.translate(name, {f: getattr(module, f) for f in signatures}, signatures))
        return [None] * len(signatures)

    monkeypatch.setattr(code_cache, "functions", functions)
    for method, module in modules().items():
        compiled_loop.compiled(method, module)
    assert len(seen) == len(modules())
    for text in seen:
        assert 'advance.packed"' in text


@needs_compiler
def test_compiled_code_agrees_with_the_interpreter(monkeypatch):
    """Residuals and tangent of a model at a state that is not consistent."""
    from mbdsl.system import build

    scene = mbdsl.load(Path(__file__).parents[3] / "models" / "slider_crank.mbd")

    def evaluated():
        monkeypatch.setattr(code_cache, "_functions", {})
        system = build(scene)
        q, v, lam = (np.random.default_rng(k).normal(size=n) for k, n in enumerate((system.n, system.n, system.m)))
        return [*system.evaluate(0.3, q, v, lam), system.tangent(0.3, q, v, lam, cM=1.0, cK=2.0, cP=3.0, cN=4.0)]

    compiled = evaluated()
    with code_cache.uncompiled():
        interpreted = evaluated()
    for one, other in zip(compiled, interpreted, strict=True):
        assert np.isfinite(one).any()
        # numpy's sin and cos may differ from the C library's by one unit in the last place
        np.testing.assert_allclose(one, other, rtol=1e-13, atol=1e-13 * np.abs(other).max())
