"""Eigenvalues of vehicles that roll straight ahead, against closed forms and published ones."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl

MODELS = Path(__file__).parents[2] / "models"

EXACT = 1e-8  # rounding of the matrices, and of differences along the motion, with a margin


def nonzero(modes):
    return [mode.eigenvalue for mode in modes if mode.omega > 0.0]


#: J. P. Meijaard, J. M. Papadopoulos, A. Ruina, A. L. Schwab, Proc. R. Soc. A 463 (2007) 1955-1982, Table 2
MEIJAARD = {
    3.0: [-2.63366137253667, 1.70675605663975 + 2.31582447384325j, -10.35101467245920],
    5.0: [-0.32286642900409, -0.77534188219585 + 4.46486771378823j, -14.07838969279822],
    8.0: [0.14327879765713, -2.69348683581097 + 8.46037971396931j, -20.27940894394569],
}


@pytest.mark.parametrize("v", MEIJAARD)
def test_benchmark_bicycle(v):
    """Four motions are free: along the track, sideways, yaw with it, and the speed."""
    modes = mbdsl.eigen(MODELS / "space/bicycle.mbd", "start", parameters={"v": v, "push": 0.0})
    assert nonzero(modes) == pytest.approx(MEIJAARD[v], rel=EXACT)
    A = mbdsl.linearise(MODELS / "space/bicycle.mbd", "start", parameters={"v": v, "push": 0.0}).A
    linear = [s for s in np.linalg.eigvals(A) if abs(s) > 1e-3 and s.imag >= 0.0]  # double zeros, to rounding
    assert sorted(linear, key=abs) == pytest.approx(MEIJAARD[v], rel=EXACT)


def test_equilibrium_of_a_bicycle_at_speed():
    """At rest, it is another state than the given one."""
    for found in (mbdsl.eigen(MODELS / "space/bicycle.mbd"), mbdsl.linearise(MODELS / "space/bicycle.mbd")):
        assert any("`--at start`" in note and "rider.vx" in note for note in found.notes)
    assert not any("start" in note for note in mbdsl.eigen(MODELS / "space/bicycle.mbd", "start").notes)


DISC = """spatial model Disc "A disc that rolls, with a body hung from its axle"
  parameter Velocity v = 2 m/s;
  Ground ground(n = {0, 0, -1});
  Body disc(m = 1 kg, I = {0.01, 0.02, 0.01} kg.m2);
  Body bob(m = 0.5 kg, I = {0.002, 0.003, 0.001} kg.m2, frames(hub = {0, 0, 0.1} m));
  Revolute axle(disc.c, bob.hub, n = {0, 1, 0});
  RollingDisc roll(ground, disc.c, radius = 0.2 m, n = {0, 1, 0}, normal = {0, 0, 1});
initial equation
  disc.x = 0 m; disc.y = 0 m; bob.phi_x = 0 rad; bob.phi_y = 0 rad; bob.phi_z = 0 rad; axle.phi = 0 rad;
  disc.vx = v; bob.wx = 0 rad/s; bob.wy = 0 rad/s; bob.wz = 0 rad/s;
end Disc;"""


@pytest.mark.parametrize("v", [0.8, 2.0, 5.0])
def test_body_hung_from_a_rolling_disc(v):
    """Pitch: a pendulum on a carriage. Roll: both lean by phi and yaw by psi, with angular momentum h of the disc,

    A phi'' - (S v + h) psi' = S g phi,   C psi'' + h phi' = 0,   S = sum of m z, A and C sums about the ground."""
    m, M, R, g = 0.5, 1.0 + 0.02 / 0.2**2 + 0.5, 0.2, 9.81
    pitch = m * g * 0.1 / (0.003 + m * 0.1**2 - (m * 0.1) ** 2 / M)
    A, C, S, h = 0.012 + R**2 + m * 0.1**2, 0.011, R + m * 0.1, 0.02 * v / R
    roll = ((S * v + h) * h / C - S * g) / A
    squares = [-pitch, -roll] if roll > 0.0 else [-pitch, -roll, -roll]  # growing, and decaying
    found = nonzero(mbdsl.eigen(mbdsl.parse(DISC), "start", parameters={"v": v}))
    assert sorted(np.square(found).real) == pytest.approx(sorted(squares), rel=EXACT)


TRAILERS = """model Trailers "Two trailers, pulled at constant speed"
  Ground ground(g = 0);
  Body hitch(m = 1 kg, I = 1 kg.m2);
  Body one(m = 5 kg, I = 2 kg.m2, frames(front = {2 m, 0}));
  Body two(m = 3 kg, I = 1 kg.m2, frames(front = {1 m, 0}, wheel = {-0.5 m, 0}));
  Prismatic rail(ground, hitch.c);
  TranslationalDriver pull(rail, s = 3 m/s*time);
  Revolute pin(hitch.c, one.front);
  Revolute link(one.c, two.front);
  KnifeEdge wheel1(ground, one.c);
  KnifeEdge wheel2(ground, two.wheel);
