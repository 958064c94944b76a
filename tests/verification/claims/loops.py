"""Slider cranks, four-bar linkages and parallelograms."""

from __future__ import annotations

from math import pi, sqrt, tanh

import numpy as np
from claim import G
from jets import Jet, acos, asin, atan2, cos, sin
from jets import sqrt as root
from mechanisms import around, bell, mechanism, rod
from scipy.special import erf


# -- slider cranks -------------------------------------------------------------------------------------------------
def slider_crank(
    name, family, extra="", *, a=0.5, w=0.0, r=0.3, l=0.6, stop=2.0, pull=None, m=1.0, motion=None, **more
):
    body = f"""  Rod crank(m = {m!r}, length = {r!r});
  Rod rod(m = {m / 2!r}, length = {l!r});
  Revolute O(ground, crank.a);
  Revolute A(crank.b, rod.a);
  PointOnLine B(ground, rod.b);
{extra}"""
    angle = "  guess crank.phi = {};" if motion else "  crank.phi = {};\n  crank.w = {};"
    start = angle.format(repr(a), repr(w)) + f"\n  guess rod.phi = {-float(np.arcsin(r / l * np.sin(a)))!r};"

    def pose(z, t):
        b = -asin(r / l * sin(z[0]))
        x, y = r * cos(z[0]), r * sin(z[0])
        return {
            "crank": (0.5 * x, 0.5 * y, z[0]),
            "rod": (x + l / 2 * cos(b), y + l / 2 * sin(b), b),
            "rod.b": (x + l * cos(b), None, None),
        }

    mechanism(
        name,
        family,
        body,
        pose,
        z=[a],
        v=[w],
        stop=stop,
        start=start,
        masses={"crank": rod(m, r), "rod": rod(m / 2, l)},
        loads=pull,
        **more,
    )


def on_slider(force):
    return lambda t, p, v, on: {"rod.b": (force(t, p["rod.b"][0], v["rod.b"][0], on), 0, 0)}


def on_crank(torque):
    return lambda t, p, v, on: {"crank": (0, 0, torque(t, p["crank"][2], v["crank"][2], on))}


