"""Claims with one degree of freedom: a block of 1 kg on a rail, and the law that pushes it."""

from __future__ import annotations

import re
from math import cos, exp, pi, sin, sqrt, tanh

import numpy as np
from claim import Claim
from scipy.special import ellipj, ellipk, erf

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
    """``push`` is the force in the language, ``rate(t, s, v, on)`` or ``exact(t)`` what it does, by hand."""
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


# -- pulses in time ------------------------------------------------------------------------------------------------
def pulse(name, at, width, **more):
    push, exact = gauss(at, width, more.get("impulse", 1.0), v=more.get("v", 0.0))
    law(name, "pulses", push, exact=exact, stop=more.get("stop", 10.0), v=more.get("v", 0.0))


pulse("Pulse10ms", 3.3337, 0.01)
pulse("Pulse1ms", 3.3337, 1e-3, v=1.0)
pulse("Pulse10us", 7.77, 1e-5, v=0.3)
pulse("PulseFaint", 1.2345, 1e-3, impulse=2e-3, v=1.0, stop=2.0)
pulse("PulseLate", 999.0, 0.01, stop=1000.0, v=0.01)
law("Rectangle1ms", "pulses", "if time > 2.3456 and time < 2.3466 then 1e3 else 0",
    exact=steps((2.3456, 2.3466, 1e3)), stop=10)  # fmt: skip
law("Rectangle1us", "pulses", "if time > 2.3456 and time < 2.345601 then 1e6 else 0",
    exact=steps((2.3456, 2.345601, 1e6)), stop=10)  # fmt: skip
law("ThereAndBack", "pulses", "(if time > 1.11 and time < 1.112 then 500 else 0)"
    " - (if time > 1.41 and time < 1.412 then 500 else 0)",
    exact=steps((1.11, 1.112, 500), (1.41, 1.412, -500)), stop=2)  # fmt: skip


def triangles(at, half, height, s=0.0, v=0.0):
    """A triangle in time by three kinks: integrals of max(0, t - a)."""

    def exact(t):
        z, w = s + v * t, v + 0 * t
        for a, slope in zip(at, (1.0, -2.0, 1.0), strict=True):
            d, k = np.clip(t - a, 0.0, None), slope * height / half
            z, w = z + k * d**3 / 6, w + k * d**2 / 2
        return z, w

    return exact


law("TablePeak", "pulses", "peak(time)", extra="\n  Table peak(table = [0, 0; 4.321, 0; 4.322, 1000; 4.323, 0; 9, 0]);",
    exact=triangles((4.321, 4.322, 4.323), 1e-3, 1e3), stop=9)  # fmt: skip
law("TablePeriodic", "pulses", "peak(time)",
    lambda t, s, v, on: 200 * max(0.0, 1 - abs(t % 1.0 - 0.503) / 3e-3),
    extra='\n  Table peak(table = [0, 0; 0.5, 0; 0.503, 200; 0.506, 0; 1, 0], extrapolation = "periodic");',
    breaks=[k + x for k in range(6) for x in (0.5, 0.503, 0.506)], stop=6)  # fmt: skip
law("Train", "pulses", "50*exp(-(sin(pi*(1*time - 0.37))/0.01)^2)",
    lambda t, s, v, on: 50 * exp(-((sin(pi * (t - 0.37)) / 0.01) ** 2)),
    breaks=[k + 0.37 + x for k in range(5) for x in (-0.03, 0, 0.03)], stop=5)  # fmt: skip
law("Clipped", "pulses", "1e4*max(0, sin(2*time) - 0.9999)", lambda t, s, v, on: 1e4 * max(0.0, sin(2 * t) - 0.9999),
    breaks=[k * pi + pi / 4 + x for k in range(4) for x in np.arccos(0.9999) * np.array([-0.5, -0.4, 0.0, 0.5])],
    stop=10)  # fmt: skip
