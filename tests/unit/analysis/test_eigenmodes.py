"""Eigenmodes against closed forms, at rest and moving, and against differences of the equations of motion."""

import json
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import cli
from mbdsl.analysis.eigenmodes import _solve, eigen
from mbdsl.analysis.equilibria import prepare
from mbdsl.errors import EquilibriumError, ModelError, UsageError
from mbdsl.system.accelerations import accelerations

G = 9.81
MODELS = Path(__file__).parents[3] / "models"
PENDULUM = """model P Ground ground; Rod rod(m = 2 kg, length = 1 m); Revolute pin(ground, rod.a);{more}
initial equation pin.phi = {phi} deg; end P;"""
CHAIN = """model C Ground ground; Rod link[{N}](each m = 1 kg, each length = 0.1 m);
Revolute J[1](ground, link[1].a);{one}
for i in 2:{N} loop Revolute J[i](link[i - 1].b, link[i].a);{more} end for;
initial equation for i in 1:{N} loop link[i].phi = -90 deg; end for; end C;"""


def modes(text, at="static", count=None):
    return eigen(mbdsl.parse(text), at, count)


def values(found):
    return np.array([mode.eigenvalue for mode in found])


# -- at rest -----------------------------------------------------------------------------------------------------------


def test_a_rod_on_a_pin():
    """omega^2 = m g l/(2 I) = 3 g/(2 l)."""
    found = modes(PENDULUM.format(phi=30, more=""))
    (mode,) = found
    assert mode.omega == pytest.approx(np.sqrt(1.5 * G), rel=1e-13)
    assert mode.frequency == mode.damped_frequency == pytest.approx(np.sqrt(1.5 * G) / (2 * np.pi), rel=1e-13)
    assert mode.damping == 0.0 and not mode.unstable
    assert mode.bodies == {"rod": 1.0}
    # it hangs: the tip moves sideways, twice as far as the middle, and the largest scaled coordinate is the angle
    assert found.displacement(0, "rod.phi") == found.displacement(0, "pin.phi") == pytest.approx(1.0)
    assert found.displacement(0, "rod.b.x") == pytest.approx(1.0)
    assert found.displacement(0, "rod.x") == pytest.approx(0.5)
    assert abs(found.displacement(0, "rod.b.y")) < 1e-14
    assert found.total == 1 and found.at == "static" and found.notes == []


def test_a_pendulum_upside_down():
    found = modes(PENDULUM.format(phi=90, more=""), "start")
    assert values(found) == pytest.approx([np.sqrt(1.5 * G), -np.sqrt(1.5 * G)], rel=1e-13)
    assert [mode.unstable for mode in found] == [True, False]
    assert [mode.damping for mode in found] == [-1.0, 1.0]
    assert found.unstable == [found[0]]
    assert "unstable" in str(found)


def test_a_double_pendulum():
    """Equal masses on equal massless rods: omega^2 = (2 -+ sqrt 2) g/l, the lower one a/b = 1 : sqrt 2 in angles."""
    found = modes("""model D Ground ground; PointMass a(m = 1 kg); PointMass b(m = 1 kg);
        Distance r(ground, a, length = 0.5 m); Distance s(a, b, length = 0.5 m);
        initial equation guess a.x = 0.1 m; guess b.x = 0.1 m; guess a.y = -0.5 m; guess b.y = -1 m; end D;""")
    wanted = np.sqrt((2.0 + np.array([-1.0, 1.0]) * np.sqrt(2.0)) * G / 0.5)
    assert [mode.omega for mode in found] == pytest.approx(wanted, rel=1e-12)
    for k, ratio in enumerate((1.0 + np.sqrt(2.0), 1.0 - np.sqrt(2.0))):
        assert found.displacement(k, "b.x") / found.displacement(k, "a.x") == pytest.approx(ratio, rel=1e-11)