SLIDER, CRANK = "  Force load(rod.b, fx = {});", "  Torque motor(O, tau = {});"
slider_crank(
    "CrankPulse",
    "pulses",
    CRANK.format("500*exp(-((time - 1.234)/2e-3)^2)"),
    pull=on_crank(lambda t, a, w, on: bell(t, 1.234, 2e-3, 500)),
    breaks=around(1.234, 2e-3),
)
slider_crank(
    "CrankTable",
    "pulses",
    "  Table peak(table = [0, 0; 1.5, 0; 1.502, 400; 1.504, 0; 3, 0]);\n" + CRANK.format("peak(time)"),
    pull=on_crank(lambda t, a, w, on: 400 * max(0.0, 1 - abs(t - 1.502) / 2e-3)),
    breaks=[1.5, 1.502, 1.504],
)
slider_crank(
    "CrankWindow",
    "windows",
    SLIDER.format("-3e3*exp(-((1*rod.b.x - 0.6)/1e-3)^2)"),
    w=6.0,
    stop=1.5,
    pull=on_slider(lambda t, x, v, on: -bell(x, 0.6, 1e-3, 3e3)),
)
slider_crank("CrankFold", "singular", l=0.3003, w=8.0)
slider_crank("CrankFoldNear", "singular", l=0.30003, w=8.0, stop=1.0)
slider_crank(
    "CrankDeadCentre",
    "growth",
    SLIDER.format("-200"),
    a=1e-7,
    stop=0.5,
    g=0.0,
    pull=on_slider(lambda t, x, v, on: -200.0),
)
slider_crank("CrankMicrometres", "scales", r=3e-6, l=6e-6, m=1e-9, stop=0.005)
slider_crank("CrankKilometres", "scales", r=3e3, l=6e3, m=1e6, stop=150.0)
slider_crank(
    "CrankStop",
    "bouncing",
    SLIDER.format("if rod.b.x < 0.45 then -1e5*(1*rod.b.x - 0.45) else 0"),
    w=5.0,
    pull=on_slider(lambda t, x, v, on: 0 if on[0] else -1e5 * (x - 0.45)),
    stop=1.5,
    switches=lambda t, z, v: (0.3 * np.cos(z[0]) + np.sqrt(0.36 - 0.09 * np.sin(z[0]) ** 2) - 0.45,),
)
slider_crank(
    "CrankFriction",
    "friction",
    SLIDER.format("-10*tanh(1*rod.b.vx/1e-3)"),
    w=10.0,
    stop=3.0,
    g=0.0,
    pull=on_slider(lambda t, x, v, on: -10 * tanh(v / 1e-3)),
)
slider_crank(
    "CrankMotor",
    "cycles",
    CRANK.format("5*tanh(10*(20 - 1*O.w))"),
    w=0.0,
    pull=on_crank(lambda t, a, w, on: 5 * tanh(10 * (20 - w))),
)
slider_crank("CrankSpin", "long", w=30.0, stop=20.0, g=0.0)
slider_crank(
    "CrankDriven",
    "drivers",
    "  RotationalDriver drive(O, phi = 0.5 + 2*time + 0.2*exp(-((1*time - 1.111)/5e-3)^2));",
    motion=True,
    exact=lambda t: (
        0.5 + 2 * t + 0.2 * np.exp(-(((t - 1.111) / 5e-3) ** 2)),
        2 - 0.4 * (t - 1.111) / 2.5e-5 * np.exp(-(((t - 1.111) / 5e-3) ** 2)),
    ),
)
slider_crank(
    "CrankVelocityDriven",
    "drivers",
    "  RotationalVelocityDriver drive(O, w = 2 + 300*exp(-((time - 1.111)/1e-3)^2));",
    w=2.0,
    exact=lambda t: (
        0.5 + 2 * t + 0.15 * sqrt(pi) * (1 + erf((t - 1.111) / 1e-3)),
        2 + 300 * np.exp(-(((t - 1.111) / 1e-3) ** 2)),
    ),
)


# -- four-bar linkages ---------------------------------------------------------------------------------------------
def four_bar(name, family, lengths, extra="", *, a, w=0.0, stop, pull=None, branch=1.0, g=G, **more):
    """Crank, coupler and rocker of ``lengths``; the last is the distance of the ground's pins."""
    r, c, l, d = lengths

    def pose(z, t):
        x, y = r * cos(z[0]), r * sin(z[0])
        ex, ey = d - x, -1 * y
        far = ex * ex + ey * ey
        gamma = acos((far + (c * c - l * l)) / (2 * c * root(far)))
        b = atan2(ey, ex) + branch * gamma
        bx, by = x + c * cos(b), y + c * sin(b)
        e = atan2(by, bx - d)
        return {
            "crank": (0.5 * x, 0.5 * y, z[0]),
            "coupler": (x + c / 2 * cos(b), y + c / 2 * sin(b), b),
            "rocker": (d + l / 2 * cos(e), l / 2 * sin(e), None),
        }

    at = pose([Jet(float(a))], 0.0)
    body = f"""  Frame base(ground, r = {{{d!r}, 0}});
  Rod crank(m = 1.0, length = {r!r});
  Rod coupler(m = 1.0, length = {c!r});
  Rod rocker(m = 1.0, length = {l!r});
  Revolute O(ground, crank.a);
  Revolute A(crank.b, coupler.a);
  Revolute B(coupler.b, rocker.b);
  Revolute C(base, rocker.a);
{extra}"""
    x, y = at["rocker"][0].f - d, at["rocker"][1].f
    start = f"  crank.phi = {a!r};\n  crank.w = {w!r};\n  guess coupler.phi = {float(at['coupler'][2].f)!r};\n"
    start += f"  guess rocker.phi = {float(np.arctan2(y, x))!r};"

    def whole(z, t):
        found = pose(z, t)
        # the rocker's angle is its own body's, continuous as the rocker does not turn over
        ex, ey = found["rocker"][0] - d, found["rocker"][1]
        return {**found, "rocker": (*found["rocker"][:2], atan2(ey, ex))}

    mechanism(
        name,
        family,
        body,
        whole,
        z=[a],
        v=[w],
        stop=stop,
        start=start,
        g=g,
        loads=pull,
        masses={"crank": rod(1.0, r), "coupler": rod(1.0, c), "rocker": rod(1.0, l)},
        **more,
    )


