"""Rotors that are symmetric about their axles: gyrostats, whose steps need not resolve the spin.

References: Euler's equations of a gyrostat, solved by DOP853 of SciPy; the equations of all bodies on their own
(``general``), with a method of high order at steps that resolve the spin; conservation of angular momentum.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import mbdsl
from mbdsl.mechanism import graph
from mbdsl.mechanism.reduction import reduce

#: a satellite with three wheels, one of them on a frame off its centre of mass, with the axes of its hinge exchanged
SATELLITE = """
spatial model Satellite
  Ground ground(g = 0);
  Body bus(m = 200 kg, I = {80, 95, 60} kg.m2,
           frames(a = {0.3, 0.1, -0.2} m, b = {-0.2, 0.3, 0.1} m, d = {0.1, -0.3, 0.2} m));
  Cylinder w1(m = 5 kg, length = 0.05 m, radius = 0.15 m, n = {1, 0, 0});
  Cylinder w2(m = 4 kg, length = 0.05 m, radius = 0.15 m, n = {0, 1, 0}, frames(s = {0, 0.04, 0} m));
  Cylinder w3(m = 3 kg, length = 0.05 m, radius = 0.12 m, n = {0, 0, 1});
  FreeMotion free(ground, bus.c);
  Revolute j1(bus.a, w1.c, n = {1, 0, 0});
  Revolute j2(w2.s, bus.b, n = {0, 1, 0});
  Revolute j3(bus.d, w3.c, n = {0, 0, 1});
  LOADS
initial equation
  bus.wx_local = 0.02 rad/s; bus.wy_local = -0.03 rad/s; bus.wz_local = 0.05 rad/s;
  bus.vx = 0.1 m/s; bus.vy = 0 m/s; bus.vz = 0 m/s;
  j1.w = 100 rad/s; j2.w = 80 rad/s; j3.w = 100 rad/s;
  annotation(experiment(StopTime = 2 s, Interval = 0.02 s));
end Satellite;
"""
LOADS = """
  Torque t1(bus.a, w1.c, n = {1, 0, 0}, tau = 0.3 N.m*sin(2*time));
  RotationalSpringDamper d2(w2.s, bus.b, n = {0, 1, 0}, c = 1e-3 N.m.s/rad);
  Torque t3(bus.d, w3.c, n = {0, 0, 1}, tau = -0.01 N.m.s/rad*(j3.w - 90 rad/s) + 1 N.m.s/rad*bus.wz_local);
