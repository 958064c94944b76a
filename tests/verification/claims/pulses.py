"""Laws that act for a short time, or on a short part of the way."""

from __future__ import annotations

from math import exp, pi, sin, sqrt, tanh

import numpy as np
from laws import gauss, law, steps


# -- pulses in time ------------------------------------------------------------------------------------------------
def pulse(name, at, width, **more):
    push, exact = gauss(at, width, more.get("impulse", 1.0), v=more.get("v", 0.0))
    law(name, "pulses", push, exact=exact, stop=more.get("stop", 10.0), v=more.get("v", 0.0))


pulse("Pulse10ms", 3.3337, 0.01)
pulse("Pulse1ms", 3.3337, 1e-3, v=1.0)
pulse("Pulse10us", 7.77, 1e-5, v=0.3)
pulse("PulseFaint", 1.2345, 1e-3, impulse=2e-3, v=1.0, stop=2.0)
pulse("PulseLate", 999.0, 0.01, stop=1000.0, v=0.01)
law(
    "Rectangle1ms",
    "pulses",
    "if time > 2.3456 and time < 2.3466 then 1e3 else 0",
    exact=steps((2.3456, 2.3466, 1e3)),
    stop=10,
)
law(
    "Rectangle1us",
    "pulses",
    "if time > 2.3456 and time < 2.345601 then 1e6 else 0",
    exact=steps((2.3456, 2.345601, 1e6)),
    rounding=1e-9,  # 1e6 N, between times that are known to 4e-16 s
    stop=10,
)
law(
    "ThereAndBack",
    "pulses",
    "(if time > 1.11 and time < 1.112 then 500 else 0) - (if time > 1.41 and time < 1.412 then 500 else 0)",
    exact=steps((1.11, 1.112, 500), (1.41, 1.412, -500)),
    stop=2,
)


def triangle(start, half, height):
    """A triangle in time, from rest: its integrals piece by piece. Sums of those of its kinks would lose 7 digits."""

    def exact(t):
        u = np.clip((t - start) / half, 0.0, None)
        rest = np.clip(2.0 - u, 0.0, None)
        z = np.where(u < 1.0, u**3 / 6.0, u - 1.0 + rest**3 / 6.0)
        w = np.where(u < 1.0, u**2 / 2.0, 1.0 - rest**2 / 2.0)
        return height * half**2 * z, height * half * w

    return exact


law(
    "TablePeak",
    "pulses",
    "peak(time)",
    extra="\n  Table peak(table = [0, 0; 4.321, 0; 4.322, 1000; 4.323, 0; 9, 0]);",
    exact=triangle(4.321, 1e-3, 1e3),
    stop=9,
)
law(
    "TablePeriodic",
    "pulses",
    "peak(time)",
    lambda t, s, v, on: 200 * max(0.0, 1 - abs(t % 1.0 - 0.503) / 3e-3),
    extra='\n  Table peak(table = [0, 0; 0.5, 0; 0.503, 200; 0.506, 0; 1, 0], extrapolation = "periodic");',
    breaks=[k + x for k in range(6) for x in (0.5, 0.503, 0.506)],
    stop=6,
)
law(
    "Train",
    "pulses",
    "50*exp(-(sin(pi*(1*time - 0.37))/0.01)^2)",
    lambda t, s, v, on: 50 * exp(-((sin(pi * (t - 0.37)) / 0.01) ** 2)),
    breaks=[k + 0.37 + x for k in range(5) for x in (-0.03, 0, 0.03)],
    stop=5,
)
law(
    "Clipped",
    "pulses",
    "1e4*max(0, sin(2*time) - 0.9999)",
    lambda t, s, v, on: 1e4 * max(0.0, sin(2 * t) - 0.9999),
    breaks=[k * pi + pi / 4 + x for k in range(4) for x in np.arccos(0.9999) * np.array([-0.5, -0.4, 0.0, 0.5])],
    stop=10,
)
law(
    "TanhPulse",
    "pulses",
    "500*(tanh((time - 1.7)/1e-4) - tanh((time - 1.701)/1e-4))",
    lambda t, s, v, on: 500 * (tanh((t - 1.7) / 1e-4) - tanh((t - 1.701) / 1e-4)),
    v=0.2,
    breaks=[1.698, 1.7, 1.701, 1.703],
    stop=4,
)
law(
    "BurstLate",
    "pulses",
    "40*exp(-((time - 97.123)/0.05)^2)*sin(60*(time - 97))",
    lambda t, s, v, on: 40 * exp(-(((t - 97.123) / 0.05) ** 2)) * sin(60 * (t - 97)),
    breaks=np.linspace(96.8, 97.45, 40),
    stop=100,
)
law(
    "PulseOnDecayed",
    "pulses",
    "-100*s - 4*v + 1e3*exp(-((time - 15.5)/2e-3)^2)",
    lambda t, s, v, on: -100 * s - 4 * v + 1e3 * exp(-(((t - 15.5) / 2e-3) ** 2)),
    s=1,
    breaks=[15.48, 15.5, 15.52],
    stop=20,
)


