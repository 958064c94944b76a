"""Remedies for what people write from habit: the text that they name is read, and means what was meant."""

import math
import re

import pytest

from mbdsl import parse
from mbdsl.errors import MbdslError

PLANE = """model M
  parameter Angle beta = 60 deg;
  Ground ground;
  Rod rod(m = 1 kg, length = 2 m);
  Revolute pin(ground, rod.a);
{}
end M;
"""
SPACE = """spatial model M
  Ground ground;
  Body rod(m = 1 kg, I = {{1, 2, 3}} kg.m2, frames(a = {{0, 0, 0}} m, b = {{1, 0, 0}} m));
  Revolute pin(ground, rod.a, n = {{0, 0, 1}});
{}
end M;
"""


def error(text):
    with pytest.raises(MbdslError) as problem:
        parse(text)
    return problem.value


@pytest.mark.parametrize(
    ("array", "remedy", "point"),
    [
        ("{0.5*cos(beta), 0} m", "{0.5 m * cos(beta), 0}", (0.25, 0.0)),
        ("{0.5*cos(beta)*2, sin(beta)} m", None, (0.5, math.sqrt(0.75))),
        ("{3 + 2*beta, 1} cm", None, (0.03 + 0.02 * math.pi / 3, 0.01)),
        ("{rod.length, 0.5} m", "{rod.length, 0.5 m}", (2.0, 0.5)),
        ("{cos(beta)/2, 0} mm", None, (0.00025, 0.0)),
    ],
)
def test_an_array_of_expressions_with_a_unit(array, remedy, point):
    """The unit moves to the elements; expected positions by hand."""
    problem = error(PLANE.format(f"  Frame tip(rod, r = {array});"))
    (written,) = re.findall(r"write `(.*)`", problem.hint)
    assert remedy is None or written == remedy
    tip = parse(PLANE.format(f"  Frame tip(rod, r = {written});")).frames["tip"]
    assert (tip.x, tip.y) == pytest.approx(point, rel=1e-15)


def test_a_matrix_with_a_unit_and_another_dimension():
    problem = error(PLANE.format("  parameter Length x[2, 2] = {{beta, 1}, {0, 2}} m;"))
    (written,) = re.findall(r"write `(.*)`", problem.hint)
    value = parse(PLANE.format(f"  parameter Length x[2, 2] = {written};")).parameters["x"].value
    assert value[0][0] == pytest.approx(math.pi / 3) and value[1] == (0.0, 2.0)
    assert "its own unit" in error(PLANE.format("  Frame tip(rod, r = {3 kg, 0} m);")).hint


@pytest.mark.parametrize("name", ["Ball", "BallJoint", "SphericalJoint"])
def test_ball_joints(name):
    declaration = f"  {name} j(ground, rod.b);"
    for text, right in ((SPACE, "Spherical"), (PLANE, "Revolute")):
        (written,) = re.findall(r"write `(.*)`", error(text.format(declaration)).hint)
        assert parse(text.format("  " + written)).components["j"].kind.name == right


@pytest.mark.parametrize(
    ("name", "own"), [("roll", "phi_x"), ("pitch", "phi_y"), ("yaw", "phi_z"), ("heading", "phi_z"), ("bank", "phi_x")]
)
def test_names_of_angles(name, own):
    assert f"`{own}`" in error(SPACE.format(f"  Real u = rod.{name};")).hint.replace(own, f"`{own}`")
    assert own in error(SPACE.format(f"initial equation\n  rod.{name} = 3 deg;")).hint


