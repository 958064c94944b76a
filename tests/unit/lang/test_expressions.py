"""Expressions: every partial derivative against central differences, and the rules that keep graphs small."""

import math

import pytest

from mbdsl.expressions import derivatives
from mbdsl.expressions import symbolic as ex
from mbdsl.expressions.derivatives import der, diff
from mbdsl.expressions.printing import text
from mbdsl.expressions.symbolic import OPERATIONS, Expr, call, const, coordinate, evaluate
from mbdsl.mechanism.scene_parts import Table

X, Y, Z = coordinate("f", "x"), coordinate("f", "y"), coordinate("f", "phi")

#: operation -> points at which it is smooth
POINTS = {
    "add": [(1.3, -0.4)],
    "sub": [(1.3, -0.4)],
    "mul": [(1.3, -0.4), (0.0, 2.0)],
    "div": [(1.3, -0.4), (0.0, 2.0)],
    "neg": [(1.3,)],
    "pow": [(1.3, 2.4), (0.7, -1.5)],
    "asin": [(0.3,), (-0.9,)],
    "acos": [(0.3,), (-0.9,)],
    "log": [(0.3,), (7.0,)],
    "log10": [(0.3,), (7.0,)],
    "sqrt": [(0.3,), (7.0,)],
    "atan2": [(1.3, -0.4), (-0.2, -0.7), (0.5, 0.9)],
    "angle": [(1.3, -0.4), (-0.2, -0.7), (0.5, 0.9)],
    "hypot": [(1.3, -0.4), (0.0, 2.0)],
    "ratio": [(1.3, -0.4)],
    "abs": [(1.3,), (-0.4,)],
    "sign": [(1.3,), (-0.4,)],
    "min": [(1.3, -0.4), (-0.4, 1.3)],
    "max": [(1.3, -0.4), (-0.4, 1.3)],
    "floor": [(1.3,)],
    "ceil": [(1.3,)],
    "mod": [(1.3, 0.4), (-1.3, 0.4)],
    "lt": [(1.3, 0.4)],
    "le": [(1.3, 0.4)],
    "eq": [(1.3, 0.4)],
    "ne": [(1.3, 0.4)],
    "and": [(1.0, 0.0)],
    "or": [(1.0, 0.0)],
    "not": [(1.0,)],
    "select": [(1.0, 0.3, 0.7), (0.0, 0.3, 0.7)],
}


def value(node, *point):
    at = dict(zip((X, Y, Z), point, strict=False))
    return evaluate([node], lambda leaf: at[leaf])[0]


@pytest.mark.parametrize("name", sorted(OPERATIONS))
def test_partial_derivatives(name):
    points = POINTS.get(name, [(0.3,), (-0.8,)])
    variables = (X, Y, Z)[: len(points[0])]
    node = Expr(name, variables)
    exact = diff(node, *variables)
    for point in points:
        for k, _ in enumerate(variables):
            h = 1e-6
            up, down = list(point), list(point)
            up[k] += h
            down[k] -= h
            if name in ("select", "and", "or", "not") and (name != "select" or k == 0):
                expected = 0.0  # conditions are 0 or 1, they have no derivative
            else:
                expected = (value(node, *up) - value(node, *down)) / (2 * h)
            assert value(exact[k], *point) == pytest.approx(expected, abs=2e-8, rel=2e-8), (name, point, k)


def test_every_operation_has_derivatives_or_is_piecewise_constant():
    flat = {"sign", "floor", "ceil", "lt", "le", "eq", "ne", "and", "or", "not"}
    assert set(OPERATIONS) - set(derivatives.PARTIALS) == flat


def test_second_derivatives_of_a_product():
    f = call("sin", X * Y) * X
    fxy = diff(diff(f, X)[0], Y)[0]
    x, y, h = 0.7, 1.1, 1e-4
    f_at = lambda a, b: value(f, a, b)  # noqa: E731
    expected = (f_at(x + h, y + h) - f_at(x + h, y - h) - f_at(x - h, y + h) + f_at(x - h, y - h)) / (4 * h * h)
    assert value(fxy, x, y) == pytest.approx(expected, rel=1e-6)


def test_equal_expressions_are_one_object():
    assert X + Y is X + Y
    assert call("sin", X) is call("sin", X)
    assert const(1) is const(1.0)


def test_simplifications():
    assert X + 0 is X and X * 1 is X and -(-X) is X and X - 0 is X and X / 1 is X  # noqa: B002
    assert ex.is_const(X * 0, 0.0) and ex.is_const(const(2) * 3, 6.0)
    assert (X**2) is X * X
    assert call("select", const(1.0), X, Y) is X


def test_a_constant_that_is_no_number_is_left_to_evaluation():
    node = call("log", const(-1.0))
    assert node.op == "log"
    with pytest.raises(ValueError, match="math"):
        evaluate([node], lambda leaf: 0.0)


def test_derivatives_stay_small():
    node = X
    for _ in range(60):
        node = node * node + Y
    assert len(ex.walk(*diff(node, X, Y))) < 600


def test_time_derivative():
    s = call("hypot", X, Y)
    v = der(s)
    assert {leaf.value[1] for leaf in ex.leaves(v)} == {"x", "y", "vx", "vy"}
    at = {"x": 3.0, "y": 4.0, "vx": 1.0, "vy": 2.0}
    assert evaluate([v], lambda leaf: at[leaf.value[1]])[0] == pytest.approx((3 + 8) / 5)
    with pytest.raises(ValueError, match="position or an angle"):
        der(v)
    assert ex.is_const(der(ex.TIME), 1.0)


def test_table_derivative_raises_the_order():
    table = Table("p", (0.0, 1.0), (0.0, 2.0))
    node = Expr("table", (X * X,), (table, 0))
    (d,) = diff(node, X)
    inner = next(n for n in ex.walk(d) if n.op == "table")
    assert inner.value == (table, 1)
    found = evaluate([d], lambda leaf: 3.0, table=lambda data, nth, u: (u, 10.0)[nth])[0]
    assert found == pytest.approx(10.0 * 6.0)


def test_substitute_and_text():
    node = call("sin", X) + 2 * Y
    new = ex.substitute(node, lambda leaf: const(0.5) if leaf is Y else None)
    assert new is call("sin", X) + 1.0
    assert text(node) == "(sin(f.x) + (2.0*f.y))"
    assert math.isclose(value(node, 0.3, 0.2), math.sin(0.3) + 0.4)
