"""Contacts at points with friction: forces on bodies in a state, by hand."""

import numpy as np
import pytest

import mbdsl
from mbdsl.mechanism import graph
from mbdsl.system import build

K, MU = 1000.0, 0.3  #: stiffness [N/m], friction
GIVEN = f"k = {K} N/m, mu = {MU}"
SPACE = """spatial model M
  Ground ground(g = 0, frames(p = {0.1, -0.2, 0.3} m));
  Body a(m = 1 kg, I = {1, 1, 1} kg.m2);
  %s
end M;"""
PLANE = """model M
  Ground ground(g = 0, frames(p = {0.1, -0.2} m));
  Body a(m = 1 kg, I = 1 kg.m2);
  %s
end M;"""
AT = np.array([0.1, -0.2, 0.3])


def loads(text, place, velocity):
    """Force and torque on the body at a place, without rotation."""
    scene = mbdsl.parse(text)
    s = build(scene, graph.build(scene))
    q, v = np.zeros(s.n), np.array(velocity, float)
    q[: len(place)] = place
    return s.Q(0.0, q, v)


def test_a_ball_on_a_plane_in_space():
    """The point of the ball that touches has the velocity v + w x (-r n); friction is against it, at this point."""
    radius, depth = 0.5, 0.02
    v, w, n = np.array([0.4, -0.3, 0.0]), np.array([0.2, 0.7, -0.5]), np.array([0.0, 0.0, 1.0])
    given = f"PointContact c(ground.p, a.c, radius = {radius} m, {GIVEN});"
    found = loads(SPACE % given, AT + (radius - depth) * n, [*v, *w])
    slip = v + np.cross(w, -radius * n)
    force = K * depth * (n - MU * slip / np.linalg.norm(slip))
    np.testing.assert_allclose(found, [*force, *np.cross(-radius * n, force)], atol=1e-9)


def test_a_circle_on_a_line_is_the_ball_of_space():
    """The plane z = 0 of a model in space, with the normal y."""
    contact = f"PointContact c(ground.p, a.c, radius = 0.5 m, {GIVEN}, mu_s = 0.5, v_s = 0.2 m/s%s);"
    flat = loads(PLANE % (contact % ""), [0.7, 0.27], [0.05, -0.2, 0.4])
    solid = loads(SPACE % (contact % ", n = {0, 1, 0}"), [0.7, 0.27, 0.0], [0.05, -0.2, 0.0, 0.0, 0.0, 0.4])
    # the speed of sliding in space has 1e-6 v_s in it
    np.testing.assert_allclose(flat, solid[[0, 1, 5]], rtol=1e-9)


@pytest.mark.parametrize("space", [False, True])
def test_a_box_acts_at_its_corners(space):
    """A level box has one half of its corners in the plane; the wrench is that of equal forces there, which turn."""
    edges, w, depth = (0.4, 0.6, 0.8), 0.5, 0.01
    if space:
        given = f"BoxContact c(ground.p, a.c, length = 0.4 m, width = 0.6 m, height = 0.8 m, {GIVEN});"
        found = loads(SPACE % given, AT + (0.0, 0.0, 0.4 - depth), [0, 0, 0, 0, 0, w])
        expected = [0, 0, 4 * K * depth, 0, 0, -4 * MU * K * depth * np.hypot(*edges[:2]) / 2]
    else:
        given = f"BoxContact c(ground.p, a.c, length = 0.4 m, width = 0.6 m, {GIVEN});"
        found = loads(PLANE % given, AT[:2] + (0.0, 0.3 - depth), [0.3, 0, 0])
        force = 2 * K * depth
        expected = [-MU * force, force, -MU * force * 0.3]
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_a_capsule_acts_at_both_ends():
    given = f"LineContact c(ground.p, a.c, length = 1 m, radius = 0.1 m, axis = {{0, 1, 0}}, {GIVEN});"
    # it turns about z: the friction of the ends is along x, opposite
    found = loads(SPACE % given, AT + (0.0, 0.0, 0.09), [0, 0, 0, 0, 0, 2])
    np.testing.assert_allclose(found, [0, 0, 20, 0, 0, -MU * 20 * 0.5], atol=1e-9)


@pytest.mark.parametrize(("axis", "height", "points"), [("{0, 0, 1}", 0.5, 3), ("{1, 0, 0}", 0.2, 2)])
def test_a_cylinder_stands_on_three_points_and_lies_on_two(axis, height, points):
    given = f"CylinderContact c(ground.p, a.c, length = 1 m, radius = 0.2 m, axis = {axis}, {GIVEN});"
    found = loads(SPACE % given, AT + (0.0, 0.0, height - 0.01), [0, 0, 0, 0, 0, 2])
    force, arm = points * K * 0.01, 0.2 if points == 3 else 0.5  # of friction against drilling
    # a lying cylinder has a lowest point that is 1e-5 off: it is at cos(1e-5) of the radius
    np.testing.assert_allclose(found, [0, 0, force, 0, 0, -MU * force * arm], atol=2e-3)
    np.testing.assert_allclose(found[[2, 5]], [force, -MU * force * arm], rtol=1e-4)


