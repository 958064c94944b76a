"""Names and notations of Modelica that are accepted mean the same as those of the language."""

import math
import re

import pytest

from mbdsl import parse
from mbdsl.errors import MbdslError, ModelError
from mbdsl.lang.parser import parse_expression
from mbdsl.lang.unparse import write

MODEL = """model M
  parameter Length L = 1 m;
  Ground world;
  Rod rod(m = 2 kg, length = L);
  Body disc(m = 1 kg, I = 0.1 kg.m2);
  Revolute pin(world, rod.a);
  {}
end M;
"""


def scene(text):
    return parse(MODEL.format(text))


@pytest.mark.parametrize(
    ("modelica", "here"),
    [
        ("Revolute j(rod.frame_b, disc.frame_a);", "Revolute j(rod.b, disc.c);"),
        ("Revolute j(world.frame_b, disc.c);", "Revolute j(world, disc.c);"),
        ("PointMass q(m = 1); Distance d(pin.b, q.frame_a, length = L);", None),
        ("Torque t(pin.a, pin.b, tau = 2 N.m);", "Torque t(pin.frame_a, pin.frame_b, tau = 2 N.m);"),
        ("Modelica.Mechanics.MultiBody.Joints.Revolute j(rod.b, disc.c);", "Revolute j(rod.b, disc.c);"),
        ("MB.Joints.Prismatic j(rod.b, disc.c);", "Prismatic j(rod.b, disc.c);"),
        ("Modelica.Mechanics.MultiBody.Parts.Body b(m = 1, I = 1);", "Body b(m = 1, I = 1);"),
        ("PlanarMechanics.Parts.Body b(m = 1, I = 1);", "Body b(m = 1, I = 1);"),
        ("Modelica.Mechanics.MultiBody.Interfaces.Frame_b f = rod.b;", "Frame f = rod.b;"),
        ("Prismatic j(rod.b, disc.c, n = {1, 0, 0});", "Prismatic j(rod.b, disc.c);"),
        ("Revolute j(rod.b, disc.c, n = {0, 0, 1});", "Revolute j(rod.b, disc.c);"),
        (
            'Revolute j(rod.b, disc.c, phi(start = 0.5, displayUnit = "deg"));',
            "Revolute j(rod.b, disc.c, phi(start = 0.5));",
        ),
        ("Torque t(pin, tau = 2 N.m*Modelica.Math.sin(2*time));", "Torque t(pin, tau = 2 N.m*sin(2*time));"),
        ("Torque t(pin, tau = smooth(1, 2*pin.w));", "Torque t(pin, tau = 2*pin.w);"),
        ("parameter Angle a = Modelica.Units.Conversions.from_deg(30);", "parameter Angle a = 30 deg;"),
        ("parameter Angle a = Modelica.SIunits.Conversions.from_deg(30);", "parameter Angle a = 30 deg;"),
        ("parameter AngularVelocity a = from_rpm(30);", "parameter AngularVelocity a = 30 rpm;"),
        ("parameter Velocity a = from_kmh(36);", "parameter Velocity a = 36 km/h;"),
        ("parameter Angle a = 2*Modelica.Constants.pi;", "parameter Angle a = 2*pi;"),
        ("extends Modelica.Icons.Example;", ""),
        (
            "parameter Mass m = 1\u00a0kg; parameter Mass k = 2\u202f\u2009kg;",
            "parameter Mass m = 1 kg; parameter Mass k = 2 kg;",
        ),
        ('equation assert(L > 0, "L is positive"); connect(world, pin.frame_a);', ""),
    ],
)
def test_accepted(modelica, here):
    here = here if here is not None else modelica.replace("pin.b", "pin.frame_b").replace("q.frame_a", "q")
    assert scene(modelica) == scene(here)


def test_numbers():
    found = scene(
        "parameter Real g = Modelica.Constants.g_n; parameter Real d = to_deg(0.5*pi); parameter Real r = to_rpm(1 Hz);"
        "parameter Real k = to_kmh(10 m/s); parameter Real a = 180*Modelica.Constants.D2R/Modelica.Constants.R2D;"
    ).parameters
    assert found["g"].value == 9.80665  # CODATA's g_n
    assert found["g"].unit == "m/s2"
    values = {name: found[name].value for name in "drka"}
    assert values == pytest.approx({"d": 90.0, "r": 60.0 / (2.0 * math.pi), "k": 36.0, "a": math.pi**2 / 180.0})


@pytest.mark.parametrize(
    "text", ["Modelica.Math.sin(2 * time)", "noEvent(smooth(0, 2 N))", "(2 kg.m2 * from_deg(30)) + 0.1 kg"]
)
def test_text_of_expressions(text):
    e = parse_expression(text)
    assert write(e) == text
    assert parse_expression(write(e)) == e


def test_own_names_have_priority():
    """A frame, port or model of the user is not replaced by a name of Modelica."""
    found = parse(
        "model World parameter Real k = 3; Ground g; Rod r(m = 1 kg, length = 1 m, frames(frame_a = {0.1 m, 0})); "
        "Revolute p(g, r.frame_a); end World;"
    )
    assert found.components["p"].ports["frame_b"] == "r.frame_a"
    assert found.frames["r.frame_a"].x == 0.1


def test_a_body_with_its_centre_of_mass_elsewhere_has_no_frame_a():
    with pytest.raises(ModelError, match="Body `b` has no `frame_a`"):
        scene("Body b(m = 1, I = 1, com = {0.1, 0}); Revolute j(rod.b, b.frame_a);")


def test_translations_keep_the_pose():
    """The remedy for a FixedTranslation between a joint and a body puts the joint at the same place of the body."""
    found = scene("Frame bar(disc.frame_a, r = -{1, 0}); Revolute j(rod.b, bar);")
    assert (found.frames["bar"].body, found.frames["bar"].x, found.frames["bar"].y) == ("disc", -1.0, 0.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('equation assert(L > 2, "too short");', "the assertion `L > 2` is false: too short"),
        ('equation assert(L, "no condition");', "found a length"),
        ("equation assert(L > 0);", "takes a condition and a text"),
        ('assert(L > 0, "no length");', "an assertion belongs to the equation section"),
    ],
)
def test_assertions(text, message):
    with pytest.raises(MbdslError, match=re.escape(message)):
        scene(text)
