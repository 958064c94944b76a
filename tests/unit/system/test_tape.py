"""User expressions in the step loop: the compiled tape against Python's floats, numpy's arrays, and differences.

One scene holds a Torque for every operation, its arguments functions of the state; another one for every kind of table.
Both have one structure, whatever the expressions say.
"""

import inspect
import math
from functools import cache

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator, interp1d

from mbdsl import Builder
from mbdsl.expressions.array_operations import ARRAY_OPERATIONS, table_value
from mbdsl.expressions.symbolic import OPERATIONS, TIME, Expr, call, coordinate, evaluate, expr
from mbdsl.kernels.columns import PLANE as C
from mbdsl.mechanism.scene_parts import Table
from mbdsl.system import build, expression_tape
from mbdsl.system.signals import values

#: operations whose arguments must stay in an interval; all others take any
DOMAINS = {
    "asin": (-0.9, 0.9),
    "acos": (-0.9, 0.9),
    "log": (0.1, 3.0),
    "log10": (0.1, 3.0),
    "sqrt": (0.1, 3.0),
    "pow": (0.2, 2.0),
    "div": (0.5, 2.0),
    "ratio": (0.5, 2.0),
    "mod": (0.3, 0.9),
    "tan": (-1.2, 1.2),
}
STEPS = {"floor", "ceil", "sign", "lt", "le", "eq", "ne", "and", "or", "not"}  #: piecewise constant
#: operands for conditions and equality, which a smooth argument hardly ever satisfies
EXACT = [0.0, 1.0, -1.0, 2.0, -0.5]


def arity(op):
    function = ARRAY_OPERATIONS[op]
    return getattr(function, "nin", None) or len(inspect.signature(function).parameters)


def scene(laws):
    """A body with a torque for each law, on a pin."""
    b = Builder("Laws")
    ground = b.Ground("ground")
    wheel = b.Body("wheel", m=1.0, I=1.0)
    b.Revolute("pin", ground, wheel.c)
    for i, root in enumerate(laws):
        b.Torque(f"law[{i + 1}]", ground, wheel.c, tau=root)
    return b.scene()


def argument(k, low, high) -> Expr:
    """The k-th argument of an operation: a function of time and of the body's angle and rate, within an interval."""
    phi, w = coordinate("wheel.c", "phi"), coordinate("wheel.c", "w")
    smooth = call("sin", (1.0 + k) * phi + 0.7 * w + 0.3 * (k + 1) * TIME)
    return 0.5 * (low + high) + 0.5 * (high - low) * smooth


def expression(op):
    low, high = DOMAINS.get(op, (-2.0, 2.0))
    return call(op, *(argument(k, low, high) for k in range(arity(op))))


@cache
def system(laws):
    return build(scene(laws))


def results(s, t, q, v):
    """The value of the tape for each law."""
    s.evaluate(t, q, v)
    return -s.gradient_table()[s.m :, C.MAGNITUDE].copy()  # the table holds -sign s


def states():
    rng = np.random.default_rng(5)
    return [(rng.uniform(0, 3), rng.uniform(-2, 2, 3), rng.uniform(-2, 2, 3)) for _ in range(7)]


LAWS = tuple(expression(op) for op in OPERATIONS)
ORDER = dict(zip(OPERATIONS, range(len(OPERATIONS)), strict=True))


def ulps(x):
    """A few roundings: compiled and library functions may differ in the last places, and so do their arguments."""
    return pytest.approx(x, rel=1e-14, abs=1e-14)


def test_every_operation_has_its_code_and_its_array_form():
    codes = set(expression_tape.OPCODE) - {"load", "multiplier", "table"}
    assert codes == set(OPERATIONS) == set(ARRAY_OPERATIONS) - {"integral"}  # of energies, which no law contains
    numbers = [expression_tape.OPCODE[name] for name in expression_tape._NAMES]
    assert [
        getattr(expression_tape, name.upper())
        for name in expression_tape._NAMES
        if hasattr(expression_tape, name.upper())
    ] == numbers