law("TanhPulse", "pulses", "500*(tanh((time - 1.7)/1e-4) - tanh((time - 1.701)/1e-4))",
    lambda t, s, v, on: 500 * (tanh((t - 1.7) / 1e-4) - tanh((t - 1.701) / 1e-4)), v=0.2,
    breaks=[1.698, 1.7, 1.701, 1.703], stop=4)  # fmt: skip
law("BurstLate", "pulses", "40*exp(-((time - 97.123)/0.05)^2)*sin(60*(time - 97))",
    lambda t, s, v, on: 40 * exp(-(((t - 97.123) / 0.05) ** 2)) * sin(60 * (t - 97)),
    breaks=np.linspace(96.8, 97.45, 40), stop=100)  # fmt: skip
law("PulseOnDecayed", "pulses", "-100*s - 4*v + 1e3*exp(-((time - 15.5)/2e-3)^2)",
    lambda t, s, v, on: -100 * s - 4 * v + 1e3 * exp(-(((t - 15.5) / 2e-3) ** 2)), s=1,
    breaks=[15.48, 15.5, 15.52], stop=20)  # fmt: skip

# -- windows in position or speed ------------------------------------------------------------------------------------


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


law("Window10um", "windows", "if rail.s > 0.50001 and rail.s < 0.50002 then 1e5 else 0",
    exact=crossing(0, 1, 0.50001, 0.50002, 1e5), v=1, stop=2)  # fmt: skip
law("Window100nm", "windows", "if rail.s > 0.5 and rail.s < 0.5000001 then -1e6 else 0",
    exact=crossing(0, 1, 0.5, 0.5000001, -1e6), v=1, stop=2)  # fmt: skip
law("BumpSmooth", "windows", "2e3*exp(-((s - 0.7)/1e-4)^2)",
    lambda t, s, v, on: 2e3 * exp(-(((s - 0.7) / 1e-4) ** 2)), v=1, breaks=[0.699, 0.7, 0.7003], stop=2)  # fmt: skip
law("BumpAlgebraic", "windows", "1e3/(1 + ((s - 0.7)/1e-4)^2)^2",
    lambda t, s, v, on: 1e3 / (1 + ((s - 0.7) / 1e-4) ** 2) ** 2, v=1, breaks=[0.69, 0.7, 0.701], stop=2)  # fmt: skip
law("HillAndBack", "windows", "-8e3*(s - 0.7)/1e-3*exp(-((s - 0.7)/1e-3)^2)",
    lambda t, s, v, on: -8e3 * (s - 0.7) / 1e-3 * exp(-(((s - 0.7) / 1e-3) ** 2)), v=3,
    breaks=[0.23, 0.2333, 0.237], stop=0.5)  # fmt: skip
law("WindowTable", "windows", "bump(rail.s)", lambda t, s, v, on: 2000 * max(0.0, 1 - abs(s - 0.301) / 1e-3),
    extra="\n  Table bump(table = [0, 0; 0.3, 0; 0.301, 2000; 0.302, 0; 1, 0]);", v=1, stop=1,
    switches=lambda t, s, v: (s - 0.3, s - 0.301, s - 0.302))  # fmt: skip
law("WindowVibrating", "windows", "-100*s + (if s > 0.5 and s < 0.501 then -50 else 0)",
    lambda t, s, v, on: -100 * s + (-50 if on[0] and not on[1] else 0), s=1, stop=5,
    switches=lambda t, s, v: (s - 0.5, s - 0.501))  # fmt: skip
law("WindowOfSpeed", "windows", "if v > 0.7 and v < 0.7001 then 0.01 else 1",
    exact=lambda t: (
        np.where(t < 0.7, t * t / 2, np.where(t < 0.71, 0.245 + 0.7 * (t - 0.7) + 0.005 * (t - 0.7) ** 2,
                 0.245 + 0.007 + 0.005e-4 + 0.7001 * (t - 0.71) + (t - 0.71) ** 2 / 2)),
        np.where(t < 0.7, t, np.where(t < 0.71, 0.7 + 0.01 * (t - 0.7), 0.7001 + t - 0.71))), stop=2)  # fmt: skip
