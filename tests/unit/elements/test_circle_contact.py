"""Contact of circles and of balls, outside of each other and one in a hole of the other, against forces by hand.

A contact with another factor of its overlap is still the gradient of its energy and has exact derivatives: only numbers
show it.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

import mbdsl
from mbdsl.mechanism import graph
from mbdsl.system import build

K, E, V_0 = 400.0, 0.6, 2.5  #: stiffness [N/m], restitution, speed of this impact [m/s]
#: D (1 + e) = ln((1 + D)/(1 - e D)) below its pole 1/e, apart from the root 0 (Hunt and Crossley 1975)
D = brentq(lambda d: d * (1 + E) - np.log((1 + d) / (1 - E * d)), 0.1, 1 / E - 1e-9, xtol=1e-15)
CASES = {
    #      r_a, r_b, hole, distance, its rate, expected overlap [m]
    "pressed together": (0.7, 0.4, False, 1.04, -0.8, 0.06),
    "moving apart": (0.7, 0.4, False, 1.04, 0.5, 0.06),
    "apart": (0.7, 0.4, False, 1.15, -9.0, -0.05),
    "pulled apart quickly": (0.7, 0.4, False, 1.04, 50.0, 0.06),
    "against the wall of the hole": (0.7, 0.4, True, 0.32, 0.9, 0.02),
    "leaving the wall": (0.7, 0.4, True, 0.32, -0.3, 0.02),
    "free in the hole": (0.7, 0.4, True, 0.25, 9.0, -0.05),
}
PLANE = """model M
  Ground ground(g = 0, frames(p = {0.1, -0.2} m));
  Body a(m = 1 kg, I = 1 kg.m2);
  CircleContact c(ground.p, a.c, %s);
end M;"""
SPACE = PLANE.replace("model M", "spatial model M").replace("{0.1, -0.2} m", "{0.1, -0.2, 0.3} m")
SPACE = SPACE.replace("I = 1 kg.m2", "I = {1, 1, 1} kg.m2")


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(
    ("text", "center", "line"), [(PLANE, (0.1, -0.2), (0.6, -0.8)), (SPACE, (0.1, -0.2, 0.3), (2 / 7, -3 / 7, 6 / 7))]
)
def test_forces_on_a_body(text, center, line, case):
    r_a, r_b, hole, distance, rate, depth = CASES[case]
    center, line = np.array(center), np.array(line)
    given = f"r_a = {r_a} m, r_b = {r_b} m, k = {K} N/m, e = {E}, v_0 = {V_0} m/s, internal = {str(hole).lower()}"
    scene = mbdsl.parse(text % given)
    s = build(scene, graph.build(scene))
    outwards = -1.0 if hole else 1.0  # a wall pushes back towards the middle
    force = outwards * K * max(0.0, depth) * max(0.0, 1.0 - D / V_0 * outwards * rate)
    q, v, expected = np.zeros((3, s.n))
    q[: len(line)], v[: len(line)], expected[: len(line)] = center + distance * line, rate * line, force * line
    # the overlap is a difference of lengths of size 1, with 1e-16 of them, times a stiffness of 400 N/m
    np.testing.assert_allclose(s.Q(0.0, q, v), expected, rtol=0, atol=1e-12)


MU = 0.3


@pytest.mark.parametrize("hole", [False, True])
@pytest.mark.parametrize(("text", "dimensions"), [(PLANE, 2), (SPACE, 3)])
def test_friction_against_the_sliding_of_the_surfaces(text, dimensions, hole):
    """At the point that touches, friction is against the velocity of the body's surface there."""
    r_a, r_b, depth = 0.7, 0.4, 0.02
    center, line = ((0.1, -0.2), (0.6, -0.8)) if dimensions == 2 else ((0.1, -0.2, 0.3), (2 / 7, -3 / 7, 6 / 7))
    center, line = np.array(center), np.array(line)
    n = -line if hole else line  # towards which the body is pushed
    distance = r_a - r_b + depth if hole else r_a + r_b - depth
    given = f"r_a = {r_a} m, r_b = {r_b} m, k = {K} N/m, internal = {str(hole).lower()}, mu = {MU}"
    scene = mbdsl.parse(text % given)
    s = build(scene, graph.build(scene))
    q, v = np.zeros((2, s.n))
    q[:dimensions] = center + distance * line
    along = np.array([0.8, 0.6]) if dimensions == 2 else np.array([3.0, 2.0, 0.0]) / np.sqrt(13.0)
    spin = np.array([0.0, 0.0, 5.0]) if dimensions == 2 else np.array([0.3, -0.4, 0.9])
    v[:dimensions], v[dimensions:] = 0.5 * along, spin[-1:] if dimensions == 2 else spin
    at = np.append(-r_b * n, 0.0)[:3]  # the point that touches, from the centre of the body
    slip = np.append(0.5 * along, 0.0)[:3] + np.cross(spin, at)
    force = K * depth * np.append(n, 0.0)[:3]
    force = force - MU * K * depth * slip / np.linalg.norm(slip)
    torque = np.cross(at, force)
    expected = [*force[:dimensions], *(torque[2:] if dimensions == 2 else torque)]
    np.testing.assert_allclose(s.Q(0.0, q, v), expected, rtol=1e-9, atol=1e-9)
    absent = scene.changed({}, ("friction",))
    np.testing.assert_allclose(
        build(absent, graph.build(absent)).Q(0.0, q, v)[:dimensions], K * depth * n, rtol=1e-12, atol=1e-12
    )