initial equation
  pin.phi = 0 rad; link.phi = 0 rad;
end Trailers;"""


@pytest.mark.parametrize("spatial", ["", "spatial "])
@pytest.mark.parametrize(
    "change",
    [
        ("", ""),
        ("TranslationalDriver pull(rail, s = 3 m/s*time)", "TranslationalVelocityDriver pull(rail, v = 3 m/s)"),
        ("KnifeEdge wheel1(ground, one.c)", "VelocityConstraint w(gamma = cos(one.phi)*one.vy - sin(one.phi)*one.vx)"),
    ],
)
def test_trailers(spatial, change):
    """They have no degree of freedom, but follow the hitch: phi' = -v/L (phi - the angle of the one in front)."""
    modes = mbdsl.eigen(mbdsl.parse(spatial + TRAILERS.replace(*change)), "start")
    assert nonzero(modes) == pytest.approx([-3.0 / 2.0, -3.0 / 1.5], rel=EXACT)
    assert list(modes[-1].bodies) == ["two", "one", "hitch"] and modes[-1].bodies["one"] < 1e-9


def test_knife_edge_under_a_hinged_body():
    """A carriage on two blades, the front one steered by a spring and behind its pivot, in the plane and in space."""
    text = """model Cart
      Ground ground(g = 0);
      Body cart(m = 4 kg, I = 2 kg.m2, frames(pivot = {0.8 m, 0}, rear = {-0.4 m, 0}));
      Body fork(m = 1 kg, I = 0.05 kg.m2, frames(wheel = {-0.1 m, 0}));
      FreeMotion floor(ground, cart.c);
      Revolute pivot(cart.pivot, fork.c);
      RotationalSpringDamper spring(pivot, k = 3 N.m/rad, c = 0.2 N.m.s/rad);
      KnifeEdge rear(ground, cart.rear);
      KnifeEdge front(ground, fork.wheel);
    initial equation
      cart.x = 0 m; cart.y = 0 m; cart.phi = 0 rad; pivot.phi = 0 rad; cart.vx = 2 m/s;
    end Cart;"""
    solid = text.replace("model", "spatial model").replace("FreeMotion", "Planar")
    flat, solid = (nonzero(mbdsl.eigen(mbdsl.parse(x), "start")) for x in (text, solid))
    assert solid == pytest.approx(flat, rel=EXACT)
    assert flat == pytest.approx(steered(2.0), rel=EXACT)


def steered(v, m=4.0, I=2.0, mf=1.0, If=0.05, a=0.8, b=0.4, e=0.1, k=3.0, c=0.2):
    """Eigenvalues of the cart: coordinates x = (y, phi, d), with constraints B x' + v C x = 0, by Lagrange's equations
    with multipliers, which scipy solves as a pencil."""
    from scipy.linalg import eig

    B = np.array([[1.0, -b, 0.0], [1.0, a - e, -e]])
    C = np.array([[0.0, -1.0, 0.0], [0.0, -1.0, -1.0]])
    M = np.array([[m + mf, mf * a, 0.0], [mf * a, I + If + mf * a**2, If], [0.0, If, If]])
    E, A = np.eye(8), np.zeros((8, 8))  # x, x', multipliers
    E[3:6, 3:6], E[6:, 6:] = M, 0.0
    A[:3, 3:6] = np.eye(3)
    A[5, 2], A[5, 5], A[3:6, 6:] = -k, -c, B.T
    A[6:, 3:6], A[6:, :3] = B, v * C
    found = eig(A, E, right=False)
    found = [s for s in found if np.isfinite(s) and 1e-6 < abs(s) < 1e6 and s.imag >= -1e-9]
    return sorted(found, key=abs)
