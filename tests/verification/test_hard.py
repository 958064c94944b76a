"""Stiffness, missing inertia, many bodies, extreme sizes, many steps."""

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import mbdsl
from mbdsl import Builder

G = 9.81


@pytest.fixture
def method(second_order):
    """Each method of second order of the paper, unless a test says otherwise."""
    return second_order


def double_pendulum(p):
    b = Builder("DoublePendulum")
    ground = b.Ground("ground", g=p["g"])
    link1, link2 = b.Rod("link1", m=p["m1"], length=p["L1"]), b.Rod("link2", m=p["m2"], length=p["L2"])
    b.Revolute("O", ground, link1.a)
    b.Revolute("A", link1.b, link2.a)
    b.RotationalSpringDamper("spring1", ground, link1.a, k=p["k1"], c=p["c1"], phi0=1.5 * np.pi)
    b.RotationalSpringDamper("spring2", link1.b, link2.a, k=p["k2"], c=p["c2"])
    b.initial(link1.phi, 1.5 * np.pi)
    b.initial(link2.phi, 1.5 * np.pi - np.pi / 12)
    return b.scene()


@pytest.mark.parametrize("method", ["hht-i3", "hht-si2"])
def test_stiff_double_pendulum(reference, order, method):
    """A damper of 5e4 N.m.s/rad pulls two light links into line at 1e-5 s and lets them creep at 1/6 s: the method must
    take steps of the slow motion, and converge to it."""
    data = reference("double_pendulum")
    k = data["t"].index(0.2)
    steps, errors = [1e-3, 5e-4, 2.5e-4, 1.25e-4], []
    for h in steps:
        r = mbdsl.simulate(double_pendulum(data["parameters"]), method=method, step=h, stop=0.2, interval=0.2)
        found = [r[name][-1] for name in ("link1.phi", "link2.phi", "link1.w", "link2.w")]
        errors.append(np.abs(np.subtract(found, data["y"][k])))
    for name, error in zip(data["columns"], np.transpose(errors), strict=True):
        assert 1.8 < order(steps, error) < 2.2, name
    assert errors[-1].max() < 1e-4


@pytest.mark.parametrize("method", ["hht-i3", "hht-si2"])
def test_stiff_double_pendulum_with_long_steps(reference, order, method):
    """Implicit methods run with steps far longer than the fast motion, and already have order 2 there."""
    data = reference("double_pendulum")
    expected = np.array([y[1] for y in data["y"][:3]])
    steps, errors = [4e-3, 2e-3, 1e-3], []
    for h in steps:
        r = mbdsl.simulate(double_pendulum(data["parameters"]), method=method, step=h, stop=0.5, interval=0.1)
        errors.append(np.abs(r["link2.phi"][[1, 2, 5]] - expected).max())
    assert 1.85 < order(steps, errors) < 2.15
    assert errors[-1] < 1e-3


@pytest.mark.parametrize("method", ["hht-i3", "nstiff", "nstiff-si2", "hht-si2"])  # hht-add divides by masses
def test_body_without_inertia(order, method):
    """A mass at the end of a massless rod: M is singular, M on the constraints' null space is not."""
    b = Builder("Massless")
    ground = b.Ground("ground")
    bob = b.Body("bob", m=1.0, I=0.0, frames={"pin": (0.0, 1.0)})
    b.Revolute("pin", ground, "bob.pin")
    b.initial(bob.phi, -np.pi / 2)
    steps = [2.0**-k for k in (6, 7, 8, 9)]
    sn, cn, _, _ = ellipj(ellipk(0.5) + np.sqrt(G), 0.5)
    phi, rate = -2 * np.arcsin(np.sqrt(0.5) * sn), -2 * np.sqrt(0.5 * G) * cn
    ends = [mbdsl.simulate(b, method=method, step=h, stop=1.0, interval=1.0) for h in steps]
    assert 1.85 < order(steps, [abs(r["bob.phi"][-1] - phi) for r in ends]) < 2.15
    assert 1.85 < order(steps, [abs(r["bob.w"][-1] - rate) for r in ends]) < 2.15
    # the rod's pull, m (rate^2 L + g cos(phi)) along it, upwards and towards the pin
    pull = rate**2 + G * np.cos(phi)
    assert 1.85 < order(steps, [abs(r["pin.fy"][-1] - pull * np.cos(phi)) for r in ends]) < 2.15


