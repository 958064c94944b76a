"""Contact of a circle with a closed profile, against distances from many points of the profile and forces by hand."""

import pickle

import numpy as np
import pytest

import mbdsl
from mbdsl.mechanism import graph
from mbdsl.system import build

K = 1000.0
AT = np.array([0.1, -0.2])
TEXT = """model M
  Ground ground(g = 0, frames(p = {0.1, -0.2, 30 deg}));
  Body a(m = 1 kg, I = 1 kg.m2);
  %s
end M;"""
TURN = np.exp(1j * np.pi / 6)


def given(points, more="", kind="ProfileContact"):
    listed = ", ".join(f"{{{x}, {y}}}" for x, y in points)
    return f"{kind} c(ground.p, a.c, points = {{{listed}}} m, k = {K} N/m{more});"


def system(text):
    scene = mbdsl.parse(TEXT % text)
    return build(scene, graph.build(scene))


def load(s, place, velocity=(0.0, 0.0, 0.0)):
    """Force (complex, in the axes of the profile) and torque on the body at a place there."""
    at = AT[0] + 1j * AT[1] + TURN * place
    fx, fy, tau = s.Q(0.0, np.array([at.real, at.imag, 0.0]), np.array(velocity, float))
    return (fx + 1j * fy) / TURN, tau


def arc(p, q, radius, n=400):
    """Points of the arc from p to q to the right of its chord, or to the left for a negative radius."""
    half = 0.5 * (q - p)
    centre = 0.5 * (p + q) + 1j * half / abs(half) * np.sign(radius) * np.sqrt(radius**2 - abs(half) ** 2)
    angle = np.angle((q - centre) / (p - centre))
    return centre + (p - centre) * np.exp(1j * angle * np.linspace(0.0, 1.0, n))


def outline(points, arcs=()):
    """Many points of a profile."""
    z, found = np.array([complex(*p) for p in points]), []
    for i, p in enumerate(z):
        q, radius = z[(i + 1) % len(z)], arcs[i] if arcs else 0.0
        found.append(arc(p, q, radius) if radius else p + (q - p) * np.linspace(0.0, 1.0, 400))
    return np.concatenate(found)


def on(z, place):
    """The nearest point on the polygon through many points, and its side."""
    side = np.roll(z, -1) - z
    along = np.clip(((place - z) * side.conjugate()).real / np.maximum(np.abs(side) ** 2, 1e-30), 0.0, 1.0)
    k = np.abs(z + along * side - place).argmin()
    return z[k] + along[k] * side[k], k


L_SHAPE = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]
CAN = [(-1.0, -0.4), (1.0, -0.4), (1.0, 0.4), (-1.0, 0.4)]  # with a round, a hollow and two straight sides
ARCS = (0.0, 0.5, 3.0, -0.6)
SHAPES = {"polygon": (L_SHAPE, ()), "clockwise": (L_SHAPE[::-1], ()), "arcs": (CAN, ARCS)}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("hole", [False, True])
def test_force_towards_the_nearest_point(shape, hole):
    """The force is k times the overlap, in the direction from the nearest of many points of the profile."""
    points, arcs = SHAPES[shape]
    z, rng, radius, touched = outline(points, arcs), np.random.default_rng(3), 0.15, 0
    listed = f", arcs = {{{', '.join(map(str, arcs))}}} m" if arcs else ""
    scene = mbdsl.parse(TEXT % given(points, f"{listed}, radius = {radius} m, hole = {str(hole).lower()}"))
    s = build(scene, graph.build(scene))
    for place in z[rng.integers(0, len(z), 80)] + rng.normal(0.0, 0.08, (80, 2)) @ (1, 1j):
        nearest, k = on(z, place)
        o = place - nearest
        winding = np.angle((np.roll(z, -1) - place) / (z - place)).sum()
        within = (abs(winding) > 3.0) != hole
        distance = -abs(o) if within else abs(o)
        others = np.abs(z - place)[np.abs(z - z[k]) > 0.3]
        corners = [1.0 + 1.0j] if points is not CAN else []
        hollow = [x for x in (complex(*p) for p in points) if (x in corners) != hole]
        if (
            any(abs(place - x) < 0.35 for x in hollow)
            or abs(o) < 1e-3
            or (others.size and others.min() < radius + 0.02)
        ):
            continue  # it may touch at a second point
        force, torque = load(s, place)
        expected = K * max(0.0, radius - distance) * o / abs(o) * (-1.0 if within else 1.0)
        assert abs(force - expected) < 1.2, (place, force, expected)
        assert abs(torque) < 1e-9
        touched += abs(expected) > 0.0
    assert touched > 12


