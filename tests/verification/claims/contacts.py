"""Laws of stops and of friction, scales, and long runs."""

from __future__ import annotations

from math import cos, exp, pi, sin, sqrt, tanh

import numpy as np
from laws import law
from scipy.special import ellipj, ellipk

# -- grazing -------------------------------------------------------------------------------------------------------
for name, gap in (("Graze", 0.9999), ("GrazeFaint", 0.999999), ("GrazeMissed", 1.0001)):
    law(
        name,
        "grazing",
        f"-s - (if s < -{gap} then 1e6*(s + {gap}) else 0)",
        lambda t, s, v, on, gap=gap: -s - (0 if on[0] else 1e6 * (s + gap)),
        s=1,
        stop=30,
        switches=lambda t, s, v, gap=gap: (s + gap,),
    )
law(
    "GrazeDriven",
    "grazing",
    "-4*s - 0.1*v + 1*cos(time) - (if s > 0.66 then 1e5*(s - 0.66) else 0)",
    lambda t, s, v, on: -4 * s - 0.1 * v + cos(t) - (1e5 * (s - 0.66) if on[0] else 0),
    stop=20,
    switches=lambda t, s, v: (s - 0.66,),
)
law(
    "GrazeStep",
    "grazing",
    "-s + (if s > 0.9999 then -5 else 0)",
    lambda t, s, v, on: -s + (-5 if on[0] else 0),
    s=0.0,
    v=1,
    stop=6,
    switches=lambda t, s, v: (s - 0.9999,),
)

# -- bouncing ------------------------------------------------------------------------------------------------------
for name, k, stop in (("Bounce1e6", "1e6", 5), ("Bounce1e8", "1e8", 3), ("Bounce1e4", "1e4", 10)):
    law(
        name,
        "bouncing",
        f"-9.81 - (if s < 0 then {k}*s else 0)",
        lambda t, s, v, on, k=float(k): -9.81 - (0 if on[0] else k * s),
        s=0.5,
        stop=stop,
        switches=lambda t, s, v: (s,),
    )
law(
    "BounceDamped",
    "bouncing",
    "-9.81 + (if s < 0 then max(0, -1e5*s - 60*v) else 0)",
    lambda t, s, v, on: -9.81 + (-1e5 * s - 60 * v if not on[0] and on[1] else 0),
    s=0.5,
    stop=3,
    switches=lambda t, s, v: (s, -1e5 * s - 60 * v),
)
law(
    "Hertz",
    "bouncing",
    "-9.81 + (if s < 0 then 1e6*(-s)^1.5 else 0)",
    lambda t, s, v, on: -9.81 + (0 if on[0] else 1e6 * max(-s, 0) ** 1.5),
    s=0.3,
    stop=3,
    switches=lambda t, s, v: (s,),
)
law(
    "TwoWalls",
    "bouncing",
    "-(if s < -1 then 1e6*(s + 1) else if s > 1 then 1e6*(s - 1) else 0)",
    exact=lambda t: two_walls(t),
    v=1.37,
    stop=20,
)
law(
    "ShakenFloor",
    "bouncing",
    "-9.81 - (if s < 0.02*sin(20*time) then 1e5*(s - 0.02*sin(20*time)) else 0)",
    lambda t, s, v, on: -9.81 - (0 if on[0] else 1e5 * (s - 0.02 * sin(20 * t))),
    s=0.2,
    stop=2,
    switches=lambda t, s, v: (s - 0.02 * sin(20 * t),),
)


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


# -- chatter -------------------------------------------------------------------------------------------------------
def relay(t):
    """s'' = -sign(s) from s = 1: parabolas of period 4 sqrt 2."""
    quarter = sqrt(2.0)
    x = np.mod(t, 4 * quarter)
    k = np.floor((x + quarter) / (2 * quarter))
    d = x - 2 * quarter * k
    sign = np.where(k % 2 == 0, 1.0, -1.0)
    return sign * (1 - d * d / 2), -sign * d


law("Relay", "chatter", "if s > 0 then -1 else 1", exact=relay, s=1, stop=20)
law(
    "CoulombStop",
    "chatter",
    "if v > 0 then -2 else 2",
    v=1,
    stop=2,
    exact=lambda t: (np.where(t < 0.5, t - t * t, 0.25), np.clip(1 - 2 * t, 0, None)),
)
law("SlidingMode", "chatter", "if 1*rail.v + 1*rail.s > 0 then -3 else 3", v=1, stop=3, exact=lambda t: _sliding(t))
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


# -- friction ------------------------------------------------------------------------------------------------------
law(
    "StickTanh",
    "friction",
    "-(2*tanh(v/1e-4) - 2.5*sin(2*time))",
    lambda t, s, v, on: -(2 * tanh(v / 1e-4) - 2.5 * sin(2 * t)),
    stop=20,
)
law(
    "CreepTanh",
    "friction",
    "-(2*tanh(v/1e-3) - 1.9*sin(2*time))",
    lambda t, s, v, on: -(2 * tanh(v / 1e-3) - 1.9 * sin(2 * t)),
    stop=20,
)
law(
    "StribeckStop",
    "friction",
    "-100*s - 1*tanh(v/1e-3)*(1 + exp(-(v/0.05)^2))",
    lambda t, s, v, on: -100 * s - tanh(v / 1e-3) * (1 + exp(-((v / 0.05) ** 2))),
    s=0.1,
    stop=4,
)

# -- scales of time and size ---------------------------------------------------------------------------------------
law(
    "StiffAndSoft",
    "scales",
    "-s - 1e4*v + 1e4*cos(time)",
    lambda t, s, v, on: -s - 1e4 * v + 1e4 * cos(t),
    stop=20,
)
law(
    "Nanometre", "scales", "-1e6*s", exact=lambda t: (1e-9 * np.cos(1e3 * t), -1e-6 * np.sin(1e3 * t)), s=1e-9, stop=0.1
)
law("Megametre", "scales", "-s", exact=lambda t: (1e6 * np.cos(t), -1e6 * np.sin(t)), s=1e6, stop=20)
law(
    "FarAway",
    "scales",
    "-1e4*(s - 1e6)",
    exact=lambda t: (1e6 + np.cos(100 * t), -100 * np.sin(100 * t)),
    s=1e6 + 1,
    stop=1,
)

# -- long horizons -------------------------------------------------------------------------------------------------
law("TwoHundred", "long", "-s", exact=lambda t: (np.cos(t), -np.sin(t)), s=1, stop=400 * pi)


def swing(t, k=0.479425538604203):
    """The pendulum of unit frequency from 1 rad; k is sin(0.5)."""
    sn, cn, *_ = ellipj(ellipk(k * k) - t, k * k)
    return 2 * np.arcsin(k * sn), -2 * k * cn


law("Swing", "long", "-1*sin(s)", exact=swing, s=1, stop=600)
law("Coast", "long", "0*s", exact=lambda t: (3 + 1e-3 * t, 1e-3 + 0 * t), s=3, v=1e-3, stop=1e6)
law(
    "SlowFast",
    "long",
    "-(1e3*sin(s/1e3) + 0.3*cos(31*time))",
    lambda t, s, v, on: -(1e3 * sin(s / 1e3) + 0.3 * cos(31 * t)),
    s=1,
    stop=100,
)
