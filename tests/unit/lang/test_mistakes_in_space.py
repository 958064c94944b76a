"""Mistakes in models in space: the message says what is wrong and what would be right, at its place."""

import pytest

import mbdsl
from mbdsl.errors import ModelError

SPACE = """spatial model M
  Ground ground;
  Body b(m = 1 kg, {body});
  {more}
end M;
"""
PLANE = """model M
  Ground ground;
  Body b(m = 1 kg, I = 1 kg.m2);
  {more}
end M;
"""
GOOD, BALL = "I = {1, 2, 2} kg.m2", "Spherical ball(ground, b.c);"
FORM = "write `I = {Ixx, Iyy, Izz}`, or the matrix with three rows of three values"


def refused(text):
    with pytest.raises(ModelError) as found:
        mbdsl.parse(text)
    problem = found.value
    line = text.splitlines()[problem.span.line - 1]
    return problem.message, problem.hint or "", line[problem.span.column - 1 :]


@pytest.mark.parametrize(
    ("body", "message", "hint", "place"),
    [
        ("I = {1, 2} kg.m2", "found an array of 2 values", FORM, "{1, 2}"),
        ("I = {1, 2, 3, 4} kg.m2", "found an array of 4 values", FORM, "{1, 2"),
        ("I = {1, 2, 2} kg", "found a mass [kg], expected a moment of inertia [kg.m2]", "", "{1"),
        ("I = {1, 2, -3} kg.m2", "the moment of inertia Izz in I is -3 kg.m2; it must be at least 0", "", "{1"),
        ("I = {{1, 0.1, 0}, {0.2, 2, 0}, {0, 0, 2}} kg.m2", "is not symmetric: I[1, 2] = 0.1", "", "{{"),
        ("I = {{1, 5, 0}, {5, 2, 0}, {0, 0, 2}} kg.m2", "has a negative principal moment", "", "{{"),
        ("I = {{1, 0, 0}, {0, 2, 0}} kg.m2", "found an array of 2 x 3 values", FORM, "{{"),
        (f"{GOOD}, com = {{1, 2, 3, 4}} m", "found an array of 4 values", "`com = {x, y, z}`", "{1, 2, 3, 4}"),
        (f"{GOOD}, com = {{1, 2, 3}} kg", "found a mass [kg], expected a length [m]", "", "{1, 2, 3} kg"),
        (f"{GOOD}, frames(tip = {{1, 2, 3, 4}} m)", "expected a position {x, y, z}", "", "{1, 2, 3, 4}"),
    ],
)
def test_bodies(body, message, hint, place):
    found = refused(SPACE.format(body=body, more=BALL))
    assert message in found[0] and hint in found[1] and found[2].startswith(place)


@pytest.mark.parametrize(
    ("more", "message", "hint", "place"),
    [
        (
            "Revolute j(ground, b.c, n = {0, 0, 0});",
            "the axis n is zero, expected a direction such as {0, 0, 1}",
            "",
            "{0, 0, 0}",
        ),
        ("Revolute j(ground, b.c, n = {0, 0, 1, 0});", "found an array of 4 values", "`n = {x, y, z}`", "{0, 0"),
        ("Revolute j(ground, b.c, n = {0, 0, 1} m);", "found a length [m], expected a pure number", "", "{0, 0"),
        ("Revolute j(ground, b.c, n = 3);", "found a single value", "a vector is written `n = {x, y, z}`", "3)"),
        ("Revolute j(ground, b.c, axis = {0, 0, 1});", "has no parameter `axis`", "write `n = {0, 0, 1}`", "axis"),
        ("Universal j(ground, b.c, n_a = {0, 0, 0});", "an axis is zero", "", "j("),
        ("Prismatic j(ground, b.c, phi0 = 3 m);", "found a length [m], expected an angle", "", "3 m"),
        ("FlexibleBeam f(length = 1 m);", "there is no FlexibleBeam in models in space", "the kinds in space", "Flex"),
    ],
)
def test_joints(more, message, hint, place):
    found = refused(SPACE.format(body=GOOD, more=more))
    assert message in found[0] and hint in found[1] and found[2].startswith(place)


@pytest.mark.parametrize(
    ("more", "message", "hint"),
    [
        (
            "Prismatic j(ground, b.c); RotationalDriver d(j, phi = time);",
            "Prismatic `j`, which does not turn",
            "use a T",
        ),
        ("Revolute j(ground, b.c); TranslationalDriver d(j, s = time);", "`j`, which does not slide", "use a Rot"),
        ("Prismatic j(ground, b.c); RotationalVelocityDriver d(j, n = {1, 0, 0}, w = 1);", "does not turn", "use a T"),
    ],
)
def test_drivers_of_motions_that_a_joint_does_not_have(more, message, hint):
    found = refused(SPACE.format(body=GOOD, more=more))
    assert message in found[0] and hint in found[1] and found[2].startswith("d(j")


@pytest.mark.parametrize(
    "joint",
    [
        "Cylindrical j(ground, b.c);",
        "PointOnLine j(ground, b.c);",
        "Planar j(ground, b.c);",
        "Screw j(ground, b.c, pitch = 1 m);",
    ],
)
def test_joints_that_turn_and_slide_take_both_drivers(joint):
    for driver in ("RotationalDriver d(j, phi = 0.1);", "TranslationalDriver d(j, s = 0.1);"):
        mbdsl.parse(SPACE.format(body=GOOD, more=joint + driver))


