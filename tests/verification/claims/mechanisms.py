"""Claims that are mechanisms; their poses by hand in minimal coordinates."""

from __future__ import annotations

from math import exp, pi, sqrt, tanh

import numpy as np
from claim import Claim, G
from jets import acos, asin, atan2, cos, sin
from scipy.special import erf

CLAIMS: dict[str, Claim] = {}


def mechanism(name, family, body, pose, *, z, v, stop, start, masses=None, g=G, **more):
    text = f"model {name}\n  Ground ground(g = {g!r});\n{body}\ninitial equation\n{start}\n"
    text += f"  annotation(experiment(StopTime = {float(stop)!r}));\nend {name};\n"
    z, v = (list(map(float, x)) for x in (z, v))
    CLAIMS[name] = Claim(name, family, text, float(stop), pose, z, v, masses=masses, g=g, **more)


def bell(t, at, width, height=1.0):
    return height * exp(-(((t - at) / width) ** 2))


def around(at, width):
    """Where the reference of a pulse starts anew."""
    return [at + k * width for k in (-8, -3, 0, 3, 8)]


def rod(m, length):
    return m, m * length**2 / 12


# -- one rod on a pin ------------------------------------------------------------------------------------------------
def pendulum(name, family, extra="", *, a, w=0.0, stop, length=1.0, m=1.0, pull=None, mu="", **more):
    body = f"  Rod bar(m = {m!r}, length = {length!r});\n  Revolute pin(ground, bar.a{mu});\n{extra}"
    start = f"  bar.phi = {a!r};\n  bar.w = {w!r};"
    loads = None if pull is None else lambda t, p, v, on: {"bar": (0, 0, pull(t, p["bar"][2], v["bar"][2], on))}

    def pose(z, t):
        return {"bar": (length / 2 * cos(z[0]), length / 2 * sin(z[0]), z[0])}

    mechanism(name, family, body, pose, z=[a], v=[w], stop=stop, start=start, masses={"bar": rod(m, length)},
              loads=loads, **more)  # fmt: skip


TORQUE = "  Torque motor(pin, tau = {});"
pendulum("BarUpright", "growth", a=pi / 2 + 1e-7, stop=5)
pendulum("BarPulse", "pulses", TORQUE.format("200*exp(-((time - 2.345)/1e-3)^2)"), a=-pi / 2, stop=4,
         pull=lambda t, a, w, on: bell(t, 2.345, 1e-3, 200), breaks=around(2.345, 1e-3))  # fmt: skip
pendulum("BarWindow", "windows", TORQUE.format("if bar.phi > -1.2001 and bar.phi < -1.2 then 500 else 0"), a=0.0, stop=3,
         pull=lambda t, a, w, on: 500 if on[0] and not on[1] else 0,
         switches=lambda t, z, v: (z[0] + 1.2001, z[0] + 1.2))  # fmt: skip
pendulum("BarStop", "bouncing", TORQUE.format("if bar.phi < -2.5 then -1e5*(bar.phi + 2.5) else 0"), a=0.0, stop=3,
         pull=lambda t, a, w, on: 0 if on[0] else -1e5 * (a + 2.5), switches=lambda t, z, v: (z[0] + 2.5,))  # fmt: skip
pendulum("BarGraze", "grazing", TORQUE.format("if bar.phi < -3.14 then -1e5*(bar.phi + 3.14) else 0"), a=0.0, stop=4,
         pull=lambda t, a, w, on: 0 if on[0] else -1e5 * (a + 3.14), switches=lambda t, z, v: (z[0] + 3.14,))  # fmt: skip
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


# -- two, and more ---------------------------------------------------------------------------------------------------
def chain(name, family, angles, *, stop, k=0.0, c=0.0, extra="", length=1.0, m=1.0, rates=None, pull=None, **more):
    """Rods one on the other, springs between them where ``k`` is given; ``pull`` gives torques on the rods."""
    n = len(angles)
    lines = [f"  Rod bar{i + 1}(m = {m!r}, length = {length!r});" for i in range(n)]
    ends = ["ground", *(f"bar{i}.b" for i in range(1, n))]
    lines += [f"  Revolute pin{i + 1}({end}, bar{i + 1}.a);" for i, end in enumerate(ends)]
    if k:
        lines += [f"  RotationalSpringDamper s{i + 1}(pin{i + 1}, k = {k!r}, c = {c!r});" for i in range(n)]
    rates = rates or [0.0] * n
    start = "\n".join(f"  bar{i + 1}.phi = {a!r};\n  bar{i + 1}.w = {w!r};" for i, (a, w) in enumerate(zip(angles, rates)))

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

    mechanism(name, family, "\n".join(lines) + "\n" + extra, pose, z=angles, v=rates, stop=stop, start=start,
              masses={f"bar{i + 1}": rod(m, length) for i in range(n)}, loads=loads, **more)  # fmt: skip


