"""Limits of speeds and reactions that a motion exceeds, or fails to reach, by less than typical errors.

A force acts on another body while the limit is exceeded. A run finds its impulse, or says that its error is larger, or
not known, or stops with the reason. Truth: closed forms of v = -sin(t), and quadrature of a falling rod.
"""

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl
from mbdsl import IntegrationError

OSCILLATOR = """model Graze
  Ground ground(g = 0);
  Body A(m = 1 kg, I = 1 kg.m2); Body B(m = 1 kg, I = 1 kg.m2);
  Prismatic pa(ground, A.c); Prismatic pb(ground, B.c);
  TranslationalSpringDamper la(pa, k = 1 N/m);
  Table near(table = [-2, 0; 0.999999, 0; 1.000001, 2], extrapolation = "linear");
  TranslationalSpringDamper lb(pb, force = -(LAW));
initial equation
  pa.s = 1 m; pa.v = 0; pb.s = 0; pb.v = 0;
  annotation(experiment(StopTime = 6 s));
end Graze;"""
HALF = np.arccos(1 - 1e-6)  # half of the time above 0.999999
#: law with a speed v of amplitude 1, and its impulse in 6 s
LAWS = {
    "if V > 0.999999 then 1e3 else 0": 2e3 * HALF,
    "if V > 1.000001 then 1e3 else 0": 0.0,
    "1e9*max(0, V - 0.999999)": 1e9 * 2 * (np.sin(HALF) - 0.999999 * HALF),
    "1e9*max(0, V*V - 0.999998)": 1e9 * 2 * 2 * (HALF / 2 + np.sin(2 * HALF) / 4 - 0.999998 * HALF),
    "1e3*(1 + sign(V - 0.999999))": 4e3 * HALF,
    "1e3*near(V)": 1e9 * 2 * (np.sin(HALF) - 0.999999 * HALF),
}


def judged(text, signal, truth, **how):
    """Whether the run is right within what it says; a run that stops, or knows no error, says enough."""
    try:
        run = mbdsl.simulate(mbdsl.parse(text), **how)
    except IntegrationError as problem:
        return re.search("is not reached|changes back and forth|stiff", str(problem)) is not None
    largest = max(1.0, np.abs(run[signal]).max(), abs(truth))
    return abs(run[signal][-1] - truth) / largest <= min(10.0 * run.stats["error"], 3.0 * how["tol"])


METHODS = [("hht-si2", 1e-4), ("nstiff", 1e-4), ("radau5", 1e-6), ("dop853", 1e-6), ("radau9", 1e-5)]


@pytest.mark.parametrize(
    ("law", "method", "tol"), [(law, *x) for i, law in enumerate(LAWS) for x in (METHODS if i < 2 else METHODS[2:])]
)
def test_speeds(law, method, tol):
    assert judged(OSCILLATOR.replace("LAW", law.replace("V", "pa.v")), "B.vx", LAWS[law], method=method, tol=tol)


@pytest.mark.parametrize(("method", "tol"), METHODS[2:4])
def test_speeds_in_space(method, tol):
    text = OSCILLATOR.replace("model", "spatial model", 1).replace("LAW", "if pa.v > 0.999999 then 1e3 else 0")
    text = re.sub(r"  Table.*\n", "", text)
    assert judged(text, "pb.v", 2e3 * HALF, method=method, tol=tol)


ROD = """model Window
  Ground ground(g = 9.81);
  Rod rod(m = 1, length = 1);
  Body B(m = 1, I = 1);
  Revolute O(ground, rod.a);
  Frame rail(ground, r = {0, 5});
  Prismatic pb(rail, B.c);
  TranslationalSpringDamper lb(pb, force = -(if O.fy > LIMIT then 1e4 else 0));
initial equation
  rod.phi = 0; rod.w = 0; pb.s = 0; pb.v = 0;
  annotation(experiment(StopTime = 1));
end Window;"""


def time_above(limit):
    """Of the vertical reaction of a rod that falls from the horizontal: m g + m d2(sin(phi)/2)/dt2."""

    def excess(t, y):
        phi, w = y
        return 9.81 + 0.5 * (-1.5 * 9.81 * np.cos(phi) ** 2 - w * w * np.sin(phi)) - limit

    found = solve_ivp(
        lambda t, y: [y[1], -1.5 * 9.81 * np.cos(y[0])],
        (0, 1), [0.0, 0.0], "DOP853", events=excess, rtol=1e-13, atol=1e-14, max_step=1e-3,
    ).t_events[0]  # fmt: skip
    return float((found[1::2] - found[::2]).sum())


@pytest.mark.parametrize(
    ("method", "tol", "below"), [(*x, [1e-6, 1e-4, 1e-2][(i + k) % 3]) for i, x in enumerate(METHODS) for k in (0, 1)]
)
def test_reactions(method, tol, below):
    limit = 2.5 * 9.81 * (1 - below)
    assert judged(ROD.replace("LIMIT", repr(limit)), "B.vx", 1e4 * time_above(limit), method=method, tol=tol)
