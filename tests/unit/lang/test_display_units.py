"""Units in which values are displayed: exact factors, quantities that share a dimension, `displayUnit`, errors."""

from fractions import Fraction

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import ModelError, UsageError
from mbdsl.lang import units
from mbdsl.lang.display_units import asked, kind, si
from mbdsl.messages import DisplayUnit

#: exact definitions: NIST Special Publication 811 (2008), appendix B: yard and pound of 1959, standard gravity
FOOT, POUND, GRAVITY = Fraction("0.3048"), Fraction("0.45359237"), Fraction("9.80665")
POUND_FORCE, INCH = POUND * GRAVITY, FOOT / 12
EXACT = {
    "in": INCH,
    "ft": FOOT,
    "yd": 3 * FOOT,
    "mi": 5280 * FOOT,
    "lb": POUND,
    "oz": POUND / 16,
    "lbf": POUND_FORCE,
    "slug": POUND_FORCE / FOOT,
    "psi": POUND_FORCE / INCH**2,
    "lbf.in": POUND_FORCE * INCH,
    "lbf.ft": POUND_FORCE * FOOT,
    "lbf/in": POUND_FORCE / INCH,
    "hp": 550 * FOOT * POUND_FORCE,
    "mph": 5280 * FOOT / 3600,
    "kgf": GRAVITY,
    "kN": Fraction(1000),
    "N.mm": Fraction(1, 1000),
    "km/h": Fraction(1000, 3600),
}

MODEL = """model M
  parameter Length a(displayUnit = "mm") = 0.08;
  parameter Real n(unit = "rpm") = 30;
  Ground ground;
  Rod rod(m = 2 kg, length = 0.5 m);
  Revolute pin(ground, rod.a, phi(start = 0.5, displayUnit = "deg"));
  Real F(unit = "N", displayUnit = "kN") = 2000 N*sin(time/(1 s));
  Real x(displayUnit = "deg") = pin.phi + 1;
  Real s[2](unit = "mm") = {rod.b.x, a};
end M;
"""


@pytest.mark.parametrize("text", EXACT)
def test_factors_are_those_of_the_definitions(text):
    assert units.parse(text).factor == pytest.approx(float(EXACT[text]), rel=1e-15)


def test_angles_are_parts_of_a_turn():
    for text, per_turn in (("deg", 360.0), ("rev", 1.0), ("rad", 2.0 * np.pi)):
        assert 2.0 * np.pi / units.parse(text).factor == pytest.approx(per_turn, rel=1e-15)
    assert units.parse("rpm").factor == pytest.approx(2.0 * np.pi / 60.0, rel=1e-15)


@pytest.mark.parametrize(
    ("alike", "other"),
    [
        (("rad", "deg", "rev", "mrad"), ("", "rad2", "1/rad")),
        (("rad/s", "deg/s", "rpm"), ("Hz", "1/s", "1/min", "rad/s2")),
        (("Hz", "1/s", "1/min", "kHz"), ("rpm",)),
        (("N.m", "N.mm", "lbf.ft", "kgf.m"), ("J", "kW.h", "N.m/rad")),
        (("J", "kJ", "kW.h", "W.s"), ("N.m",)),
        (("N.m/rad", "N.mm/deg", "lbf.in/rad"), ("N.m", "N.m.s/rad", "J")),
        (("kg/(m.s)", "Pa.s"), ("kg.m/s",)),
    ],
)
def test_quantities_of_one_dimension_are_distinguished(alike, other):
    assert len({kind(text) for text in alike}) == 1
    assert not {kind(text) for text in other} & {kind(alike[0])}


@pytest.mark.parametrize(
    ("text", "own"),
    [("deg", "rad"), ("rpm", "rad/s"), ("N.mm/deg", "N.m/rad"), ("kW.h", "J"), ("1/min", "Hz"), ("mm3/s", "m3/s")],
)
def test_the_si_unit_of_a_quantity(text, own):
    assert (si(text), kind(si(text))) == (own, kind(text))