law("TwoWindows", "windows",
    "(if s > 0.2 and s < 0.20001 then 1e5 else 0) - (if s > 0.9 and s < 0.90001 then 1e5 else 0)",
    exact=lambda t: two_windows(t), v=1, stop=1.5)  # fmt: skip


def two_windows(t):
    """Faster by sqrt(3) between the two."""
    t2 = 0.2 + (sqrt(3.0) - 1) / 1e5
    middle = np.array([0.5 * (t2 + (0.9 - 0.20001) / sqrt(3.0) + t2)])
    one, w = crossing(0, 1, 0.2, 0.20001, 1e5)(t)
    z, _ = crossing(0, 1, 0.2, 0.20001, 1e5)(middle)
    two, w2 = crossing(z[0], sqrt(3.0), 0.9, 0.90001, -1e5)(t - middle[0])
    return np.where(t < middle[0], one, two), np.where(t < middle[0], w, w2)


# -- growth that shows late ------------------------------------------------------------------------------------------
law("Delayed", "growth", "-(20*v + 10*(20 - time)*s + 1e3*s^3)",
    lambda t, s, v, on: -(20 * v + 10 * (20 - t) * s + 1e3 * s**3), s=0.1, stop=42, atol=1e-60)  # fmt: skip
law("Inverted", "growth", "9.81*sin(s)", lambda t, s, v, on: 9.81 * sin(s), s=1e-6, stop=8)
law("InvertedAtRest", "growth", "9.81*sin(s)", exact=lambda t: (0 * t, 0 * t), stop=10)
law("DoubleWell", "growth", "s - s^3 - 0.1*v", lambda t, s, v, on: s - s**3 - 0.1 * v, s=1e-5, stop=30)
law("FromNothing", "growth", "1e-16*exp(40*time)",
    exact=lambda t: (1e-16 / 1600 * (np.exp(40 * t) - 1 - 40 * t), 1e-16 / 40 * (np.exp(40 * t) - 1)), stop=1)
law("Pole", "growth", "6*s^2", exact=lambda t: ((1 - t) ** -2.0, 2 * (1 - t) ** -3.0), s=1, v=2, stop=0.99)
law("PoleNear", "growth", "6*s^2", exact=lambda t: ((1 - t) ** -2.0, 2 * (1 - t) ** -3.0), s=1, v=2, stop=0.999)
law("StiffThenFree", "growth", "-1e4*(1 - tanh(5*(time - 2)))*s - 0.1*v",
    lambda t, s, v, on: -1e4 * (1 - tanh(5 * (t - 2))) * s - 0.1 * v, s=1e-2, stop=5)  # fmt: skip
law("NegativeDamping", "growth", "-s + 0.5*(time - 20)*v/10", lambda t, s, v, on: -s + 0.05 * (t - 20) * v, s=1,
    stop=40)  # fmt: skip
law("Saddle", "growth", "25*s", exact=lambda t: (1e-9 * np.cosh(5 * t), 5e-9 * np.sinh(5 * t)), s=1e-9, stop=4)

# -- chaos -----------------------------------------------------------------------------------------------------------
UEDA = "-(0.1*v + s^3 - 7.5*cos(time))"
law("Ueda", "chaos", UEDA, lambda t, s, v, on: -(0.1 * v + s**3 - 7.5 * cos(t)), s=1, stop=40)
law("UedaLong", "chaos", UEDA, lambda t, s, v, on: -(0.1 * v + s**3 - 7.5 * cos(t)), s=1, stop=120)
law("WellsDriven", "chaos", "s - s^3 - 0.25*v + 0.4*cos(time)",
    lambda t, s, v, on: s - s**3 - 0.25 * v + 0.4 * cos(t), s=1, stop=80)  # fmt: skip
law("PendulumDriven", "chaos", "-1*sin(s) - 0.5*v + 1.5*cos(2/3*time)",
    lambda t, s, v, on: -sin(s) - 0.5 * v + 1.5 * cos(2 / 3 * t), s=0.2, stop=60)  # fmt: skip
