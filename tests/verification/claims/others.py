"""Blades, discs, gears, springs in the plane, orbits."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
from claim import Claim, G
from jets import cos, sin
from mechanisms import CLAIMS, around, bell, mechanism


# -- conditions on velocities --------------------------------------------------------------------------------------
def blade(name, family, extra, *, pose=None, rate=None, exact=None, z, v, stop, start, g=0.0, n="", **more):
    body = f"  Body skate(m = 2.0, I = 0.3, frames(P = {{-0.1, 0}}));\n{extra}"
    pose = pose or (lambda z, t: {"skate": (z[0], z[1], z[2])})
    mechanism(name, family, body, pose, z=z, v=v, stop=stop, start=start, rate=rate, exact=exact, g=g, **more)
    if n:
        old = CLAIMS[name]
        text = old.text.replace(f"ground(g = {g!r})", f"ground(g = {g!r}, n = {n})")
        CLAIMS[name] = Claim(**{**old.__dict__, "text": text})


def on_slope(t, w=1.5, g=4.905):
    """A blade that turns at w on a slope: a cycloid."""
    x, y = g / (2 * w * w) * np.sin(w * t) ** 2, g / (2 * w * w) * (w * t - 0.5 * np.sin(2 * w * t))
    speed = g / w * np.sin(w * t)
    return (np.stack([x, y, w * t], 1), np.stack([speed * np.cos(w * t), speed * np.sin(w * t), w + 0 * t], 1))


def sliding(t, z, v, on):
    """A blade below the centre, pushed along by a pulse, while it turns."""
    along = v[0] * np.cos(z[2]) + v[1] * np.sin(z[2])
    push = bell(t, 3.21, 2e-3, 500) / 2.0
    return [push * np.cos(z[2]) - along * v[2] * np.sin(z[2]), push * np.sin(z[2]) + along * v[2] * np.cos(z[2]), 0.0]


def sleigh(t, z, v, on, a=0.1, m=2.0, I=0.3):
    """Chaplygin's: z are those of the blade."""
    along = v[0] * np.cos(z[2]) + v[1] * np.sin(z[2])
    grows, turns = a * v[2] ** 2, -m * a * along * v[2] / (I + m * a * a)
    return [
        grows * np.cos(z[2]) - along * v[2] * np.sin(z[2]),
        grows * np.sin(z[2]) + along * v[2] * np.cos(z[2]),
        turns,
    ]


PLACE = "  skate.x = 0; skate.y = 0; skate.phi = 0; skate.w = {}; blade.v = {};"
blade(
    "KnifeSlope",
    "nonholonomic",
    "  KnifeEdge blade(skate.c);",
    exact=on_slope,
    z=[0, 0, 0],
    v=[0, 0, 1.5],
    stop=10,
    start=PLACE.format(1.5, 0),
    g=4.905,
    n="{1, 0}",
)
blade(
    "KnifePulse",
    "nonholonomic",
    "  KnifeEdge blade(skate.c);\n  Force push(skate.c, skate.c, fx = 500*exp(-((time - 3.21)/2e-3)^2));",
    rate=sliding,
    z=[0, 0, 0],
    v=[0.2, 0, 0.7],
    stop=5,
    start=PLACE.format(0.7, 0.2),
    breaks=around(3.21, 2e-3),
)
blade(
    "Sleigh",
    "nonholonomic",
    "  KnifeEdge blade(ground, skate.P);",
    rate=sleigh,
    z=[0, 0, 0],
    v=[1, 0, 2],
    stop=20,
    pose=lambda z, t: {"skate": (z[0] + 0.1 * cos(z[2]), z[1] + 0.1 * sin(z[2]), z[2])},
    start="  skate.P.x = 0; skate.P.y = 0; skate.phi = 0; skate.w = 2; blade.v = 1;",
)


def disc(name, family, extra, push, *, v=0.0, stop=3.0, **more):
    body = f"""  Frame plane(ground, phi = {-pi / 6!r});
  Frame hook(plane, r = {{0, 0.1}});
  Body disc(m = 2.0, I = 0.01);
  RollingDisc contact(plane, disc.c, radius = 0.1);
  SpringDamper spring(hook, disc.c, k = 50, s0 = 0.3);
{extra}"""
    c, s = float(np.cos(pi / 6)), float(np.sin(pi / 6))

    def pose(z, t):
        return {"disc": (c * z[0] + 0.1 * s, -s * z[0] + 0.1 * c, -10.0 * (z[0] - 0.3))}

    mechanism(
        name,
        family,
        body,
        pose,
        z=[0.3],
        v=[v],
        stop=stop,
        start=f"  contact.s = 0.3; contact.v = {v!r}; disc.phi = 0;",
        rate=lambda t, z, v, on: (2 * G * s - 50 * (z[0] - 0.3) + push(t, z[0], v[0], on)) / 3.0,
        **more,
    )


disc(
    "DiscPulse",
    "nonholonomic",
    "  Real blow = 600*exp(-((time - 2.222)/2e-3)^2);\n  Force kick(plane, disc.c, fx = 1*blow);",
    lambda t, s, v, on: bell(t, 2.222, 2e-3, 600),
    breaks=around(2.222, 2e-3),
)
disc("DiscSpring", "nonholonomic", "", lambda t, s, v, on: 0.0, stop=30.0)