# -- windows in position or speed ----------------------------------------------------------------------------------
def crossing(s, v, a, b, f):
    """Through a window of constant force, from the left: three pieces."""
    t1 = (a - s) / v
    out = sqrt(v * v + 2 * f * (b - a))
    t2 = t1 + (out - v) / f

    def exact(t):
        d = np.clip(t - t1, 0.0, t2 - t1)
        inside = f * (d * d / 2 + d * np.clip(t - t2, 0.0, None))
        return s + v * t + inside, v + f * d

    return exact


law(
    "Window10um",
    "windows",
    "if rail.s > 0.50001 and rail.s < 0.50002 then 1e5 else 0",
    exact=crossing(0, 1, 0.50001, 0.50002, 1e5),
    v=1,
    stop=2,
)
law(
    "Window100nm",
    "windows",
    "if rail.s > 0.5 and rail.s < 0.5000001 then -1e6 else 0",
    exact=crossing(0, 1, 0.5, 0.5000001, -1e6),
    v=1,
    stop=2,
)
law(
    "BumpSmooth",
    "windows",
    "2e3*exp(-((s - 0.7)/1e-4)^2)",
    lambda t, s, v, on: 2e3 * exp(-(((s - 0.7) / 1e-4) ** 2)),
    v=1,
    breaks=[0.699, 0.7, 0.7003],
    stop=2,
)
law(
    "BumpAlgebraic",
    "windows",
    "1e3/(1 + ((s - 0.7)/1e-4)^2)^2",
    lambda t, s, v, on: 1e3 / (1 + ((s - 0.7) / 1e-4) ** 2) ** 2,
    v=1,
    breaks=[0.69, 0.7, 0.701],
    stop=2,
)
law(
    "HillAndBack",
    "windows",
    "-8e3*(s - 0.7)/1e-3*exp(-((s - 0.7)/1e-3)^2)",
    lambda t, s, v, on: -8e3 * (s - 0.7) / 1e-3 * exp(-(((s - 0.7) / 1e-3) ** 2)),
    v=3,
    breaks=[0.23, 0.2333, 0.237],
    stop=0.5,
)
law(
    "WindowTable",
    "windows",
    "bump(rail.s)",
    lambda t, s, v, on: 2000 * max(0.0, 1 - abs(s - 0.301) / 1e-3),
    extra="\n  Table bump(table = [0, 0; 0.3, 0; 0.301, 2000; 0.302, 0; 1, 0]);",
    v=1,
    stop=1,
    switches=lambda t, s, v: (s - 0.3, s - 0.301, s - 0.302),
)
law(
    "WindowVibrating",
    "windows",
    "-100*s + (if s > 0.5 and s < 0.501 then -50 else 0)",
    lambda t, s, v, on: -100 * s + (-50 if on[0] and not on[1] else 0),
    s=1,
    stop=5,
    switches=lambda t, s, v: (s - 0.5, s - 0.501),
)
law(
    "WindowOfSpeed",
    "windows",
    "if v > 0.7 and v < 0.7001 then 0.01 else 1",
    exact=lambda t: (
        np.where(
            t < 0.7,
            t * t / 2,
            np.where(
                t < 0.71,
                0.245 + 0.7 * (t - 0.7) + 0.005 * (t - 0.7) ** 2,
                0.245 + 0.007 + 0.005e-4 + 0.7001 * (t - 0.71) + (t - 0.71) ** 2 / 2,
            ),
        ),
        np.where(t < 0.7, t, np.where(t < 0.71, 0.7 + 0.01 * (t - 0.7), 0.7001 + t - 0.71)),
    ),
    stop=2,
)
law(
    "TwoWindows",
    "windows",
    "(if s > 0.2 and s < 0.20001 then 1e5 else 0) - (if s > 0.9 and s < 0.90001 then 1e5 else 0)",
    exact=lambda t: two_windows(t),
    v=1,
    stop=1.5,
)


def two_windows(t):
    """Faster by sqrt(3) between the two."""
    t2 = 0.2 + (sqrt(3.0) - 1) / 1e5
    middle = np.array([0.5 * (t2 + (0.9 - 0.20001) / sqrt(3.0) + t2)])
    one, w = crossing(0, 1, 0.2, 0.20001, 1e5)(t)
    z, _ = crossing(0, 1, 0.2, 0.20001, 1e5)(middle)
    two, w2 = crossing(z[0], sqrt(3.0), 0.9, 0.90001, -1e5)(t - middle[0])
    return np.where(t < middle[0], one, two), np.where(t < middle[0], w, w2)