@pytest.mark.parametrize(
    ("more", "hint"),
    [
        ("Body k(m = 1 kg, Ixx = 1, Iyy = 2, Izz = 3);", "write `I = {1, 2, 3}`"),
        ("Body k(m = 1 kg, Ixx = 1, Iyy = 2, Izz = 3, Ixy = 4);", "write `I = {{1, 4, 0}, {4, 2, 0}, {0, 0, 3}}`"),
        ("Body k(m = 1 kg, Izz = 3);", "write `I = {..., ..., 3}`"),
        ("Cylinder k(m = 1 kg, length = 1 m, diameter = 50 mm);", "write `radius = 25 mm`"),
        ("parameter Length d = 1 m; Sphere k(m = 1 kg, diameter = d);", "write `radius = (d)/2`"),
        ("Rod k(m = 1 kg, length = 1 m, radius = 1 cm);", "use a Cylinder, which has a `radius`"),
        ("SphericalSpherical k(rodLength = 0.5);", "write `Distance k(length = 0.5 m);`"),
        ("UniversalSpherical k(rRod_ia = {3, 0, 4});", "write `Distance k(length = 5 m);`"),
    ],
)
def test_names_of_other_programs(more, hint):
    assert hint in refused(SPACE.format(body=GOOD, more=more))[1]


@pytest.mark.parametrize(
    ("initial", "message", "hint", "place"),
    [
        ("b.phi_x = 3 m;", "found a length [m], expected a pure number", "", "b.phi_x"),
        ("b.wx_local = 3 m;", "expected an angular velocity", "", "b.wx_local"),
        ("b.p0 = 1 kg;", "found a mass [kg], expected a pure number", "", "b.p0"),
        ("b.quaternion = {1, 0, 0, 0};", "has no `quaternion`", "its quaternion is p0, p1, p2, p3", "quaternion"),
        ("b.angles = {1, 2, 3};", "has no `angles`", "its Cardan angles are phi_x, phi_y, phi_z", "angles"),
        ("b.omega_y = 3;", "has no `omega_y`", "wy about the axis of the world, wy_local about its own", "omega_y"),
        ("b.alphaz = 3;", "`b.alphaz` is a result of the simulation", "", "alphaz"),
        ("b.c.az = 3;", "`b.c.az` is a result of the simulation", "", "az"),
    ],
)
def test_initial_values(initial, message, hint, place):
    found = refused(SPACE.format(body=GOOD, more=f"{BALL}\ninitial equation\n  {initial}"))
    assert message in found[0] and hint in found[1] and found[2].startswith(place)


def test_gravity_as_a_vector():
    message, hint, place = refused(SPACE.replace("ground;", "ground(g = {{0, 0, -10}});").format(body=GOOD, more=BALL))
    assert "expected a single value" in message and "`g = 10 m/s2, n = {0, 0, -1}`" in hint and place.startswith("{0")


@pytest.mark.parametrize(
    ("more", "hint"),
    [
        ("Spherical j(ground, b.c);", "for a model in space write `spatial model`"),
        ("Revolute j(ground, b.c, n = {1, 0, 0});", "for a model in space write `spatial model M`"),
        ("Frame f(b, quaternion = {1, 0, 0, 0});", "models in space begin with `spatial model`"),
        ("Body k(m = 1 kg, I = {1, 2, 2} kg.m2);", "for a model in space write `spatial model`"),
        ("Revolute j(ground, b.c);\ninitial equation\n  b.phi_x = 1;", "in space it has `phi_x`"),
        ("Revolute j(ground, b.c);\ninitial equation\n  b.c.vz = 1;", "in space it has `vz`"),
    ],
)
def test_a_planar_model_with_parts_of_space(more, hint):
    assert hint in refused(PLANE.format(more=more))[1]


@pytest.mark.parametrize(
    ("body", "doubt"),
    [
        ("I = {1, 2, 4} kg.m2", "Izz = 4 kg.m2 is larger than Ixx + Iyy = 3 kg.m2"),
        ("I = {{3, 0, 0}, {0, 2, 1}, {0, 1, 2}} kg.m2", None),
        ("I = {{3, 0, 0}, {0, 2, 1.9}, {0, 1.9, 2}} kg.m2", "a principal moment of inertia is larger than the sum"),
        ("I = {0, 2, 2} kg.m2", None),
        ("I = {0.333, 0.333, 0.667} kg.m2", None),
    ],
)
def test_moments_that_no_body_has_are_doubted(body, doubt):
    """The principal moments of {{3, 0, 0}, {0, 2, x}, {0, x, 2}} are 3, 2 - x and 2 + x: for x = 1.9, 3.9 > 3.1."""
    warnings = mbdsl.parse(SPACE.format(body=body, more=BALL)).warnings
    assert len(warnings) == (doubt is not None)
    if doubt is not None:
        assert doubt in warnings[0].message
        assert warnings[0].span.column == len("  Body b(m = 1 kg, I = ") + 1
