"""Claims with one degree of freedom: a block of 1 kg on a rail, and the law that pushes it."""

from __future__ import annotations

import re
from math import pi, sqrt

import numpy as np
from claim import Claim
from scipy.special import erf

TEXT = """model {name}
  Ground ground(g = 0);
  Body b(m = 1.0, I = 1);
  Prismatic rail(ground, b.c);{extra}
  TranslationalSpringDamper law(rail, force = -({push}));
initial equation
  rail.s = {s!r};
  rail.v = {v!r};
  annotation(experiment(StopTime = {stop!r}));
end {name};
"""
CLAIMS: dict[str, Claim] = {}


def pose(z, t):
    return {"b": (z[0], 0.0, 0.0)}


def law(name, family, push, rate=None, *, s=0.0, v=0.0, stop, extra="", **more):
    """``push`` is the force in the language, ``rate(t, s, v, on)`` or ``exact(t)`` the motion, by hand."""
    if family not in ("pulses", "windows"):
        push = re.sub(r"(?<![\w.])(time|s|v)\b(?! [<>])", r"(1*\1)", push)  # as pure numbers
    text = TEXT.format(name=name, push=push, s=float(s), v=float(v), stop=float(stop), extra=extra)
    rates = None if rate is None else lambda t, z, zd, on: rate(t, z[0], zd[0], on)
    switches = more.pop("switches", None)
    if switches is not None:
        more["switches"] = lambda t, z, zd: switches(t, z[0], zd[0])
    CLAIMS[name] = Claim(name, family, text, float(stop), pose, [float(s)], [float(v)], rate=rates, **more)


def _erf_integral(x):
    return x * erf(x) + np.exp(-x * x) / sqrt(pi)


def gauss(at, width, impulse=1.0, s=0.0, v=0.0):
    """A pulse of the form of Gauss's curve: its integrals in closed form."""

    def exact(t):
        x, x0 = (t - at) / width, (0.0 - at) / width
        speed = v + impulse / 2 * (erf(x) - erf(x0))
        return s + (v - impulse / 2 * erf(x0)) * t + impulse / 2 * width * (_erf_integral(x) - _erf_integral(x0)), speed

    height = impulse / (width * sqrt(pi))
    return f"{height!r}*exp(-((time - {at!r})/{width!r})^2)", exact


def steps(*pieces, s=0.0, v=0.0):
    """Forces that jump in time: ((from, to, size), ...)."""

    def exact(t):
        z, w = s + v * t, v + 0 * t
        for a, b, f in pieces:
            d = np.clip(t - a, 0.0, b - a)
            z, w = z + f * (d * d / 2 + d * np.clip(t - b, 0.0, None)), w + f * d
        return z, w

    return exact