four_bar(
    "LinkagePulse",
    "pulses",
    (0.3, 0.8, 0.6, 0.9),
    CRANK.format("400*exp(-((time - 1.321)/2e-3)^2)"),
    a=1.0,
    stop=2,
    pull=on_crank(lambda t, a, w, on: bell(t, 1.321, 2e-3, 400)),
    breaks=around(1.321, 2e-3),
)
four_bar("LinkageChangePoint", "singular", (0.3, 0.8, 0.601, 1.1), a=1.0, w=6.0, stop=2)
four_bar(
    "LinkageMotor",
    "cycles",
    (0.3, 0.8, 0.6, 0.9),
    CRANK.format("8*tanh(5*(12 - 1*O.w))"),
    a=1.0,
    stop=2,
    pull=on_crank(lambda t, a, w, on: 8 * tanh(5 * (12 - w))),
)


# -- parallelograms, one constraint too many -----------------------------------------------------------------------
def parallelogram(name, family, extra="", *, a=-2.0, w=0.0, stop=4.0, pull=None, **more):
    """A plate on three parallel bars."""
    body = f"""  Frame base[3](ground, r = {{{{0, 0}}, {{1, 0}}, {{2, 0}}}});
  Rod bar[3](each m = 1.0, each length = 0.5);
  Body plate(m = 2.0, I = 0.7, frames(P1 = {{-1, 0}}, P2 = {{0, 0}}, P3 = {{1, 0}}));
  Revolute foot[3](base, bar.a);
  Revolute top1(bar[1].b, plate.P1);
  Revolute top2(bar[2].b, plate.P2);
  Revolute top3(bar[3].b, plate.P3);
{extra}"""
    start = f"  bar[1].phi = {a!r};\n  bar[1].w = {w!r};\n  guess plate.phi = 0;"
    start += f"\n  guess bar[2].phi = {a!r};\n  guess bar[3].phi = {a!r};"

    def pose(z, t):
        x, y = 0.5 * cos(z[0]), 0.5 * sin(z[0])
        bars = {f"bar[{i + 1}]": (i + 0.5 * x, 0.5 * y, z[0]) for i in range(3)}
        return {**bars, "plate": (1 + x, y, None)}

    masses = {f"bar[{i}]": rod(1.0, 0.5) for i in (1, 2, 3)} | {"plate": (2.0, 0.7)}
    mechanism(name, family, body, pose, z=[a], v=[w], stop=stop, start=start, masses=masses, loads=pull, **more)


parallelogram("PlateSwings", "redundant")
parallelogram(
    "PlatePulse",
    "redundant",
    "  Force kick(plate.c, fx = 500*exp(-((time - 2.468)/2e-3)^2));",
    a=-pi / 2,
    pull=lambda t, p, v, on: {"plate": (bell(t, 2.468, 2e-3, 500), 0, 0)},
    breaks=around(2.468, 2e-3),
)
parallelogram(
    "PlateOver",
    "redundant",
    "  Force push(plate.c, fx = 3*sin(20*time));",
    a=-2.8,
    pull=lambda t, p, v, on: {"plate": (3 * np.sin(20 * t), 0, 0)},
)
