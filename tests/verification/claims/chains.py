"""Rods on pins: one, two and more."""

from __future__ import annotations

from math import pi

import numpy as np
from claim import G
from jets import cos, sin
from mechanisms import around, bell, mechanism, rod


# -- one rod on a pin ----------------------------------------------------------------------------------------------
def pendulum(name, family, extra="", *, a, w=0.0, stop, length=1.0, m=1.0, pull=None, mu="", **more):
    body = f"  Rod bar(m = {m!r}, length = {length!r});\n  Revolute pin(ground, bar.a{mu});\n{extra}"
    start = f"  bar.phi = {a!r};\n  bar.w = {w!r};"
    loads = None if pull is None else lambda t, p, v, on: {"bar": (0, 0, pull(t, p["bar"][2], v["bar"][2], on))}

    def pose(z, t):
        return {"bar": (length / 2 * cos(z[0]), length / 2 * sin(z[0]), z[0])}

    mechanism(
        name,
        family,
        body,
        pose,
        z=[a],
        v=[w],
        stop=stop,
        start=start,
        masses={"bar": rod(m, length)},
        loads=loads,
        **more,
    )


TORQUE = "  Torque motor(pin, tau = {});"
pendulum("BarUpright", "growth", a=pi / 2 + 1e-7, stop=5)
pendulum(
    "BarPulse",
    "pulses",
    TORQUE.format("200*exp(-((time - 2.345)/1e-3)^2)"),
    a=-pi / 2,
    stop=4,
    pull=lambda t, a, w, on: bell(t, 2.345, 1e-3, 200),
    breaks=around(2.345, 1e-3),
)
pendulum(
    "BarWindow",
    "windows",
    TORQUE.format("if bar.phi > -1.2001 and bar.phi < -1.2 then 500 else 0"),
    a=0.0,
    stop=3,
    pull=lambda t, a, w, on: 500 if on[0] and not on[1] else 0,
    switches=lambda t, z, v: (z[0] + 1.2001, z[0] + 1.2),
)
pendulum(
    "BarStop",
    "bouncing",
    TORQUE.format("if bar.phi < -2.5 then -1e5*(bar.phi + 2.5) else 0"),
    a=0.0,
    stop=3,
    pull=lambda t, a, w, on: 0 if on[0] else -1e5 * (a + 2.5),
    switches=lambda t, z, v: (z[0] + 2.5,),
)
pendulum(
    "BarGraze",
    "grazing",
    TORQUE.format("if bar.phi < -3.14 then -1e5*(bar.phi + 3.14) else 0"),
    a=0.0,
    stop=4,
    pull=lambda t, a, w, on: 0 if on[0] else -1e5 * (a + 3.14),
    switches=lambda t, z, v: (z[0] + 3.14,),
)
pendulum("BarLong", "long", a=0.5, stop=300)
pendulum("BarMillimetre", "scales", a=0.0, length=1e-3, m=1e-6, stop=0.3)
pendulum("BarTenKilometres", "scales", a=0.0, length=1e4, m=1e6, stop=600)


def pin_friction(t, z, v, on, m=1.0, l=1.0, mu=0.3, r=0.02, ws=0.5):
    """With N of the pin, which depends on the acceleration: Newton's iteration, by differences."""
    a, w = z[0], v[0]

    def rest(alpha):
        ax = -l / 2 * (np.sin(a) * alpha + np.cos(a) * w * w)
        ay = l / 2 * (np.cos(a) * alpha - np.sin(a) * w * w)
        N = np.hypot(m * ax, m * (ay + G))
        return m * l * l / 3 * alpha + m * G * l / 2 * np.cos(a) + N * mu * r * np.tanh(w / ws)

    x = -1.5 * G / l * np.cos(a)
    for _ in range(20):
        slope = (rest(x + 1e-6) - rest(x - 1e-6)) / 2e-6
        change = rest(x) / slope
        x -= change
        if abs(change) < 1e-14 * max(abs(x), 1.0):
            break
    return x


