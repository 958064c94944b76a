"""Kinds that public bug reports and questions are about: loads that act through friction only, limits of speeds and
reactions that a motion exceeds by less than its error, long regular motions."""

from __future__ import annotations

from math import acos, erf, pi

import numpy as np
from jets import cos, sin
from mechanisms import CLAIMS, mechanism

G = 9.81


def slide(name, at, width, mu, impulse):
    """A load of Gauss's form on a slide with friction: mu times its impulse is lost, without any load before it."""
    height = impulse / (width * pi**0.5)

    def exact(t):
        lost = mu * impulse / 2
        x, x0 = (t - at) / width, -at / width
        step = np.array([erf(y) for y in x])

        def area(y, step):
            return y * step + np.exp(-y * y) / pi**0.5

        way = 10.0 * t - lost * (t + width * (area(x, step) - area(x0, erf(x0))))
        return way, 10.0 - lost * (1.0 + step)

    mechanism(
        name,
        "reported",
        f"  Body A(m = 1, I = 1);\n  Prismatic j(ground, A.c, mu = {mu!r}, v_s = 1e-3);\n"
        f"  Force push(A.c, fy = -{height!r}*exp(-((time - {at!r})/{width!r})^2));",
        lambda z, t: {"A": (z[0], 0.0, 0.0)},
        exact=exact,
        z=[0.0],
        v=[10.0],
        stop=10,
        start="  j.s = 0;\n  j.v = 10;",
        g=0.0,
    )


slide("LoadOnSlide", 3.3337, 1e-4, 0.5, 2.0)
slide("LoadOnSlideLate", 9.1, 2e-3, 0.2, 5.0)


def limited(name, law, speed):
    """B is pushed while the speed -sin(t) of A is beyond a limit; ``speed(t)`` is B's position and speed."""

    def exact(t):
        s, v = speed(t)
        return np.stack([np.cos(t), s], 1), np.stack([-np.sin(t), v], 1)

    mechanism(
        name,
        "reported",
        "  Body A(m = 1, I = 1);\n  Body B(m = 1, I = 1);\n  Prismatic pa(ground, A.c);\n  Prismatic pb(ground, B.c);\n"
        f"  TranslationalSpringDamper la(pa, k = 1);\n  TranslationalSpringDamper lb(pb, force = -({law}));",
        lambda z, t: {"A": (z[0], 0.0, 0.0), "B": (z[1], 0.0, 0.0)},
        exact=exact,
        z=[1.0, 0.0],
        v=[0.0, 0.0],
        stop=6,
        start="  pa.s = 1;\n  pa.v = 0;\n  pb.s = 0;\n  pb.v = 0;",
        g=0.0,
        rounding=1e-8,  # the limit is 1e-6 from the largest speed, which is rounded
    )


LIMIT = 0.999999
HALF = acos(LIMIT)


def within(t):
    """Time since the limit was exceeded, at most its duration, and the time since then."""
    inside = np.clip(t - (1.5 * pi - HALF), 0.0, 2.0 * HALF)
    return inside, np.clip(t - (1.5 * pi + HALF), 0.0, None)


def constant(t):
    inside, after = within(t)
    return 1e3 * (inside**2 / 2 + inside * after), 1e3 * inside


def linear(t):
    inside, after = within(t)
    x = inside - HALF  # from the largest speed
    speed = 1e9 * (np.sin(x) + np.sin(HALF) - LIMIT * inside)
    way = 1e9 * (np.cos(HALF) - np.cos(x) + np.sin(HALF) * inside - LIMIT * inside**2 / 2)
    return way + speed * after, speed


limited("SpeedLimit", f"if pa.v > {LIMIT} then 1e3 else 0", constant)
limited("SpeedLimitMissed", "if pa.v > 1.000001 then 1e3 else 0", lambda t: (0.0 * t, 0.0 * t))
limited("SpeedLimitSoft", f"1e9*max(0, pa.v - {LIMIT})", linear)

# -- a rod that falls from the horizontal; B is pushed while its vertical reaction is beyond a limit -------------------
for name, below in (("ReactionLimit", 1e-2), ("ReactionLimitNear", 1e-5)):
    limit = 2.5 * G * (1 - below)
    mechanism(
        name,
        "reported",
        "  Rod rod(m = 1, length = 1);\n  Body B(m = 1, I = 1);\n  Revolute O(ground, rod.a);\n"
        "  Frame rail(ground, r = {0, 5});\n  Prismatic pb(rail, B.c);\n"
        f"  TranslationalSpringDamper lb(pb, force = -(if O.fy > {limit!r} then 10 else 0));",
        lambda z, t: {"rod": (0.5 * cos(z[0]), 0.5 * sin(z[0]), z[0]), "B": (z[1], 5.0, 0.0)},
        rate=lambda t, z, v, on: [-1.5 * G * np.cos(z[0]), 10.0 if on[0] else 0.0],
        switches=lambda t, z, v, limit=limit: (
            G + 0.5 * (-1.5 * G * np.cos(z[0]) ** 2 - v[0] ** 2 * np.sin(z[0])) - limit,
        ),
        z=[0.0, 0.0],
        v=[0.0, 0.0],
        stop=2,
        start="  rod.phi = 0;\n  rod.w = 0;\n  pb.s = 0;\n  pb.v = 0;",
        g=G,
    )

