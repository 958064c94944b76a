"""Equilibria, eigenmodes and linear models in space, against closed forms and against the nonlinear motion."""

import numpy as np
import pytest
from scipy.linalg import expm

import mbdsl
from mbdsl.analysis import operating_points
from mbdsl.analysis.excitations import columns
from mbdsl.analysis.linear_equations import LinearEquations
from mbdsl.analysis.named_basis import Named
from mbdsl.system.accelerations import accelerations

EXACT = 1e-9  # frequencies: rounding of the matrices and of differences along the motion, with a margin

PENDULUM = """spatial model Pendulum
  Ground ground;
  Body body(m = 2 kg, I = {0.1, 0.2, 0.3} kg.m2, frames(p = {0.1, 0.3, -0.2} m));
  Spherical ball(ground, body.p);
initial equation
  guess body.x = 0.3 m;
end Pendulum;"""


def test_hanging_position():
    """The centre of mass hangs below the ball joint; the pendulum can turn about the vertical."""
    found = mbdsl.static(mbdsl.parse(PENDULUM))
    assert found["body.y"] == pytest.approx(-np.sqrt(0.14), rel=EXACT)
    assert (found["body.x"], found["body.z"]) == pytest.approx((0, 0), abs=1e-9)
    assert found["ball.fy"] == pytest.approx(2 * 9.81, rel=EXACT)
    assert found.stability == "indifferent"


def test_physical_pendulum():
    """Swings about the principal axes x and z: w^2 = m g l/(I + m l^2), and a free turn about the vertical."""
    text = PENDULUM.replace("p = {0.1, 0.3, -0.2} m", "p = {0, 0.5, 0} m").replace("body.x = 0.3", "body.y = -0.5")
    modes = mbdsl.eigen(mbdsl.parse(text))
    expected = np.sqrt(2 * 9.81 * 0.5 / (np.array([0.3, 0.1]) + 2 * 0.25))
    assert [mode.omega for mode in modes] == pytest.approx([0.0, *expected], rel=EXACT, abs=1e-6)


def test_spherical_pendulum():
    """A point mass on a massless link: sqrt(g/l) in both directions."""
    text = """spatial model S Ground ground; PointMass mass(m = 3 kg); Distance link(ground, mass, length = 0.7 m);
      initial equation guess mass.y = -0.7 m; end S;"""
    modes = mbdsl.eigen(mbdsl.parse(text))
    assert [mode.omega for mode in modes] == pytest.approx([np.sqrt(9.81 / 0.7)] * 2, rel=EXACT)


def test_plate_on_springs():
    """A plate hangs on three vertical springs of different stiffness: levers give forces, Hooke gives lengths."""
    text = """spatial model Plate
      Ground ground;
      Body plate(m = 6 kg, I = {0.1, 0.2, 0.1} kg.m2,
        frames(p = {0.4, 0, 0} m, q = {-0.2, 0, 0.3} m, r = {-0.2, 0, -0.3} m));
      Frame P(ground, r = {0.4, 1, 0} m); Frame Q(ground, r = {-0.2, 1, 0.3} m); Frame R(ground, r = {-0.2, 1, -0.3} m);
      SpringDamper s1(P, plate.p, k = 1e5 N/m, s0 = 0.5 m);
      SpringDamper s2(Q, plate.q, k = 2e5 N/m, s0 = 0.5 m);
      SpringDamper s3(R, plate.r, k = 4e5 N/m, s0 = 0.5 m);
    end Plate;"""
    found = mbdsl.static(mbdsl.parse(text))
    assert found.stability == "stable"
    for k, (name, stiffness) in enumerate({"s1": 1e5, "s2": 2e5, "s3": 4e5}.items()):
        # a third of the weight each, by the levers; tilts of 1e-3 rad change them by their square, and by 0.5 m times
        # the tilt over 0.4 m where a spring is not vertical
        assert found[f"{name}.force"] == pytest.approx(6 * 9.81 / 3, rel=2e-3), k
        assert found[f"{name}.s"] - 0.5 == pytest.approx(6 * 9.81 / 3 / stiffness, rel=2e-3)