def test_a_unit_is_that_of_all_values_of_its_quantity():
    display = asked("deg, rpm,kN, N.mm, kJ")
    assert display.of("rad", "any.phi") == DisplayUnit("deg", np.pi / 180.0)
    assert display.of("N.m").symbol == "N.mm" and display.of("J").symbol == "kJ"
    assert display.of("kN").factor == 1.0 and display.of("m") == DisplayUnit("m", 1.0)
    assert asked(["deg", "rpm"]) == asked("deg, rpm")


@pytest.mark.parametrize(
    ("given", "message", "hint"),
    [
        ("deg, degg", "unknown unit `degg`", "units are, with prefixes such as k and m: m, g, s"),
        ("Nm", "unknown unit `Nm`", "did you mean `N.m`?"),
        ("deg, rev", "deg and rev are both units of angles", "one unit for each quantity"),
        ("lbf.ft, N.m", "lbf.ft and N.m are both units of torques", "one unit for each quantity"),
        ("kJ, J", "kJ and J are both units of energies", "one unit for each quantity"),
        ("1", "`1` is not a unit: it is a pure number", "deg, rpm"),
        ([1.0], "found 1.0, expected a text", "units="),
    ],
)
def test_errors_say_what_exists(given, message, hint):
    with pytest.raises(UsageError) as found:
        asked(given)
    assert message in found.value.message and hint in found.value.hint


def test_a_model_declares_units():
    display = mbdsl.parse(MODEL).display
    shown = {name: display.of(unit, name).symbol for name, unit in
             (("a", "m"), ("n", "rad/s"), ("pin.phi", "rad"), ("F", "N"), ("x", "rad"), ("s[1]", "m"), ("s[2]", "m"),
              ("s[:]", "m"), ("rod.phi", "rad"), ("rod.x", "m"))}  # fmt: skip
    assert shown == {"a": "mm", "n": "rpm", "pin.phi": "deg", "F": "kN", "x": "deg", "s[1]": "mm", "s[2]": "mm",
                     "s[:]": "mm", "rod.phi": "rad", "rod.x": "m"}  # fmt: skip
    assert asked("rev", display).of("rad", "pin.phi").symbol == "rev"  # what is asked for comes first
    scene = mbdsl.parse(MODEL)
    assert scene == mbdsl.parse(MODEL.replace('displayUnit = "deg"', 'displayUnit = "rev"'))
    assert scene.parameters["a"].value == 0.08 and scene.descriptions["x"].unit == "rad"


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ('"mm") = 0.08', '"kN") = 0.08', 2, "`displayUnit` of `a` is a force [kN], expected a unit of a length [m]"),
        ('start = 0.5, displayUnit = "deg"', 'start = 0.5, displayUnit = "m"', 6, "of `pin.phi` is a length [m]"),
        ('displayUnit = "kN"', 'displayUnit = "kNN"', 7, 'unknown unit "kNN"'),
        ('displayUnit = "kN"', "displayUnit = 3", 7, "`displayUnit` is a text, found"),
    ],
)
def test_a_wrong_display_unit_is_an_error_at_its_place(old, new, line, message):
    with pytest.raises(ModelError) as found:
        mbdsl.parse(MODEL.replace(old, new, 1))
    assert message in found.value.message and found.value.span.line == line and found.value.span.column > 10


def test_the_builder_declares_them_as_a_text_does():
    b = mbdsl.Builder("M")
    ground = b.Ground("g")
    rod = b.Rod("rod", m=1.0, length="1 m")
    b.Revolute("pin", ground, rod.a)
    b.parameter("a", "80 mm", display_unit="mm")
    b.input("u", unit="N", display_unit="kN")
    b.variable("x", "pin.phi", display_unit="deg")
    display = b.scene().display
    assert [display.of(u, n).symbol for n, u in (("a", "m"), ("u", "N"), ("x", "rad"))] == ["mm", "kN", "deg"]
    b.input("v", unit="N", display_unit="mm")
    with pytest.raises(ModelError, match="expected a unit of a force"):
        b.scene()