law("ImpactChaos", "chaos", "-s + 1*cos(2.8*time) - 0.05*v - (if s > 0 then 1e4*s else 0)",
    lambda t, s, v, on: -s + cos(2.8 * t) - 0.05 * v - (1e4 * s if on[0] else 0), s=-0.5, stop=15,
    switches=lambda t, s, v: (s,))  # fmt: skip

# -- resonance -------------------------------------------------------------------------------------------------------
law("Resonance", "resonance", "-100*s + 1*cos(10*time)", exact=lambda t: (
    t / 20 * np.sin(10 * t), np.sin(10 * t) / 20 + t / 2 * np.cos(10 * t)), stop=30)  # fmt: skip
law("Beat", "resonance", "-100*s + 1*cos(10.1*time)", exact=lambda t: (
    (np.cos(10.1 * t) - np.cos(10 * t)) / (100 - 10.1**2),
    (-10.1 * np.sin(10.1 * t) + 10 * np.sin(10 * t)) / (100 - 10.1**2)), stop=60)  # fmt: skip
law("HighQ", "resonance", "-100*s - 0.002*v + 0.01*sin(10*time)",
    lambda t, s, v, on: -100 * s - 0.002 * v + 0.01 * sin(10 * t), stop=100)  # fmt: skip
law("Mathieu", "resonance", "-(1 + 0.4*cos(2*time))*s - 0.02*v",
    lambda t, s, v, on: -(1 + 0.4 * cos(2 * t)) * s - 0.02 * v, s=1e-3, stop=60)  # fmt: skip
law("Superharmonic", "resonance", "-s - s^3 - 0.1*v + 5*cos(0.31*time)",
    lambda t, s, v, on: -s - s**3 - 0.1 * v + 5 * cos(0.31 * t), stop=60)  # fmt: skip
law("Sweep", "resonance", "-400*s - 0.1*v + 1*sin(0.5*time^2)",
    lambda t, s, v, on: -400 * s - 0.1 * v + sin(0.5 * t * t), stop=40)  # fmt: skip

# -- stiff limit cycles ----------------------------------------------------------------------------------------------
for mu, stop in ((5, 40), (100, 300), (300, 600)):
    law(f"VanDerPol{mu}", "cycles", f"{mu}*(1 - s^2)*v - s",
        lambda t, s, v, on, mu=mu: mu * (1 - s * s) * v - s, s=2, stop=stop)  # fmt: skip
law("Rayleigh", "cycles", "30*(v - v^3/3) - s", lambda t, s, v, on: 30 * (v - v**3 / 3) - s, s=2, stop=100)
law("BeltSmooth", "cycles", "-25*s - 3*tanh((v - 0.5)/0.01)*(1 + 1/(1 + 10*abs(v - 0.5)))",
    lambda t, s, v, on: -25 * s - 3 * tanh((v - 0.5) / 0.01) * (1 + 1 / (1 + 10 * abs(v - 0.5))), stop=5,
    switches=lambda t, s, v: (v - 0.5,))  # fmt: skip

# -- grazing ---------------------------------------------------------------------------------------------------------
for name, gap in (("Graze", 0.9999), ("GrazeFaint", 0.999999), ("GrazeMissed", 1.0001)):
    law(name, "grazing", f"-s - (if s < -{gap} then 1e6*(s + {gap}) else 0)",
        lambda t, s, v, on, gap=gap: -s - (0 if on[0] else 1e6 * (s + gap)), s=1, stop=30,
        switches=lambda t, s, v, gap=gap: (s + gap,))  # fmt: skip
law("GrazeDriven", "grazing", "-4*s - 0.1*v + 1*cos(time) - (if s > 0.66 then 1e5*(s - 0.66) else 0)",
    lambda t, s, v, on: -4 * s - 0.1 * v + cos(t) - (1e5 * (s - 0.66) if on[0] else 0), stop=20,
    switches=lambda t, s, v: (s - 0.66,))  # fmt: skip
law("GrazeStep", "grazing", "-s + (if s > 0.9999 then -5 else 0)",
    lambda t, s, v, on: -s + (-5 if on[0] else 0), s=0.0, v=1, stop=6, switches=lambda t, s, v: (s - 0.9999,))