def test_a_damped_oscillator():
    """omega0 = sqrt(k/m), zeta = c/(2 sqrt(k m))."""
    (mode,) = eigen(MODELS / "spring_mass.mbd")
    assert mode.omega == pytest.approx(10.0, rel=1e-12)
    assert mode.damping == pytest.approx(0.1, rel=1e-12)
    assert mode.damped_frequency == pytest.approx(10.0 * np.sqrt(0.99) / (2 * np.pi), rel=1e-12)
    slow, fast = eigen(MODELS / "spring_mass.mbd", parameters={"c": 100.0})
    assert slow.eigenvalue * fast.eigenvalue == pytest.approx(100.0)
    assert slow.eigenvalue + fast.eigenvalue == pytest.approx(-50.0)
    assert (slow.damping, slow.damped_frequency) == (1.0, 0.0)
    (undamped,) = eigen(MODELS / "spring_mass.mbd", without=["damping"])
    assert undamped.damping == 0.0


def test_a_mass_between_two_springs():
    found = modes("""model T Ground ground(g = 0, frames(l = {-1 m, 0 m, 0}, r = {1 m, 0 m, 0})); PointMass m(m = 2 kg);
        SpringDamper a(ground.l, m, k = 300 N/m, s0 = 0.5 m); SpringDamper b(ground.r, m, k = 300 N/m, s0 = 0.5 m);
        end T;""")
    # along the springs both stiffnesses, across the tension over the length
    assert [mode.omega for mode in found] == pytest.approx(np.sqrt([300.0 / 2, 600.0 / 2]), rel=1e-12)
    # the frames on the ground are 2 m apart, which is the size of the mechanism
    assert [abs(found.displacement(1, key)) for key in ("m.x", "m.y")] == pytest.approx([2.0, 0.0], abs=1e-12)


def test_what_rolls():
    """The effective mass is one and a half times the mass, as the disc rolls."""
    found = eigen(MODELS / "rolling_disc.mbd")
    assert values(found) == pytest.approx([1j * np.sqrt(50.0 / 3.0)], rel=1e-12)
    ratio = found.displacement(0, "disc.phi") / found.displacement(0, "contact.s")
    assert ratio == pytest.approx(-10.0)


def test_gears():
    """I_a + I_b/9 with the stiffness of the spring on a."""
    found = modes("""model R Ground ground(g = 0); Body a(m = 1 kg, I = 2 kg.m2); Body b(m = 1 kg, I = 9 kg.m2);
        Revolute A(ground, a.c); Revolute B(ground, b.c); VelocityConstraint c(gamma = a.w + 3*b.w);
        RotationalSpringDamper s(A, k = 12 N.m/rad); end R;""")
    assert values(found) == pytest.approx([2j], rel=1e-12)


def test_reactions_in_forces():
    """tau = r fy: about equilibrium, fy changes with the acceleration of the centre, and K with phi."""
    r, k, m = 0.1, 5.0, 1.0
    found = modes("""model R Ground ground; Rod a(m = 1 kg, length = 1 m); Revolute A(ground, a.a);
        RotationalSpringDamper s(A, k = 5 N.m/rad); Torque T(a.c, tau = 0.1 m*A.fy); end R;""")
    phi = float(found.q[2])
    # I phi'' = -m g l/2 cos(phi) - k phi + r (m g + m l/2 (cos(phi) phi'' - sin(phi) phi'^2))
    inertia = m / 3.0 - r * m / 2.0 * np.cos(phi)
    assert found[0].omega ** 2 == pytest.approx((k - m * G / 2.0 * np.sin(phi)) / inertia, rel=1e-9)


def test_what_moves_freely():
    found = modes("model F Ground g(g = 0); Rod rod(m = 2 kg, length = 1 m); FreeMotion f(g, rod.c); end F;")
    assert values(found) == pytest.approx([0.0, 0.0, 0.0])
    assert "moves freely" in str(found) and "indifferent" in found.notes[0]
    damped = """model W Ground ground; Body wheel(m = 2 kg, I = 1 kg.m2); Revolute pin(ground, wheel.c);
        RotationalSpringDamper d(pin, c = 3 N.m.s/rad); end W;"""
    assert values(modes(damped)) == pytest.approx([0.0, -3.0])


def test_two_bodies_on_one_spring():
    """One zero for the motion together, sqrt(k (1/m + 1/M)) for that against each other, by either solver."""
    text = """model W Ground ground; Body a(m = 1 kg, I = 1 kg.m2); Body b(m = 3 kg, I = 1 kg.m2);
        Prismatic p(ground, a.c); Prismatic q(ground, b.c); SpringDamper s(a.c, b.c, k = 12 N/m, s0 = 1 m{c});
        initial equation guess p.s = 0 m; guess q.s = 1 m; end W;"""
    assert values(modes(text.replace("{c}", ""))) == pytest.approx([0.0, 4j], abs=1e-12)
    found = modes(text.replace("{c}", ", c = 1.5 N.s/m"))
    assert values(found) == pytest.approx([0.0, -1.0 + 1j * np.sqrt(15.0)], abs=1e-9)