chain("TwoBars", "chaos", [1.0, 1.5], stop=6)
chain("TwoBarsLong", "chaos", [2.0, 2.5], stop=20)
chain("TwoBarsUpright", "growth", [pi / 2 + 1e-6, pi / 2], stop=4)
chain("TwoBarsPulse", "pulses", [-pi / 2, -pi / 2], stop=3, extra="  Force kick(bar2.b, fx = 300*exp(-((time - 1.777)/2e-3)^2));",
      pull=lambda t, p, v, on: {"bar2.b": (bell(t, 1.777, 2e-3, 300), 0, 0)}, breaks=around(1.777, 2e-3))  # fmt: skip
chain("TwoBarsStiff", "flexible", [0.0, 0.0], stop=2, k=1e4, c=0.1)
chain("FourBarsStiff", "flexible", [0.0, 0.0, 0.0, 0.0], stop=0.5, length=0.25, m=0.1, k=200.0, c=0.01,
      extra="  Force kick(bar4.b, fy = 100*exp(-((time - 0.3117)/1e-3)^2));",
      pull=lambda t, p, v, on: {"bar4.b": (0, bell(t, 0.3117, 1e-3, 100), 0)}, breaks=around(0.3117, 1e-3))  # fmt: skip
chain("ThreeBarsSlack", "chaos", [0.3, 0.6, 0.9], stop=3, k=1.0)


# -- slider cranks ---------------------------------------------------------------------------------------------------
def slider_crank(name, family, extra="", *, a=0.5, w=0.0, r=0.3, l=0.6, stop=2.0, pull=None, m=1.0, motion=None, **more):
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

    mechanism(name, family, body, pose, z=[a], v=[w], stop=stop, start=start, masses={"crank": rod(m, r), "rod": rod(m / 2, l)},
              loads=pull, **more)  # fmt: skip


def on_slider(force):
    return lambda t, p, v, on: {"rod.b": (force(t, p["rod.b"][0], v["rod.b"][0], on), 0, 0)}


def on_crank(torque):
    return lambda t, p, v, on: {"crank": (0, 0, torque(t, p["crank"][2], v["crank"][2], on))}


SLIDER, CRANK = "  Force load(rod.b, fx = {});", "  Torque motor(O, tau = {});"
slider_crank("CrankPulse", "pulses", CRANK.format("500*exp(-((time - 1.234)/2e-3)^2)"),
             pull=on_crank(lambda t, a, w, on: bell(t, 1.234, 2e-3, 500)), breaks=around(1.234, 2e-3))  # fmt: skip
slider_crank("CrankTable", "pulses", "  Table peak(table = [0, 0; 1.5, 0; 1.502, 400; 1.504, 0; 3, 0]);\n" + CRANK.format("peak(time)"),
             pull=on_crank(lambda t, a, w, on: 400 * max(0.0, 1 - abs(t - 1.502) / 2e-3)),
             breaks=[1.5, 1.502, 1.504])  # fmt: skip
slider_crank("CrankWindow", "windows", SLIDER.format("-3e3*exp(-((1*rod.b.x - 0.6)/1e-3)^2)"), w=6.0, stop=1.5,
             pull=on_slider(lambda t, x, v, on: -bell(x, 0.6, 1e-3, 3e3)))  # fmt: skip
slider_crank("CrankFold", "singular", l=0.3003, w=8.0)
slider_crank("CrankFoldNear", "singular", l=0.30003, w=8.0, stop=1.0)
slider_crank("CrankDeadCentre", "growth", SLIDER.format("-200"), a=1e-7, stop=1.2, g=0.0,
             pull=on_slider(lambda t, x, v, on: -200.0))  # fmt: skip