@pytest.mark.parametrize(
    ("declaration", "values"),
    [
        ("Torque t(rod.a, tau = {3, 0, 0} N.m);", {"tau": 3.0, "n": (1.0, 0.0, 0.0)}),
        ("Torque t(rod.a, torque = {0, 2, 0} N.m);", {"tau": 2.0, "n": (0.0, 1.0, 0.0)}),
        ("Force t(rod.a, f = {1, 0, 4} N);", {"fx": 1.0, "fy": 0.0, "fz": 4.0}),
        ("Force t(rod.a, fx = {1, 2, 3} N);", {"fx": 1.0, "fy": 2.0, "fz": 3.0}),
        ("Force t(rod.a, F = {1, 0, 0});", {"fx": 1.0, "fy": 0.0, "fz": 0.0}),
    ],
)
def test_vectors_of_forces_become_components(declaration, values):
    (written,) = re.findall(r"`(.*)`", error(SPACE.format(f"  {declaration}")).hint)
    found = parse(SPACE.format(f"  {declaration.split('(')[0]}(rod.a, {written});")).components["t"].values
    for name, x in values.items():
        assert getattr(found[name], "value", found[name]) == x


def test_vectors_of_forces_in_the_plane():
    assert "`fx = 1 N, fy = 2 N`" in error(PLANE.format("  Force t(rod.b, force = {1, 2} N);")).hint
    assert "`tau = 3 N.m`" in error(PLANE.format("  Torque t(pin, tau = {0, 0, 3} N.m);")).hint


@pytest.mark.parametrize(
    ("frames", "remedy"),
    [
        ("a = {0, 0, 1} m, n = {0, 1, 0}", "a(r = {0, 0, 1} m, n = {0, 1, 0}, phi = ...)"),
        ("a = {0, 0, 1} m, n = {0, 1, 0}, phi = 90 deg", "a(r = {0, 0, 1} m, n = {0, 1, 0}, phi = 90 deg)"),
        ("a = {0, 0, 1} m, angles = {0, 0, 1}", "a(r = {0, 0, 1} m, angles = {0, 0, 1})"),
        ("r = {0, 0, 1} m, phi = 1 rad", "tip(r = {0, 0, 1} m, phi = 1 rad)"),
    ],
)
def test_parameters_of_a_frame_beside_it(frames, remedy):
    problem = error(SPACE.format(f"  Body x(m = 1 kg, I = 1 kg.m2, frames({frames}));"))
    assert "belongs to one" in problem.message and problem.hint == f"write `frames({remedy})`"
    if "..." not in remedy:
        parse(SPACE.format(f"  Body x(m = 1 kg, I = 1 kg.m2, frames({remedy}));"))


def test_an_angle_of_a_frame_in_the_plane():
    problem = error(PLANE.format("  Body x(m = 1 kg, I = 1 kg.m2, frames(a = {1, 2} m, phi = 90 deg));"))
    (written,) = re.findall(r"write `(.*)`", problem.hint)
    found = parse(PLANE.format(f"  Body x(m = 1 kg, I = 1 kg.m2, {written});")).frames["x.a"]
    assert (found.x, found.y, found.phi) == pytest.approx((1.0, 2.0, math.pi / 2))


@pytest.mark.parametrize("frames", ["n = {0, 1, 0}", "a = {0, 0, 0} m, n = {0, 1, 0} m", "n = {1, 0, 0} m"])
def test_frames_may_have_these_names(frames):
    assert "x.n" in parse(SPACE.format(f"  Body x(m = 1 kg, I = 1 kg.m2, frames({frames}));")).frames


def test_an_input_is_set_by_its_start():
    text = PLANE.format("  input Torque u;\n  Torque t(pin, tau = u);")
    with pytest.raises(MbdslError) as problem:
        parse(text, overrides={"u": 3.0})
    (written,) = re.findall(r"`(u.*)`", problem.value.hint)
    name, _, value = written.partition("=")
    assert parse(text, overrides={name: value}).inputs["u"].start == 3.0


def test_an_input_with_a_value_takes_another_one_and_no_start():
    text = PLANE.format("  input Torque u = 2 N.m;\n  Torque t(pin, tau = u);")
    assert parse(text, overrides={"u": "3 N.m"}).components["t"].values["tau"].value == 3.0
    with pytest.raises(MbdslError, match="has a value and takes no start"):
        parse(text, overrides={"u.start": 3.0})