def test_redundant_constraints():
    """A parallelogram with a third crank: (3 I + M l^2) phi'' = -(3 m g l/2 + M g l) phi."""
    found = modes("""model R Ground ground(frames(b = {1 m, 0 m, 0}, w = {2 m, 0 m, 0}));
        Rod r[3](each m = 1 kg, each length = 1 m); Rod t(m = 3 kg, length = 2 m);
        Revolute A(ground, r[1].a); Revolute B(ground.b, r[2].a); Revolute C(ground.w, r[3].a);
        Revolute D(r[1].b, t.a); Revolute E(r[2].b, t.c); Revolute F(r[3].b, t.b);
        initial equation for i in 1:3 loop guess r[i].phi = -30 deg; end for; end R;""")
    assert [mode.omega for mode in found] == pytest.approx([np.sqrt((1.5 + 3.0) * G / (1.0 + 3.0))], rel=1e-11)


def test_nothing_free():
    found = eigen(MODELS / "driven_crank.mbd")
    assert len(found) == found.total == 0
    assert str(found).startswith("DrivenCrank: no modes about its static equilibrium\nnote: velocities set to zero")


@pytest.mark.parametrize("mass", [0.0, 1e-9])
def test_what_has_no_mass_adds_no_mode(mass):
    """Two springs in a row with nothing between them: 1/k = 1/300 + 1/150."""
    found = modes(f"""model S Ground ground(g = 0); Body m(m = 1 kg, I = 1 kg.m2);
        Body n(m = {mass} kg, I = {mass} kg.m2);
        Prismatic p(ground, n.c); Prismatic q(ground, m.c); SpringDamper a(ground, n.c, k = 300 N/m, s0 = 1 m);
        SpringDamper b(n.c, m.c, k = 150 N/m, s0 = 1 m); initial equation guess p.s = 1 m; guess q.s = 2 m; end S;""")
    assert found[0].omega == pytest.approx(10.0, rel=1e-8)
    assert len(found) == (2 if mass else 1)


# -- large -------------------------------------------------------------------------------------------------------------


def omegas(K, M):
    """Frequencies [rad/s], from the lowest, of K x = omega^2 M x."""
    L = np.linalg.inv(np.linalg.cholesky(M))
    return np.sqrt(np.maximum(np.linalg.eigvalsh(L @ K @ L.T), 0.0))


def across(N, m, l):
    """Places of the links' middles across the chain (N, N) and its mass matrix for small angles, without y of the
    first end: rods with inertia m l^2/12."""
    B = l * (np.tri(N, k=-1) + np.eye(N) / 2)
    return B, m * B.T @ B + m * l**2 / 12 * np.eye(N)


def hanging(N, m, l):
    """A chain's small oscillations: every link carries the weight of those below it and half of its own."""
    _, M = across(N, m, l)
    return omegas(np.diag(m * G * l * (N - np.arange(N) - 0.5)), M)


def afloat(N, m, l, k):
    """The same without weight, nothing held, with springs k between neighbours: y of the first end comes first."""
    B, _ = across(N, m, l)
    B = np.column_stack([np.ones(N), B])
    turn = np.column_stack([np.zeros(N), np.eye(N)])
    bend = np.diff(turn, axis=0)
    return omegas(k * bend.T @ bend, m * B.T @ B + m * l**2 / 12 * turn.T @ turn)


@pytest.mark.parametrize("damper", ["", " RotationalSpringDamper d[{i}](J[{i}], c = 0.02 N.m.s/rad);"])
def test_sparse_is_dense(damper):
    """A chain of 100 links, 500 unknowns: by Arnoldi's method and by all eigenvalues."""
    one, more = damper.replace("{i}", "1"), damper.replace("{i}", "i")
    text = CHAIN.format(N=100, one=one, more=more)
    few, every = modes(text, count=6), modes(text)
    assert (len(few), few.total, every.total) == (6, None, 100 if not damper else every.total)
    assert values(few) == pytest.approx(values(every)[:6], rel=1e-8)
    for one, other in zip(few, every, strict=False):
        assert np.abs(one.shape) == pytest.approx(np.abs(other.shape), abs=1e-8)
        assert list(one.bodies)[:3] == list(other.bodies)[:3]
    if not damper:
        assert values(few).imag == pytest.approx(hanging(100, 1.0, 0.1)[:6], rel=1e-8)