slider_crank("CrankMicrometres", "scales", r=3e-6, l=6e-6, m=1e-9, stop=0.005)
slider_crank("CrankKilometres", "scales", r=3e3, l=6e3, m=1e6, stop=150.0)
slider_crank("CrankStop", "bouncing", SLIDER.format("if rod.b.x < 0.45 then -1e5*(1*rod.b.x - 0.45) else 0"), w=5.0,
             pull=on_slider(lambda t, x, v, on: 0 if on[0] else -1e5 * (x - 0.45)), stop=1.5,
             switches=lambda t, z, v: (0.3 * np.cos(z[0]) + np.sqrt(0.36 - 0.09 * np.sin(z[0]) ** 2) - 0.45,))  # fmt: skip
slider_crank("CrankFriction", "friction", SLIDER.format("-10*tanh(1*rod.b.vx/1e-3)"), w=10.0, stop=3.0, g=0.0,
             pull=on_slider(lambda t, x, v, on: -10 * tanh(v / 1e-3)))  # fmt: skip
slider_crank("CrankMotor", "cycles", CRANK.format("5*tanh(10*(20 - 1*O.w))"), w=0.0,
             pull=on_crank(lambda t, a, w, on: 5 * tanh(10 * (20 - w))))  # fmt: skip
slider_crank("CrankSpin", "long", w=30.0, stop=20.0, g=0.0)
slider_crank("CrankDriven", "drivers", "  RotationalDriver drive(O, phi = 0.5 + 2*time + 0.2*exp(-((1*time - 1.111)/5e-3)^2));",
             motion=True, exact=lambda t: (0.5 + 2 * t + 0.2 * np.exp(-(((t - 1.111) / 5e-3) ** 2)),
             2 - 0.4 * (t - 1.111) / 2.5e-5 * np.exp(-(((t - 1.111) / 5e-3) ** 2))))  # fmt: skip
slider_crank("CrankVelocityDriven", "drivers", "  RotationalVelocityDriver drive(O, w = 2 + 300*exp(-((time - 1.111)/1e-3)^2));",
             w=2.0, exact=lambda t: (0.5 + 2 * t + 0.15 * sqrt(pi) * (1 + erf((t - 1.111) / 1e-3)),
             2 + 300 * np.exp(-(((t - 1.111) / 1e-3) ** 2))))  # fmt: skip


# -- four-bar linkages ------------------------------------------------------------------------------------------------
def four_bar(name, family, lengths, extra="", *, a, w=0.0, stop, pull=None, branch=1.0, g=G, **more):
    """Crank, coupler and rocker of ``lengths``; the last is the distance of the ground's pins."""
    r, c, l, d = lengths

    def pose(z, t):
        x, y = r * cos(z[0]), r * sin(z[0])
        ex, ey = d - x, -1 * y
        far = ex * ex + ey * ey
        gamma = acos((far + (c * c - l * l)) / (2 * c * (far_root(far))))
        b = atan2(ey, ex) + branch * gamma
        bx, by = x + c * cos(b), y + c * sin(b)
        e = atan2(by, bx - d)
        return {
            "crank": (0.5 * x, 0.5 * y, z[0]),
            "coupler": (x + c / 2 * cos(b), y + c / 2 * sin(b), b),
            "rocker": (d + l / 2 * cos(e), l / 2 * sin(e), None),
        }

    from jets import Jet
    from jets import sqrt as root

    def far_root(x):
        return root(x)

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

    mechanism(name, family, body, whole, z=[a], v=[w], stop=stop, start=start, g=g, loads=pull,
              masses={"crank": rod(1.0, r), "coupler": rod(1.0, c), "rocker": rod(1.0, l)}, **more)  # fmt: skip


four_bar("LinkagePulse", "pulses", (0.3, 0.8, 0.6, 0.9), CRANK.format("400*exp(-((time - 1.321)/2e-3)^2)"), a=1.0, stop=2,
         pull=on_crank(lambda t, a, w, on: bell(t, 1.321, 2e-3, 400)), breaks=around(1.321, 2e-3))  # fmt: skip
four_bar("LinkageChangePoint", "singular", (0.3, 0.8, 0.601, 1.1), a=1.0, w=6.0, stop=2)
four_bar("LinkageMotor", "cycles", (0.3, 0.8, 0.6, 0.9), CRANK.format("8*tanh(5*(12 - 1*O.w))"), a=1.0, stop=2,
         pull=on_crank(lambda t, a, w, on: 8 * tanh(5 * (12 - w))))  # fmt: skip