def test_derivatives_with_friction_in_the_plane():
    """Against differences with the step 1e-6, of sizes up to 1e3 N; in space see test_derivatives_in_space.py."""
    given = "r_a = 0.7 m, r_b = 0.4 m, k = 400 N/m, e = 0.6, v_0 = 2 m/s, exponent = 1.5, mu = 0.3, mu_s = 0.5"
    scene = mbdsl.parse(PLANE % f"{given}, v_s = 0.4 m/s")
    s = build(scene, graph.build(scene))
    q, v, lam = np.array([0.7, -1.0, 0.3]), np.array([-0.3, 0.2, 0.9]), np.zeros(0)
    for found, f in (
        (s.stiffness(0.0, q, v, lam), lambda d: s.Q(0.0, q + d, v)),
        (s.damping(0.0, q, v, lam), lambda d: s.Q(0.0, q, v + d)),
    ):
        expected = [(f(-d) - f(d)) / 2e-6 for d in 1e-6 * np.eye(3)]
        np.testing.assert_allclose(np.asarray(found), np.transpose(expected), rtol=1e-6, atol=1e-5)


def test_friction_of_circles_turns_a_driven_wheel():
    """A wheel that slides on a turning drum has the torque mu N r until both surfaces have the same speed."""
    text = """model Wheels
      Ground ground(g = 0, frames(shaft = {0.3 m, 0}));
      Body drum(m = 1 kg, I = 0.5 kg.m2), wheel(m = 1 kg, I = 0.02 kg.m2);
      Revolute A(ground, drum.c), B(ground.shaft, wheel.c);
      CircleContact touch(drum.c, wheel.c, r_a = 0.2 m, r_b = 0.101 m, k = 1e4 N/m, mu = 0.2, v_s = 1e-5 m/s);
      RotationalVelocityDriver motor(A, w = 3 rad/s);
    initial equation
      A.phi = 0; B.phi = 0; B.w = 0 rad/s;
      annotation(experiment(StopTime = 1 s, Tolerance = 1e-7));
    end Wheels;"""
    run = mbdsl.simulate(mbdsl.parse(text))
    # the point that touches has the arm 0.101 m on the wheel and 0.199 m on the drum
    rate = -0.2 * 10.0 * 0.101 / 0.02
    sliding = run.t < 0.5
    np.testing.assert_allclose(run["B.w"][sliding], rate * run.t[sliding], atol=1e-4)
    assert run["B.w"][-1] == pytest.approx(-3.0 * 0.199 / 0.101, abs=1e-3)
