"""Pulses that act through friction only: their force has no component along the motion.

Truth from momentum: a slide loses mu J/m of its speed, a hinge mu r J/I of its rate, where J is the integral of the
magnitude of the transverse force. No load acts before and after the pulse, so that the derivative of friction by the
reaction is zero where the pulse begins. With v >> v_s, the friction does not depend on the speed.
"""

from math import pi, sqrt

import pytest

import mbdsl
from mbdsl.integrators import compiled, declared

BELL = f"{2 / (1e-4 * sqrt(pi))!r} N*exp(-((time - 3.3337 s)/0.1 ms)^2)"  # J = 2 N.s
BOX = "(if time > 3.3337 s and time < 3.3339 s then 1e4 N else 0 N)"
TWO = "(if time > 1.5 s and time < 1.501 s then 1e3 N else if time > 6 s and time < 6.001 s then -1e3 N else 0 N)"
PULSES = {"bell": BELL, "box": BOX, "two": TWO}
MECHANISMS = {
    "slide": (
        "model M\n Ground ground(g = 0);\n Body A(m = 1 kg, I = 1 kg.m2);\n"
        " Prismatic j(ground, A.c, mu = 0.5, v_s = 1e-3 m/s);\n Force push(A.c, fy = PULSE);\n"
        "initial equation\n j.v = 10 m/s;\nend M;",
        "j.v",
        9.0,
    ),
    "hinge": (
        "model M\n Ground ground(g = 0);\n Body A(m = 1 kg, I = 2 kg.m2);\n"
        " Revolute j(ground, A.c, mu = 0.2, radius = 0.5 m, w_s = 1e-3 rad/s);\n Force push(A.c, fx = PULSE);\n"
        "initial equation\n j.w = 10 rad/s;\nend M;",
        "j.w",
        9.9,
    ),
    "slide in space": (
        "spatial model M\n Ground ground(g = 0);\n Body A(m = 1 kg, I = 1 kg.m2);\n"
        " Prismatic j(ground, A.c, n = {0, 0, 1}, mu = 0.5, v_s = 1e-3 m/s);\n Force push(A.c, fx = PULSE);\n"
        "initial equation\n j.v = 10 m/s;\nend M;",
        "j.v",
        9.0,
    ),
}
PLANE, ALL = ["slide", "hinge"], list(MECHANISMS)


def mechanisms(method):
    """Reactions of index-3 methods have the rounding error of positions over h^2, and friction in space, where
    attitudes are rounded, follows it."""
    return PLANE if declared(method).index == 3 else ALL


#: every method with two mechanisms and pulses, in turn
CASES = [
    (method, mechanisms(method)[(k + i) % len(mechanisms(method))], list(PULSES)[(k + 2 * i) % 3])
    for k, method in enumerate(compiled())
    for i in (0, 1)
]


@pytest.mark.parametrize(("method", "mechanism", "pulse"), CASES)
def test_momentum_lost(method, mechanism, pulse):
    text, signal, truth = MECHANISMS[mechanism]
    scene = mbdsl.parse(text.replace("PULSE", PULSES[pulse]))
    run = mbdsl.simulate(scene, method=method, tol=1e-5, stop=10.0)
    error = abs(run[signal][-1] - truth) / 10.0
    assert error <= min(3e-5, 10.0 * run.stats["error"])