# -- parallelograms, one constraint too many ---------------------------------------------------------------------------
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
    start = f"  bar[1].phi = {a!r};\n  bar[1].w = {w!r};\n  guess bar[2].phi = {a!r};\n  guess bar[3].phi = {a!r};\n  guess plate.phi = 0;"

    def pose(z, t):
        x, y = 0.5 * cos(z[0]), 0.5 * sin(z[0])
        bars = {f"bar[{i + 1}]": (i + 0.5 * x, 0.5 * y, z[0]) for i in range(3)}
        return {**bars, "plate": (1 + x, y, None)}

    masses = {f"bar[{i}]": rod(1.0, 0.5) for i in (1, 2, 3)} | {"plate": (2.0, 0.7)}
    mechanism(name, family, body, pose, z=[a], v=[w], stop=stop, start=start, masses=masses, loads=pull, **more)


parallelogram("PlateSwings", "redundant")
parallelogram("PlatePulse", "redundant", "  Force kick(plate.c, fx = 500*exp(-((time - 2.468)/2e-3)^2));", a=-pi / 2,
              pull=lambda t, p, v, on: {"plate": (bell(t, 2.468, 2e-3, 500), 0, 0)}, breaks=around(2.468, 2e-3))  # fmt: skip
parallelogram("PlateOver", "redundant", "  Force push(plate.c, fx = 3*sin(20*time));", a=-2.8,
              pull=lambda t, p, v, on: {"plate": (3 * np.sin(20 * t), 0, 0)})  # fmt: skip


# -- conditions on velocities ------------------------------------------------------------------------------------------
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
    return (np.stack([x, y, w * t], 1),
            np.stack([speed * np.cos(w * t), speed * np.sin(w * t), w + 0 * t], 1))  # fmt: skip


def sliding(t, z, v, on):
    """A blade below the centre, pushed along by a pulse, while it turns."""
    along = v[0] * np.cos(z[2]) + v[1] * np.sin(z[2])
    push = bell(t, 3.21, 2e-3, 500) / 2.0
    return [push * np.cos(z[2]) - along * v[2] * np.sin(z[2]), push * np.sin(z[2]) + along * v[2] * np.cos(z[2]), 0.0]


def sleigh(t, z, v, on, a=0.1, m=2.0, I=0.3):
    """Chaplygin's: z are those of the blade."""
    along = v[0] * np.cos(z[2]) + v[1] * np.sin(z[2])
    grows, turns = a * v[2] ** 2, -m * a * along * v[2] / (I + m * a * a)
    return [grows * np.cos(z[2]) - along * v[2] * np.sin(z[2]), grows * np.sin(z[2]) + along * v[2] * np.cos(z[2]), turns]


PLACE = "  skate.x = 0; skate.y = 0; skate.phi = 0; skate.w = {}; blade.v = {};"
blade("KnifeSlope", "nonholonomic", "  KnifeEdge blade(skate.c);", exact=on_slope, z=[0, 0, 0], v=[0, 0, 1.5], stop=10,
      start=PLACE.format(1.5, 0), g=4.905, n="{1, 0}")  # fmt: skip
blade("KnifePulse", "nonholonomic", "  KnifeEdge blade(skate.c);\n  Force push(skate.c, skate.c, fx = 500*exp(-((time - 3.21)/2e-3)^2));",
      rate=sliding, z=[0, 0, 0], v=[0.2, 0, 0.7], stop=5, start=PLACE.format(0.7, 0.2), breaks=around(3.21, 2e-3))  # fmt: skip
blade("Sleigh", "nonholonomic", "  KnifeEdge blade(ground, skate.P);", rate=sleigh, z=[0, 0, 0], v=[1, 0, 2], stop=20,
      pose=lambda z, t: {"skate": (z[0] + 0.1 * cos(z[2]), z[1] + 0.1 * sin(z[2]), z[2])},
      start="  skate.P.x = 0; skate.P.y = 0; skate.phi = 0; skate.w = 2; blade.v = 1;")  # fmt: skip


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

    mechanism(name, family, body, pose, z=[0.3], v=[v], stop=stop, start=f"  contact.s = 0.3; contact.v = {v!r}; disc.phi = 0;",
              rate=lambda t, z, v, on: (2 * G * s - 50 * (z[0] - 0.3) + push(t, z[0], v[0], on)) / 3.0, **more)  # fmt: skip