@pytest.mark.parametrize("op", OPERATIONS)
def test_operation(op):
    s, i = system(LAWS), ORDER[op]
    for t, q, v in states():
        found = results(s, t, q, v)[i]
        known = {"time": t, "phi": q[2], "w": v[2]}
        (scalar,) = evaluate([LAWS[i]], lambda n, known=known: known[n.op if n.op == "time" else n.value[1]])
        (array,) = values(s, [LAWS[i]], np.array([t]), q[None], v[None])
        assert found == ulps(scalar)
        assert found == ulps(array[0])


@pytest.mark.parametrize("op", [op for op in OPERATIONS if op not in STEPS])
def test_derivative_of_operation(op):
    """The gradient tape, seen in the tangents, against five-point differences of the value tape.

    With steps of 1e-3 truncation is 1e-12/30 times a fifth derivative: the arguments' frequencies of up to 3 (5 for mod
    and select, of three arguments) and the functions' own give at most 1e4.
    """
    s, h = system((LAWS[ORDER[op]],)), 1e-3
    for t, q, v in states():
        slopes = []
        for dq, dv in ((np.eye(3)[2] * h, 0), (0, np.eye(3)[2] * h)):
            f = [results(s, t, q + k * dq, v + k * dv)[0] for k in (1, -1, 2, -2)]
            slopes.append((8 * (f[0] - f[1]) - (f[2] - f[3])) / (12 * h))
        size = 1 + np.abs(slopes).max()
        assert -s.stiffness(t, q, v)[2, 2] == pytest.approx(slopes[0], abs=1e-8 * size)
        assert -s.damping(t, q, v)[2, 2] == pytest.approx(slopes[1], abs=1e-8 * size)


@pytest.mark.parametrize("op", sorted(STEPS | {"select", "abs", "min", "max", "ratio"}))
def test_operation_at_its_edges(op):
    """Equal and zero operands, where conditions and one-sided functions decide."""
    s = system((call(op, *(coordinate("wheel.c", k) for k in ("x", "y", "phi")[: arity(op)])),))
    for a in EXACT:
        for b in EXACT:
            q = np.array([a, b, 0.5])
            (array,) = values(s, [LAWS_OF(s)], np.zeros(1), q[None], q[None])
            assert results(s, 0.0, q, q)[0] == OPERATIONS[op](*q[: arity(op)].tolist()) == array[0]


def LAWS_OF(s):
    return s.scene.components["law[1]"].values["tau"]


# -- tables ----------------------------------------------------------------------------------------------------

U, Y = (0.0, 0.5, 1.2, 2.0, 3.1), (1.0, 2.0, 0.5, 0.7, 1.0)
WAYS = [(s, e) for s in ("linear", "cubic", "monotone") for e in ("hold", "linear", "periodic", "error")]
TABLES = [Table(f"{s}{e}", U, Y, s, e) for s, e in WAYS]
INSIDE = [0.0, 0.1, 0.5, 0.77, 1.2, 1.9, 2.5, 3.1]
OUTSIDE = [-7.3, -0.2, 3.3, 9.7]


def reference(table, order, u):
    """The same by scipy's interpolation and the definitions of the extrapolation."""
    first, last = U[0], U[-1]
    if table.smoothness == "linear":
        inner = interp1d(U, Y)
        slopes = np.diff(Y) / np.diff(U)

        def f(x, nu):
            k = min(int(np.searchsorted(U, x, side="right")) - 1, len(U) - 2)
            return inner(x) if nu == 0 else slopes[k] if nu == 1 else 0.0

    elif table.smoothness == "monotone":
        f = PchipInterpolator(U, Y)
    else:
        f = CubicSpline(U, Y, bc_type="periodic" if table.extrapolation == "periodic" else "not-a-knot")
    if first <= u <= last:
        return f(u, order)
    edge = first if u < first else last
    if table.extrapolation == "hold":
        return f(edge, 0) if order == 0 else 0.0
    if table.extrapolation == "linear":
        return f(edge, 0) + f(edge, 1) * (u - edge) if order == 0 else f(edge, 1) if order == 1 else 0.0
    if table.extrapolation == "periodic":
        return f(first + (u - first) % (last - first), order)
    return math.nan