pendulum("BarPinFriction", "friction", a=0.0, stop=6, mu=", mu = 0.3, radius = 0.02, w_s = 0.5", rate=pin_friction)


# -- two, and more -------------------------------------------------------------------------------------------------
def chain(name, family, angles, *, stop, k=0.0, c=0.0, extra="", length=1.0, m=1.0, rates=None, pull=None, **more):
    """Rods one on the other, springs between them where ``k`` is given; ``pull`` gives torques on the rods."""
    n = len(angles)
    lines = [f"  Rod bar{i + 1}(m = {m!r}, length = {length!r});" for i in range(n)]
    ends = ["ground", *(f"bar{i}.b" for i in range(1, n))]
    lines += [f"  Revolute pin{i + 1}({end}, bar{i + 1}.a);" for i, end in enumerate(ends)]
    if k:
        lines += [f"  RotationalSpringDamper s{i + 1}(pin{i + 1}, k = {k!r}, c = {c!r});" for i in range(n)]
    rates = rates or [0.0] * n
    start = "\n".join(
        f"  bar{i + 1}.phi = {a!r};\n  bar{i + 1}.w = {w!r};"
        for i, (a, w) in enumerate(zip(angles, rates, strict=True))
    )

    def pose(z, t):
        x, y, found = 0.0, 0.0, {}
        for i in range(n):
            dx, dy = length / 2 * cos(z[i]), length / 2 * sin(z[i])
            found[f"bar{i + 1}"] = (x + dx, y + dy, z[i])
            x, y = x + 2 * dx, y + 2 * dy
        found[f"bar{n}.b"] = (x, y, None)
        return found

    def loads(t, p, v, on):
        a, w = ([0.0, *(of[f"bar{i + 1}"][2] for i in range(n))] for of in (p, v))
        springs = [k * (a[i + 1] - a[i]) + c * (w[i + 1] - w[i]) for i in range(n)] + [0.0]
        found = {f"bar{i + 1}": [0.0, 0.0, springs[i + 1] - springs[i]] for i in range(n)}
        for body, force in (pull(t, p, v, on) if pull else {}).items():
            found[body] = [x + y for x, y in zip(found.get(body, (0.0, 0.0, 0.0)), force, strict=True)]
        return found

    mechanism(
        name,
        family,
        "\n".join(lines) + "\n" + extra,
        pose,
        z=angles,
        v=rates,
        stop=stop,
        start=start,
        masses={f"bar{i + 1}": rod(m, length) for i in range(n)},
        loads=loads,
        **more,
    )


chain("TwoBars", "chaos", [1.0, 1.5], stop=6)
chain("TwoBarsLong", "chaos", [2.0, 2.5], stop=10)
chain("TwoBarsUpright", "growth", [pi / 2 + 1e-6, pi / 2], stop=4)
chain(
    "TwoBarsPulse",
    "pulses",
    [-pi / 2, -pi / 2],
    stop=3,
    extra="  Force kick(bar2.b, fx = 300*exp(-((time - 1.777)/2e-3)^2));",
    pull=lambda t, p, v, on: {"bar2.b": (bell(t, 1.777, 2e-3, 300), 0, 0)},
    breaks=around(1.777, 2e-3),
)
chain("TwoBarsStiff", "flexible", [0.0, 0.0], stop=2, k=1e4, c=0.1)
chain(
    "FourBarsStiff",
    "flexible",
    [0.0, 0.0, 0.0, 0.0],
    stop=0.5,
    length=0.25,
    m=0.1,
    k=200.0,
    c=0.01,
    extra="  Force kick(bar4.b, fy = 100*exp(-((time - 0.3117)/1e-3)^2));",
    pull=lambda t, p, v, on: {"bar4.b": (0, bell(t, 0.3117, 1e-3, 100), 0)},
    breaks=around(0.3117, 1e-3),
)
chain("ThreeBarsSlack", "chaos", [0.3, 0.6, 0.9], stop=3, k=1.0)