disc("DiscPulse", "nonholonomic", "  Force kick(plane, disc.c, fx = 600*exp(-((time - 2.222)/2e-3)^2)*cos(-pi/6), fy = 600*exp(-((time - 2.222)/2e-3)^2)*sin(-pi/6));",
     lambda t, s, v, on: bell(t, 2.222, 2e-3, 600), breaks=around(2.222, 2e-3))  # fmt: skip
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
    mechanism(name, family, body, pose, z=[0], v=[0], stop=stop, exact=exact, rate=rate,
              start="  one.phi = 0; one.w = 0; two.phi = 0;", **more)  # fmt: skip


gear("GearPulse", "gears", "30*exp(-((time - 4.56)/5e-3)^2)", lambda t, a, w, on: bell(t, 4.56, 5e-3, 30), stop=6,
     breaks=around(4.56, 5e-3))  # fmt: skip
gear("GearTable", "gears", "curve(O.w)", lambda t, a, w, on: np.interp(w, [0, 10, 30, 32, 34], [5, 4.5, 4, 3, -3]), stop=4,
     extra="  Table curve(table = [0, 5; 10, 4.5; 30, 4; 32, 3; 34, -3]);\n",
     switches=lambda t, z, v: tuple(v[0] - x for x in (10, 30, 32)))  # fmt: skip


# -- masses on springs in the plane; orbits --------------------------------------------------------------------------
for name, L in (("MetreSpring", 1.0), ("CentimetreSpring", 0.01), ("MillimetreSpring", 1e-3)):
    mechanism(name, "scales", f"  Frame p(ground, r = {{{L!r}, 0}});\n  PointMass b(m = 1);\n"
              f"  SpringDamper s(p, b, k = 1000, s0 = {2 * L!r});",
              lambda z, t: {"b": (z[0], 0.0, None)}, z=[3.2 * L], v=[0], stop=1, g=0.0,
              start=f"  b.x = {3.2 * L!r}; b.y = 0; b.vx = 0; b.vy = 0;",
              exact=lambda t, L=L: (3 * L + 0.2 * L * np.cos(sqrt(1000) * t),
                                    -0.2 * L * sqrt(1000) * np.sin(sqrt(1000) * t)))  # fmt: skip


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
        return (np.stack([np.cos(E) - e, b * np.sin(E)], 1),
                np.stack([-np.sin(E) * rate, b * np.cos(E) * rate], 1))  # fmt: skip

    return exact


for name, e, turns in (("Orbit", 0.9, 3), ("OrbitClose", 0.99, 2)):
    far, slow = -(1 + e), -sqrt((1 - e) / (1 + e))
    mechanism(name, "windows", "  PointMass b(m = 1);\n  SpringDamper s(ground, b, force = 1/(1*s)^2);",
              lambda z, t: {"b": (z[0], z[1], None)}, z=[far, 0], v=[0, slow], stop=2 * pi * turns, g=0.0,
              start=f"  b.x = {far!r}; b.y = 0; b.vx = 0; b.vy = {slow!r};", exact=kepler(e))  # fmt: skip

# -- friction of a slide ---------------------------------------------------------------------------------------------
mechanism("SlopeFriction", "friction", f"  Frame slope(ground, phi = {-pi / 9!r});\n  Body block(m = 1, I = 1);\n"
          "  Prismatic slide(slope, block.c, mu = 0.5, v_s = 0.01);",
          lambda z, t: {"block": (float(np.cos(pi / 9)) * z[0], -float(np.sin(pi / 9)) * z[0], None)}, z=[0], v=[2], stop=4,
          start="  slide.s = 0; slide.v = 2;",
          rate=lambda t, z, v, on: G * np.sin(pi / 9) - 0.5 * G * np.cos(pi / 9) * np.tanh(v[0] / 0.01))  # fmt: skip

# -- a compliant joint, and a pulse on it ------------------------------------------------------------------------------
mechanism("BushingPulse", "flexible", "  Body block(m = 2, I = 0.1);\n  Bushing mount(ground, block.c, k = {1e5, 1e3}, c = {20, 2});\n"
          "  Force kick(block.c, fx = 1e3*exp(-((time - 1.357)/1e-3)^2));",
          lambda z, t: {"block": (z[0], z[1], None)}, z=[0, 0], v=[0, 0], stop=2,
          start="  block.x = 0; block.y = 0; block.vx = 0; block.vy = 0; block.phi = 0; block.w = 0;",
          rate=lambda t, z, v, on: [(bell(t, 1.357, 1e-3, 1e3) - 1e5 * z[0] - 20 * v[0]) / 2,
                                    -G - 500 * z[1] - v[1]], breaks=around(1.357, 1e-3))  # fmt: skip