"""
#: the bus hangs on a ball joint in gravity, and a wheel is driven with a given speed
HANGING = (
    SATELLITE.replace("Satellite", "Hanging")
    .replace("FreeMotion free(ground, bus.c)", "Spherical hip(ground, bus.d)")
    .replace("g = 0", "g = 9.81 m/s2")
    .replace("  bus.vx = 0.1 m/s; bus.vy = 0 m/s; bus.vz = 0 m/s;\n", "")
    .replace("j1.w = 100 rad/s; ", "")
    .replace("LOADS", LOADS.replace(
        "Torque t1(bus.a, w1.c, n = {1, 0, 0}, tau = 0.3 N.m*sin(2*time))",
        "RotationalVelocityDriver t1(bus.a, w1.c, n = {1, 0, 0}, w = 100 rad/s + 3 rad/s*sin(3*time))",
    ))
)  # fmt: skip
LOADED = SATELLITE.replace("LOADS", LOADS)
FREE = SATELLITE.replace("LOADS", "")
OF_BUS = [f"bus.w{x}_local" for x in "xyz"]
#: method -> largest error of the rates of the bus at steps of 20 ms, in which the wheels turn by 2 rad
METHODS = {
    "hht-si2": 1e-6, "hht-i3": 1e-6, "hht-add": 1e-6, "nstiff": 1e-6, "nstiff-si2": 1e-6, "generalized-alpha": 1e-6,
    "generalized-alpha-i3": 1e-6, "newmark": 1e-4, "radau5": 1e-12, "radau9": 1e-12, "radau13": 1e-12, "dop853": 1e-12,
    "scipy-dop853": 1e-9, "scipy-radau": 1e-6, "scipy-lsoda": 1e-6, "ida": 1e-6,
}  # fmt: skip
BACKENDS = ("scipy-dop853", "scipy-radau", "scipy-lsoda", "ida")


def inertia(m, r, l, k):
    """Of a cylinder about its centre, with the axis k."""
    own = np.full(3, m * (3 * r * r + l * l) / 12)
    own[k] = m * r * r / 2
    return np.diag(own)


@pytest.fixture(scope="module")
def euler():
    """Omega of the bus at 0, 0.02, ..., 2 s, (101, 3), of the free satellite."""
    wheels = [
        (5.0, inertia(5.0, 0.15, 0.05, 0), np.array([0.3, 0.1, -0.2]), 100.0),
        (4.0, inertia(4.0, 0.15, 0.05, 1), np.array([-0.2, 0.26, 0.1]), -80.0),  # of the wheel relative to the bus
        (3.0, inertia(3.0, 0.12, 0.05, 2), np.array([0.1, -0.3, 0.2]), 100.0),
    ]
    parts = [(200.0, np.diag([80.0, 95.0, 60.0]), np.zeros(3)), *(x[:3] for x in wheels)]
    centre = sum(m * c for m, _, c in parts) / sum(m for m, _, _ in parts)
    J = sum(I + m * ((c - centre) @ (c - centre) * np.eye(3) - np.outer(c - centre, c - centre)) for m, I, c in parts)
    C = np.array([I[k, k] for k, (_, I, _, _) in enumerate(wheels)])

    def rates(_t, y):
        w, sigma = y[:3], y[3:]
        change = np.linalg.solve(J - np.diag(C), -np.cross(w, J @ w + C * sigma))
        return [*change, *(-change)]

    start = [0.02, -0.03, 0.05, *(x[3] for x in wheels)]
    t = np.linspace(0.0, 2.0, 101)
    return solve_ivp(rates, (0.0, 2.0), start, method="DOP853", rtol=1e-13, atol=1e-15, t_eval=t).y[:3].T


@pytest.fixture(scope="module")
def free():
    return mbdsl.parse(FREE)


@pytest.mark.parametrize("method", [name for name in METHODS if name not in BACKENDS])
def test_free_satellite(free, euler, method):
    run = mbdsl.simulate(free, method=method, step=2e-2)
    assert run.stats["steps"] == 100
    assert np.abs(np.transpose([run[x] for x in OF_BUS]) - euler).max() < METHODS[method]
    for name in ("w1.wx_local", "w2.wy_local", "w3.wz_local"):  # no torque acts about an axle
        assert np.abs(run[name] - run[name][0]).max() < METHODS[method] * 100.0


@pytest.mark.parametrize("method", BACKENDS)
def test_free_satellite_by_others(free, euler, method):
    pytest.importorskip("sksundae" if method == "ida" else "scipy")
    run = mbdsl.simulate(free, method=method, tol=1e-8)
    assert np.abs(np.transpose([run[x] for x in OF_BUS]) - euler).max() < METHODS[method]


@pytest.mark.parametrize("text", [LOADED, HANGING], ids=["free", "hanging"])
def test_all_signals_are_those_of_the_bodies_on_their_own(text):
    """At steps of 20 ms, of 2 rad, and of all bodies on their own at steps of 1 ms: reactions of the hinges, too."""
    scene = mbdsl.parse(text.replace("StopTime = 2 s", "StopTime = 0.6 s"))
    run = mbdsl.simulate(scene, method="dop853", step=2e-2)
    other = mbdsl.simulate(scene, method="dop853", step=1e-3, general=True)
    assert run.signals == other.signals
    for name in other.signals:
        expected = np.asarray(other[name])
        error = np.abs(np.asarray(run[name]) - expected).max()
        if any(x in name for x in (".Phi[", ".dPhi[", ".Gam[")):
            assert error < 1e-11  # residuals are rounding
        else:
            # forces are 1e-9 of m r w^2 of the wheels
            assert error < 1e-9 * max(1.0, np.abs(expected).max()), name
    assert np.abs(other["j1.fy"]).max() > 0.0


def momentum(run):
    """The angular momentum about the origin (N, 3)."""
    total = 0.0
    for name, m, I in (
        ("bus", 200.0, np.diag([80.0, 95.0, 60.0])),
        ("w1", 5.0, inertia(5.0, 0.15, 0.05, 0)),
        ("w2", 4.0, inertia(4.0, 0.15, 0.05, 1)),
        ("w3", 3.0, inertia(3.0, 0.12, 0.05, 2)),
    ):
        x, v = (np.transpose([run[f"{name}.{key}"] for key in keys]) for keys in (("x", "y", "z"), ("vx", "vy", "vz")))
        w = np.transpose([run[f"{name}.w{i}_local"] for i in "xyz"])
        R = Rotation.from_quat(np.transpose([run[f"{name}.p{i}"] for i in (1, 2, 3, 0)]))
        total = total + m * np.cross(x, v) + R.apply(w @ I)
    return total


def test_motors_conserve_the_angular_momentum():
    """Wheels that motors spin up from rest turn the bus the other way."""
    motors = "".join(
        f"  Torque m{k}({a}, {b}, n = {n}, tau = {tau} N.m);\n"
        for k, a, b, n, tau in (
            (1, "bus.a", "w1.c", "{1, 0, 0}", 0.5),
            (2, "w2.s", "bus.b", "{0, 1, 0}", 0.3),
            (3, "bus.d", "w3.c", "{0, 0, 1}", -0.2),
        )
    )
    text = SATELLITE.replace("LOADS", motors).replace("= 100 rad/s", "= 0 rad/s").replace("= 80 rad/s", "= 0 rad/s")
    run = mbdsl.simulate(mbdsl.parse(text), method="radau5", step=2e-2)
    L = momentum(run)
    assert run["j1.w"][-1] > 15.0 and run["j3.w"][-1] < -15.0
    assert np.abs(L - L[0]).max() < 1e-11 * np.abs(L).max()
    # work of the motors
    work = run["energy.total"] - run["energy.total"][0]
    done = 0.5 * run["j1.phi"] + 0.3 * run["j2.phi"] - 0.2 * run["j3.phi"]
    assert np.abs(work - (done - done[0])).max() < 1e-9 * work.max()


def test_steps_are_those_of_the_bus():
    """With a tolerance: in 100 s, in which a wheel turns by 10,000 rad."""
    text = FREE.replace("StopTime = 2 s, Interval = 0.02 s", "StopTime = 100 s, Interval = 10 s")
    run = mbdsl.simulate(mbdsl.parse(text), method="dop853", tol=1e-8)
    assert run.stats["steps"] < 60
    other = mbdsl.simulate(mbdsl.parse(text), method="radau5", step=0.05)
    for name in OF_BUS:
        assert np.abs(run[name] - other[name]).max() < 1e-8
    assert np.abs(run["w1.wx_local"] - 100.02).max() < 1e-8 * 100.0


@pytest.mark.parametrize("method", ["hht-si2", "radau5", "dop853"])
@pytest.mark.parametrize("text", [LOADED, HANGING], ids=["free", "hanging"])
def test_tolerances_hold_for_the_rotors_as_well(text, method):
    """Angles and speeds, the latter relative to the largest one, against steps of 5 ms of a method of order 8."""
    scene = mbdsl.parse(text.replace("StopTime = 2 s", "StopTime = 1 s"))
    run, exact = mbdsl.simulate(scene, method=method, tol=1e-5), mbdsl.simulate(scene, method="dop853", step=5e-3)
    for j in ("j1", "j2", "j3"):
        assert np.abs(run[f"{j}.phi"] - exact[f"{j}.phi"]).max() < 1e-5
        assert np.abs(run[f"{j}.w"] - exact[f"{j}.w"]).max() < 1e-5 * 100.0
    for name in OF_BUS:
        assert np.abs(run[name] - exact[name]).max() < 1e-5 * 100.0


#: a wheel in two gimbals with mass, and one below the outer one, which a constraint couples; centres of mass off the
#: reference points, and an inclined hinge whose rotor is its frame_a
GIMBALS = """
spatial model Gimbals
  Ground ground(g = 9.81 m/s2);
  Body ring(m = 2 kg, I = {{0.08, 0.01, 0}, {0.01, 0.06, 0}, {0, 0, 0.09}} kg.m2, com = {0.01, 0.02, 0.03} m,
            frames(a = {0, 0.1, 0} m, b = {0.2, 0.1, 0} m));
  Body fork(m = 1 kg, I = {0.03, 0.02, 0.04} kg.m2, com = {0.02, 0, 0.01} m,
            frames(a = {0, 0, 0.1} m, b = {0.05, 0.1, 0} m));
  Body wheel(m = 3 kg, I = {0.02, 0.02, 0.05} kg.m2, com = {0.1, 0.2, 0.3} m, frames(a = {0.1, 0.2, 0.25} m));
  Body ball(m = 1 kg, I = {0.02, 0.02, 0.02} kg.m2);
  Revolute g(ground, ring.a, n = {0, 1, 0.3});
  Revolute h(ring.b, fork.a, n = {1, 0, 0});
  Revolute j(fork.b, wheel.a, n = {0, 0, 1});
  Revolute k(ball.c, ring.c, n = {0.5, 0.5, 1});
  VelocityConstraint gear(gamma = j.w + 2*k.w);
  Torque t(j, tau = 0.3 N.m - 0.01 N.m.s/rad*j.w);
  Torque u(ground, ball.c, n = {0, 1, 0}, tau = 0.05 N.m);
  RotationalSpringDamper d(h, k = 2 N.m/rad, c = 0.01 N.m.s/rad);