def test_sparse_free_motion():
    """Free in the plane, it can translate and turn: three zero frequencies, and no other rigid-body mode."""
    text = CHAIN.format(N=100, one="", more=" RotationalSpringDamper d[i](J[i], k = 5 N.m/rad);")
    text = text.replace("Revolute J[1](ground, link[1].a)", "FreeMotion J[1](ground, link[1].a)")
    found = modes(text.replace("ground;", "ground(g = 0);", 1), count=5)
    assert values(found)[:3] == pytest.approx([0.0, 0.0, 0.0])
    assert [mode.omega for mode in found][3:] == pytest.approx(afloat(100, 1.0, 0.1, 5.0)[2:4], rel=1e-8)


# -- moving ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("omega", [0.0, 1.0, 3.0, 4.5])
@pytest.mark.parametrize("angle", [0.0, 0.3, 1.6])
def test_a_bead_on_a_turning_rod(omega, angle):
    """omega_n^2 = k/m - Omega^2, for any angle of the rod."""
    k, m, s0 = 50.0, 2.0, 0.5
    s = k * s0 / (k - m * omega**2)
    found = modes(
        f"""model B Ground ground(g = 0); Body arm(m = 1 kg, I = 1 kg.m2); Revolute pin(ground, arm.c);
        RotationalDriver d(pin, phi = {angle} rad + {omega} rad/s*time); PointMass b(m = {m} kg);
        PointOnLine p(arm.c, b); SpringDamper spring(arm.c, b, k = {k} N/m, s0 = {s0} m);
        initial equation guess b.x = {s * np.cos(angle)} m; guess b.y = {s * np.sin(angle)} m;
        spring.s = {s!r} m; end B;""",
        "start",
    )
    # Z'' is a difference over a hundredth of the time in which the bead crosses 0.5 m: rounding over its square, with
    # weights whose sum is 6, and a margin of 10
    rounding = 10.0 * 6.0 * np.finfo(float).eps * (100.0 * omega * s / 0.5) ** 2 + 1e-14 * k / m
    assert [mode.omega**2 for mode in found] == pytest.approx([k / m - omega**2], abs=rounding)
    assert abs(found[0].damping) < rounding


def test_a_pendulum_on_a_turning_disc():
    """Pointing outwards, without weight: omega^2 = Omega^2 R m (l/2)/I."""
    found = modes(
        """model B Ground ground(g = 0); Body arm(m = 1 kg, I = 1 kg.m2, frames(e = {0.4 m, 0 m, 0}));
        Revolute pin(ground, arm.c); RotationalDriver d(pin, phi = 0.3 rad + 3 rad/s*time);
        Rod r(m = 2 kg, length = 1 m); Revolute j(arm.e, r.a); initial equation j.phi = 0 deg; end B;""",
        "start",
    )
    assert values(found) == pytest.approx([3j * np.sqrt(0.4 * 1.5)], rel=1e-9)
    assert found.notes[0].startswith("the mechanism moves")


def test_a_sleigh_that_glides():
    """Straight ahead, with the knife edge behind: turning decays by m a u/(I + m a^2); the rest is free."""
    found = modes(
        """model S Ground ground(g = 0); Body b(m = 2 kg, I = 0.5 kg.m2, frames(e = {-0.3 m, 0 m, 0}));
        FreeMotion f(ground, b.c); KnifeEdge k(b.e);
        initial equation b.phi = 0.4 rad; b.w = 0 rad/s; b.e.vx = 2 m/s*cos(0.4); end S;""",
        "start",
    )
    nonzero = values(found)[np.abs(values(found)) > 0.0]
    assert nonzero == pytest.approx([-2.0 * 0.3 * 2.0 / (0.5 + 2.0 * 0.09)], rel=1e-8)


