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