def test_two_arcs_are_a_circle():
    """The same force, friction and torque as of CircleContact."""
    more = ", {} = 0.2 m, mu = 0.3, mu_s = 0.4, v_s = 0.1 m/s, exponent = 1.5, e = 0.5, v_0 = 1 m/s"
    profile = system(given([(-0.7, 0.0), (0.7, 0.0)], ", arcs = {0.7, 0.7} m" + more.format("radius")))
    circle = system(f"CircleContact c(ground.p, a.c, k = {K} N/m, r_a = 0.7 m{more.format('r_b')});")
    for angle in np.linspace(0.1, 6.1, 7):
        place, velocity = 0.88 * np.exp(1j * angle), (0.2, -0.1, 0.7)
        (f, tau), (g, torque) = load(profile, place, velocity), load(circle, place, velocity)
        assert abs(f - g) < 1e-9 and tau == pytest.approx(torque, abs=1e-9) and abs(tau) > 0.01


def test_a_smooth_profile_through_points_of_a_circle_is_the_circle():
    """An eccentric cam: a disc of 0.5 m about a point 0.1 m off its axis, with the lift of a roller known."""
    z = 0.1 + 0.5 * np.exp(2j * np.pi * np.arange(9) / 9)
    s = system(given([(x.real, x.imag) for x in z], ", smooth = true, radius = 0.2 m"))
    for angle in np.linspace(0.0, 6.0, 25):
        n = np.exp(1j * angle)
        assert abs(load(s, 0.1 + 0.69 * n)[0] - 10.0 * n) < 1e-9
        assert load(s, 0.1 + 0.7001 * n)[0] == 0.0


def test_a_smooth_profile_through_points_of_an_ellipse():
    """The normal at the angle u of x = a cos u, y = b sin u is (cos u/a, sin u/b)."""
    t = 2 * np.pi * np.arange(40) / 40
    s = system(given(np.stack([np.cos(t), 0.6 * np.sin(t)], 1).tolist(), ", smooth = true, radius = 0.1 m"))
    for u in np.linspace(0.0, 6.0, 31):
        n = np.cos(u) + 1j * np.sin(u) / 0.6
        n /= abs(n)
        force = load(s, np.cos(u) + 0.6j * np.sin(u) + 0.09 * n)[0]
        assert abs(force - 10.0 * n) < 0.2  # 0.2 mm, and the direction


def test_a_square_on_a_point():
    """A point in a square is pushed through the nearest side, and in a hole back from both sides of a corner."""
    square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    s = system(given(square, ", mu = 0.5"))
    turned = -2.0 * np.array([TURN.imag, TURN.real, 0.0])  # along -y of the world's axes
    assert abs(load(s, 0.98 + 0.3j)[0] - 20.0) < 1e-9
    force, _ = load(s, 0.98 + 0.3j, (0.0, 0.0, 0.0) + turned)
    assert force.real == pytest.approx(20.0) and abs(force.imag) == pytest.approx(10.0)
    s = system(given(square, ", radius = 0.2 m, hole = true"))
    assert abs(load(s, 0.81 - 0.83j)[0] - (-10.0 + 30.0j)) < 1e-9
    slot = [(-1.0, -0.1), (1.0, -0.1), (1.0, 0.1), (-1.0, 0.1)]
    s = system(given(slot, ", radius = 0.11 m, hole = true"))
    assert abs(load(s, 0.2 + 0.002j)[0] + 4.0j) < 1e-9  # 12 N and 8 N
    assert abs(load(s, 0.2)[0]) < 1e-9


def test_no_jump_around_a_convex_corner_and_at_joints():
    """Around all of it, at a constant distance from the surface, the force has the same size, and turns steadily."""
    points = [(-1.0, -0.4), (1.0, -0.4), (1.0, 0.4), (-1.0, 0.4)]
    s = system(given(points, ", arcs = {0, 0.4, 0, 0} m, radius = 0.1 m"))
    for corner, start, end in ((-1.0 - 0.4j, -np.pi, -np.pi / 2), (1.0 + 0.0j, -np.pi / 2, np.pi / 2)):
        r = 0.0 if corner.real < 0 else 0.4
        for angle in np.linspace(start, end, 12):
            n = np.exp(1j * angle)
            assert abs(load(s, corner + (r + 0.095) * n)[0] - 5.0 * n) < 1e-9
        for n in (np.exp(1j * start), np.exp(1j * end)):
            for side in (-1e-10, 1e-10):
                assert abs(load(s, corner + (r + 0.095) * n + 1j * n * side)[0] - 5.0 * n) < 1e-6


