"""Ropes in the plane and in space against closed forms: Atwood's machine, block and tackle, winch, yo-yo, capstan.

In space the same machines are in an inclined plane. Ropes that begin with the tension of the motion do not vibrate: the
acceleration is constant, and the runs differ from it by their tolerance. Where tensions are not equal at the start,
damping ends the vibration, and the test compares what follows.
"""

import math
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import Builder

HOIST = Path(__file__).parents[2] / "models" / "hoist.mbd"
G, K = 9.81, 1e5
E1, E2 = np.array([0.6, 0.8, 0.0]), np.array([-0.48, 0.36, 0.8])


class Plane:
    """Builds machines in the x-y plane of a planar model."""

    def __init__(self):
        self.b = Builder("Machine")
        self.b.Ground("ground", g=G, n=(0.0, -1.0))

    def hook(self, name, x, y):
        self.b.frame(name, "ground", r=(x, y))
        return name

    def mass(self, name, m, x, y):
        self.b.PointMass(name, m=m)
        self.place(name, x, y)
        return name

    def wheel(self, name, m, I, x, y, held=True):
        self.b.Body(name, m=m, I=I, frames={"e": (0.0, 0.0)})
        if held:
            self.b.Revolute(f"{name}_pin", self.hook(f"{name}_axle", x, y), f"{name}.e")
        else:
            self.place(name, x, y)
        return f"{name}.e"

    def place(self, name, x, y):
        self.b.initial(f"{name}.x", x)
        self.b.initial(f"{name}.y", y)

    def torque(self, frame, tau):
        self.b.Torque("motor", frame, tau=tau)

    def height(self, run, name):
        """y of a mass, and its rate."""
        return run[f"{name}.y"], run[f"{name}.vy"]


class Space(Plane):
    """Builds them in the plane of E1 and E2."""

    def __init__(self):
        self.b = mbdsl.SpatialBuilder("Machine")
        self.b.Ground("ground", g=G, n=tuple(-E2))

    def hook(self, name, x, y):
        self.b.frame(name, "ground", r=tuple(x * E1 + y * E2), n_x=tuple(E1), n_y=tuple(E2))
        return name

    def wheel(self, name, m, I, x, y, held=True):
        self.b.Body(name, m=m, I=(I, I, I), frames={"e": {"n_x": tuple(E1), "n_y": tuple(E2)}})
        if held:
            self.b.Revolute(f"{name}_pin", self.hook(f"{name}_axle", x, y), f"{name}.e")
        else:
            self.place(name, x, y)
        return f"{name}.e"

    def place(self, name, x, y):
        for key, value in zip("xyz", x * E1 + y * E2, strict=True):
            self.b.initial(f"{name}.{key}", value)

    def torque(self, frame, tau):
        self.b.Torque("motor", frame, tau=tau, n=tuple(np.cross(E1, E2)))

    def height(self, run, name):
        return tuple(sum(e * run[f"{name}.{v}{key}"] for e, key in zip(E2, "xyz", strict=True)) for v in ("", "v"))


BOTH = pytest.mark.parametrize("world", [Plane, Space])


def accelerates(machine, name, a, stop=0.3):
    """Whether a mass accelerates from rest with a, along the vertical."""
    run = mbdsl.simulate(machine.b.scene(), stop=stop, interval=stop / 10, tol=1e-8)
    y, v = machine.height(run, name)
    np.testing.assert_allclose(v, a * run.t, atol=1e-6 * abs(a) * stop)
    np.testing.assert_allclose(y - y[0], 0.5 * a * run.t**2, atol=1e-6 * abs(a) * stop**2)
    return run


def atwood(world, **rope):
    """Two masses of 3 kg and 2 kg on a disc of 0.2 m; the path is 1.5 m, half a turn, and 1 m long."""
    machine = world()
    disc = machine.wheel("wheel", 1.0, 0.02, 0.0, 0.0)
    heavy, light = machine.mass("heavy", 3.0, 0.2, -1.5), machine.mass("light", 2.0, -0.2, -1.0)
    machine.b.Rope("rope", heavy, light, over=[disc], radius=0.2, k=K, **rope)
    return machine


