"""Inputs: their names, start values, and use in sub-models and arrays."""

import math

import pytest

from mbdsl import Builder
from mbdsl.expressions import symbolic as ex
from mbdsl.lang.load import parse_text
from mbdsl.mechanism.scene import Input

ARM = (
    'model Arm input Torque u(start = 2) "drive"; Frame root; Rod rod(m = 1, length = 1); Revolute pin(root, rod.a);'
    " Torque t(pin, tau = u); end Arm; "
)


def scene(text):
    return parse_text(f"{ARM} model M Ground ground; Rod rod(m = 1, length = 1); {text} end M;")


def properties(found):
    return {x.name: (x.start, x.unit) for x in found.inputs.values()}


@pytest.mark.parametrize(
    ("declaration", "expected"),
    [
        ("input Torque u;", {"u": (0.0, "N.m")}),
        ("input Torque u(start = 2 N.m);", {"u": (2.0, "N.m")}),
        ("input Torque u(start = 3 + 1);", {"u": (4.0, "N.m")}),
        ("input Real u;", {"u": (0.0, "")}),
        ("input Real u(start = 3 kN);", {"u": (3000.0, "N")}),
        ('input Real u(unit = "rpm", start = 60);', {"u": (2 * math.pi, "rad/s")}),
        ("input Force u[2];", {"u[1]": (0.0, "N"), "u[2]": (0.0, "N")}),
        ("input Force u[2](start = 3);", {"u[1]": (3.0, "N"), "u[2]": (3.0, "N")}),
        ("input Force u[:](start = {1, 2});", {"u[1]": (1.0, "N"), "u[2]": (2.0, "N")}),
        ("input Real u[1,2];", {"u[1,1]": (0.0, ""), "u[1,2]": (0.0, "")}),
        ("input Force u, w;", {"u": (0.0, "N"), "w": (0.0, "N")}),
        ("parameter Force f = 3 N; input Force u(start = 2*f);", {"u": (6.0, "N")}),
        ("input Force u = 3 N/s*time;", {}),
        ("Arm arm(ground);", {"arm.u": (2.0, "N.m")}),
        ("Arm arm(ground, u(start = 5));", {"arm.u": (5.0, "N.m")}),
        ("Arm arm(ground, u = 3*time);", {}),
        ("input Torque v; Arm arm(ground, u = 2*v);", {"v": (0.0, "N.m")}),
        ("Arm arm[2](each root = ground, u(start = {3, 4}));", {"arm[1].u": (3.0, "N.m"), "arm[2].u": (4.0, "N.m")}),
    ],
)
def test_declarations(declaration, expected):
    assert properties(scene(declaration)) == expected


def test_what_is_known_of_an_input():
    u = scene('input Torque u(start = 1 N.m) "by the controller";').inputs["u"]
    assert isinstance(u, Input) and u.doc == "by the controller" and u.span.line == 1


def test_uses():
    found = scene(
        "input Torque u; input Force f[2]; input AngularVelocity w; Revolute pin(ground, rod.a);"
        "Torque t(pin, tau = 2*u);"
        "Force push(rod.b, fx = f[1], fy = f[2]*sin(rod.phi)); RotationalVelocityDriver d(pin, w = w);"
        "Real twice = 2*u; Arm arm(ground, u = u); SpringDamper s(ground, rod.b, force = f[1] + 2 N/m*s);"
    )
    u, parts = ex.input_signal("u"), found.components
    assert parts["t"].values["tau"] is 2 * u is found.variables["twice"]
    assert parts["push"].values["fx"] is ex.input_signal("f[1]")
    assert ex.input_signal("w") in ex.leaves(*parts["d"].velocity_constraints)
    assert parts["arm.t"].values["tau"] is u
    assert found.signal("u") is u and list(found.inputs) == ["u", "f[1]", "f[2]", "w"]


def test_builder():
    b = Builder("M")
    ground = b.Ground("ground")
    rod = b.Rod("rod", m=1.0, length=1.0)
    pin = b.Revolute("pin", ground, rod.a, mu=0.1, radius="5 mm")
    u = b.input("u", start=2.0, unit="N.m", doc="motor")
    b.Torque("t", pin, tau=u)
    b.Torque("s", pin, tau="0.5*u - 1 mm*pin.fx")
    b.VelocityConstraint("c", gamma=ex.coordinate("rod.c", "w") - ex.input_signal("u"))
    found = b.scene()
    assert found.inputs == {"u": Input("u", 2.0, "N.m", "motor")}
    assert found.components["t"].values["tau"] is ex.input_signal("u")
    assert found.components["c"].velocity_constraints == (ex.coordinate("rod.c", "w") - ex.input_signal("u"),)
    assert str(pin.friction) == "pin.friction" and found.components["pin"].friction is not None
