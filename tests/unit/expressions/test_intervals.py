"""Bounds of expressions contain numpy samples of random expressions and of their exact derivatives."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as some
from scipy.interpolate import BPoly, PPoly

from mbdsl.expressions.array_operations import ARRAY_OPERATIONS, table_value
from mbdsl.expressions.derivatives import diff
from mbdsl.expressions.symbolic import OPERATIONS, TIME, Expr, call, coordinate, evaluate, expr, walk
from mbdsl.mechanism.scene_parts import Table
from mbdsl.system.paths import Program, over_time

U, Y = (-1.0, 0.0, 0.5, 2.0), (0.0, 1.0, -1.0, 0.0)
TABLES = [
    Table("p", U, Y, smoothness, beyond)
    for smoothness in ("linear", "monotone", "cubic")
    for beyond in ("hold", "linear", "periodic", "error")
]
BEYOND, PERIODIC = TABLES[1], TABLES[6]  # extrapolated with its last slope; of monotone slopes
ARITY = {"select": 3, **dict.fromkeys("sin cos tan asin acos atan sinh cosh tanh exp log log10 sqrt".split(), 1)}
ARITY |= dict.fromkeys("neg abs sign floor ceil not".split(), 1)
JUMPS = ("sign", "floor", "ceil", "mod", "lt", "le", "eq", "ne", "and", "or", "not", "select", "tan", "atan2", "ratio")


def expressions():
    numbers = NUMBERS.map(expr)

    def grown(inner):
        of_op = some.sampled_from(sorted(set(OPERATIONS) - {"eq", "ne"})).flatmap(
            lambda op: some.tuples(*[inner] * ARITY.get(op, 2)).map(lambda args: call(op, *args))
        )
        of_table = some.tuples(some.sampled_from(TABLES), some.integers(0, 2), inner)
        return of_op | of_table.map(lambda x: Expr("table", (x[2],), (x[0], x[1])) if x[2].op != "const" else x[2])

    return some.recursive(some.just(TIME) | numbers, grown, max_leaves=6)


#: none so small that its inverse overflows
NUMBERS = some.floats(-3.0, 3.0).map(lambda x: round(x, 9))


def sampled(root, t):
    """Values of an expression; NaN if one of its parts is NaN."""
    parts = list(walk(root))
    with np.errstate(all="ignore"):
        try:
            found = evaluate(parts, lambda leaf: t, ARRAY_OPERATIONS, table_value)
        except ZeroDivisionError:  # of two constants
            found = [np.nan]
    found = np.array([np.broadcast_to(np.asarray(f, float), t.shape) for f in found])
    return np.where(np.isnan(found).any(axis=0), np.nan, found[-1])


def bounds(root, a, b):
    with np.errstate(all="ignore"):
        found = over_time(root).jets(np.zeros(1, int), np.array([a]), np.array([b]))
    return [float(x[0, 0]) for x in found]


@given(expressions(), NUMBERS, some.floats(-7.0, 0.5))
@example(call("pow", expr(0.0), TIME), 0.0, 0.0)  # jumps from 1 to 0
@example(call("tan", TIME), 0.0, 0.5)
@example(Expr("table", (TIME,), (PERIODIC, 1)), 2.0, 0.0)  # the slope jumps where a period ends
@example(Expr("table", (TIME,), (BEYOND, 0)), -3.0, 0.0)  # before the first value
@example(Expr("table", (TIME,), (BEYOND, 0)), -1.5, 0.5)  # before it and within
@example(Expr("table", (TIME,), (BEYOND, 0)), 1.5, 0.5)  # within and behind the last value
@settings(max_examples=150, deadline=None, derandomize=True)
def test_samples_lie_within(root, a, width):
    b = a + 10.0**width
    lo, hi, d_lo, d_hi = bounds(root, a, b)
    t = np.linspace(a, b, 41)
    y = sampled(root, t)
    finite = np.isfinite(y)
    # rounding of intermediate values that cancel is not a value of the expression
    noise = 1e-12 * (1.0 + np.abs(y[finite]).max(initial=0.0))
    assert (y[finite] >= lo - noise).all() and (y[finite] <= hi + noise).all()
    if finite.all():
        slopes = np.diff(y) / np.diff(t)
        noise = 1e-10 * (1.0 + np.abs(y).max()) / (t[1] - t[0])
        assert (slopes >= d_lo - noise).all() and (slopes <= d_hi + noise).all()


@given(expressions(), NUMBERS)
@example(call("mod", expr(-0.5), TIME), 1.0)
@settings(max_examples=80, deadline=None, derandomize=True)
def test_bounds_shrink_to_the_value_and_the_derivative(root, t):
    lo, hi, d_lo, d_hi = bounds(root, t, t)
    value = float(sampled(root, np.array([t]))[0])
    slope = float(sampled(diff(root, TIME)[0], np.array([t]))[0])
    if np.isfinite(value):
        size = 1e-9 * (1.0 + abs(value))
        assert lo - size <= value <= hi + size
        if np.isfinite(slope) and not any(n.op in JUMPS for n in (root,)):
            assert d_lo - 1e-9 * (1.0 + abs(slope)) <= slope <= d_hi + 1e-9 * (1.0 + abs(slope))


@pytest.mark.parametrize("law", ["square", "cube", "gauss"])
def test_bounds_are_sharp(law):
    """Closed forms: on [1, 2], t^2 has the range [1, 4], t^3 [1, 8], exp(-t^2) [e^-4, e^-1]."""
    root = {"square": TIME * TIME, "cube": TIME**3.0, "gauss": call("exp", -(TIME * TIME))}[law]
    exact = {"square": (1, 4, 2, 4), "cube": (1, 8, 3, 12), "gauss": (np.exp(-4), np.exp(-1), None, None)}[law]
    for found, wanted in zip(bounds(root, 1.0, 2.0), exact, strict=True):
        assert wanted is None or found == pytest.approx(wanted, rel=1e-13)


@pytest.mark.parametrize("name", ["sin", "cos"])
def test_bounds_of_waves_are_sharp_in_all_periods(name):
    """The range on an interval: the values at its ends, and 1 or -1 where it has an extremum."""
    function, at = {"sin": (np.sin, 0.5 * np.pi), "cos": (np.cos, 0.0)}[name]
    for a in np.linspace(-20.0, 20.0, 41):
        for b in (a + 0.3, a + 2.0, a + 5.0):
            ends = function([a, b])
            hi = 1.0 if np.floor((b - at) / (2 * np.pi)) > np.floor((a - at) / (2 * np.pi)) else ends.max()
            lo = -1.0 if np.floor((b - at) / (2 * np.pi) - 0.5) > np.floor((a - at) / (2 * np.pi) - 0.5) else ends.min()
            assert bounds(call(name, TIME), a, b)[:2] == pytest.approx([lo, hi], abs=1e-12)


def one_of(jet):
    """The bounds of the only root."""
    return type(jet)(*(x[:, 0] for x in jet))


def test_ways_lie_within_their_bounds():
    """Cubic polynomials with random coefficients, one or all at a time, over whole steps, parts of them, and several
    steps."""
    x = coordinate("b", "x")
    ways = np.concatenate([np.eye(4), -np.eye(4), np.random.default_rng(5).normal(size=(40, 4))])
    k, s = np.arange(len(ways)), np.linspace(0.0, 1.0, 33)
    f = Program([x]).of({x: ways}, {})
    y = np.array([c0 + s * (c1 + s * (c2 + s * c3)) for c0, c1, c2, c3 in ways])
    slopes = np.diff(y) / np.diff(s)
    assert pytest.approx(y, abs=1e-14) == np.array([f.at(k, np.full(len(k), at))[:, 0] for at in s]).T
    for a, b in ((0, 32), (0, 8), (8, 32)):
        jet = one_of(f.jets(k, np.full(len(k), s[a]), np.full(len(k), s[b])))
        assert (jet.lo <= y[:, a : b + 1].min(axis=1)).all() and (y[:, a : b + 1].max(axis=1) <= jet.hi).all()
        slope = slopes[:, a:b]
        assert (jet.d_lo <= slope.min(axis=1) + 1e-12).all() and (slope.max(axis=1) <= jet.d_hi + 1e-12).all()
    # as tight as SciPy's coefficients in Bernstein's form
    coefficients = BPoly.from_power_basis(PPoly(ways.T[::-1, None, :], [0.0, 1.0])).c[:, 0, :]
    for jet in (one_of(f.over(k)), one_of(f.jets(k, np.zeros(len(k)), np.ones(len(k))))):
        assert np.asarray(jet.lo) == pytest.approx(coefficients.min(axis=0), abs=1e-13)
        assert np.asarray(jet.hi) == pytest.approx(coefficients.max(axis=0), abs=1e-13)
    first = np.arange(0, len(ways), 3)
    jet = one_of(f.over(first))
    assert (jet.lo <= np.minimum.reduceat(y.min(axis=1), first)).all()
    assert (np.maximum.reduceat(y.max(axis=1), first) <= jet.hi).all()
    assert (jet.d_lo <= np.minimum.reduceat(slopes.min(axis=1), first) + 1e-12).all()
    assert (np.maximum.reduceat(slopes.max(axis=1), first) <= jet.d_hi + 1e-12).all()