# -- bouncing --------------------------------------------------------------------------------------------------------
for name, k, stop in (("Bounce1e6", "1e6", 5), ("Bounce1e8", "1e8", 3), ("Bounce1e4", "1e4", 10)):
    law(name, "bouncing", f"-9.81 - (if s < 0 then {k}*s else 0)",
        lambda t, s, v, on, k=float(k): -9.81 - (0 if on[0] else k * s), s=0.5, stop=stop,
        switches=lambda t, s, v: (s,))  # fmt: skip
law("BounceDamped", "bouncing", "-9.81 + (if s < 0 then max(0, -1e5*s - 60*v) else 0)",
    lambda t, s, v, on: -9.81 + (-1e5 * s - 60 * v if not on[0] and on[1] else 0), s=0.5, stop=3,
    switches=lambda t, s, v: (s, -1e5 * s - 60 * v))  # fmt: skip
law("Hertz", "bouncing", "-9.81 + (if s < 0 then 1e6*(-s)^1.5 else 0)",
    lambda t, s, v, on: -9.81 + (0 if on[0] else 1e6 * max(-s, 0) ** 1.5), s=0.3, stop=3,
    switches=lambda t, s, v: (s,))  # fmt: skip
law("TwoWalls", "bouncing", "-(if s < -1 then 1e6*(s + 1) else if s > 1 then 1e6*(s - 1) else 0)",
    exact=lambda t: two_walls(t), v=1.37, stop=20)  # fmt: skip
law("ShakenFloor", "bouncing", "-9.81 - (if s < 0.02*sin(20*time) then 1e5*(s - 0.02*sin(20*time)) else 0)",
    lambda t, s, v, on: -9.81 - (0 if on[0] else 1e5 * (s - 0.02 * sin(20 * t))), s=0.2, stop=2,
    switches=lambda t, s, v: (s - 0.02 * sin(20 * t),))  # fmt: skip



def two_walls(t, v=1.37, w=1e3):
    """Free flight between -1 and 1, half a period of the walls' springs at each end; from the middle."""
    flight, touch = 2 / v, pi / w
    x = t + flight / 2
    k = np.floor(x / (flight + touch))
    x = x - k * (flight + touch)
    sign = np.where(k % 2 == 0, 1.0, -1.0)
    d = np.clip(x - flight, 0.0, None)
    z = np.where(x < flight, -1 + v * x, 1 + v / w * np.sin(w * d))
    return sign * z, sign * np.where(x < flight, v, v * np.cos(w * d))


# -- chatter ---------------------------------------------------------------------------------------------------------


def relay(t):
    """s'' = -sign(s) from s = 1: parabolas of period 4 sqrt 2."""
    quarter = sqrt(2.0)
    x = np.mod(t, 4 * quarter)
    k = np.floor((x + quarter) / (2 * quarter))
    d = x - 2 * quarter * k
    sign = np.where(k % 2 == 0, 1.0, -1.0)
    return sign * (1 - d * d / 2), -sign * d


law("Relay", "chatter", "if s > 0 then -1 else 1", exact=relay, s=1, stop=20)
law("CoulombStop", "chatter", "if v > 0 then -2 else 2", v=1, stop=2,
    exact=lambda t: (np.where(t < 0.5, t - t * t, 0.25), np.clip(1 - 2 * t, 0, None)))  # fmt: skip
law("SlidingMode", "chatter", "if 1*rail.v + 1*rail.s > 0 then -3 else 3", v=1, stop=3,
    exact=lambda t: _sliding(t))  # fmt: skip
law("HoldAgainstDrive", "chatter", "1*sin(time) - (if v > 0 then 2 else -2)", exact=lambda t: (0 * t, 0 * t), stop=5)
law("Sampled", "chatter", "-floor(10*s)", exact=lambda t: sampled(t), s=1.05, stop=5)