@BOTH
def test_atwood_without_friction(world):
    """The disc does not turn: a = (m_1 - m_2) g/(m_1 + m_2), and the tension is 2 m_1 m_2 g/(m_1 + m_2)."""
    tension, path = 12.0 / 5.0 * G, 2.5 + 0.2 * math.pi
    run = accelerates(atwood(world, mu=0.0, length=path - tension / K), "light", G / 5.0)
    np.testing.assert_allclose(run["rope.tension"], tension, rtol=1e-6)
    np.testing.assert_allclose(run["rope.s"], path, rtol=1e-9)
    np.testing.assert_allclose(run["rope.power"], 0.0, atol=1e-3)  # neither its length nor its tension changes


@BOTH
@pytest.mark.parametrize("mu", [None, 0.4])
def test_atwood_with_a_disc_that_turns(world, mu):
    """a = (m_1 - m_2) g/(m_1 + m_2 + I/r^2), without sliding or with friction that suffices; tensions m (g -+ a).

    The rope slides slowly, v_s atanh(ln(T_1/T_2)/(mu pi)) = 0.03 v_s, which is constant as soon as the tensions are.
    """
    a = G / 5.5
    given = {} if mu is None else {"mu": mu}
    run = mbdsl.simulate(atwood(world, c=400.0, **given).b.scene(), stop=0.4, interval=0.02, tol=1e-7)
    late = run.t > 0.25
    np.testing.assert_allclose(run["rope.tension"][late], 3.0 * (G - a), rtol=2e-5)
    np.testing.assert_allclose(run["rope.tension_b"][late], 2.0 * (G + a), rtol=2e-5)
    assert (run["rope.slack"] == 0.0).all()
    np.testing.assert_allclose(run["rope.frame_a.f"][late], 3.0 * (G - a), rtol=2e-5)
    np.testing.assert_allclose(run["rope.frame_b.f"][late], 2.0 * (G + a), rtol=2e-5)
    if mu is None:
        np.testing.assert_allclose(run["rope.power"][late], 0.0, atol=1e-3)


@BOTH
@pytest.mark.parametrize("parts", [2, 3])
def test_block_and_tackle(world, parts):
    """A load M on 2 or 3 parts of rope, and a mass m at its end: M rises with a, m falls with n a.

    (M + n^2 m) a = (n m - M) g and T = m (g - n a); the rope has no friction, and the load turns nothing.
    """
    M, m, r, n = 5.0, 3.0, 0.1, parts
    a = (n * m - M) * G / (M + n * n * m)
    machine = world()
    block, low = machine.wheel("block", M, 0.01, 0.0, -2.0, held=False), machine.mass("weight", m, 3.0 * r, -1.0)
    last, path = machine.hook("last", 2.0 * r, 0.0), 5.0 + 2.0 * math.pi * r
    first, over, radius = machine.hook("ceiling", -r, 0.0), [block, last], [r, -r]
    if n == 3:  # from the block over a disc of half the radius
        first, over, radius = block, [machine.hook("first", -0.5 * r, 0.0), *over], [0.5 * r, *radius]
        path += 2.0 + 0.5 * math.pi * r
    tension = m * (G - n * a)
    machine.b.Rope("rope", first, low, over=over, radius=radius, k=K, mu=0.0, length=path - tension / K)
    run = accelerates(machine, "block", a)
    np.testing.assert_allclose(run["rope.tension"], tension, rtol=1e-6)


@BOTH
def test_winch(world):
    """A torque tau on a drum lifts a mass: a = (tau/r - m g)/(m + I/r^2); the rope is wound by r phi."""
    m, I, r, tau = 10.0, 0.3, 0.2, 30.0
    a = (tau / r - m * G) / (m + I / r**2)
    machine = world()
    drum = machine.wheel("drum", 5.0, I, 0.0, 0.0)
    load = machine.mass("load", m, -r, -3.0)
    machine.torque(drum, -tau)  # the rope turns to the right around the drum
    machine.b.Rope("rope", load, drum, drum=-r, k=K, length=3.0 - m * (G + a) / K)
    run = accelerates(machine, "load", a, stop=0.8)
    np.testing.assert_allclose(run["rope.s"][-1], 3.0 - 0.5 * a * 0.8**2, rtol=1e-6)