def test_chain_of_many_links(model, order, method):
    """64 links: more than a dense matrix would be suited for; energy to order 2."""
    steps, errors = [2e-3, 1e-3, 5e-4], []
    for h in steps:
        r = mbdsl.simulate(model("chain"), method=method, step=h, stop=0.5, interval=0.1, parameters={"N": 64})
        assert r.stats["n"] == 192
        assert r["energy.total"][0] == pytest.approx(0.0, abs=1e-12)
        errors.append(np.abs(r["energy.total"]).max())
    assert 1.8 < order(steps, errors) < 2.2
    assert np.abs(np.hypot(r["link[64].b.x"], r["link[64].b.y"])[0] - 64) < 1e-10
    assert r["link[64].b.y"][-1] < -0.5  # it falls


def mechanism(length, mass, time=1.0):
    """A slider crank with a spring in units of ``length``, ``mass`` and ``time``."""
    force = mass * length / time**2
    b = Builder("Scaled")
    ground = b.Ground("ground", g=G * length / time**2, frames={"wall": (2.0 * length, 0.1 * length)})
    crank, rod = b.Rod("crank", m=mass, length=0.3 * length), b.Body("rod", m=0.5 * mass, length=0.6 * length)
    b.Revolute("O", ground, crank.a)
    b.Revolute("A", crank.b, rod.a)
    b.PointOnLine("B", ground, rod.b)
    b.SpringDamper("spring", "ground.wall", rod.b, k=50 * force / length, c=2 * force / length * time, s0=length)
    b.initial(crank.phi, 0.7)
    b.initial(rod.phi, -0.3, fixed=False)
    b.initial(crank.w, 1.0 / time)
    return b.scene(), force


# nstiff-si2 is not among these: it corrects q' by Phi_q^T mu, which adds metres to radians
@pytest.mark.parametrize("method", ["hht-i3", "nstiff", "hht-add", "hht-si2"])
@pytest.mark.parametrize(
    ("length", "mass", "time"),
    [
        (1e-6, 1e-12, 1.0),
        (1e4, 1e9, 1.0),
        (1e-6, 1e-12, 1e-4),
        (1.0, 1.0, 1e3),
        (1.0, 1.0, 1e-3),
        (10.0, 0.1, 1.0),
    ],
)
def test_similar_mechanisms_move_alike(method, length, mass, time):
    """Units have no effect: the scaled mechanism has the scaled motion, with the same work.

    The runs differ by rounding and by the point at which Newton's method stops, each 1.2e-4 of the local error at most:
    ten times both is allowed, relative to the discretisation error as halving the step shows it.
    """
    (unit, _), (scaled, force) = mechanism(1.0, 1.0), mechanism(length, mass, time)
    plain, coarse = (mbdsl.simulate(unit, method=method, step=h, stop=1.0, interval=0.1) for h in (1e-3, 2e-3))
    other = mbdsl.simulate(scaled, method=method, step=1e-3 * time, stop=time, interval=0.1 * time)
    scales = {"crank.phi": 1, "rod.x": length, "rod.vy": length / time, "rod.w": 1 / time, "O.fx": force, "B.fy": force}
    for name, scale in scales.items():
        error = np.abs(plain[name] - coarse[name]).max()
        assert np.abs(other[name] / scale - plain[name]).max() < 2.4e-3 * error, name
    assert other.stats["iterations"] <= 1.1 * plain.stats["iterations"]
    residual = max(np.abs(other[name]).max() / length for name in other.select(["*.Phi[*]"]))
    assert residual < 1e-12


def test_a_million_steps(model, method):
    """1000 s of the pendulum, some 420 swings: energy is never gained, and little is lost.

    The damping of a linear oscillation is of order (w h)^3 |alpha| a step: for w = 3/s, h = 1e-3 it is 3e-9 of the
    energy of 10 J, 1e6 times: 0.03 J. At any time it is off by C h^2 besides.
    """
    r = mbdsl.simulate(model("pendulum"), method=method, step=1e-3, stop=1000.0, interval=1.0)
    assert r.stats["steps"] == 1_000_000
    energy = r["energy.total"]
    assert energy.max() < 1e-4
    assert energy.min() > -0.05
    assert -0.05 < energy[-200:].mean() - energy[:200].mean() < 1e-6
    assert np.abs(np.hypot(r["mass.x"], r["mass.y"]) - 1).max() < 1e-11