FLEXIBLE = "length = 1 m, mass = 1 kg, S = 1e-4 m2, I = 1e-9 m4, E = 200 GPa"
BEAMS = {
    "floating": ('modes = 4, reference = "clamped-free"', 4),
    "nodes": ('elements = 3, reference = "clamped-free"', 12),
    "ancf": ('formulation = "ancf", elements = 4', 17),
    "odd": ('formulation = "ancf", elements = 3', 13),
}


def on_a_pin(more, w, at="start"):
    return modes(
        f"""model S Ground world(g = 0); FlexibleBeam b({FLEXIBLE}, {more}); Revolute f(world, b.a);
        initial equation f.phi = 0.7 rad; b.w = {w} rad/s; annotation(experiment(StopTime = 1 s)); end S;""",
        at,
    )


@pytest.mark.parametrize("kind", BEAMS)
def test_a_beam_that_turns_slowly(kind):
    """As at rest, with as many modes as it can move in, and without damping."""
    more, elastic = BEAMS[kind]
    rest, slow, fast = (on_a_pin(more, w) for w in (0.0, 0.1, 5.0))
    for found in (rest, slow, fast):
        assert np.count_nonzero(values(found).imag > 1.0) == elastic
        assert np.abs(values(found).real).max() <= 1e-9 * np.abs(values(found)).max()
    assert values(slow)[-elastic:] == pytest.approx(values(rest)[-elastic:], rel=1e-5, abs=1e-3)
    # Tension is in the floating frame's kinetic energy; a cable has none before it is stretched, and softens by w^2.
    # Elements can stretch as well, and their start is not steady, so that they have no tension there.
    beta, x, step = 3.9266023120479185, (np.arange(4000) + 0.5) / 4000, 1 / 4000
    shape = np.sin(beta * x) / np.sin(beta) + np.sinh(beta * x) / np.sinh(beta)
    slope = beta * (np.cos(beta * x) / np.sin(beta) + np.cosh(beta * x) / np.sinh(beta))
    tension = (0.5 * (1 - x**2) * slope**2).sum() * step / ((shape**2).sum() * step)
    shift = values(fast)[-elastic:].imag.min() ** 2 - values(rest)[-elastic:].imag.min() ** 2
    if kind != "nodes":
        assert shift == pytest.approx(25.0 * ((tension if kind == "floating" else 0.0) - 1.0), rel=1e-3)
    if kind == "floating":
        assert values(rest) == pytest.approx([0.0, 218.05j, 706.93j, 1481.48j, 4057.62j], rel=1e-5)


@pytest.mark.parametrize("kind", ["floating", "ancf"])
def test_a_beam_that_flies_and_turns(kind):
    """In axes that turn with it, a straight motion turns the other way."""
    found = modes(
        f"""model S Ground world(g = 0); FlexibleBeam b({FLEXIBLE}, {BEAMS[kind][0]}); FreeMotion f(world, b.c);
        initial equation f.w = 0.5 rad/s; f.vx = 1 m/s; annotation(experiment(StopTime = 1 s)); end S;""",
        "start",
    )
    assert np.abs(values(found)[:3]) == pytest.approx([0.0, 0.5, 0.5], abs=1e-3)
    # clamped-free modes can bend and turn: free-free frequencies are approximate
    wanted = 22.3733 * np.sqrt(200.0)
    assert abs(values(found)[3]) == pytest.approx(wanted, rel=5e-3)
    assert np.abs(values(found).real).max() <= 1e-8 * np.abs(values(found)).max()