@pytest.mark.parametrize("table", TABLES, ids=lambda t: t.name)
@pytest.mark.parametrize("order", [0, 1, 2])
def test_table(table, order):
    """Values and derivatives, compiled and on arrays, against scipy: polynomials of the same coefficients."""
    s = system((Expr("table", (coordinate("wheel.c", "x"),), (table, order)),))
    for u in INSIDE + OUTSIDE:
        q = np.array([u, 0.0, 0.0])
        expected = pytest.approx(reference(table, order, u), abs=1e-12, nan_ok=True)
        if table.extrapolation == "error" and u in OUTSIDE and order > 0:
            continue  # the value itself stops the integration
        assert results(s, 0.0, q, q)[0] == expected
        assert table_value(table, order, np.array([u]))[0] == expected


@pytest.mark.parametrize("table", [t for t in TABLES if t.extrapolation != "error"], ids=lambda t: t.name)
def test_derivative_of_table(table):
    """Away from the breaks a table is a cubic, of which five-point differences are exact to rounding: eps/h = 2e-13."""
    s, h = system((call("sin", Expr("table", (coordinate("wheel.c", "phi"),), (table, 0))),)), 1e-3
    for u in (0.2, 0.9, 1.7, 2.5, -0.2, 3.4):
        f = [math.sin(reference(table, 0, u + k * h)) for k in (1, -1, 2, -2)]
        slope = (8 * (f[0] - f[1]) - (f[2] - f[3])) / (12 * h)
        q = np.array([0.0, 0.0, u])
        assert -s.stiffness(0.0, q)[2, 2] == pytest.approx(slope, abs=1e-9)


def test_two_points_and_three():
    """Few points: a straight line; a natural spline."""
    for u, y, expected in (
        ((0.0, 2.0), (1.0, 5.0), lambda x: 1.0 + 2.0 * x),
        ((0.0, 1.0, 3.0), (0.0, 2.0, 1.0), CubicSpline([0, 1, 3], [0, 2, 1], bc_type="natural")),
    ):
        table = Table("t", u, y, "cubic", "hold")
        s = system((Expr("table", (coordinate("wheel.c", "x"),), (table, 0)),))
        for x in (0.0, 0.4, 1.0, 1.7, 2.0):
            assert results(s, 0.0, np.array([x, 0, 0]), np.zeros(3))[0] == pytest.approx(float(expected(x)), abs=1e-14)


def test_driver_by_table_has_exact_rates():
    """u'' of a driver that follows a spline is the spline's own second derivative."""
    b = Builder("Driven")
    ground = b.Ground("ground")
    wheel = b.Body("wheel", m=1.0, I=1.0)
    b.Revolute("pin", ground, wheel.c)
    table = Table("t", U, Y, "cubic", "hold")
    b.RotationalDriver("drive", ground, wheel.c, phi=Expr("table", (2.0 * TIME,), (table, 0)))
    s, spline = build(b.scene()), CubicSpline(U, Y)
    row = s.tables.rows["drive"]
    for t in (0.1, 0.4, 0.9, 1.3):
        zero = np.zeros(3)
        assert s.Phi(t, zero)[row] == pytest.approx(-spline(2 * t), abs=1e-14)
        assert s.Phi_t(t, zero)[row] == pytest.approx(-2 * spline(2 * t, 1), abs=1e-13)
        assert s.gamma_c(t, zero, zero)[row] == pytest.approx(4 * spline(2 * t, 2), abs=1e-12)


def test_shared_subexpressions_are_computed_once():
    phi = coordinate("wheel.c", "phi")
    twice = call("sin", phi * TIME) + call("sin", phi * TIME) * expr(2.0)
    t = expression_tape.Tape({"wheel.c": 0})
    t.add(twice)
    assert [expression_tape._NAMES[op] for op, *_ in t.code].count("sin") == 1
    before = len(t.code)
    t.add(twice)
    assert len(t.code) == before