# -- gears ---------------------------------------------------------------------------------------------------------
def gear(name, family, tau, torque=None, *, stop, exact=None, extra="", **more):
    body = f"""  Body one(m = 1.0, I = 0.1);
  Body two(m = 1.0, I = 0.8);
  Frame right(ground, r = {{1, 0}});
  Revolute O(ground, one.c);
  Revolute P(right, two.c);
  VelocityConstraint mesh(gamma = one.w + 2*two.w);
{extra}  Torque motor(O, tau = {tau});"""

    def pose(z, t):
        return {"one": (0.0, 0.0, z[0]), "two": (1.0, 0.0, -0.5 * z[0])}

    rate = None if torque is None else lambda t, z, v, on: torque(t, z[0], v[0], on) / 0.3
    mechanism(
        name,
        family,
        body,
        pose,
        z=[0],
        v=[0],
        stop=stop,
        exact=exact,
        rate=rate,
        start="  one.phi = 0; one.w = 0; two.phi = 0;",
        **more,
    )


gear(
    "GearPulse",
    "gears",
    "30*exp(-((time - 4.56)/5e-3)^2)",
    lambda t, a, w, on: bell(t, 4.56, 5e-3, 30),
    stop=6,
    breaks=around(4.56, 5e-3),
)
gear(
    "GearTable",
    "gears",
    "curve(O.w)",
    lambda t, a, w, on: np.interp(w, [0, 10, 30, 32, 34], [5, 4.5, 4, 3, -3]),
    stop=4,
    extra="  Table curve(table = [0, 5; 10, 4.5; 30, 4; 32, 3; 34, -3]);\n",
    switches=lambda t, z, v: tuple(v[0] - x for x in (10, 30, 32)),
)

# -- masses on springs in the plane; orbits ------------------------------------------------------------------------
for name, L in (("MetreSpring", 1.0), ("CentimetreSpring", 0.01), ("MillimetreSpring", 1e-3)):
    mechanism(
        name,
        "scales",
        f"  Frame p(ground, r = {{{L!r}, 0}});\n  PointMass b(m = 1);\n"
        f"  SpringDamper s(p, b, k = 1000, s0 = {2 * L!r});",
        lambda z, t: {"b": (z[0], 0.0, None)},
        z=[3.2 * L],
        v=[0],
        stop=1,
        g=0.0,
        start=f"  b.x = {3.2 * L!r}; b.y = 0; b.vx = 0; b.vy = 0;",
        exact=lambda t, L=L: (3 * L + 0.2 * L * np.cos(sqrt(1000) * t), -0.2 * L * sqrt(1000) * np.sin(sqrt(1000) * t)),
    )


def kepler(e):
    """From the far end of an ellipse of half axis 1, GM = 1."""

    def exact(t):
        M = np.mod(t + pi, 2 * pi)
        E = np.where(pi > M, pi / 2, 3 * pi / 2)
        low, high = 0 * M, 2 * pi + 0 * M
        for _ in range(60):
            E = 0.5 * (low + high)
            over = E - e * np.sin(E) > M
            low, high = np.where(over, low, E), np.where(over, E, high)
        rate = 1 / (1 - e * np.cos(E))
        b = sqrt(1 - e * e)
        return (np.stack([np.cos(E) - e, b * np.sin(E)], 1), np.stack([-np.sin(E) * rate, b * np.cos(E) * rate], 1))

    return exact


for name, e, turns in (("Orbit", 0.9, 3), ("OrbitClose", 0.99, 2)):
    far, slow = -(1 + e), -sqrt((1 - e) / (1 + e))
    mechanism(
        name,
        "windows",
        "  PointMass b(m = 1);\n  SpringDamper s(ground, b, force = 1/(1*s)^2);",
        lambda z, t: {"b": (z[0], z[1], None)},
        z=[far, 0],
        v=[0, slow],
        stop=2 * pi * turns,
        g=0.0,
        start=f"  b.x = {far!r}; b.y = 0; b.vx = 0; b.vy = {slow!r};",
        exact=kepler(e),
    )

# -- friction of a slide -------------------------------------------------------------------------------------------
mechanism(
    "SlopeFriction",
    "friction",
    f"  Frame slope(ground, phi = {-pi / 9!r});\n  Body block(m = 1, I = 1);\n"
    "  Prismatic slide(slope, block.c, mu = 0.5, v_s = 0.01);",
    lambda z, t: {"block": (float(np.cos(pi / 9)) * z[0], -float(np.sin(pi / 9)) * z[0], None)},
    z=[0],
    v=[2],
    stop=4,
    start="  slide.s = 0; slide.v = 2;",
    rate=lambda t, z, v, on: G * np.sin(pi / 9) - 0.5 * G * np.cos(pi / 9) * np.tanh(v[0] / 0.01),
)

# -- a compliant joint, and a pulse on it --------------------------------------------------------------------------
mechanism(
    "BushingPulse",
    "flexible",
    "  Body block(m = 2, I = 0.1);\n  Bushing mount(ground, block.c, k = {1e5, 1e3}, c = {20, 2});\n"
    "  Force kick(block.c, fx = 1e3*exp(-((time - 1.357)/1e-3)^2));",
    lambda z, t: {"block": (z[0], z[1], None)},
    z=[0, 0],
    v=[0, 0],
    stop=2,
    start="  block.x = 0; block.y = 0; block.vx = 0; block.vy = 0; block.phi = 0; block.w = 0;",
    rate=lambda t, z, v, on: [(bell(t, 1.357, 1e-3, 1e3) - 1e5 * z[0] - 20 * v[0]) / 2, -G - 500 * z[1] - v[1]],
    breaks=around(1.357, 1e-3),
)