@BOTH
def test_yo_yo(world):
    """A disc that unwinds a rope from itself falls with g/(1 + I/(m r^2)), in the plane for four turns."""
    m, I, r = 0.5, 2e-3, 0.05
    a = G / (1.0 + I / (m * r * r))
    machine = world()
    disc = machine.wheel("disc", m, I, r, -0.3, held=False)
    machine.b.Rope("rope", machine.hook("hand", 0.0, 0.0), disc, drum=r, k=1e4, length=0.3 - m * (G - a) / 1e4)
    run = accelerates(machine, "disc", -a, stop=0.8 if world is Plane else 0.3)  # in space, it tips over later
    np.testing.assert_allclose(run["rope.s"][-1], 0.3 + 0.5 * a * run.t[-1] ** 2, rtol=1e-6)


@BOTH
@pytest.mark.parametrize("turns", [0, 1])
def test_capstan(world, turns):
    """The rope slides around a fixed cylinder: T_1/T_2 = exp(mu alpha), with alpha of half a turn, or one more."""
    mu, heavy, light = 0.1, 5.0, 1.5
    ratio = math.exp(mu * math.pi * (1 + 2 * turns))
    machine = world()
    pole = machine.hook("pole", 0.0, 0.0)
    first, second = machine.mass("first", heavy, 0.2, -1.0), machine.mass("second", light, -0.2, -1.0)
    machine.b.Rope("rope", first, second, over=[pole], radius=0.2, turns=turns, mu=mu, k=K, c=300.0)
    run = mbdsl.simulate(machine.b.scene(), stop=0.4, interval=0.02, tol=1e-6)
    late, (_, v) = run.t > 0.25, machine.height(run, "first")
    if heavy > light * ratio:
        a = (heavy - light * ratio) / (heavy + light * ratio) * G
        np.testing.assert_allclose(np.diff(v[late]) / 0.02, -a, rtol=1e-4)
        np.testing.assert_allclose((run["rope.tension"] / run["rope.tension_b"])[late], ratio, rtol=1e-9)
    else:  # it holds, and creeps with v_s atanh(ln(m_1/m_2)/(mu alpha))
        creep = 1e-3 * math.atanh(math.log(heavy / light) / math.log(ratio))
        np.testing.assert_allclose(v[late], -creep, rtol=1e-3)


@BOTH
def test_a_slack_rope_catches_a_falling_mass(world):
    """A mass falls freely over h, and then swings as on a spring about its rest, until the rope is slack."""
    m, h, k = 2.0, 0.5, 2e3
    machine = world()
    mass = machine.mass("mass", m, 0.0, -1.0)
    machine.b.Rope("rope", machine.hook("hook", 0.0, 0.0), mass, k=k, length=1.0 + h)
    fall, w = math.sqrt(2.0 * h / G), math.sqrt(k / m)
    # e = e0 - e0 cos(w t) + v/w sin(w t), which is zero again at t1
    e0, v = m * G / k, G * fall
    t1 = 2.0 * (math.pi - math.atan2(v / w, e0)) / w
    run = mbdsl.simulate(machine.b.scene(), stop=fall + t1 + 0.05, interval=0.001, tol=1e-8)
    taut = (run.t > fall + 1e-6) & (run.t < fall + t1 - 1e-6)
    assert (run["rope.slack"] == np.where(taut, 0.0, 1.0)).all()
    s = run.t[taut] - fall
    np.testing.assert_allclose(run["rope.stretch"][taut], e0 - e0 * np.cos(w * s) + v / w * np.sin(w * s), atol=1e-6)