# -- long regular motions: errors grow in proportion to time -----------------------------------------------------------
for name, angle, stop in (("SwingFar", 2.4, 60), ("SwingOver", 2.8, 30)):
    mechanism(
        name,
        "reported",
        "  Rod rod(m = 1, length = 1);\n  Revolute O(ground, rod.a);",
        lambda z, t: {"rod": (0.5 * cos(z[0]), 0.5 * sin(z[0]), z[0])},
        rate=lambda t, z, v, on: [-1.5 * G * np.cos(z[0])],
        z=[angle - pi / 2],
        v=[0.0],
        stop=stop,
        start=f"  rod.phi = {angle - pi / 2!r};\n  rod.w = 0;",
        g=G,
    )

# -- runs far from t = 0: a driven oscillator, and a ball on a spring ------------------------------------------------
for name, begin in (("LateDrive", 86400.0), ("LatestDrive", 1e6)):
    phase, size = 3.0 * begin % (2 * pi), 10.0 / 91.0

    def driven(t, phase=phase, size=size):
        x0, v0 = 0.2 - size * np.sin(phase), -3 * size * np.cos(phase)
        x = x0 * np.cos(10 * t) + v0 / 10 * np.sin(10 * t) + size * np.sin(3 * t + phase)
        return x, v0 * np.cos(10 * t) - 10 * x0 * np.sin(10 * t) + 3 * size * np.cos(3 * t + phase)

    mechanism(
        name,
        "reported",
        "  Body A(m = 1, I = 1);\n  Prismatic j(ground, A.c);\n  TranslationalSpringDamper s(j, k = 100);\n"
        "  Force push(A.c, fx = 10*sin(3*time));",
        lambda z, t: {"A": (z[0], 0.0, 0.0)},
        exact=driven,
        z=[0.2],
        v=[0.0],
        stop=10,
        start="  j.s = 0.2;\n  j.v = 0;",
        g=0.0,
        begin=begin,
        rounding=3.0 * begin * 1e-16,
    )


def bouncing(t):
    """From 0.5 m onto a spring of 1e5 N/m: parabolas, and y = -g/k + A cos(w t) + B sin(w t) on the spring."""
    k, t0, y, v, above, y_at, v_at = 1e5, 0.0, 0.5, 0.0, True, np.zeros(len(t)), np.zeros(len(t))
    w, left = k**0.5, np.arange(len(t))
    while len(left):
        if above:
            lasts = (v + (v * v + 2 * G * y) ** 0.5) / G
            found = lambda s, y=y, v=v: (y + v * s - G * s * s / 2, v - G * s)  # noqa: E731
        else:
            a, b = y + G / k, v / w
            lasts = (2 * pi - acos(G / k / (a * a + b * b) ** 0.5) + np.arctan2(b, a)) % (2 * pi) / w
            found = lambda s, a=a, b=b: (  # noqa: E731
                -G / k + a * np.cos(w * s) + b * np.sin(w * s),
                w * (b * np.cos(w * s) - a * np.sin(w * s)),
            )
        now = left[t[left] <= t0 + lasts]
        y_at[now], v_at[now] = found(t[now] - t0)
        (_, v), y, t0, above, left = found(lasts), 0.0, t0 + lasts, not above, left[len(now) :]
    return y_at, v_at


for name, begin in (("Floor", 0.0), ("LateFloor", 86400.0)):
    mechanism(
        name,
        "reported",
        "  Body A(m = 1, I = 1);\n  Frame rail(ground, phi = 90 deg);\n  Prismatic j(rail, A.c);\n"
        "  Force floor(A.c, fy = if A.y < 0 then -1e5*A.y else 0);",
        lambda z, t: {"A": (0.0, z[0], pi / 2)},
        exact=bouncing,
        z=[0.5],
        v=[0.0],
        stop=2,
        start="  j.s = 0.5;\n  j.v = 0;",
        g=G,
        begin=begin,
        rounding=5e-9 if begin else 1e-13,  # of times late in a day, 1.5e-11 s, at 100 g in the contact
    )

__all__ = ["CLAIMS"]