@pytest.mark.parametrize("place", [0.95 - 0.47j, 1.05 + 0.45j, 0.3 + 0.33j, -1.02 - 0.4j, -0.85 + 0.1j])
def test_derivatives(place):
    more = f", arcs = {{{', '.join(map(str, ARCS))}}} m, radius = 0.15 m, e = 0.5, v_0 = 1 m/s, exponent = 1.5"
    s = system(given(CAN, f"{more}, mu = 0.4, v_s = 0.3 m/s"))
    at = AT[0] + 1j * AT[1] + TURN * place
    q, v, lam = np.array([at.real, at.imag, 0.4]), np.array([0.1, -0.3, 0.5]), np.zeros(0)
    assert np.abs(s.Q(0.0, q, v)).max() > 1.0
    for found, f in (
        (s.stiffness(0.0, q, v, lam), lambda d: s.Q(0.0, q + d, v)),
        (s.damping(0.0, q, v, lam), lambda d: s.Q(0.0, q, v + d)),
    ):
        expected = [(f(-d) - f(d)) / 2e-6 for d in 1e-6 * np.eye(3)]
        np.testing.assert_allclose(np.asarray(found), np.transpose(expected), rtol=1e-6, atol=1e-4)


def test_energy_without_damping():
    """A disc in a triangular hole, with elastic walls and without friction."""
    text = """model Box
      Ground ground(g = 0);
      Body a(m = 1 kg, I = 1 kg.m2);
      ProfileContact c(ground, a.c, points = {{-1, -1}, {1, -1}, {0, 1}} m, hole = true, radius = 0.2 m, k = 5e3 N/m);
    initial equation
      a.x = 0 m; a.y = 0 m; a.phi = 0; a.vx = 1 m/s; a.vy = 0.4 m/s; a.w = 1 rad/s;
      annotation(experiment(StopTime = 3 s, Tolerance = 1e-6));
    end Box;"""
    run = mbdsl.simulate(mbdsl.parse(text))
    assert (run["c.gap"] < 0.0).any() and np.ptp(run["a.x"]) > 0.5
    np.testing.assert_allclose(run["energy.total"], 0.5 * 1.16 + 0.5, rtol=1e-4)


def test_a_model_without_contact():
    """No force, and no speed of touch is kept."""
    scene = mbdsl.parse(TEXT % given(L_SHAPE, ", e = 0.5, mu = 0.5"))
    absent = scene.changed({}, ("contact",))
    assert absent.without == {"contact": ("c",)} and scene.changed({}, ("friction",)).without == {"friction": ("c",)}
    assert scene.events and not absent.events
    s = build(absent, graph.build(absent))
    assert load(s, 0.5 + 0.1j, (1.0, 1.0, 1.0)) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("points", "more", "message"),
    [
        (L_SHAPE[:2], "", "at least three"),
        ([(0, 0), (1, 0), (1, 0), (0, 1)], "", "point 3 is the same as point 2"),
        ([(0, 0), (1, 0), (0, 1)], ", arcs = {0, 0.1, 0} m", "radius 2 is 0.1 m, less than half"),
        ([(0, 0), (1, 0), (0, 1)], ", arcs = {0, 0.1} m", "2 radii, expected 3"),
        ([(0, 0), (1, 0), (0, 1)], ", smooth = true, arcs = {0, 1, 0} m", "leave `arcs` out"),
        ([(0, 0), (1, 0), (2, 0)], "", "encloses nothing"),
        ([(i, i * i) for i in range(101)], "", "at most 100"),
    ],
)
def test_wrong_values(points, more, message):
    with pytest.raises(mbdsl.ModelError, match=message):
        mbdsl.parse(TEXT % given(points, more))


def test_points_of_another_shape():
    with pytest.raises(mbdsl.ModelError, match="expected an array of n x 2 values"):
        mbdsl.parse(TEXT % f"ProfileContact c(ground.p, a.c, points = {{1, 2, 3}} m, k = {K} N/m);")


def test_a_scene_is_pickled():
    scene = mbdsl.parse(TEXT % given(L_SHAPE))
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert pickle.loads(pickle.dumps(scene)).components["c"].kind is scene.components["c"].kind


def test_models_in_space_have_none():
    with pytest.raises(mbdsl.ModelError, match="no ProfileContact in models in space"):
        mbdsl.parse(TEXT.replace("model M", "spatial model M", 1).replace("I = 1", "I = {1, 1, 1}") % given(L_SHAPE))