initial equation
  g.phi = 0.3 rad; h.phi = 0.5 rad; g.w = 1 rad/s; h.w = -2 rad/s; j.w = 50 rad/s;
  annotation(experiment(StopTime = 0.4 s, Interval = 20 ms));
end Gimbals;
"""


def test_gimbals():
    """All signals, as in test_all_signals_are_those_of_the_bodies_on_their_own."""
    scene = mbdsl.parse(GIMBALS)
    run, other = (mbdsl.simulate(scene, method="dop853", step=2e-3, general=general) for general in (False, True))
    assert [part.graph.coordinates for part in reduce(graph.build(scene)).parts] == [14]
    for name in other.signals:
        expected = np.asarray(other[name])
        assert np.abs(np.asarray(run[name]) - expected).max() < 1e-10 * max(1.0, np.abs(expected).max()), name


def test_angles_of_other_joints_keep_their_turns():
    """A boom beside the wheels, whose spring is wound up by more than a turn."""
    boom = """
  Body boom(m = 6 kg, I = {1, 2, 3} kg.m2, frames(s = {0.2, 0.5, 0} m));
  Revolute h(bus.a, boom.s, n = {0, 0.6, 0.8});
  RotationalSpringDamper s(h, k = 3 N.m/rad, c = 0.1 N.m.s/rad, phi0 = 380 deg);
"""
    text = (
        SATELLITE.replace("LOADS", boom)
        .replace("StopTime = 2 s", "StopTime = 1 s")
        .replace("j1.w = 100", "h.phi = 400 deg; h.w = 0 rad/s; j1.w = 100")
    )
    scene = mbdsl.parse(text)
    run = mbdsl.simulate(scene, method="dop853", step=2e-2)
    other = mbdsl.simulate(scene, method="dop853", step=4e-3, general=True)
    assert run["h.phi"][0] == pytest.approx(np.radians(400.0))
    assert np.ptp(other["h.phi"]) > 0.05
    for name in ("h.phi", "s.torque", "h.tx", "boom.wx", "w3.wx_local"):
        assert np.abs(run[name] - other[name]).max() < 1e-7 * max(1.0, np.abs(other[name]).max()), name