@BOTH
def test_elastic_belt(world):
    """A torque on the small pulley: alpha = tau/(I_a + I_b i^2) with i = r_a/r_b; force I_b i alpha/r_b."""
    machine, ratio = world(), 0.1 / 0.3
    a, b = machine.wheel("a", 1.0, 0.02, 0.0, 0.0), machine.wheel("b", 1.0, 0.5, 1.0, 0.5)
    machine.torque(a, 1.0)
    machine.b.ElasticBelt("belt", a, b, r_a=0.1, r_b=0.3, k=K, c=100.0)
    run = mbdsl.simulate(machine.b.scene(), stop=1.0, interval=0.1, tol=1e-7)
    alpha = 1.0 / (0.02 + 0.5 * ratio**2)
    np.testing.assert_allclose(run["belt.force"][-5:], 0.5 * ratio * alpha / 0.3, rtol=1e-6)
    np.testing.assert_allclose(run["belt.stretch"][-5:], 0.5 * ratio * alpha / 0.3 / K, rtol=1e-6)


def test_power_of_a_rope_on_a_pole_that_turns():
    """A pole that turns under a rope at rest: the rope does the work -(T_2 - T_1) r w, with T_2/T_1 = exp(mu pi)."""
    machine = Plane()
    pole = machine.wheel("pole", 1.0, 1.0, 0.0, 0.0)
    machine.b.RotationalDriver("motor", "pole_pin", phi="5 rad/s*time")
    load = machine.mass("load", 2.0, 0.2, -1.0)
    machine.b.Rope("rope", machine.hook("anchor", -0.2, -2.0), load, over=[pole], radius=-0.2, mu=0.15, k=K, c=3000.0)
    run = mbdsl.simulate(machine.b.scene(), stop=0.3, interval=0.01, tol=1e-7)
    expected = 2.0 * G * (1.0 - math.exp(-0.15 * math.pi)) * 0.2 * 5.0
    np.testing.assert_allclose(run["rope.power"][-5:], -expected, rtol=1e-4)
    np.testing.assert_allclose(run["motor.power"][-5:], expected, rtol=1e-4)


def driven(elements, spatial):
    """A run in which an arm of 1 m turns by 10 rad, from the direction of y on: all moves by drivers."""
    text = f"""
    {"spatial " if spatial else ""}model Driven
      Ground ground(g = 0);
      Rod arm(m = 1 kg, length = 1 m);
      Revolute O(ground, arm.a);
      RotationalDriver d(O, phi = 90 deg + 1 rad/s*time);
      {elements}
    end Driven;
    """
    return mbdsl.simulate(mbdsl.parse(text), stop=10.0, interval=0.1, method="hht-si2", step=0.02)


IN_BOTH = pytest.mark.parametrize("spatial", [False, True])


@IN_BOTH
def test_a_drum_counts_its_turns(spatial):
    """The end of the rope circles around the drum: the rope is wound by r phi, and stretches as much."""
    run = driven("Rope rope(arm.b, ground, drum = -0.1 m, k = 1e4 N/m);", spatial)
    np.testing.assert_allclose(run["rope.stretch"], 0.1 * run.t, atol=1e-9)
    np.testing.assert_allclose(run["rope.tension"], 1e3 * run.t, atol=1e-5)
    np.testing.assert_allclose(run[5.0:10.0]["rope.stretch"], 0.1 * run.t[50:], atol=1e-9)
    np.testing.assert_allclose(run["rope.power"], -1e3 * run.t * 0.1, atol=1e-5)


@IN_BOTH
@pytest.mark.parametrize("mu", ["0", "0.1"])
def test_a_disc_counts_the_turns_of_a_rope_that_slides(spatial, mu):
    """The end of the rope circles around the disc: the path grows by r phi, beyond 315 degrees too."""
    hook = "{-2 m, -0.1 m, 0}" if spatial else "{-2 m, -0.1 m}"
    rope = f"Rope rope(hook, arm.b, over = {{ground}}, radius = 0.1 m, mu = {mu}, k = 1e4 N/m);"
    run = driven(f"Frame hook(ground, r = {hook}); {rope}", spatial)
    # 2 m, the tangent from the end, and the arc up to its point of contact
    first = 2.0 + math.sqrt(0.99) + 0.1 * (math.pi - math.acos(0.1))
    np.testing.assert_allclose(run["rope.s"], first + 0.1 * run.t, atol=1e-9)
    np.testing.assert_allclose(run["rope.stretch"], 0.1 * run.t, atol=1e-9)


