"""Units: factors, dimensions, and where a unit ends."""

import math

import pytest

from mbdsl.errors import ModelError
from mbdsl.lang import quantities, units
from mbdsl.lang.lexer import tokenize
from mbdsl.lang.load import parse_text
from mbdsl.lang.source import Source

HALF = units.Fraction(1, 2)


@pytest.mark.parametrize(
    ("text", "factor", "dimension"),
    [
        ("kg", 1.0, (1, 0, 0, 0, 0, 0, 0)),
        ("g", 1e-3, (1, 0, 0, 0, 0, 0, 0)),
        ("mm", 1e-3, (0, 1, 0, 0, 0, 0, 0)),
        ("m2", 1.0, (0, 2, 0, 0, 0, 0, 0)),
        ("m^2", 1.0, (0, 2, 0, 0, 0, 0, 0)),
        ("m^-1", 1.0, (0, -1, 0, 0, 0, 0, 0)),
        ("m^(-1)", 1.0, (0, -1, 0, 0, 0, 0, 0)),
        ("mm4", 1e-12, (0, 4, 0, 0, 0, 0, 0)),
        ("N", 1.0, (1, 1, -2, 0, 0, 0, 0)),
        ("N.m/rad", 1.0, (1, 2, -2, 0, 0, 0, 0)),
        ("kN/mm", 1e6, (1, 0, -2, 0, 0, 0, 0)),
        ("N.s/m", 1.0, (1, 0, -1, 0, 0, 0, 0)),
        ("m3/(s.Pa^0.5)", 1.0, (-HALF, 7 * HALF, 0, 0, 0, 0, 0)),
        ("N/mm^1.5", 10.0**4.5, (1, -HALF, -2, 0, 0, 0, 0)),
        ("m^(-1/2)", 1.0, (0, -HALF, 0, 0, 0, 0, 0)),
        ("kg.m2", 1.0, (1, 2, 0, 0, 0, 0, 0)),
        ("kg/(m.s)", 1.0, (1, -1, -1, 0, 0, 0, 0)),
        ("m/s2", 1.0, (0, 1, -2, 0, 0, 0, 0)),
        ("1/s", 1.0, (0, 0, -1, 0, 0, 0, 0)),
        ("GPa", 1e9, (1, -1, -2, 0, 0, 0, 0)),
        ("deg", math.pi / 180, units.NUMBER),
        ("rev", 2 * math.pi, units.NUMBER),
        ("rpm", math.pi / 30, (0, 0, -1, 0, 0, 0, 0)),
        ("deg/s", math.pi / 180, (0, 0, -1, 0, 0, 0, 0)),
        ("ms", 1e-3, (0, 0, 1, 0, 0, 0, 0)),
        ("min", 60.0, (0, 0, 1, 0, 0, 0, 0)),
        ("in", 0.0254, (0, 1, 0, 0, 0, 0, 0)),
        ("lbf/in", 4.4482216152605 / 0.0254, (1, 0, -2, 0, 0, 0, 0)),
        ("1", 1.0, units.NUMBER),
    ],
)
def test_units(text, factor, dimension):
    unit = units.parse(text)
    assert unit is not None
    assert unit.factor == pytest.approx(factor, rel=1e-15)
    assert unit.dimension == dimension


@pytest.mark.parametrize(
    "text",
    ["kilo", "m1", "m22", "L", "N..m", "N m", "m/", "/s", "m_a", "then", "N.", "kk", "m^1.55", "m^n", "m^2)", "m^(2"],
)
def test_no_units(text):
    assert units.parse(text) is None


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("3 kg", "3 kg"),
        ("3kg", "3kg"),
        ("2 m/L2", "2 m"),
        ("2 m/s*x", "2 m/s"),
        ("2 m/s2", "2 m/s2"),
        ("0.033 N.m * sin(x)", "0.033 N.m"),
        ("1 N / m", "1 N"),
        ("3 then", "3"),
        ("2 m^n", "2 m"),
        ("2 m/(s + 1)", "2 m"),
        ("1e3 m", "1e3 m"),
        ("1 else", "1"),
        ("2 \n m", "2"),
        ("9.81 m/s^2)", "9.81 m/s^2"),
        ("1 m^(-2))", "1 m^(-2)"),
        ("2 m^2)/(1 m)", "2 m^2"),
        ("3 kg.m^2)", "3 kg.m^2"),
        ("2 m^(2 - n)", "2 m"),
        ("2 N/m^1.5*x", "2 N/m^1.5"),
        ("2 m^(1/2)*x", "2 m^(1/2)"),
    ],
)
def test_where_a_unit_ends(text, first):
    opening = "(" * (text.count(")") - text.count("("))
    found = tokenize(Source("t", opening + text))
    assert next(t.text for t in found if t.type == "NUMBER") == first


@pytest.mark.parametrize(
    ("text", "value"),
    [("(9.81 m/s^2)", 9.81), ("2*(1 kg.m^2)", 2.0), ("(2 m^2)/(1 m)", 2.0), ("(3 m^(-2))*(2 m^2)", 6.0)],
)
def test_a_unit_leaves_the_bracket_that_it_did_not_open(text, value):
    scene = parse_text(f"model M parameter Real x = {text}; Ground g; end M;")
    assert scene.parameters["x"].value == value


def test_unit_of_an_array():
    assert [t.text for t in tokenize(Source("t", "{1, 2} m"))][-2] == "m"
    assert [t.type for t in tokenize(Source("t", "x[2] m"))][-2] == "NAME"
    assert [t.type for t in tokenize(Source("t", "[1, 2; 3, 4] m"))][-2] == "UNIT"


def test_every_type_has_a_unit_and_words():
    for name, unit in quantities.TYPES.items():
        assert units.parse(unit) is not None, name
        assert quantities.type_unit(f"SI.{name}") == quantities.type_unit(f"Modelica.Units.SI.{name}") == unit
    assert quantities.words(units.dimension("kg")) == "a mass [kg]"
    assert quantities.words(units.dimension("N/m")) == "a stiffness [N/m]"
    assert quantities.words(units.NUMBER) == "a pure number"


@pytest.mark.parametrize("text", ["kg.m3/s", "1/(m.s)", "kg2/A", "m^(1/2)"])
def test_dimensions_as_text(text):
    base = {"m^(1/2)": units.power(units.dimension("m"), units.Fraction(1, 2))}.get(text) or units.dimension(
        text.replace("1/(m.s)", "m^-1.s^-1")
    )
    assert quantities.unit_text(base) == text


@pytest.mark.parametrize(
    ("word", "unit"),
    [("Nm", "N.m"), ("kNm", "kN.m"), ("Nms", "N.m.s"), ("kgm2", "kg.m2"), ("degrees", "deg"), ("Degree", "deg")]
    + [("Kg", "kg"), ("KN", "kN"), ("hz", "Hz"), ("metres", "m"), ("parsec", None), ("x", None), ("a1", None)],
)
def test_units_that_were_meant(word, unit):
    assert units.parse(word) is None
    assert units.meant(word) == unit


def test_an_angle_of_a_rate_without_unit():
    """The motion of a driver as Modelica users write it: the message has the remedy, which is right as it is."""
    model = "model M Ground ground; Rod r(m = 1, length = 1); RotationalDriver d(ground, r.a, phi = {}); end M;"
    with pytest.raises(ModelError) as problem:
        parse_text(model.format("pi/2 - 2*pi*time"))
    assert "`2*pi*(1 rad/s)*time`" in str(problem.value)
    parse_text(model.format("pi/2 - 2*pi*(1 rad/s)*time"))