def test_torsional_springs_count_turns():
    """A spring without torque at 10 rad holds a wheel there, and not whole turns before."""
    text = """spatial model Wheel
      Ground ground; Body wheel(m = 1 kg, I = {1, 1, 1} kg.m2); Revolute pin(ground, wheel.c, n = {1, 2, -1});
      RotationalSpringDamper spring(ground, wheel.c, k = 2 N.m/rad, phi0 = 10 rad, n = {1, 2, -1});
    end Wheel;"""
    found = mbdsl.static(mbdsl.parse(text))
    assert found["spring.torque"] == pytest.approx(0.0, abs=1e-9)
    assert found["spring.phi"] == pytest.approx(10.0, abs=1e-9)


FREE = """spatial model Free
  Ground ground(g = 0);
  Body top(m = 2 kg, I = {0.2, 0.2, 0.3} kg.m2);
  Force none(top.c);
initial equation
  top.wx = 0;
  top.wy = 0;
  top.wz = 10 rad/s;
end Free;"""


def test_nutation_of_a_free_top():
    """The axis of a free symmetric top moves with C/A times its spin, seen from the ground."""
    modes = mbdsl.eigen(mbdsl.parse(FREE), at="start")
    assert modes[-1].eigenvalue == pytest.approx(10j * 0.3 / 0.2, rel=1e-7)
    assert all(mode.omega == 0.0 for mode in modes[:-1])


@pytest.mark.parametrize("spin", [300.0, 100.0])
def test_sleeping_top(spin):
    """A s^2 - i C n s - m g l = 0 for the axis of an upright top: nutation and precession, or unstable below n^2 =
    4 A m g l/C^2 = (174 rad/s)^2."""
    text = """spatial model Sleeping
      Ground ground; Body top(m = 2 kg, I = {0.2, 0.03, 0.2} kg.m2, frames(p = {0, -0.5, 0} m));
      Spherical ball(ground, top.p);
    initial equation
      top.wx = 0; top.wy = %g rad/s; top.wz = 0;
    end Sleeping;"""
    modes = mbdsl.eigen(mbdsl.parse(text % spin), at="start")
    A = 0.2 + 2 * 0.25
    expected = np.roots([A, -1j * 0.03 * spin, -2 * 9.81 * 0.5])
    found = [mode.eigenvalue for mode in modes if mode.omega > 1e-6]
    assert sorted(found, key=lambda s: (s.imag, s.real)) == pytest.approx(
        sorted(expected, key=lambda s: (round(s.imag, 9), s.real)), rel=1e-6
    )


SKEW = """spatial model Skew "Two bodies on skew hinges, with springs"
  input Torque u(start = 0.3 N.m);
  input Force f(start = 1 N);
  Ground ground;
  Body b(m = 2 kg, I = {0.2, 0.03, 0.1} kg.m2, frames(p = {0, 0.5, 0} m, q = {0.1, -0.2, 0.3} m));
  Body c(m = 1 kg, I = {0.02, 0.03, 0.04} kg.m2, frames(p = {0, 0.5, 0.1} m));
  Revolute pin(ground, b.p, n = {1, 0.3, 0.2});
  Revolute hinge(b.q, c.p, n = {0.2, -0.4, 1});
  RotationalSpringDamper spring(ground, b.p, k = 3 N.m/rad, c = 0.1 N.m.s/rad, n = {1, 0.3, 0.2});
  SpringDamper link(ground, c.c, k = 5 N/m, c = 0.2 N.s/m, s0 = 0.2 m);
  Torque act(ground, b.p, tau = u, n = {1, 0.3, 0.2});
  Force push(b.c, c.p, fx = f, fz = f*pin.phi/(1 rad));
initial equation
  pin.phi = 20 deg;
  pin.w = 2 rad/s;
  hinge.phi = -10 deg;
  hinge.w = -3 rad/s;
end Skew;"""