@IN_BOTH
def test_an_elastic_belt_counts_turns_of_its_line_of_centres(spatial):
    """The line turns by theta, pulley a does not, and pulley b with the line: r_a (0 - theta) + r_b (theta - theta)."""
    inertia = "{0.01, 0.01, 0.01} kg.m2" if spatial else "0.01 kg.m2"
    bodies = "".join(f"Body {x}(m = 1 kg, I = {inertia}); Revolute R{x}(arm.{x}, {x}.c);" for x in "ab")
    drivers = "RotationalDriver da(Ra, phi = -90 deg - 1 rad/s*time); RotationalDriver db(Rb, phi = 0);"
    run = driven(f"{bodies} {drivers} ElasticBelt belt(a.c, b.c, r_a = 0.1 m, r_b = 0.2 m, k = 100 N/m);", spatial)
    np.testing.assert_allclose(run["belt.stretch"], -0.1 * run.t, atol=1e-9)


@IN_BOTH
def test_a_rope_that_leaves_its_disc(spatial):
    """It is straight where its end has passed the tangent from the hook to the disc, at 4 m tan(beta)."""
    z, axis = (", 0", ", n_x = {0, 1, 0}, n_y = {-1, 0, 0}") if spatial else ("", ", phi = 90 deg")
    text = f"""
    {"spatial " if spatial else ""}model Lift
      Ground ground(g = 0, frames(axle = {{0, 1 m{z}}}, hook = {{-2 m, 0{z}}}));
      Frame rail(ground, r = {{2 m, 0{z}}}{axis});
      Rod bar(m = 1 kg, length = 1 m);
      Prismatic slide(rail, bar.a);
      TranslationalDriver lift(slide, s = 4 m/s*time);
      Rope rope(ground.hook, bar.a, over = {{ground.axle}}, radius = -0.2 m, mu = 0, k = 1e4 N/m, length = 3 m);
    end Lift;
    """
    t = math.tan(math.atan(0.5) + math.asin(0.2 / math.sqrt(5.0)))  # 0.6179 s
    run = mbdsl.simulate(mbdsl.parse(text), stop=0.7, interval=0.001, method="hht-si2", step=1e-3)
    (warning,) = [x for x in run.stats["warnings"] if "leaves" in x]
    assert (
        f"Rope rope leaves the disc at ground.axle until t = {math.ceil(1e3 * t) / 1e3:g} s: later results" in warning
    )
    run = mbdsl.simulate(mbdsl.parse(text), stop=0.6, interval=0.001, method="hht-si2", step=1e-3)
    assert not any("leaves" in x for x in run.stats["warnings"])


@pytest.mark.parametrize("method", ["hht-si2", "radau5"])
def test_a_mirrored_hoist_moves_as_in_a_mirror(method):
    """Every place and every sense of turning of models/hoist.mbd is reversed from left to right."""
    text = HOIST.read_text(encoding="utf-8")
    image = text
    for old, new in (
        ("r = {-r, 3 m}", "r = {r, 3 m}"),
        ("r = {2*r, 3 m}", "r = {-2*r, 3 m}"),
        ("r = {1 m, 0}", "r = {-1 m, 0}"),
        ("radius = {r, -r}, drum = -0.15 m", "radius = {-r, r}, drum = 0.15 m"),
        ("(-speed*tanh", "(speed*tanh"),
    ):
        assert old in image
        image = image.replace(old, new)
    one, other = (mbdsl.simulate(mbdsl.parse(x), stop=0.2, method=method, step=1e-4) for x in (text, image))
    for name in ("block.y", "rope.s", "rope.tension", "rope.tension_b", "rope.span2.tension", "rope.power"):
        assert other[name] == pytest.approx(one[name], rel=1e-12, abs=1e-12)
    for name in ("block.phi", "disc.w", "drum.w"):
        assert other[name] == pytest.approx(-one[name], rel=1e-12, abs=1e-12)