@pytest.mark.parametrize("ratio", [0.5, 2.0])
def test_a_cantilever_on_a_hub(ratio):
    """Stiffened by its centrifugal force, in the plane: omega^2 = omega0^2 + (1.1933 - 1) Omega^2 about (Southwell).

    In absolute coordinates, it is its stretched length that stiffens it.
    """
    first = 3.516015 * np.sqrt(200.0)

    def turning(more):
        return mbdsl.parse(f"""model R Ground world(g = 0); Body hub(m = 1 kg, I = 1 kg.m2);
            Revolute pin(world, hub.c); RotationalDriver d(pin, phi = 0.4 rad + {ratio * first} rad/s*time);
            FlexibleBeam b({FLEXIBLE}, {more}); Fixed f(hub.c, b.a); annotation(experiment(StopTime = 1 s)); end R;""")

    floating = 'modes = 6, reference = "clamped-free"'
    found = eigen(turning(floating), "start", None)
    assert found.total == 6 and not values(found).real.any()
    southwell = first * np.sqrt(1.0 + 0.1933 * ratio**2)
    assert southwell * (0.95 if ratio > 1.0 else 0.999) < abs(values(found)[0]) < southwell
    # stretched until it is steady, which is linear in where its nodes and slopes are along it
    system, _ = prepare(turning('formulation = "ancf", elements = 8'), None, (), None)
    e, n = np.array([np.cos(0.4), np.sin(0.4)]), np.array([-np.sin(0.4), np.cos(0.4)])
    w = ratio * first

    def state(along):
        pairs = np.concatenate([[0.0], along])[:, None]
        q = np.concatenate([[0.0, 0.0, 0.4], (pairs * e).ravel()])
        v = w * np.concatenate([[0.0, 0.0, 1.0], (pairs * n).ravel()])
        return q, v, *accelerations(system, 0.0, q, v)

    def unsteady(along):
        q, _, a, _ = state(along)
        return ((a + w**2 * q)[3:].reshape(-1, 2) @ e)[1:]

    along = np.stack([np.linspace(0.0, 1.0, 9), np.ones(9)], axis=1).ravel()[1:]
    for _ in range(3):
        along -= np.linalg.solve(derivative(unsteady, along), unsteady(along))
    k = np.sqrt(w**2 / (200e9 * 1e-4))
    assert along[-2] - 1.0 == pytest.approx(np.tan(k) / k - 1.0, rel=1e-6)
    q, v, a, lam = state(along)
    other, _, total = _solve(system, 0.0, q, v, a, lam, True, None)
    assert total == 33
    assert np.abs(np.real(other)).max() <= 1e-9 * abs(other[-1])
    assert other[:2] == pytest.approx(values(found)[:2], rel=2e-3)
    # without the stiffening it softens with speed, and becomes unstable in the end
    plain = values(eigen(turning(floating + ", stiffening = false"), "start", None))
    wanted = first * np.sqrt(abs(1.0 - ratio**2)) * (1j if ratio < 1.0 else 1.0)
    assert plain[0] == pytest.approx(wanted, rel=1e-3)


def derivative(f, x, h=1e-4):
    """Jacobian of f by differences of order 4."""
    columns = [
        (8.0 * (f(x + h * e) - f(x - h * e)) - f(x + 2 * h * e) + f(x - 2 * h * e)) / (12.0 * h) for e in np.eye(len(x))
    ]
    return np.array(columns).T


def test_differences_of_the_equations_of_motion():
    """A double pendulum in full swing: in its relative angles, as eigen takes them."""
    scene = mbdsl.parse("""model D Ground g; Rod a(m = 1 kg, length = 1 m); Rod b(m = 2 kg, length = 0.7 m);
        Revolute A(g, a.a); Revolute B(a.b, b.a); RotationalSpringDamper s(B, k = 3 N.m/rad, c = 0.4 N.m.s/rad);
        initial equation A.phi = 0.3 rad; B.phi = -0.8 rad; A.w = 1.3 rad/s; B.w = -2 rad/s; end D;""")
    system, _ = prepare(scene, None, (), None)

    def rate(x):
        phi, w = np.array([x[0], x[0] + x[1]]), np.array([x[2], x[2] + x[3]])
        e, n = np.array([np.cos(phi), np.sin(phi)]).T, np.array([-np.sin(phi), np.cos(phi)]).T
        q = np.concatenate([0.5 * e[0], phi[:1], e[0] + 0.35 * e[1], phi[1:]])
        v = np.concatenate([0.5 * w[0] * n[0], w[:1], w[0] * n[0] + 0.35 * w[1] * n[1], w[1:]])
        a = accelerations(system, 0.0, q, v)[0]
        return np.array([x[2], x[3], a[2], a[5] - a[2]])

    wanted = np.linalg.eigvals(derivative(rate, np.array([0.3, -0.8, 1.3, -2.0])))
    wanted = sorted((s for s in wanted if s.imag >= 0.0), key=abs)
    assert values(eigen(scene, "start", None)) == pytest.approx(np.array(wanted), rel=1e-7)