def test_linear_model_against_the_motion():
    """Deviations after 0.3 s from the equilibrium: exp(0.3 A) x for two states, and with a constant input.

    Runs with steps of 0.25 ms have relative errors of 1e-6; deviations of +-1e-3 add the like by their third order."""
    linear = mbdsl.linearise(mbdsl.parse(SKEW))
    assert linear.states == ["pin.phi", "hinge.phi", "pin.w", "hinge.w"]
    e, T = 1e-3, 0.3
    big = np.zeros((6, 6))
    big[:4, :4], big[:4, 4:] = linear.A, linear.B
    exact = expm(T * big)[:4]
    for k in (1, 2, 4, 5):
        ends = []
        for sign in (1, -1):
            x, u = linear.x0.copy(), linear.u0.copy()
            (x if k < 4 else u)[k % 4] += sign * e
            text = SKEW.replace("start = 0.3 N.m", f"start = {float(u[0])!r} N.m")
            text = text.replace("start = 1 N)", f"start = {float(u[1])!r} N)")
            text = text.replace("pin.phi = 20 deg", f"pin.phi = {float(x[0])!r}")
            text = text.replace("hinge.phi = -10 deg", f"hinge.phi = {float(x[1])!r}")
            text = text.replace("pin.w = 2 rad/s", f"pin.w = {float(x[2])!r}")
            text = text.replace("hinge.w = -3 rad/s", f"hinge.w = {float(x[3])!r}")
            run = mbdsl.simulate(mbdsl.parse(text), step=2.5e-4, stop=T, interval=T)
            ends.append([run[name][-1] for name in linear.states])
        found = (np.array(ends[0]) - np.array(ends[1])) / (2 * e)
        np.testing.assert_allclose(found, exact[:, k], rtol=0, atol=3e-5 * np.abs(exact[:, k]).max())


COIN = """spatial model Coin "A disc that rolls along a curve, with a body on a ball joint"
  Ground ground(n = {0, 0, -1});
  Body disc(m = 1 kg, I = {0.01, 0.02, 0.01} kg.m2);
  Body bob(m = 0.5 kg, I = {0.002, 0.002, 0.001} kg.m2, frames(hub = {0, 0.1, 0.1} m));
  Spherical ball(disc.c, bob.hub);
  RollingDisc roll(ground, disc.c, radius = 0.2 m, n = {0, 1, 0}, normal = {0, 0, 1});
initial equation
  disc.x = 0 m; disc.y = 0 m; disc.phi_x = 0.3 rad; bob.phi_x = 0 rad; bob.phi_y = 0 rad; bob.phi_z = 0 rad;
  disc.vx = 2 m/s; disc.wx = 0.3 rad/s; disc.wz = 0.7 rad/s; bob.wx = 0.1 rad/s; bob.wy = 0.5 rad/s; bob.wz = 0 rad/s;
end Coin;"""

SLEDGE = """spatial model Sledge "On a table that a driver turns, with a pendulum and a law of velocities"
  Ground ground;
  Body table(m = 10 kg, I = {10, 20, 30} kg.m2);
  Body sledge(m = 5 kg, I = {2, 1, 2} kg.m2, frames(f = {0.5, 0, 0.2} m, k = {-0.3, 0.1, 0} m));
  Body bob(m = 2 kg, I = {0.2, 0.1, 0.2} kg.m2, frames(f = {0.3, 0, 0} m));
  Revolute pin(ground, table.c, n = {0, 0.3, 1});
  RotationalVelocityDriver turn(pin, w = 2 rad/s + 1 rad/s2*time);
  Planar glide(table.c, sledge.c, n = {0, 0, 1});
  KnifeEdge blade(table.c, sledge.k, n = {0, 0, 1});
  Spherical ball(sledge.f, bob.f);
  VelocityConstraint law(gamma = bob.wz + 0.4*sledge.wz*cos(glide.phi) - 0.1 rad/m*sin(2*glide.phi)*bob.vx);
initial equation
  pin.phi = 0.2 rad; sledge.x = 0.1 m; sledge.y = -0.2 m; glide.phi = 0.4 rad; glide.w = 1 rad/s; blade.v = 0.5 m/s;
  bob.phi_x = 0.2 rad; bob.phi_y = 0.3 rad; bob.phi_z = 0.1 rad; bob.wx = 0.2 rad/s; bob.wy = -0.4 rad/s;
end Sledge;"""