def sampled(t, s=1.05, v=0.0):
    """Parabolas between multiples of 0.1, where s'' = -k."""
    k, now, found = 10, 0.0, []
    z, w = s, v
    while len(found) < len(t):
        a = -float(k)
        after = []
        for x, way in ((k / 10, -1), ((k + 1) / 10, 1)):
            for root in np.roots([a / 2, w, z - x]) if a else [(x - z) / w]:
                if abs(np.imag(root)) < 1e-300 and np.real(root) > 1e-9 and (w + a * np.real(root)) * way > 0:
                    after.append((float(np.real(root)), x, way))
        d, x, way = min(after)
        while len(found) < len(t) and t[len(found)] <= now + d:
            e = t[len(found)] - now
            found.append((z + w * e + a * e * e / 2, w + a * e))
        z, w, now, k = x, w + a * d, now + d, k + way
    return tuple(np.array(found).T)


def _sliding(t):
    """From s = 0, v = 1 with -3 until v + s = 0, then s falls as e^-t, as |s - ...| < 3 holds it there."""
    # v = 1 - 3 t, s = t - 1.5 t^2: v + s = 1 - 2 t - 1.5 t^2
    t1 = (-2 + sqrt(4 + 6)) / 3
    s1 = t1 - 1.5 * t1 * t1
    late = s1 * np.exp(-(t - t1))
    return np.where(t < t1, t - 1.5 * t * t, late), np.where(t < t1, 1 - 3 * t, -late)


# -- friction --------------------------------------------------------------------------------------------------------
law("StickTanh", "friction", "-(2*tanh(v/1e-4) - 2.5*sin(2*time))",
    lambda t, s, v, on: -(2 * tanh(v / 1e-4) - 2.5 * sin(2 * t)), stop=20)  # fmt: skip
law("CreepTanh", "friction", "-(2*tanh(v/1e-3) - 1.9*sin(2*time))",
    lambda t, s, v, on: -(2 * tanh(v / 1e-3) - 1.9 * sin(2 * t)), stop=20)  # fmt: skip
law("StribeckStop", "friction", "-100*s - 1*tanh(v/1e-3)*(1 + exp(-(v/0.05)^2))",
    lambda t, s, v, on: -100 * s - tanh(v / 1e-3) * (1 + exp(-((v / 0.05) ** 2))), s=0.1, stop=4)

# -- scales of time and size -----------------------------------------------------------------------------------------
law("StiffAndSoft", "scales", "-s - 1e4*v + 1e4*cos(time)", lambda t, s, v, on: -s - 1e4 * v + 1e4 * cos(t), stop=20,
    )  # fmt: skip
law("Nanometre", "scales", "-1e6*s", exact=lambda t: (1e-9 * np.cos(1e3 * t), -1e-6 * np.sin(1e3 * t)), s=1e-9, stop=0.1)
law("Megametre", "scales", "-s", exact=lambda t: (1e6 * np.cos(t), -1e6 * np.sin(t)), s=1e6, stop=20)
law("FarAway", "scales", "-1e4*(s - 1e6)", exact=lambda t: (1e6 + np.cos(100 * t), -100 * np.sin(100 * t)), s=1e6 + 1,
    stop=1)  # fmt: skip

# -- long horizons ---------------------------------------------------------------------------------------------------
law("Thousand", "long", "-s", exact=lambda t: (np.cos(t), -np.sin(t)), s=1, stop=2000 * pi)


def swing(t, k=sin(0.5)):
    """The pendulum of unit frequency from 1 rad."""
    sn, cn, dn, _ = ellipj(ellipk(k * k) - t, k * k)
    return 2 * np.arcsin(k * sn), -2 * k * cn


law("Swing", "long", "-1*sin(s)", exact=swing, s=1, stop=600)
law("Coast", "long", "0*s", exact=lambda t: (3 + 1e-3 * t, 1e-3 + 0 * t), s=3, v=1e-3, stop=1e6)
law("SlowFast", "long", "-(1e3*sin(s/1e3) + 0.3*cos(31*time))",
    lambda t, s, v, on: -(1e3 * sin(s / 1e3) + 0.3 * cos(31 * t)), s=1, stop=100)  # fmt: skip