def outwards(shape, c):
    """The vector from the nearest point of a solid, of a capsule from that of its axis, to a point c, and the distance
    of the surface: a box of edges 0.4, 0.6, 0.8, a cylinder or a capsule of the length 1 along x, radius 0.3."""
    if shape == "Box":
        h = np.array([0.2, 0.3, 0.4])
        o = c - np.clip(c, -h, h)
        return o, np.linalg.norm(o)
    axis, across = np.array([np.clip(c[0], -0.5, 0.5), 0.0, 0.0]), np.linalg.norm(c[1:])
    if shape == "Capsule":
        return c - axis, np.linalg.norm(c - axis) - 0.3
    o = c - axis - np.array([0.0, *c[1:]]) * min(1.0, 0.3 / across)
    return o, np.linalg.norm(o)


SHAPES = {
    "Box": "length = 0.4 m, width = 0.6 m, height = 0.8 m",
    "Cylinder": "length = 1 m, R = 0.3 m",
    "Capsule": "length = 1 m, R = 0.3 m",
}


@pytest.mark.parametrize("shape", SHAPES)
def test_a_ball_on_a_solid(shape):
    """The force is k times the overlap along the line to the nearest point: near faces, edges and corners."""
    radius, rng, touched = 0.25, np.random.default_rng(2), 0
    scene = mbdsl.parse(
        SPACE % f"Sphere{shape}Contact c(ground.p, a.c, radius = 0.25 m, {SHAPES[shape]}, k = {K} N/m);"
    )
    s = build(scene, graph.build(scene))
    for c in rng.uniform(-0.8, 0.8, (60, 3)):
        o, distance = outwards(shape, c)
        if np.linalg.norm(o) > 1e-9:
            q, v = np.zeros((2, s.n))
            q[:3] = AT + c
            expected = K * max(0.0, radius - distance) * o / np.linalg.norm(o)
            np.testing.assert_allclose(s.Q(0.0, q, v), [*expected, 0, 0, 0], atol=1e-9)
            touched += distance < radius
    assert touched > 8


def test_a_ball_inside_of_a_box_is_pushed_through_the_nearest_face():
    given = f"SphereBoxContact c(ground.p, a.c, radius = 0.1 m, {SHAPES['Box']}, k = {K} N/m);"
    found = loads(SPACE % given, AT + (0.1, -0.25, 0.0), np.zeros(6))
    np.testing.assert_allclose(found, [0, -K * (0.1 + 0.05), 0, 0, 0, 0], atol=1e-9)


def test_a_crate_has_loads_in_proportion_on_its_corners():
    """Equal springs at the corners (x, y): N = m g/4 (1 + x X/a^2 + y Y/b^2), with the centre of mass at (X, Y)."""
    text = """spatial model Crate
      Ground ground(n = {0, 0, -1});
      Body box(m = 20 kg, I = {1, 1, 1} kg.m2, com = {0.05, 0.06, 0} m, frames(middle = {0, 0, 0}));
      BoxContact c(ground, box.middle, length = 0.4 m, width = 0.6 m, height = 0.8 m, k = 1e6 N/m, mu = 0.3);
    initial equation
      guess box.x = 0 m; guess box.y = 0 m; guess box.z = 0.4 m;
    end Crate;"""
    still = mbdsl.static(mbdsl.parse(text))
    weight = 20.0 * 9.81
    expected = [weight / 4 * (1 + x * 0.05 / 0.2 + y * 0.06 / 0.3) for x in (-1, 1) for y in (-1, 1)]
    # the upper corners are the even ones; it leans by 1e-4
    assert [still[f"c.force_{i}"] for i in (1, 3, 5, 7)] == pytest.approx(expected, rel=1e-3)
    assert still["c.force"] == pytest.approx(weight, rel=1e-9)
    assert still["c.active"] == 4.0


def test_hertz():
    """d = (m g/k)^(2/3)."""
    text = """model Hertz
      Ground ground;
      PointMass ball(m = 3 kg);
      PointContact c(ground, ball, k = 1e6 N/m, exponent = 1.5);
    initial equation
      guess ball.x = 0 m; guess ball.y = -1 mm;
    end Hertz;"""
    still = mbdsl.static(mbdsl.parse(text))
    assert -still["c.gap"] == pytest.approx((3.0 * 9.81 / 1e6) ** (2.0 / 3.0), rel=1e-8)


def test_a_model_without_contact():
    scene = mbdsl.parse(PLANE % f"PointContact c(ground.p, a.c, e = 0.5, {GIVEN});")
    absent = scene.changed({}, ("contact",))
    assert absent.without == {"contact": ("c",)}
    assert not absent.events and scene.events  # no speed of touch is kept
    s = build(absent, graph.build(absent))
    assert not s.Q(0.0, np.array([0.0, -1.0, 0.0]), np.array([1.0, -1.0, 1.0])).any()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("PointContact c(ground.p, a.c, k = 1 N/m, e = 0.01)", "between 0.05 and 1"),
        ("PointContact c(ground.p, a.c, k = 1 N/m, exponent = 0.5)", "at least 1"),
        ("PointContact c(ground.p, a.c, k = 1 N/m, mu = 0.5, mu_s = 0.2)", "mu_s is 0.2, less than mu"),
        ("PointContact c(ground.p, a.c, k = 1 N/m, n = {0, 0, 0})", "axis n is zero"),
        ("LineContact c(ground.p, a.c, k = 1 N/m, length = 1 m, axis = {0, 0, 0})", "`axis` is zero"),
        (
            "SphereCapsuleContact c(ground.p, a.c, k = 1 N/m, radius = 1 m, length = 1 m, R = 1 m, axis = {0, 0, 0})",
            "zero",
        ),
    ],
)
def test_wrong_values(given, message):
    with pytest.raises(mbdsl.ModelError, match=message):
        mbdsl.parse(SPACE % f"{given};")