@pytest.mark.parametrize("model", [SKEW, FREE, COIN, SLEDGE])
def test_linear_model_of_a_motion(model):
    """Accelerations at deviating states, by central differences over 1e-5, whose errors are below 1e-8.

    The deviations keep the constraints, and those of positions change at the rates of the coordinates."""
    point = operating_points.find(mbdsl.parse(model), "start", (), None, None)
    system, t, q, v, a = point.system, point.t, point.q, point.v, point.a
    basis = Named(system, t, q, v, a)
    linear = LinearEquations(point, [], columns(system, [], t, q, v, point.lam))
    assert isinstance(linear.basis, Named)
    before, after = (basis._at(s)[0] for s in (-1e-5, 1e-5))
    np.testing.assert_allclose((after - before) / 2e-5, basis.Z1, atol=1e-6 * np.abs(basis.Z1).max())
    for k in range(linear.A.shape[0]):
        dq, dv = linear.dq.x[:, k], linear.dv.x[:, k]
        found = []
        for e in (1e-5, -1e-5):
            state = t, system.moved(q, e * dq), v + e * dv
            assert np.abs(system.evaluate(*state)[2]).max(initial=0.0) < 1e-8
            assert np.abs(system.Gam(*state)).max(initial=0.0) < 1e-8
            found.append(accelerations(system, *state)[0])
        np.testing.assert_allclose((found[0] - found[1]) / 2e-5, linear.da.x[:, k], rtol=1e-5, atol=1e-4)


def test_outputs_of_a_linear_model():
    """Positions, reactions and accelerations at deviating states: differences of +-1e-5 leave 1e-7 by rounding."""
    names = ["c.z", "c.vx", "c.wy", "hinge.fx", "pin.tz", "c.ax", "c.az", "b.alphax", "c.alphay"]
    e, text = 1e-5, SKEW.replace("f*pin.phi/(1 rad)", "f")
    linear = mbdsl.linearise(mbdsl.parse(text), at="start", signals=names)
    for k, start in enumerate(("20 deg", "-10 deg", "2 rad/s", "-3 rad/s")):
        target = ("pin.phi = ", "hinge.phi = ", "pin.w = ", "hinge.w = ")[k]
        found = []
        for sign in (1, -1):
            x = linear.x0[k] + sign * e
            run = mbdsl.simulate(mbdsl.parse(text.replace(target + start, f"{target}{float(x)!r}")), stop=0.0)
            found.append([run[name][0] for name in names])
        slope = (np.array(found[0]) - np.array(found[1])) / (2 * e)
        np.testing.assert_allclose(slope, linear.C[:, k], rtol=0, atol=1e-6 * np.abs(linear.C[:, k]).max())


def test_equilibrium_of_an_overconstrained_loop():
    """A four-bar in space has the equilibrium and the mode of the planar one."""
    text = """spatial model FourBar
      Ground ground; Frame d(ground, r = {1, 0} m);
      Rod r1(m = 1 kg, length = 0.4 m); Rod r2(m = 1 kg, length = 1.1 m); Rod r3(m = 1 kg, length = 0.8 m);
      Revolute A(ground, r1.a); Revolute B(r1.b, r2.a); Revolute C(r2.b, r3.b); Revolute D(d, r3.a);
    initial equation
      guess r1.phi = -60 deg; guess r3.phi = -80 deg; guess r2.phi = -20 deg;
    end FourBar;"""
    solid, flat = (mbdsl.eigen(mbdsl.parse(x)) for x in (text, text.replace("spatial ", "")))
    assert len(solid) == len(flat) == 1
    assert solid[0].omega == pytest.approx(flat[0].omega, rel=EXACT)
    solid, flat = (mbdsl.static(mbdsl.parse(x)) for x in (text, text.replace("spatial ", "")))
    assert len(solid.redundant) == 3
    for name in ("A.fx", "A.fy", "C.fx", "D.fy", "r2.x", "r2.y"):
        assert solid[name] == pytest.approx(flat[name], rel=1e-8)
