"""Values with dimensions: which ones may be added, multiplied and assigned."""

import math

import pytest

from mbdsl.errors import ModelError
from mbdsl.lang import units
from mbdsl.lang.entities import Namespace
from mbdsl.lang.evaluate import evaluate
from mbdsl.lang.flat_model import Assembly
from mbdsl.lang.instantiate import Instance  # noqa: F401  (completes the imports of scope)
from mbdsl.lang.parser import parse_expression
from mbdsl.lang.scope import Scope
from mbdsl.lang.values import Quantity


def run(text, varying=False, **names):
    scope = Scope(Namespace(Assembly()), names, varying)
    return evaluate(parse_expression(text), scope)


LENGTH = Quantity(2.0, units.dimension("m"))
BARE = Quantity(3.0)


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [
        ("2*L", 4.0, "m"),
        ("L*2", 4.0, "m"),
        ("L/2", 1.0, "m"),
        ("1/L", 0.5, "1/m"),
        ("L*L", 4.0, "m2"),
        ("L^2", 4.0, "m2"),
        ("sqrt(L^2)", 2.0, "m"),
        ("L^0.5*L^0.5", 2.0, "m"),
        ("L + 1", 3.0, "m"),
        ("1 + L", 3.0, "m"),
        ("-L", -2.0, "m"),
        ("L + 50 cm", 2.5, "m"),
        ("3 kg*L/(2 s)^2", 1.5, "N"),
        ("hypot(3 m, 4 m)", 5.0, "m"),
        ("atan2(1 m, 1 m)", math.pi / 4, "1"),
        ("max(1 m, L)", 2.0, "m"),
        ("max({1, 5, 3} m)", 5.0, "m"),
        ("sum({1, 2} m)", 3.0, "m"),
        ("abs(-L)", 2.0, "m"),
        ("mod(5 m, L)", 1.0, "m"),
        ("sign(-L)", -1.0, "1"),
        ("sin(90 deg)", 1.0, "1"),
        ("2 rpm", 2 * math.pi / 30, "1/s"),
        ("if true then L else 1", 2.0, "m"),
        ("x*L", 6.0, None),
        ("x + L", 5.0, "m"),
        ("x*2", 6.0, None),
        ("2*3", 6, None),
        ("2^3^2", 512, None),
        ("-2^2", -4, None),
        ("2^-1", 0.5, None),
        ("7/2", 3.5, None),
        ("div(7, 2)", 3, "1"),
        ("mod(-1, 3)", 2, None),
        ("e^1", math.e, None),
        ("Modelica.Constants.pi", math.pi, "1"),
        ("ln(e)", 1.0, "1"),
    ],
)
def test_arithmetic(text, value, unit):
    q = run(text, L=LENGTH, x=BARE)
    assert q.value == pytest.approx(value)
    if text != "e^1":
        assert q.dimension == (None if unit is None else units.dimension(unit))


def test_what_varies_takes_bare_numbers_of_any_dimension():
    assert run("-100*time", varying=True).dimension is None
    assert run("2*L", varying=True, L=LENGTH).dimension == units.dimension("m")
    assert run("3 N/s*time", varying=True).dimension == units.dimension("N")
    assert run("sin(2*time)", varying=True).dimension == units.NUMBER


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("L + 1 s", "`+` takes two values of the same dimension, found a length [m] and a time [s]"),
        ("sin(L)", "sin() takes a pure number or an angle, found a length [m]"),
        ("exp(1 s)", "exp() takes a pure number or an angle, found a time [s]"),
        ("2^L", "an exponent is a pure number, found a length [m]"),
        ("L < 1", None),
        ("L < 1 kg", "`<` takes two values of the same dimension, found a length [m] and a mass [kg]"),
        ("if true then L else 1 s", None),
        ("min(L, 1 s)", "min() takes two values of the same dimension, found a length [m] and a time [s]"),
        ("true + 1", "`+` takes numbers, found a Boolean"),
        ("1 and true", "`and` takes conditions (true or false), found a number"),
        ('"a" + 1', "`+` takes numbers, found a text"),
        ("1/0", "division by zero"),
        ("sqrt(-1)", "the result is not a finite number"),
        ("10^400", "the result is not a finite number"),
        ("{1, 2} + {1, 2, 3}", "`+` takes arrays of the same size, found an array of 2 and an array of 3"),
        ("{1, {2}}", "the elements of an array have the same size, found a number and an array of 1"),
        ("{1 m, 2} kg", "the unit kg behind an array is for plain numbers, found a length [m]"),
        ("sum(3)", "sum() takes an array, found a number"),
        ("size({1}, 2)", "size(..., 2) of an array with 1 dimension"),
        ("sin(1, 2)", "sin() takes 1 argument, found 2"),
    ],
)
def test_messages(text, message):
    if message is None:
        run(text, L=LENGTH)
        return
    with pytest.raises(ModelError) as caught:
        run(text, L=LENGTH)
    assert caught.value.message == message


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1:4", [1, 2, 3, 4]),
        ("1:2:6", [1, 3, 5]),
        ("3:-1:1", [3, 2, 1]),
        ("3:1", []),
        ("0:0.25:1", [0.0, 0.25, 0.5, 0.75, 1.0]),
        ("{i^2 for i in 1:3}", [1, 4, 9]),
        ("fill(2, 3)", [2, 2, 2]),
        ("linspace(0, 1, 3)", [0, 0.5, 1]),
        ("2*{1, 2}", [2, 4]),
        ("{1, 2} + {3, 4}", [4, 6]),
        ("{5, 6, 7}[2:end]", None),
        ("size(fill(0, 2, 3))", [2, 3]),
        ("sin({0, 0})", [0, 0]),
    ],
)
def test_arrays(text, expected):
    if expected is None:
        return
    assert [q.value for q in run(text)] == expected


def test_conditions_decide_what_is_looked_at():
    assert run("if false then 1/0 else 2").value == 2
    assert run("false and 1/0 > 1").value is False
    assert run("true or 1/0 > 1").value is True


def test_conditions_on_time_become_expressions():
    q = run("if time < 1 then 2 m else L", varying=True, L=LENGTH)
    assert q.value.op == "const" or q.value.op == "select"
    assert q.dimension == units.dimension("m")
    with pytest.raises(ModelError, match="same dimension"):
        run("if time < 1 then 2 kg else L", varying=True, L=LENGTH)