def test_after_a_time():
    """The state of a driven bead after a second, as a simulation returns it."""
    found = eigen(MODELS / "slider_crank.mbd", 0.5)
    run = mbdsl.simulate(MODELS / "slider_crank.mbd", stop=0.5, interval=0.5)
    assert found.t == 0.5
    assert found.q == pytest.approx(run.q[-1], abs=1e-12)
    assert found.at == "t = 0.5 s" and len(found) == 1
    assert values(eigen(MODELS / "pendulum.mbd", "start")) == pytest.approx([0.0], abs=1e-12)  # horizontal
    assert values(eigen(MODELS / "pendulum.mbd", 0.0)) == pytest.approx([0.0], abs=1e-12)


# -- requests ----------------------------------------------------------------------------------------------------------


def test_arguments():
    scene = mbdsl.parse(PENDULUM.format(phi=0, more=""))
    for given, message in (
        ({"count": 0}, "number of modes is 1 or more"),
        ({"count": 1.5}, "number of modes"),
        ({"at": "rest"}, "`static`, `start` or a time"),
        ({"at": np.nan}, "not a finite number"),
        ({"at": -1.0}, "before the start"),
    ):
        with pytest.raises(UsageError, match=message):
            eigen(scene, **given)
    found = eigen(scene)
    with pytest.raises(ModelError, match="no signal"):
        found.displacement(0, "rod.z")
    with pytest.raises(UsageError, match="more than positions"):
        found.displacement(0, "rod.w")
    with pytest.raises(EquilibriumError, match="m keeps moving"):
        modes("model F Ground g; PointMass m(m = 1 kg); FreeMotion f(g, m); end F;")


def test_large_motions_are_refused(monkeypatch):
    monkeypatch.setattr("mbdsl.analysis.eigenmodes.LARGEST_MOVING", 450)
    text = CHAIN.format(N=100, one="", more="").replace("link[i].phi = -90 deg", "link[i].phi = 0 deg")
    with pytest.raises(UsageError, match="500 unknowns are too many"):
        modes(text, "start")


@pytest.fixture
def say(capsys, tmp_path, monkeypatch):
    """Run a command in an empty folder: exit code, standard output, standard error without lines about compilation."""
    monkeypatch.chdir(tmp_path)

    def run(*argv):
        code = cli.main([str(a) for a in argv])
        out, err = capsys.readouterr()
        return code, out, "".join(x for x in err.splitlines(True) if not x.startswith("compiling"))

    return run


def test_the_command(say):
    code, out, err = say("eigen", MODELS / "chain.mbd", "--count", 2, "--output", "m.csv")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0] == "Chain: 2 of 8 modes about its static equilibrium"
    assert lines[1] == "    #      f [Hz]  damped [Hz]     damping  moving bodies"
    assert lines[2].startswith("    1    0.212015     0.212015           0  link[8] 39%, ")
    assert lines[-1] == "m.csv: 2 modes, frequencies, damping and shapes"
    table = np.genfromtxt("m.csv", delimiter=",", names=True, deletechars="", replace_space=" ")
    assert len(table) == 2
    assert table["frequency"] == pytest.approx([mode.frequency for mode in eigen(MODELS / "chain.mbd", count=2)])
    assert table.dtype.names[-1] == "link[8].phi.phase"
    assert say("eigen", MODELS / "spring_mass.mbd", "--output", "m.json")[0] == 0
    with open("m.json") as stream:
        (mode,) = json.load(stream)["modes"]
    assert mode["damping"] == pytest.approx(0.1)
    assert np.hypot(*mode["shape"]["block.y"]) == pytest.approx(0.5)  # the only length, that of the spring, is the size
    assert mode["bodies"] == {"block": 1.0}


def test_wrong_requests(say):
    pendulum = MODELS / "pendulum.mbd"
    for argv, message in (
        (["--count", "0"], "`0` is not a number of modes"),
        (["--at", "1kg"], "wrong unit"),
        (["--at", "rest"], "`rest` is not a number"),
        (["--output", "m.xls"], "known suffixes are .csv, .json"),
        (["--output", "no/m.csv"], "there is no folder `no`"),
    ):
        code, out, err = say("eigen", pendulum, *argv)
        assert (code, out) == (2, "") and message in err and "Traceback" not in err, err
